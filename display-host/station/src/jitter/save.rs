//! Writes the files of a report.

use std::path::Path;

use jitter::report::FILE;
use jitter::{Report, table};

use crate::document;
use crate::problem::Problem;

/// Writes all files, each by a rename: a reader sees the old or the new one.
pub(super) fn save(report: &Report, folder: &Path) -> Result<(), Problem> {
    let json = serde_json::to_string(&document::JITTER.of(report.to_json()))?;
    let trace = serde_json::to_string(&jitter::trace(&report.incidents))?;
    for (name, text) in [
        (FILE, json),
        ("jitter.csv", table::csv(report)),
        ("jitter.html", jitter::html(report)),
        ("jitter.trace.json", trace),
    ] {
        let path = folder.join(name);
        let draft = folder.join(format!(".{name}.new"));
        std::fs::write(&draft, text)
            .and_then(|()| std::fs::rename(&draft, &path))
            .map_err(|error| format!("{}: {error}", path.display()))?;
    }
    Ok(())
}
