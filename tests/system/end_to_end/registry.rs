//! Python with packages of the Python registry.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Python of an environment of this name, in which packages are installed.
pub(super) struct Python {
    folder: PathBuf,
}

impl Python {
    /// Makes the environment, unless an earlier test did. `None` if the registry cannot be reached.
    pub(super) fn with(name: &str, packages: &[&str]) -> Option<Self> {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let python = Self { folder };
        if !python.program().exists() {
            let mut make = Command::new("python3");
            make.args(["-m", "venv"]).arg(&python.folder);
            if !make.output().is_ok_and(|it| it.status.success()) {
                println!(
                    "skipped: python3 -m venv does not work here (Debian: apt install python3-venv)"
                );
                return None;
            }
        }
        if !python.install(packages) {
            println!("skipped: pip cannot install {packages:?}; is its registry reachable?");
            return None;
        }
        Some(python)
    }

    pub(super) fn program(&self) -> PathBuf {
        self.folder.join("bin/python")
    }

    /// Folder for files of the environment.
    pub(super) fn folder(&self) -> &Path {
        &self.folder
    }

    pub(super) fn install(&self, what: &[&str]) -> bool {
        let mut command = Command::new(self.program());
        command.args(["-m", "pip", "install", "--quiet"]);
        command.arg("--disable-pip-version-check").args(what);
        command.output().is_ok_and(|it| it.status.success())
    }
}
