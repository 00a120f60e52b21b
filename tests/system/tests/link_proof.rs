//! Proves that the tick links without a panic path and without an allocator. The test builds
//! `tests/link-proof` as it is, and then with a panic or an allocation added, to show that the
//! build notices.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn package() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../link-proof")
}

/// Builds the proof with `features`. Cargo has already fetched all dependencies with the workspace.
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
        .env_remove("RUSTC_WORKSPACE_WRAPPER")
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

/// The tick computes the same bits on every machine. It calls no function of the system's maths
/// library, because those differ by version and choose their code by processor. It uses no fused
/// multiply-add, which rounds once where two operations round twice.
#[test]
fn the_tick_uses_no_maths_library_and_no_fused_multiply_add() {
    let output = build("");
    assert!(
        output.status.success(),
        "the tick does not link: see the other test"
    );
    let proof = Path::new(env!("CARGO_TARGET_TMPDIR")).join("link-proof/release/link-proof");
    let tell = |tool: &str, option: &str| {
        let output = Command::new(tool).arg(option).arg(&proof).output();
        let output = output.unwrap_or_else(|e| panic!("{tool}, which comes with the linker: {e}"));
        assert!(output.status.success(), "{tool}");
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    let imported = tell("nm", "-u");
    let imported: Vec<&str> = imported
        .split_whitespace()
        .filter(|word| *word != "U")
        .collect();
    let moves_bytes = ["memcpy", "memmove", "memset", "memcmp", "bcmp"];
    let others: Vec<_> = imported
        .iter()
        .filter(|name| !moves_bytes.contains(name))
        .collect();
    assert!(others.is_empty(), "the tick calls {others:?}");
    let code = tell("objdump", "-d");
    assert!(code.contains("mulps"), "the tick's code was not understood");
    let fused = ["vfmadd", "vfmsub", "vfnmadd", "vfnmsub"];
    let found = code
        .lines()
        .find(|line| fused.iter().any(|name| line.contains(name)));
    assert_eq!(found, None);
    // The tick may not link Rust's maths library either, although some of its functions are exact.
    let own = tell("nm", "-C");
    assert!(!own.contains("libm::"), "{own}");
}

#[test]
fn a_panic_in_the_tick_does_not_link() {
    check_fails_with("broken-panic", "the_tick_can_panic");
}

#[test]
fn an_allocation_in_the_tick_does_not_link() {
    check_fails_with("broken-alloc", "no global memory allocator found");
}

/// The proof is built with the versions of dependencies that the workspace uses, so that it needs
/// no network.
#[test]
fn link_proof_is_about_the_same_versions() {
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
