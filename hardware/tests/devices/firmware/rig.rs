//! Runs `pty.c` as a device.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

use tempfile::TempDir;

use super::compiler::{Language, compile, path};

/// The compiled program.
pub(super) struct Program {
    file: PathBuf,
    folder: TempDir,
}

impl Program {
    pub(super) fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let file = compile(Language::C, &path("firmware/pty.c"), &[], &folder);
        Self { file, folder }
    }

    /// Starts a device with these arguments, and waits until it listens.
    pub(super) fn start(&self, words: &[&str]) -> Rig<'_> {
        let line = self.folder.path().join("rig");
        let mut program = Command::new(&self.file)
            .args(words)
            .arg(&line)
            .stdout(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let mut said = String::new();
        BufReader::new(program.stdout.take().expect("a pipe"))
            .read_line(&mut said)
            .expect("a line");
        assert!(said.starts_with("/dev/pts/"), "{words:?}: {said}");
        Rig {
            program,
            line,
            _made_of: self,
        }
    }

    /// Starts a device with one mistake. `mistake` is the name, followed by `=` and a number if the
    /// mistake has one.
    pub(super) fn mistaken(&self, mistake: &str) -> Rig<'_> {
        self.start(&["--fault", mistake])
    }
}

/// A running device. Dropping it ends its process.
pub(super) struct Rig<'a> {
    program: Child,
    pub(super) line: PathBuf,
    /// The folder of this program holds the link `line`.
    _made_of: &'a Program,
}

impl Drop for Rig<'_> {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}
