//! A virtual screen (Xvfb): its windows by title, its keyboard and mouse (xdotool), and its pixels.

use std::io::{BufRead as _, BufReader};
use std::os::unix::fs::FileExt as _;
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::{Program, wait_until};

/// A virtual screen. It is killed on drop.
pub struct VirtualScreen {
    server: Child,
    /// Value for `DISPLAY`.
    pub display: String,
    pixels: std::path::PathBuf,
}

impl VirtualScreen {
    /// Starts a screen that keeps its pixels in this folder. `None` if Xvfb or xdotool is not
    /// installed.
    #[must_use]
    pub fn start(folder: &Path) -> Option<Self> {
        // Without a screen xdotool may fail. Only its presence matters here.
        Command::new("xdotool").arg("version").output().ok()?;
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1300x900x24"])
            // Each xdotool is a client. Without this option the server resets when its last client
            // leaves, and rejects a client that connects during the reset.
            .arg("-noreset")
            .args(["-nolisten", "tcp", "-fbdir"])
            .arg(folder)
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut line = String::new();
        BufReader::new(server.stdout.take()?)
            .read_line(&mut line)
            .ok()?;
        Some(Self {
            server,
            display: format!(":{}", line.trim()),
            pixels: folder.join("Xvfb_screen0"),
        })
    }

    fn tool(&self, words: &[&str]) -> String {
        let output = Command::new("xdotool")
            .args(words)
            .env("DISPLAY", &self.display)
            .output();
        // A window may close during the query; then there is no answer.
        output.map_or_else(
            |_| String::new(),
            |it| String::from_utf8_lossy(&it.stdout).trim().to_owned(),
        )
    }

    /// Ids and titles of Calot's visible windows.
    #[must_use]
    pub fn windows(&self) -> Vec<(String, String)> {
        let ids = self.tool(&["search", "--onlyvisible", "--name", "^Calot: "]);
        let named = |id: &str| (id.to_owned(), self.tool(&["getwindowname", id]));
        ids.lines().map(named).collect()
    }

    /// Waits for the window of this title and returns its id.
    #[must_use]
    #[track_caller]
    pub fn window(&self, title: &str) -> String {
        let mut found = None;
        wait_until(title, || {
            let windows = self.windows();
            found = windows.into_iter().find(|it| it.1 == title);
            found.is_some()
        });
        found.map(|it| it.0).unwrap_or_default()
    }

    /// Presses Esc in a window until its program has ended.
    pub fn leave(&self, window: &str, program: &mut Program) {
        wait_until("the program's end by Esc", || {
            self.press(window, "Escape");
            program.ended().is_some()
        });
    }

    /// Leaves the launcher's screens with Esc, and the launcher with Ctrl+Q.
    pub fn leave_launcher(&self, window: &str, launcher: &mut Program) {
        wait_until("the launcher's end by Ctrl+Q", || {
            self.press(window, "Escape");
            self.press(window, "ctrl+q");
            launcher.ended().is_some()
        });
    }

    /// Destroys a window as another program would, without asking its owner.
    pub fn destroy(&self, window: &str) {
        self.tool(&["windowclose", window]);
    }

    /// Kills the screen, with all connections to it.
    pub fn kill(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }

    /// Presses a key, by its X name, in a window. A window that has just closed ignores it.
    pub fn press(&self, window: &str, key: &str) {
        self.tool(&["windowfocus", "--sync", window, "key", key]);
    }

    /// Presses a key and waits until the screen changes.
    pub fn press_and_see(&self, window: &str, key: &str) {
        let before = self.pixels();
        self.press(window, key);
        wait_until("another picture", || self.pixels() != before);
    }

    /// Moves the mouse to the middle of a window.
    pub fn point_at(&self, window: &str) {
        self.tool(&["mousemove", "--polar", "--window", window, "0", "0"]);
    }

    /// Moves the mouse by these counts to the right and down.
    pub fn move_mouse(&self, [right, down]: [i32; 2]) {
        let (right, down) = (right.to_string(), down.to_string());
        self.tool(&["mousemove_relative", "--", &right, &down]);
    }

    /// Presses or releases a mouse button: 1 is left, 2 middle, 3 right.
    pub fn hold_button(&self, button: u8, down: bool) {
        let verb = if down { "mousedown" } else { "mouseup" };
        self.tool(&[verb, &button.to_string()]);
    }

    /// Turns the mouse wheel by one notch, away from the user or towards them.
    pub fn turn_wheel(&self, away: bool) {
        self.tool(&["click", if away { "4" } else { "5" }]);
    }

    /// Current pixels of the screen.
    ///
    /// # Panics
    ///
    /// If Xvfb has written none.
    #[must_use]
    pub fn pixels(&self) -> Vec<u8> {
        std::fs::read(&self.pixels).expect("Xvfb keeps its pixels there")
    }

    /// True if a pixel is white.
    ///
    /// # Panics
    ///
    /// If Xvfb has written none.
    #[must_use]
    pub fn is_white(&self, x: u64, y: u64) -> bool {
        // XWD: a header of big-endian words, a table of colours, then rows of four bytes a pixel.
        let file = std::fs::File::open(&self.pixels).expect("Xvfb keeps its pixels there");
        let read = |at: u64| {
            let mut bytes = [0; 4];
            file.read_exact_at(&mut bytes, at).expect("it is that long");
            bytes
        };
        let word = |i: u64| u64::from(u32::from_be_bytes(read(4 * i)));
        let (header, row, colours) = (word(0), word(12), word(19));
        let pixel = read(header + 12 * colours + row * y + 4 * x);
        pixel.iter().take(3).all(|&part| part > 200)
    }
}

impl Drop for VirtualScreen {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("Windows on the test's screen: {:?}", self.windows());
        }
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}
