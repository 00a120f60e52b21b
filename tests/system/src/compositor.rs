//! A Wayland compositor without a screen (weston).

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use crate::wait_until;

/// A compositor. It is killed on drop.
pub struct Compositor {
    server: Child,
    /// Value for `WAYLAND_DISPLAY`.
    pub display: PathBuf,
}

impl Compositor {
    /// Starts a compositor with its socket in this folder. `None` if weston is not installed.
    ///
    /// # Panics
    ///
    /// If weston ends, or opens no socket.
    #[must_use]
    pub fn start(folder: &Path) -> Option<Self> {
        let mut server = Command::new("weston")
            .args(["--backend=headless-backend.so", "--use-pixman"])
            .args(["--no-config", "--idle-time=0", "--socket=calot-test"])
            .args(["--width=1300", "--height=900"])
            .env("XDG_RUNTIME_DIR", folder)
            .env_remove("WAYLAND_DISPLAY")
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
