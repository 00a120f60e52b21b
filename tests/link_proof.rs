//! The tick links without a panic path and without an allocator, and this test would notice if
//! it did not: it builds `tests/link-proof` as it is, and broken in either way.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn package() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("link-proof")
}

/// Builds the proof with `features`; everything it needs was fetched with the workspace.
fn build(features: &str) -> Output {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    Command::new(cargo)
        .args([
            "build",
            "--release",
            "--locked",
            "--offline",
            "--features",
            features,
        ])
        .arg("--manifest-path")
        .arg(package().join("Cargo.toml"))
        .arg("--target-dir")
        .arg(Path::new(env!("CARGO_TARGET_TMPDIR")).join("link-proof"))
        .env_remove("RUSTFLAGS")
        .env_remove("CARGO_ENCODED_RUSTFLAGS")
        .output()
        .expect("cargo runs")
}

fn check_fails_with(features: &str, message: &str) {
    let output = build(features);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success(), "{features} was not noticed");
    assert!(
        said.contains(message),
        "{features} failed for another reason:\n{said}"
    );
}

#[test]
fn the_tick_neither_panics_nor_allocates() {
    let output = build("");
    assert!(
        output.status.success(),
        "a path of the tick can panic (undefined `the_tick_can_panic`) or allocate (no global \
         memory allocator); look for an index, a slice range, an integer division or an unwrap \
         in the last change of rt-core:\n{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn a_panic_in_the_tick_does_not_link() {
    check_fails_with("broken-panic", "the_tick_can_panic");
}

#[test]
fn an_allocation_in_the_tick_does_not_link() {
    check_fails_with("broken-alloc", "no global memory allocator found");
}

/// The proof is about the versions that the workspace uses, and needs no network for others.
#[test]
fn it_is_about_the_same_versions() {
    let versions = |path: PathBuf| {
        let lock = std::fs::read_to_string(&path).expect("a lock file");
        let package = |block: &str| {
            let value = |key: &str| {
                let line = block.lines().find(|line| line.starts_with(key))?;
                Some(line.split('"').nth(1)?.to_owned())
            };
            Some((value("name = ")?, value("version = ")?))
        };
        let packages: Vec<_> = lock.split("[[package]]").filter_map(package).collect();
        assert!(packages.len() > 3, "{} was not understood", path.display());
        packages
    };
    let workspace = versions(package().join("../../Cargo.lock"));
    for found in versions(package().join("Cargo.lock")) {
        assert!(
            found.0 == "link-proof" || workspace.contains(&found),
            "{found:?} is not what the workspace uses: copy Cargo.lock to tests/link-proof and \
             run cargo build there"
        );
    }
}
