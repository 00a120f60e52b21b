//! A virtual screen (Xvfb), its windows by title, its keyboard and mouse (xdotool), and its pixels.

use std::io::{BufRead as _, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

use crate::{Program, wait_until};

/// A virtual screen that ends with its owner.
pub struct VirtualScreen {
    server: Child,
    /// Value for `DISPLAY`.
    pub display: String,
    pixels: std::path::PathBuf,
}

impl VirtualScreen {
    /// Starts one, its pixels in this folder; `None`: Xvfb or xdotool is not installed.
    #[must_use]
    pub fn start(folder: &Path) -> Option<Self> {
        // Whatever it says without a screen: it is there.
        Command::new("xdotool").arg("version").output().ok()?;
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1300x900x24"])
            // Else it begins anew, and throws out who comes just then, when its last client goes:
            // each xdotool is one.
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
        // A window may go while it is asked for: then there is no answer.
        output.map_or_else(
            |_| String::new(),
            |it| String::from_utf8_lossy(&it.stdout).trim().to_owned(),
        )
    }

    /// Windows that are seen, with their titles.
    #[must_use]
    pub fn windows(&self) -> Vec<(String, String)> {
        let ids = self.tool(&["search", "--onlyvisible", "--name", "^Calot: "]);
        let named = |id: &str| (id.to_owned(), self.tool(&["getwindowname", id]));
        ids.lines().map(named).collect()
    }

    /// The window whose title is this, once there is one.
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

    /// Presses Esc in a window until its program has ended, as a person does who wants to leave.
    pub fn leave(&self, window: &str, program: &mut Program) {
        wait_until("the program's end by Esc", || {
            self.press(window, "Escape");
            program.ended().is_some()
        });
    }

    /// Presses a key, by its X name, in a window. One that has just gone takes none.
    pub fn press(&self, window: &str, key: &str) {
        self.tool(&["windowfocus", "--sync", window, "key", key]);
    }

    /// Presses a key and waits until something else is on the screen.
    pub fn press_and_see(&self, window: &str, key: &str) {
        let before = self.pixels();
        self.press(window, key);
        wait_until("another picture", || self.pixels() != before);
    }

    /// Puts the mouse in the middle of a window.
    pub fn point_at(&self, window: &str) {
        self.tool(&["mousemove", "--polar", "--window", window, "0", "0"]);
    }

    /// Moves the mouse by so many counts to the right and down.
    pub fn move_mouse(&self, [right, down]: [i32; 2]) {
        let (right, down) = (right.to_string(), down.to_string());
        self.tool(&["mousemove_relative", "--", &right, &down]);
    }

    /// Presses a button of the mouse, or lets it go: 1 is the left, 2 the middle, 3 the right.
    pub fn hold_button(&self, button: u8, down: bool) {
        let verb = if down { "mousedown" } else { "mouseup" };
        self.tool(&[verb, &button.to_string()]);
    }

    /// Turns its wheel by a notch, away from the person or towards.
    pub fn turn_wheel(&self, away: bool) {
        self.tool(&["click", if away { "4" } else { "5" }]);
    }

    /// The screen as it is now.
    ///
    /// # Panics
    /// When Xvfb has left no pixels.
    #[must_use]
    pub fn pixels(&self) -> Vec<u8> {
        std::fs::read(&self.pixels).expect("Xvfb keeps its pixels there")
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
