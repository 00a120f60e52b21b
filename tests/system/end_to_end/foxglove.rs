//! Foxglove's own packages read sessions: its MCAP reader and its published messages, from the npm
//! registry.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Packages from the npm registry, at the versions that were tried.
const PACKAGES: [&str; 4] = [
    "@foxglove/schemas@2.1.0",
    "@mcap/core@2.2.2",
    "@mcap/nodejs@1.0.2",
    "protobufjs@7.6.6",
];

/// Program that reads the files it is given and fails at the first message that is not as Foxglove
/// publishes it.
const PROGRAM: &str = include_str!("foxglove.mjs");

/// Lines of topic, message and count, one for each channel of the files. `None` if there is no
/// Node.js, or its registry cannot be reached.
///
/// # Panics
///
/// If a file cannot be read, or a message differs from Foxglove's.
pub(super) fn channels(files: &[&Path]) -> Option<String> {
    let folder = packages()?;
    let program = folder.join("foxglove.mjs");
    std::fs::write(&program, PROGRAM).expect("written");
    let output = Command::new("node").arg(&program).args(files).output();
    let output = output.expect("node runs");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    Some(String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Folder with the packages.
fn packages() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("node");
    std::fs::create_dir_all(&folder).expect("a folder in target");
    let mut install = Command::new("npm");
    install
        .args(["install", "--no-save", "--ignore-scripts", "--no-fund"])
        .args(["--no-audit", "--prefix"])
        .arg(&folder)
        .args(PACKAGES);
    if !install.output().is_ok_and(|it| it.status.success()) {
        println!("skipped: npm cannot install {PACKAGES:?} (Debian: apt install npm)");
        return None;
    }
    Some(folder)
}
