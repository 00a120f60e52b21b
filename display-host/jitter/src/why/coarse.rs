//! Guesses the cause of a late tick from counters that every user may read. It serves machines on
//! which only root may use the tracers.
//!
//! The counters are read every 50 ms from another core: time stolen by the hypervisor, interrupts
//! and softirqs of the tick's core, and involuntary context switches of the tick's thread. The lost
//! time of a late tick is attributed to whatever rose unusually in its interval. That is coarse. It
//! names one suspect, and cannot tell apart two things that rise together.

use std::collections::{BTreeMap, VecDeque};
use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use super::tracer::monotonic_ns;
use super::{Loss, What};
use crate::kernel::{self, TICK_THREAD};

/// Interval between two readings. A reading takes some 0.2 ms of another core.
const READ_EVERY: Duration = Duration::from_millis(50);
/// Intervals kept: ten seconds.
const INTERVALS_MAX: usize = 200;
/// Share that the newest interval has in the running means. The means follow within twenty
/// intervals, a second.
const NEW_SHARE: f64 = 0.05;
/// Deviations above its mean at which a count is unusual. Counts of independent events spread by
/// the root of their mean, so three deviations are exceeded once in 700 intervals.
const UNUSUAL: f64 = 3.0;

/// Name of the local timer's interrupt. Every tick and every sleeping thread makes it rise, so it
/// is no cause.
const LOCAL_TIMER: &str = "LOC";

/// Kind and name of a counter.
type Key = (What, String);

/// Increase of the counters in an interval.
#[derive(Debug, Clone, Default)]
pub struct Rise {
    from_ns: u64,
    to_ns: u64,
    /// Time that the hypervisor took from the core, ms.
    stolen_ms: u64,
    /// Involuntary context switches of the tick's thread.
    switches: u64,
    /// Interrupt or softirq that rose most unusually.
    suspect: Option<Key>,
}

/// Counters at one moment.
#[derive(Debug, Clone, Default)]
struct Reading {
    at_ns: u64,
    stolen_ms: u64,
    switches: u64,
    counts: BTreeMap<Key, u64>,
}

/// Usual increase of each counter, and the latest intervals.
#[derive(Debug, Default)]
pub struct Rises {
    last: Option<Reading>,
    means: BTreeMap<Key, f64>,
    latest: VecDeque<Rise>,
}

impl Rises {
    fn take(&mut self, reading: Reading) {
        let Some(last) = self.last.replace(reading.clone()) else {
            return;
        };
        let mut rise = Rise {
            from_ns: last.at_ns,
            to_ns: reading.at_ns,
            stolen_ms: reading.stolen_ms.saturating_sub(last.stolen_ms),
            switches: reading.switches.saturating_sub(last.switches),
            suspect: None,
        };
        let mut worst = UNUSUAL;
        for (key, count) in reading.counts {
            let before = last.counts.get(&key).copied().unwrap_or(count);
            let more = count.saturating_sub(before) as f64;
            let mean = self.means.entry(key.clone()).or_insert(more);
            let deviations = (more - *mean) / mean.max(1.0).sqrt();
            *mean += NEW_SHARE * (more - *mean);
            if deviations > worst {
                worst = deviations;
                rise.suspect = Some(key);
            }
        }
        if self.latest.len() >= INTERVALS_MAX {
            self.latest.pop_front();
        }
        self.latest.push_back(rise);
    }

    /// Time up to which the counters were read, ns.
    pub fn known_to_ns(&self) -> u64 {
        self.last.as_ref().map_or(0, |last| last.at_ns)
    }

    /// Cause to which a tick lost `lost_ns` from `due_ns` on. `None` if nothing is known of that
    /// time.
    pub fn cause(&self, due_ns: u64, lost_ns: u64) -> Option<Loss> {
        let end_ns = due_ns + lost_ns;
        let overlaps = |it: &&Rise| it.from_ns < end_ns && due_ns < it.to_ns;
        let mut during = self.latest.iter().filter(overlaps).peekable();
        during.peek()?;
        let (mut stolen_ms, mut switches, mut suspect) = (0, 0, None);
        for rise in during {
            stolen_ms += rise.stolen_ms;
            switches += rise.switches;
            suspect = suspect.or(rise.suspect.as_ref());
        }
        let (what, name) = match (stolen_ms, switches, suspect) {
            (1.., _, _) => (What::Steal, "the host counted time as stolen"),
            (0, 1.., _) => (What::Thread, "a thread that displaced the tick"),
            (0, 0, Some((what, name))) => (*what, name.as_str()),
            (0, 0, None) => (What::Unseen, "no counter rose"),
        };
        Some(Loss {
            what,
            name: name.to_owned(),
            ns: lost_ns,
        })
    }
}

/// A thread that reads the counters.
#[derive(Debug)]
pub struct Counters {
    rises: Arc<Mutex<Rises>>,
    /// Process of the tick's thread; 0 until it is known.
    process: Arc<AtomicU32>,
    stop: Arc<AtomicBool>,
    reader: Option<JoinHandle<()>>,
}

impl Counters {
    /// Starts to read the counters of a core. `process` is the process of the tick's thread, 0
    /// until it is known.
    ///
    /// # Errors
    ///
    /// The system's error, if it cannot start a thread.
    pub fn begin(core: usize, process: Arc<AtomicU32>) -> std::io::Result<Self> {
        let (rises, stop) = (Arc::<Mutex<Rises>>::default(), Arc::<AtomicBool>::default());
        let reader = {
            let (rises, process, stop) = (rises.clone(), process.clone(), stop.clone());
            let read = move || {
                let mut task = None;
                while !stop.load(Ordering::Relaxed) {
                    let reading = Reading::now(core, process.load(Ordering::Relaxed), &mut task);
                    rises
                        .lock()
                        .unwrap_or_else(PoisonError::into_inner)
                        .take(reading);
                    std::thread::sleep(READ_EVERY);
                }
            };
            let thread = std::thread::Builder::new().name("calot-why".to_owned());
            thread.spawn(read)?
        };
        Ok(Self {
            rises,
            process,
            stop,
            reader: Some(reader),
        })
    }

    /// Says which process has the tick's thread.
    pub fn watch(&self, process: u32) {
        self.process.store(process, Ordering::Relaxed);
    }

    /// Passes the intervals so far to `of`.
    pub fn with<T>(&self, of: impl FnOnce(&Rises) -> T) -> T {
        of(&self.rises.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Drop for Counters {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(reader) = self.reader.take() {
            let _ = reader.join();
        }
    }
}

impl Reading {
    fn now(core: usize, process: u32, task: &mut Option<PathBuf>) -> Self {
        let read = |path: &str| fs::read_to_string(path).unwrap_or_default();
        let mut counts = BTreeMap::new();
        for (what, path) in [
            (What::Interrupt, "/proc/interrupts"),
            (What::Softirq, "/proc/softirqs"),
        ] {
            let all = kernel::interrupts(&read(path), core);
            for (name, count) in all.into_iter().filter(|it| it.0 != LOCAL_TIMER) {
                *counts.entry((what, name)).or_default() += count;
            }
        }
        if task.is_none() && process > 0 {
            *task = kernel::task(process, TICK_THREAD);
        }
        let status = task
            .as_ref()
            .map(|task| fs::read_to_string(task.join("status")));
        let status = status.and_then(Result::ok).unwrap_or_default();
        Self {
            at_ns: monotonic_ns(),
            stolen_ms: kernel::stolen_ms(core).unwrap_or(0),
            switches: kernel::switches(&status, "nonvoluntary_ctxt_switches").unwrap_or(0),
            counts,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn reading(at_ms: u64, change: impl FnOnce(&mut Reading)) -> Reading {
        let mut reading = Reading {
            at_ns: at_ms * MS,
            ..Reading::default()
        };
        // Both counters rise by 10 in each 50 ms.
        for name in ["virtio0", "eth0"] {
            let key = (What::Interrupt, name.to_owned());
            reading.counts.insert(key, at_ms / 5);
        }
        change(&mut reading);
        reading
    }

    fn cause_after(change: impl FnOnce(&mut Reading)) -> Option<Loss> {
        let mut rises = Rises::default();
        for i in 0..20 {
            rises.take(reading(50 * i, |_| ()));
        }
        rises.take(reading(1000, change));
        assert_eq!(rises.known_to_ns(), 1000 * MS);
        rises.cause(980 * MS, MS)
    }

    #[test]
    fn a_late_tick_is_laid_to_what_rose_meanwhile() {
        let told = |loss: Option<Loss>| loss.map(|loss| (loss.what, loss.name, loss.ns));
        let expected = |what, name: &str| Some((what, name.to_owned(), MS));
        let none = cause_after(|_| ());
        assert_eq!(told(none), expected(What::Unseen, "no counter rose"));
        let burst = cause_after(|it| {
            it.counts.insert((What::Interrupt, "eth0".to_owned()), 400);
        });
        assert_eq!(told(burst), expected(What::Interrupt, "eth0"));
        let displaced = cause_after(|it| it.switches = 1);
        assert_eq!(
            told(displaced),
            expected(What::Thread, "a thread that displaced the tick")
        );
        let stolen = cause_after(|it| (it.stolen_ms, it.switches) = (10, 1));
        assert_eq!(
            told(stolen),
            expected(What::Steal, "the host counted time as stolen")
        );
    }

    #[test]
    fn nothing_is_said_of_a_time_before_the_counters() {
        let mut rises = Rises::default();
        assert!(rises.cause(0, MS).is_none());
        for i in 0..1000 {
            rises.take(reading(50 * i, |_| ()));
        }
        assert_eq!(rises.latest.len(), INTERVALS_MAX);
        assert!(rises.cause(0, MS).is_none());
    }

    #[test]
    fn this_machines_counters_are_read_while_somebody_listens() {
        let counters = Counters::begin(0, Arc::default()).unwrap();
        counters.watch(std::process::id());
        while counters.with(|rises| rises.latest.is_empty()) {
            std::thread::sleep(Duration::from_millis(5));
        }
        let known = counters.with(Rises::known_to_ns);
        assert!(known > 0 && known <= monotonic_ns());
    }
}
