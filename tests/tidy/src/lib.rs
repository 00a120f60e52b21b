//! Reads the checkout's tracked files for the tests of this package.
//!
//! Each test fails with one line per finding, most of the form `file:line: finding; remedy`.

use std::path::{Path, PathBuf};
use std::process::Command;

/// A file of the checkout.
pub struct Tracked {
    /// Path from the root of the checkout, with `/` between its parts.
    pub path: String,
    /// The file's text.
    pub text: String,
}

/// Root of the checkout.
#[must_use]
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Text files, tracked or new but not ignored, whose path ends in `ending`, sorted. A file that the
/// working tree has deleted is left out.
///
/// # Panics
///
/// If git cannot list the files.
#[must_use]
pub fn tracked(ending: &str) -> Vec<Tracked> {
    let root = root();
    let out = Command::new("git")
        .args([
            "ls-files",
            "-z",
            "--cached",
            "--others",
            "--exclude-standard",
        ])
        .current_dir(&root)
        .output()
        .expect("git lists the tracked files");
    assert!(
        out.status.success(),
        "git ls-files: {}",
        String::from_utf8_lossy(&out.stderr)
    );
    let mut files: Vec<Tracked> = String::from_utf8_lossy(&out.stdout)
        .split('\0')
        .filter(|path| !path.is_empty() && path.ends_with(ending))
        .filter_map(|path| {
            let text = std::fs::read_to_string(root.join(path)).ok()?;
            Some(Tracked {
                path: path.to_owned(),
                text,
            })
        })
        .collect();
    files.sort_by(|a, b| a.path.cmp(&b.path));
    files.dedup_by(|a, b| a.path == b.path);
    files
}

/// Fails with the findings, one per line.
///
/// # Panics
///
/// If there is a finding.
pub fn report(findings: &[String]) {
    assert!(
        findings.is_empty(),
        "{} findings\n{}",
        findings.len(),
        findings.join("\n")
    );
}
