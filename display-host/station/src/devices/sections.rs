//! Sections of a station file that a command writes. All else stays, comments included.

use std::path::Path;

use hardware::station::StationFile;

use crate::problem::Problem;

/// A section of a station file.
pub(super) struct Section {
    /// Name between its brackets.
    pub(super) head: String,
    /// Its lines.
    pub(super) body: String,
}

impl Section {
    /// The section as text, with an empty line behind it.
    pub(super) fn text(&self) -> String {
        format!("[{}]\n{}\n", self.head, self.body)
    }
}

/// Replaces these sections of a station file and keeps the rest, including comments. `path` appears
/// in errors.
pub(super) fn with_sections(
    path: &Path,
    text: &str,
    sections: &[Section],
) -> Result<String, Problem> {
    let is_head = |line: &str| {
        let mut heads = sections.iter().map(|it| format!("[{}]", it.head));
        heads.any(|head| line.starts_with(&head))
    };
    let mut kept = String::new();
    let mut is_old = false;
    for line in text.lines() {
        let start = line.trim_start();
        if start.starts_with('[') {
            is_old = is_head(start);
        }
        let goes = is_old && (is_head(start) || start.contains('='));
        if !goes || start.starts_with('#') {
            kept.push_str(line);
            kept.push('\n');
        }
    }
    let new: String = sections.iter().map(Section::text).collect();
    let whole = format!("{}\n\n{}\n", kept.trim_end(), new.trim_end());
    // Check that the written file parses.
    StationFile::parse(&whole, path).map_err(|error| {
        format!(
            "the new sections do not fit into this file; give them sections of their own, as in `calot \
             devices --help`: {error}"
        )
    })?;
    Ok(whole)
}
