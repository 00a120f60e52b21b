//! Writes the files of a report.

use std::path::Path;

use jitter::report::FILE;
use jitter::{Report, exchange, table};

use crate::document;
use crate::problem::Problem;

/// Folder of the histograms in the formats of other tools.
const HISTOGRAMS: &str = "histograms";

/// Writes all files of a finished run.
pub(super) fn save_all(report: &Report, folder: &Path) -> Result<(), Problem> {
    save(report, folder)?;
    let folder = folder.join(HISTOGRAMS);
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let times = report.times.iter().filter(|(_, times)| times.count() > 0);
    for (name, times) in times {
        for (ending, text) in [
            ("hgrm", exchange::hgrm(times)),
            ("txt", exchange::cyclictest(times)),
        ] {
            write(&folder, &format!("{name}.{ending}"), &text)?;
        }
    }
    Ok(())
}

/// Writes the report's files, each by a rename, so that a reader sees the old or the new file. The
/// histograms are written at the end only: megabytes every few seconds would be a load.
pub(super) fn save(report: &Report, folder: &Path) -> Result<(), Problem> {
    let json = serde_json::to_string(&document::JITTER.of(report.to_json()))?;
    let trace = serde_json::to_string(&jitter::trace(&report.incidents))?;
    for (name, text) in [
        (FILE, json),
        ("jitter.csv", table::csv(report)),
        ("jitter.html", jitter::html(report)),
        ("jitter.trace.json", trace),
    ] {
        write(folder, name, &text)?;
    }
    Ok(())
}

fn write(folder: &Path, name: &str, text: &str) -> Result<(), Problem> {
    let path = folder.join(name);
    let draft = folder.join(format!(".{name}.new"));
    std::fs::write(&draft, text)
        .and_then(|()| std::fs::rename(&draft, &path))
        .map_err(|error| format!("{}: {error}", path.display()).into())
}
