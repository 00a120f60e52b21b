//! Prints messages for the user. Never use `println!`: it panics if the reader of the pipe has
//! ended (`calot … | head`), and a panic would end the controller.

use std::fmt::Display;
use std::fs::File;
use std::io::{IsTerminal as _, Write as _};
use std::os::fd::AsFd as _;
use std::sync::OnceLock;

/// The real standard output, once [`keep_answers_apart`] was called.
static ANSWERS: OnceLock<File> = OnceLock::new();

/// Reserves standard output for [`answer`], so that answers in JSON stay JSON. Output of other
/// code, such as the library of a device's vendor, goes to standard error.
///
/// # Errors
///
/// The system's error.
pub(crate) fn keep_answers_apart() -> std::io::Result<()> {
    if ANSWERS.get().is_none() {
        let own = std::io::stdout().as_fd().try_clone_to_owned()?;
        rustix::stdio::dup2_stdout(rustix::stdio::stderr())?;
        let _ = ANSWERS.set(File::from(own));
    }
    Ok(())
}

/// True if answers go to a terminal.
pub(crate) fn is_terminal() -> bool {
    ANSWERS
        .get()
        .map_or_else(|| std::io::stdout().is_terminal(), File::is_terminal)
}

/// Prints a line on standard error: progress, warnings, written files.
pub(crate) fn note(text: impl Display) {
    let _ = writeln!(std::io::stderr(), "{text}");
}

/// Prints a line on standard output: the answer to the command.
pub(crate) fn answer(text: impl Display) {
    print(format_args!("{text}\n"));
}

/// Prints on standard output, without a new line.
pub(crate) fn print(text: std::fmt::Arguments<'_>) {
    let _ = match ANSWERS.get() {
        Some(mut own) => own.write_all(text.to_string().as_bytes()),
        None => {
            let mut stdout = std::io::stdout();
            stdout.write_fmt(text).and_then(|()| stdout.flush())
        }
    };
}
