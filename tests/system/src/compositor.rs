//! A Wayland compositor (weston), without a screen or in the window of a virtual screen.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use crate::screen::VirtualScreen;
use crate::wait_until;

/// A compositor. It is killed on drop.
pub struct Compositor {
    server: Child,
    /// Value for `WAYLAND_DISPLAY`.
    pub display: PathBuf,
}

impl Compositor {
    /// Starts a compositor with its socket in this folder. If `screen` is given, its windows cover
    /// that screen; otherwise nobody sees them. `None` if weston is not installed.
    ///
    /// # Panics
    ///
    /// If weston ends, or opens no socket.
    #[must_use]
    pub fn start(folder: &Path, screen: Option<&VirtualScreen>) -> Option<Self> {
        let mut weston = Command::new("weston");
        weston
            .args(["--use-pixman", "--no-config", "--idle-time=0"])
            .args(["--socket=calot-test", "--width=1300", "--height=900"])
            .env("XDG_RUNTIME_DIR", folder)
            .env_remove("WAYLAND_DISPLAY");
        match screen {
            // Without a screen, this shell of version 10 shows no window.
            Some(screen) => weston
                .args(["--backend=x11-backend.so", "--shell=kiosk-shell.so"])
                .env("DISPLAY", &screen.display),
            None => weston.arg("--backend=headless-backend.so"),
        };
        let mut server = weston
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let display = folder.join("calot-test");
        wait_until("the compositor's socket", || {
            let ended = server.try_wait().expect("a child");
            assert!(ended.is_none(), "weston ended: {ended:?}");
            display.exists()
        });
        Some(Self { server, display })
    }
}

impl Drop for Compositor {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}
