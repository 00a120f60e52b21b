//! Finds the programs that have a line open, so that a person knows which one to stop.

use std::fs;
use std::path::Path;

/// Most programs that are named.
const NAMED: usize = 3;

/// Programs that have `path` open, as text: "calot (process 4711)". `None` if nobody is seen: only
/// root sees the programs of other users.
pub(crate) fn holders(path: &Path) -> Option<String> {
    let line = path.canonicalize().ok()?;
    let programs = fs::read_dir("/proc").ok()?.flatten();
    let holders: Vec<String> = programs
        .filter(|program| has_open(&program.path(), &line))
        .filter_map(|program| {
            let number = program.file_name().into_string().ok()?;
            let name = fs::read_to_string(program.path().join("comm")).ok()?;
            // A program may call itself anything.
            let name: String = name.chars().filter(|it| !it.is_control()).collect();
            Some(format!("{name} (process {number})"))
        })
        .take(NAMED)
        .collect();
    (!holders.is_empty()).then(|| holders.join(", "))
}

fn has_open(program: &Path, line: &Path) -> bool {
    fs::read_dir(program.join("fd")).is_ok_and(|files| {
        files
            .flatten()
            .any(|file| fs::read_link(file.path()).is_ok_and(|it| it == line))
    })
}
