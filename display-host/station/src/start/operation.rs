//! An operation of the launcher: the process `calot run`, which has its own window.

use std::collections::VecDeque;
use std::ffi::OsString;
use std::io::{BufRead as _, BufReader};
use std::os::unix::process::CommandExt as _;
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use display_host::ui::launcher::StartForm;

use crate::say;

/// Largest number of lines of output that are kept.
const LINES_KEPT: usize = 12;
/// Time that an operation may take to end when asked. Then the user may kill it, without a report.
const PATIENCE_TO_END: Duration = Duration::from_secs(5);
/// Longest wait for the last output: another process may hold the pipe open for longer.
const PATIENCE_TO_READ: Duration = Duration::from_millis(500);

/// A running operation.
pub(super) struct Operation {
    child: Child,
    pub(super) form: StartForm,
    /// True if the expert operates and the trainee watches.
    pub(super) watched: bool,
    /// Folder of its session.
    pub(super) out: PathBuf,
    last_lines: Arc<Mutex<VecDeque<String>>>,
    reader: Option<JoinHandle<()>>,
    /// Time of the request to end, if there was one.
    asked: Option<Instant>,
    /// Time when the end of the child was noticed.
    seen: Option<Instant>,
}

impl Operation {
    /// Starts `calot ARGS`.
    pub(super) fn begin(
        args: &[OsString],
        form: StartForm,
        watched: bool,
        out: PathBuf,
    ) -> std::io::Result<Self> {
        let mut child = Command::new(std::env::current_exe()?)
            .args(args)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            // A terminal's Ctrl-C reaches only the launcher, which then ends the operation in
            // order.
            .process_group(0)
            .spawn()?;
        let last_lines = Arc::new(Mutex::new(VecDeque::new()));
        let reader = child.stderr.take().map(|stderr| {
            let kept = Arc::clone(&last_lines);
            std::thread::spawn(move || {
                let lines = BufReader::new(stderr).split(b'\n');
                for line in lines.map_while(Result::ok) {
                    let line = String::from_utf8_lossy(&line);
                    say::note(&line);
                    let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
                    if kept.len() == LINES_KEPT {
                        kept.pop_front();
                    }
                    kept.push_back(session::printable(&line));
                }
            })
        });
        Ok(Self {
            child,
            form,
            watched,
            out,
            last_lines,
            reader,
            asked: None,
            seen: None,
        })
    }

    /// Last lines of the operation's output, oldest first.
    pub(super) fn last_lines(&self) -> Vec<String> {
        let lines = self
            .last_lines
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        lines.iter().cloned().collect()
    }

    /// Exit status, once the operation has ended and its output is read, or
    /// [`PATIENCE_TO_READ`] is over.
    pub(super) fn ended(&mut self) -> Option<ExitStatus> {
        let status = self.child.try_wait().ok().flatten()?;
        let seen = *self.seen.get_or_insert_with(Instant::now);
        let reads = self.reader.as_ref().is_some_and(|it| !it.is_finished());
        (!reads || seen.elapsed() >= PATIENCE_TO_READ).then_some(status)
    }

    /// True if the operation was asked to end.
    pub(super) fn is_ending(&self) -> bool {
        self.asked.is_some()
    }

    /// True if the request to end is so old that the operation may hang.
    pub(super) fn is_overdue(&self) -> bool {
        self.asked.is_some_and(|it| it.elapsed() >= PATIENCE_TO_END)
    }

    /// Asks the operation to end. It then writes its report.
    pub(super) fn stop(&mut self) {
        self.asked.get_or_insert_with(Instant::now);
        if let Some(pid) = rustix::process::Pid::from_raw(self.child.id().cast_signed()) {
            let _ = rustix::process::kill_process(pid, rustix::process::Signal::TERM);
        }
    }

    /// Kills the operation. Its child processes end with it.
    pub(super) fn kill(&mut self) {
        let _ = self.child.kill();
    }

    pub(super) fn wait(&mut self) {
        let _ = self.child.wait();
    }
}
