//! A process whose lines a test reads while it runs.

use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use rustix::process::Signal;
use serde_json::Value;
use system_tests::{signal, wait_until};

/// A child that prints a JSON object per line. It ends on drop.
pub(super) struct Process {
    pub(super) child: Child,
    pub(super) lines: Arc<Mutex<Vec<Value>>>,
}

impl Process {
    pub(super) fn start(command: &mut Command) -> Self {
        let piped = command.stdin(Stdio::null()).stdout(Stdio::piped());
        let mut child = piped.spawn().expect("it starts");
        let lines = Arc::new(Mutex::new(Vec::new()));
        let (stdout, into) = (child.stdout.take().expect("piped"), lines.clone());
        std::thread::spawn(move || {
            for line in BufReader::new(stdout).lines().map_while(Result::ok) {
                if let Ok(value) = serde_json::from_str(&line) {
                    into.lock().expect("no panic").push(value);
                }
            }
        });
        Self { child, lines }
    }

    /// Returns the first line that satisfies `which`.
    pub(super) fn says(&self, what: &str, which: impl Fn(&Value) -> bool) -> Value {
        let mut found = None;
        wait_until(what, || {
            let lines = self.lines.lock().expect("no panic");
            found = lines.iter().find(|it| which(it)).cloned();
            found.is_some()
        });
        found.unwrap_or_default()
    }

    /// Asks the process to end and returns its last line. Its exit status must say whether it ever
    /// connected.
    pub(super) fn end(mut self) -> Value {
        signal(self.child.id(), Signal::TERM);
        let status = self.child.wait().expect("it ends");
        let last = self.says("its last words", |it| it["states"].is_number());
        let connected = last["connections"].as_u64() > Some(0);
        assert_eq!(status.success(), connected, "{status}: {last}");
        last
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        signal(self.child.id(), Signal::CONT);
        signal(self.child.id(), Signal::TERM);
        let start = Instant::now();
        while matches!(self.child.try_wait(), Ok(None)) {
            if start.elapsed() > Duration::from_secs(10) {
                let _ = self.child.kill();
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}
