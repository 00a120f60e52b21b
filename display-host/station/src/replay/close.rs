//! `calot replay --repair`: closes a session that breaks off, and saves the rest of a damaged one.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use serde::Serialize;
use session::{Lost, Repaired, repair};
use shared_mem::scene::SceneFile;

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
    /// Parts that are lost before the last whole record; null if none is.
    lost: Option<LostOutcome>,
}

/// Parts that a damaged session lost.
#[derive(Debug, Serialize)]
struct LostOutcome {
    messages: u64,
    /// True if more may be lost than is counted.
    more: bool,
    topics: BTreeMap<String, u64>,
    /// Begin and end of each span, s since the session's first message.
    spans_s: Vec<[f64; 2]>,
    scene: bool,
    damage: Vec<String>,
}

impl From<Lost> for LostOutcome {
    fn from(lost: Lost) -> Self {
        let seconds = |span: [u64; 2]| span.map(|ns| ns as f64 / 1e9);
        Self {
            messages: lost.messages,
            more: lost.is_more,
            topics: lost.topics,
            spans_s: lost.spans_ns.into_iter().map(seconds).collect(),
            scene: lost.scene,
            damage: lost.damage,
        }
    }
}

/// Repairs a session. The scene at `scene` replaces the session's own scene if that is damaged.
pub(super) fn run(
    session: &Path,
    scene: Option<&Path>,
    overwrite: Overwrite,
    json: bool,
) -> Result<ExitCode, Problem> {
    let to = repaired_path(session);
    output::check("SESSION-repaired.mcap", &to, Format::Session, overwrite)?;
    let mut outcome = RepairOutcome {
        session: session.to_owned(),
        repaired: None,
        messages: 0,
        broke_off: None,
        left_out_bytes: 0,
        lost: None,
    };
    let scene = scene.map(SceneFile::open).transpose()?;
    match repair(session, &to, scene.as_ref())? {
        Repaired::Whole => say::note("the session is whole; there is nothing to repair"),
        Repaired::Closed {
            messages,
            why,
            left_out_bytes,
            lost,
        } => {
            let left_out = match left_out_bytes {
                0 => String::new(),
                bytes => format!("; {bytes} bytes of it are left out"),
            };
            say::note(format_args!(
                "wrote {}: {messages} messages; of the session: {why}{left_out}",
                to.display()
            ));
            in_words(&lost).into_iter().for_each(say::note);
            outcome.lost = (!lost.is_nothing()).then(|| lost.into());
            (outcome.messages, outcome.left_out_bytes) = (messages, left_out_bytes);
            (outcome.broke_off, outcome.repaired) = (Some(why), Some(to));
        }
    }
    if json {
        document::REPAIR.answer(&outcome)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Lines about the lost parts.
fn in_words(lost: &Lost) -> Vec<String> {
    if lost.is_nothing() {
        return Vec::new();
    }
    let mut lines = vec![format!("lost: {}", lost.in_words())];
    let topic = |(topic, count): (&String, &u64)| format!("{topic} {count}");
    let topics: Vec<String> = lost.topics.iter().map(topic).collect();
    if !topics.is_empty() {
        lines.push(format!("messages by topic: {}", topics.join(", ")));
    }
    if lost.scene {
        lines.push(
            "the compiled scene can be put back: prepare it again, and repeat this command with \
             --scene FILE --overwrite"
                .to_owned(),
        );
    }
    lines
}

/// Path of the repaired copy: `a/session-repaired.mcap` for `a/session.mcap`.
fn repaired_path(session: &Path) -> PathBuf {
    let stem = session.file_stem().unwrap_or_default().to_string_lossy();
    session.with_file_name(format!("{stem}-repaired.mcap"))
}
