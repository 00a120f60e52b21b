//! Child processes of the station: this program, executed again.

use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt as _;
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::time::{Duration, Instant};

use crate::problem::Problem;

/// Time that a child may take to end when asked. Then it is killed.
const PATIENCE_TO_END: Duration = Duration::from_secs(5);

/// A child process that has reported ready.
#[derive(Debug)]
pub(crate) struct Process {
    name: &'static str,
    child: Child,
    /// Rest of the line with which the child reported ready.
    ready_text: String,
}

/// Error of a child that ended before it was ready. Its own message is on standard error.
#[derive(Debug)]
pub(crate) struct EndedEarly {
    name: &'static str,
    pub(crate) status: ExitStatus,
    /// True if the child printed [`REFUSED`].
    pub(crate) has_refused: bool,
}

impl std::fmt::Display for EndedEarly {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { name, status, .. } = self;
        write!(f, "the {name} ended before it was ready ({status})")
    }
}

impl std::error::Error for EndedEarly {}

/// First word of the line that a child prints on standard output when it is ready.
pub(crate) const READY: &str = "ready";
/// Line that a child prints on standard output when a rule, such as `--must-fit`, makes it refuse
/// its task. A child that fails does not print it.
pub(crate) const REFUSED: &str = "refused";
/// Longest wait for each last line of a child that has ended: another process may hold the pipe
/// open for longer.
const LAST_WORDS: Duration = Duration::from_secs(1);

impl Process {
    /// Starts `calot ARGS` and waits until it is ready. The child shares our standard error.
    pub(crate) fn start(
        name: &'static str,
        args: &[std::ffi::OsString],
        patience: Duration,
        stop: &std::sync::atomic::AtomicBool,
    ) -> Result<Self, Problem> {
        let program = std::env::current_exe()?;
        let mut child = Command::new(program)
            .args(args)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            // The child has a process group of its own, so that a terminal's Ctrl-C reaches only
            // the station. The station then ends its children in order, the controller before the
            // devices.
            .process_group(0)
            .spawn()
            .map_err(|error| format!("cannot start the {name}: {error}"))?;
        let lines = read_lines(&mut child);
        let mut process = Self {
            name,
            child,
            ready_text: String::new(),
        };
        let mut has_refused = false;
        let start = Instant::now();
        loop {
            if let Ok(line) = lines.recv_timeout(Duration::from_millis(20)) {
                if let Some(text) = line.strip_prefix(READY) {
                    process.ready_text = text.trim().to_owned();
                    return Ok(process);
                }
                has_refused |= line == REFUSED;
            }
            if let Some(status) = process.ended()? {
                let rest = std::iter::from_fn(|| lines.recv_timeout(LAST_WORDS).ok());
                let early = EndedEarly {
                    name,
                    status,
                    has_refused: has_refused || rest.take(1000).any(|line| line == REFUSED),
                };
                return Err(early.into());
            }
            if stop.load(std::sync::atomic::Ordering::Relaxed) {
                return Err("stopped while starting".into());
            }
            if start.elapsed() > patience {
                return Err(format!(
                    "the {name} was not ready within {} s; try `calot {name}` by hand",
                    patience.as_secs()
                )
                .into());
            }
        }
    }

    /// Name of the process in messages.
    pub(crate) fn name(&self) -> &'static str {
        self.name
    }

    /// Rest of the line with which the child reported ready.
    pub(crate) fn ready_text(&self) -> &str {
        &self.ready_text
    }

    pub(crate) fn id(&self) -> u32 {
        self.child.id()
    }

    /// Exit status, if the child has ended.
    pub(crate) fn ended(&mut self) -> std::io::Result<Option<ExitStatus>> {
        self.child.try_wait()
    }

    /// Asks the child to end, and kills it if it does not end in time. Returns what went wrong, if
    /// anything.
    pub(crate) fn end(mut self) -> Option<String> {
        self.ask();
        let start = Instant::now();
        while start.elapsed() < PATIENCE_TO_END {
            match self.ended() {
                Ok(Some(status)) if status.success() => return None,
                Ok(Some(status)) => {
                    return Some(format!("the {} failed at its end ({status})", self.name));
                }
                _ => std::thread::sleep(Duration::from_millis(5)),
            }
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
        Some(format!(
            "the {} did not end when asked and was killed",
            self.name
        ))
    }

    fn ask(&self) {
        if let Some(pid) = rustix::process::Pid::from_raw(self.child.id().cast_signed()) {
            let _ = rustix::process::kill_process(pid, rustix::process::Signal::TERM);
        }
    }
}

impl Drop for Process {
    /// After an error, asks a child that still runs to end. Kills it if it does not end in time,
    /// for example because it hangs in a device's library.
    fn drop(&mut self) {
        if let Ok(None) = self.child.try_wait() {
            self.ask();
            let start = Instant::now();
            while start.elapsed() < PATIENCE_TO_END {
                if !matches!(self.child.try_wait(), Ok(None)) {
                    return;
                }
                std::thread::sleep(Duration::from_millis(5));
            }
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
    }
}

/// Reads the child's standard output in a thread, so that its pipe never fills.
fn read_lines(child: &mut Child) -> Receiver<String> {
    let (sender, lines) = mpsc::channel();
    if let Some(stdout) = child.stdout.take() {
        std::thread::spawn(move || {
            for line in BufReader::new(stdout).lines().map_while(Result::ok) {
                // The receiver is dropped once the child is ready. Keep emptying the pipe.
                let _ = sender.send(line);
            }
        });
    }
    lines
}

/// Converts arguments to the form of the operating system.
pub(crate) fn args<const N: usize>(
    words: [&dyn AsRef<std::ffi::OsStr>; N],
) -> Vec<std::ffi::OsString> {
    words.iter().map(|word| word.as_ref().to_owned()).collect()
}

/// Appends `--name value` if there is a value.
pub(crate) fn option(args: &mut Vec<std::ffi::OsString>, name: &str, value: Option<&Path>) {
    if let Some(value) = value {
        args.push(name.into());
        args.push(value.into());
    }
}
