//! The machine that is examined. Findings see it only through [`System`] or below a root folder, so
//! that tests can replace it.

use std::path::PathBuf;

use rt_process::trial::Trial;
use rustix::process::{Resource, getrlimit};

/// Default `SCHED_FIFO` priority of the tick.
pub(super) const TICK_PRIORITY: u8 = 80;

/// The machine as files, tried calls and limits.
#[derive(Debug, Clone)]
pub(crate) struct System {
    /// `/`, or a folder of the same layout.
    pub(super) root: PathBuf,
    /// Outcomes of the calls that were tried.
    pub(super) trial: Trial,
    /// Time after which the kernel ends the process of a realtime thread that does not sleep, µs;
    /// `None`: unlimited.
    pub(super) rttime_us: Option<u64>,
}

impl System {
    /// The machine that runs this program, after a trial on this core.
    pub(crate) fn this(core: usize) -> Self {
        Self {
            root: "/".into(),
            trial: Trial::run(core, TICK_PRIORITY),
            rttime_us: getrlimit(Resource::Rttime).maximum,
        }
    }

    pub(super) fn read(&self, path: &str) -> Option<String> {
        let text = std::fs::read_to_string(self.root.join(path)).ok()?;
        Some(text.trim().to_owned())
    }

    pub(super) fn number(&self, path: &str) -> Option<i64> {
        self.read(path)?.parse().ok()
    }

    pub(super) fn entries(&self, folder: &str) -> Vec<PathBuf> {
        let read = std::fs::read_dir(self.root.join(folder));
        let mut paths: Vec<_> = read
            .into_iter()
            .flatten()
            .flatten()
            .map(|e| e.path())
            .collect();
        paths.sort();
        paths
    }
}
