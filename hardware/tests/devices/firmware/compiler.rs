//! Calls the machine's C and C++ compilers to build programs and libraries from
//! `hardware/firmware`.

use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::process::Command;

use tempfile::TempDir;

/// Options that turn warnings into errors.
const STRICT: [&str; 6] = [
    "-Wall",
    "-Wextra",
    "-Wpedantic",
    "-Wconversion",
    "-Wshadow",
    "-Werror",
];

/// Language as which the header is compiled.
#[derive(Debug, Clone, Copy)]
pub(super) enum Language {
    C,
    Cpp,
}

impl Language {
    const fn compiler(self) -> (&'static str, &'static str, &'static str) {
        match self {
            Self::C => ("cc", "gcc", "-std=c99"),
            Self::Cpp => ("c++", "g++", "-std=c++11"),
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::C => "c",
            Self::Cpp => "c++",
        }
    }
}

/// Path of a file inside this package.
pub(super) fn path(below: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(below)
}

/// Compiles `source` with `options` into `folder`, and returns the result's path. Panics with the
/// name of the package to install if there is no compiler, and with the compiler's messages if it
/// finds a mistake.
pub(super) fn compile(
    language: Language,
    source: &Path,
    options: &[&str],
    folder: &TempDir,
) -> PathBuf {
    let (compiler, package, standard) = language.compiler();
    let stem = source.file_stem().expect("a file").to_string_lossy();
    let made = folder.path().join(&*stem);
    let out = Command::new(compiler)
        .args([standard, "-O1", "-x", language.name()])
        .args(STRICT)
        .args(options)
        .arg("-I")
        .arg(path("firmware"))
        .arg(source)
        .arg("-o")
        .arg(&made)
        .output();
    let out = match out {
        Ok(out) => out,
        Err(error) if error.kind() == ErrorKind::NotFound => {
            panic!("this machine has no '{compiler}'; install the package {package}")
        }
        Err(error) => panic!("cannot run {compiler}: {error}"),
    };
    let said = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success(), "{}:\n{said}", source.display());
    made
}
