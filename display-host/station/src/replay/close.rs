//! `calot replay --repair`: closes a session that breaks off.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde::Serialize;
use session::{Repaired, repair};

use crate::document;
use crate::output::{self, Format, Overwrite};
use crate::problem::Problem;
use crate::say;

/// Result of a repair.
#[derive(Debug, Serialize)]
struct RepairOutcome {
    session: PathBuf,
    /// The repaired copy; null if the session is whole.
    repaired: Option<PathBuf>,
    messages: u64,
    /// Reason of the repair; null if the session is whole.
    broke_off: Option<String>,
    left_out_bytes: u64,
}

pub(super) fn run(session: &Path, overwrite: Overwrite, json: bool) -> Result<ExitCode, Problem> {
    let to = beside(session);
    output::check("SESSION-repaired.mcap", &to, Format::Session, overwrite)?;
    let mut outcome = RepairOutcome {
        session: session.to_owned(),
        repaired: None,
        messages: 0,
        broke_off: None,
        left_out_bytes: 0,
    };
    match repair(session, &to)? {
        Repaired::Whole => say::note("the session is whole; there is nothing to repair"),
        Repaired::Closed {
            messages,
            why,
            left_out_bytes,
        } => {
            let left_out = match left_out_bytes {
                0 => String::new(),
                bytes => format!("; its last {bytes} bytes are left out"),
            };
            say::note(format_args!(
                "wrote {}: {messages} messages; of the session: {why}{left_out}",
                to.display()
            ));
            (outcome.messages, outcome.left_out_bytes) = (messages, left_out_bytes);
            (outcome.broke_off, outcome.repaired) = (Some(why), Some(to));
        }
    }
    if json {
        document::REPAIR.answer(&outcome)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// `a/session.mcap` → `a/session-repaired.mcap`.
fn beside(session: &Path) -> PathBuf {
    let stem = session.file_stem().unwrap_or_default().to_string_lossy();
    session.with_file_name(format!("{stem}-repaired.mcap"))
}
