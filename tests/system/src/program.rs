//! A program that runs during a test.

use std::io::Read;
use std::process::{Child, Command, ExitStatus, Output, Stdio};
use std::thread::JoinHandle;

use crate::{documents, wait_until};

/// Thread that reads a stream of the program. It reads continuously, so that the pipe never fills.
/// `None` once its text has been taken.
type Told = Option<JoinHandle<Vec<u8>>>;

/// A program that is killed on drop. If the test fails, the program's output is shown.
pub struct Program {
    child: Child,
    stdout: Told,
    stderr: Told,
    /// True if its standard output is JSON.
    is_json: bool,
}

impl Program {
    /// Starts a program and reads its output.
    ///
    /// # Panics
    ///
    /// If it cannot be started.
    pub fn start(command: &mut Command) -> Self {
        let is_json = documents::is_asked_for(command);
        let command = command.stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("it starts");
        Self {
            stdout: child.stdout.take().map(read),
            stderr: child.stderr.take().map(read),
            child,
            is_json,
        }
    }

    /// Process id.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Exit status, if the program has ended.
    ///
    /// # Panics
    ///
    /// If the system does not give the status.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        self.child.try_wait().expect("a child can be waited for")
    }

    /// Waits for the end of the program.
    ///
    /// # Panics
    ///
    /// If it does not end within [`PATIENCE`](crate::PATIENCE), or if it was asked for JSON and its
    /// output does not follow the schemas.
    #[must_use]
    #[track_caller]
    pub fn finish(mut self) -> Output {
        let mut status = None;
        wait_until("the program's end", || {
            status = self.ended();
            status.is_some()
        });
        let output = Output {
            status: status.unwrap_or_default(),
            stdout: whole(&mut self.stdout),
            stderr: whole(&mut self.stderr),
        };
        if self.is_json {
            documents::check_output(&output.stdout);
        }
        output
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let before = self.child.try_wait();
        let _ = self.child.kill();
        let _ = self.child.wait();
        if std::thread::panicking() {
            let [out, err] = [&mut self.stdout, &mut self.stderr].map(whole);
            eprintln!(
                "A program beside this test (how it had ended: {before:?}) said:\n{}{}",
                String::from_utf8_lossy(&err),
                String::from_utf8_lossy(&out)
            );
        }
    }
}

/// Starts a thread that reads a stream to its end.
fn read(mut stream: impl Read + Send + 'static) -> JoinHandle<Vec<u8>> {
    std::thread::spawn(move || {
        let mut bytes = Vec::new();
        let _ = stream.read_to_end(&mut bytes);
        bytes
    })
}

/// Waits for the end of a stream, and takes its text.
fn whole(told: &mut Told) -> Vec<u8> {
    let told = told.take().map(JoinHandle::join);
    told.and_then(Result::ok).unwrap_or_default()
}
