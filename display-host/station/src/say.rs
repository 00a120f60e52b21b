//! Words for the user. Never `println!`: it panics when nobody reads any more (`calot … | head`),
//! and a controller must not die of that.

use std::fmt::Display;
use std::io::Write as _;

/// A line on standard error: progress, warnings, what was written.
pub(crate) fn note(text: impl Display) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// A line on standard output: what was asked for.
pub(crate) fn answer(text: impl Display) {
    let mut stdout = std::io::stdout();
    let _ = writeln!(stdout, "{text}").and_then(|()| stdout.flush());
}
