//! Prints messages for the user. Never use `println!`: it panics when the reader has gone (`calot …
//! | head`), and the controller must not die of that.

use std::fmt::Display;
use std::io::Write as _;

/// Prints a line on standard error: progress, warnings, written files.
pub(crate) fn note(text: impl Display) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Prints a line on standard output: the answer to the command.
pub(crate) fn answer(text: impl Display) {
    let mut stdout = std::io::stdout();
    let _ = writeln!(stdout, "{text}").and_then(|()| stdout.flush());
}
