//! Tells the program its commit and profile.

use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let git = |args: &[&str]| {
        let output = Command::new("git").args(args).output().ok()?;
        let text = String::from_utf8(output.stdout).ok()?;
        output.status.success().then(|| text.trim().to_owned())
    };
    // Git notes every commit and every change of branch in this file.
    if let Some(log) = git(&["rev-parse", "--git-path", "logs/HEAD"])
        && std::path::Path::new(&log).exists()
    {
        println!("cargo::rerun-if-changed={log}");
    }
    let commit = git(&["describe", "--always", "--tags"]).unwrap_or_else(|| "unknown".to_owned());
    println!("cargo::rustc-env=CALOT_COMMIT={commit}");
    // Cargo's `PROFILE` is debug or release only, so take the name of the profile from OUT_DIR,
    // which is target/PROFILE/build/calot-HASH/out.
    let out = std::env::var_os("OUT_DIR").unwrap_or_default();
    let profile = std::path::Path::new(&out).ancestors().nth(3);
    let profile = profile.and_then(|it| it.file_name()).unwrap_or_default();
    println!("cargo::rustc-env=CALOT_PROFILE={}", profile.display());
}
