//! Replaces sections in the text of a station file, and keeps other sections and lines of comment.

use std::path::Path;

use hardware::station::StationFile;

use crate::problem::Problem;

/// A section of a station file.
pub(super) struct Section {
    /// Name between the brackets.
    pub(super) head: String,
    /// Lines with the values.
    pub(super) body: String,
}

impl Section {
    /// The section as text. It ends with an empty line.
    pub(super) fn text(&self) -> String {
        format!("[{}]\n{}\n", self.head, self.body)
    }
}

/// Text of a station file with these sections at the end and the old ones removed, except their
/// lines of comment. `path` appears in errors.
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
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let start = line.trim_start();
        let is_value = start.contains('=') && !start.starts_with(['[', '#']);
        let statement = match is_value {
            true => whole_value(line, &mut lines),
            false => line.to_owned(),
        };
        if start.starts_with('[') {
            is_old = is_head(start);
        }
        let goes = is_old && (is_head(start) || is_value);
        for line in statement.lines() {
            if !goes || line.trim_start().starts_with('#') {
                kept.push_str(line);
                kept.push('\n');
            }
        }
    }
    let new: String = sections.iter().map(Section::text).collect();
    let whole = format!("{}\n\n{}\n", kept.trim_end(), new.trim_end());
    // A file that gives the same values in another form (`frames = { … }`) does not parse with the
    // new sections.
    StationFile::parse(&whole, path).map_err(|error| {
        format!(
            "this file gives the same values in another form; give them sections of their own, as in `calot \
             devices --help`: {error}"
        )
    })?;
    Ok(whole)
}

/// All lines of a value, from `first` to the value's end. Only `first` if the value has no end.
fn whole_value(first: &str, lines: &mut std::str::Lines<'_>) -> String {
    let mut value = first.to_owned();
    let mut rest = lines.clone();
    loop {
        if toml::from_str::<toml::Table>(&value).is_ok() {
            *lines = rest;
            return value;
        }
        let Some(line) = rest.next() else {
            return first.to_owned();
        };
        value.push('\n');
        value.push_str(line);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(old: &str, head: &str, body: &str) -> Result<String, Problem> {
        let (head, body) = (head.to_owned(), body.to_owned());
        with_sections(Path::new("station.toml"), old, &[Section { head, body }])
    }

    #[test]
    fn a_value_over_several_lines_is_removed_as_a_whole() {
        let old = "[frames.world_from_device]\nposition_m = [\n  # from the phantom\n  9.0,\n  9.0, 9.0\n]\n\
                   rotation_xyzw = [0.0, 0.0, 0.0, 1.0]\n\n[pedal]\ndriver = \"rig\"\npath = \"/dev/ttyACM1\"\n";
        let new = "position_m = [1.0, 0.0, 0.0]\nrotation_xyzw = [0.0, 0.0, 0.0, 1.0]\n";
        let written = with(old, "frames.world_from_device", new).unwrap();
        assert!(!written.contains("9.0"), "{written}");
        assert!(written.contains("# from the phantom"), "{written}");
        assert!(written.contains("[pedal]\ndriver"), "{written}");
        assert_eq!(written.matches("position_m").count(), 1, "{written}");
    }

    #[test]
    fn a_line_of_a_value_that_begins_with_a_bracket_is_no_section() {
        let haptic = "[haptic]\ndriver = \"woody\"\npath = \"/dev/ttyACM0\"\n";
        let old =
            format!("{haptic}\n[haptic.felt]\ndevice = \"\"\"\n[Woody]\n\"\"\"\npassed = false\n");
        let written = with(&old, "haptic.felt", "passed = true\n").unwrap();
        assert_eq!(written, format!("{haptic}\n[haptic.felt]\npassed = true\n"));
    }

    #[test]
    fn a_file_that_is_no_toml_is_refused() {
        let error = with("[pedal]\npath = [\n", "haptic.felt", "passed = true\n").unwrap_err();
        assert!(error.to_string().contains("station.toml"), "{error}");
    }
}
