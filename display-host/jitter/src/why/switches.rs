//! Reads the context switches of one core through `perf_event_open`. It serves machines on which
//! only root may read tracefs, but a user may count events. It does not see interrupts and
//! softirqs. Their time counts as time of the thread that they interrupt.

use std::collections::HashMap;
use std::fs;
use std::io::ErrorKind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use perf_event::data::Record;
use perf_event::data::SwitchCpuWide;
use perf_event::events::Software;
use perf_event::{Builder, Clock, SampleFlag, Sampler};

use super::course::{Course, Event};
use super::tracer::monotonic_ns;

/// Interval between two readings.
const READ_EVERY: Duration = Duration::from_millis(20);
/// Size of the buffer: 16 000 records, as large as Linux grants every user
/// (`kernel.perf_event_mlock_kb`).
const BUFFER_BYTES: usize = 512 << 10;
/// Largest number of threads' names that are kept. A full table is emptied, so memory is constant.
const NAMES_MAX: usize = 1000;
/// File of the setting that decides whether a user may read switches.
const PARANOID: &str = "/proc/sys/kernel/perf_event_paranoid";

/// Running reader of the switches of a core. It ends when dropped.
#[derive(Debug)]
pub struct Switches {
    course: Arc<Mutex<Course>>,
    stop: Arc<AtomicBool>,
    reader: Option<JoinHandle<()>>,
}

impl Switches {
    /// Starts to read.
    ///
    /// # Errors
    ///
    /// The permission that is missing, and its remedy.
    pub fn begin(core: usize) -> Result<Self, String> {
        let told = |error: &std::io::Error| {
            let paranoid = fs::read_to_string(PARANOID).unwrap_or_default();
            refused(core, error, paranoid.trim())
        };
        let opened = Builder::new(Software::DUMMY)
            .any_pid()
            .one_cpu(core)
            .include_kernel()
            .context_switch(true)
            .sample_id_all(true)
            .sample(SampleFlag::TID | SampleFlag::TIME)
            .clockid(Clock::MONOTONIC)
            .build();
        let counter = opened.map_err(|error| told(&error))?;
        let mut sampler = counter
            .sampled(BUFFER_BYTES)
            .map_err(|error| told(&error))?;
        let enabled = sampler.as_counter_mut().enable();
        enabled.map_err(|error| told(&error))?;
        let (course, stop) = (
            Arc::<Mutex<Course>>::default(),
            Arc::<AtomicBool>::default(),
        );
        let (into, asked) = (Arc::clone(&course), Arc::clone(&stop));
        let reader = std::thread::Builder::new()
            .name("calot-why".to_owned())
            .spawn(move || {
                let mut names = Names::default();
                while !asked.load(Ordering::Relaxed) {
                    read(&mut sampler, &mut names, &into);
                    std::thread::sleep(READ_EVERY);
                }
            })
            .map_err(|error| format!("cannot start the thread that reads switches: {error}"))?;
        Ok(Self {
            course,
            stop,
            reader: Some(reader),
        })
    }

    /// Course of the core so far.
    pub fn course(&self) -> MutexGuard<'_, Course> {
        self.course.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Switches {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(reader) = self.reader.take() {
            let _ = reader.join();
        }
    }
}

/// Reads the records that have come. The kernel writes a switch as it happens, so all switches
/// before the reading are known after it.
fn read(sampler: &mut Sampler, names: &mut Names, into: &Mutex<Course>) {
    let begun_ns = monotonic_ns();
    let mut course = into.lock().unwrap_or_else(PoisonError::into_inner);
    while let Some(record) = sampler.next_record() {
        let at_ns = time_ns(&record.to_contiguous());
        match record.parse_record() {
            // The record of the thread that leaves names the one that comes.
            Ok(Record::SwitchCpuWide(SwitchCpuWide::Out { pid, tid })) => {
                let next = names.of(pid, tid);
                course.take(Event::Switch { next }, at_ns);
            }
            Ok(Record::Lost(lost)) => course.take(Event::Lost(lost.lost), at_ns),
            _ => {}
        }
    }
    course.known_to_ns = course.known_to_ns.max(begun_ns);
}

/// Time of a record, which its last eight bytes hold.
fn time_ns(bytes: &[u8]) -> u64 {
    bytes
        .last_chunk::<8>()
        .map_or(0, |time| u64::from_ne_bytes(*time))
}

/// Names of threads by their id.
#[derive(Debug, Default)]
struct Names(HashMap<u32, String>);

impl Names {
    fn of(&mut self, process: u32, thread: u32) -> &str {
        if self.0.len() >= NAMES_MAX {
            self.0.clear();
        }
        self.0.entry(thread).or_insert_with(|| match thread {
            0 => "swapper/".to_owned(),
            _ => fs::read_to_string(format!("/proc/{process}/task/{thread}/comm")).map_or_else(
                // It has ended since.
                |_| format!("thread {thread}"),
                |name| name.trim_end().to_owned(),
            ),
        })
    }
}

fn refused(core: usize, error: &std::io::Error, paranoid: &str) -> String {
    let what = format!("perf_event_open on core {core}: {error}");
    match error.kind() {
        ErrorKind::PermissionDenied => format!(
            "{what}; kernel.perf_event_paranoid is {paranoid}, and other threads may be seen from 0 \
             down: `sudo sysctl kernel.perf_event_paranoid=0`, or CAP_PERFMON"
        ),
        ErrorKind::Unsupported | ErrorKind::NotFound => {
            format!("{what}; this kernel takes it with CONFIG_PERF_EVENTS")
        }
        _ => what,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_switches_of_a_core_name_the_threads_that_run() {
        let switches = match Switches::begin(0) {
            Ok(switches) => switches,
            Err(missing) => {
                // It is not permitted here. The error must name the call and the core.
                assert!(missing.contains("perf_event_open on core 0"), "{missing}");
                return;
            }
        };
        // Sleeping makes this very thread come and go, if it runs on that core at all.
        let start = std::time::Instant::now();
        while switches.course().events < 20 && start.elapsed() < Duration::from_secs(20) {
            std::thread::sleep(Duration::from_millis(1));
        }
        let course = switches.course();
        assert!(course.events >= 20, "{} events", course.events);
        let now_ns = monotonic_ns();
        let slices = course.between(now_ns - 20_000_000_000, now_ns);
        assert!(!slices.is_empty() && slices.iter().all(|slice| !slice.name.is_empty()));
        let is_recent = |ns: u64| now_ns.abs_diff(ns) < 30_000_000_000;
        assert!(
            is_recent(course.known_to_ns),
            "{} {now_ns}",
            course.known_to_ns
        );
        assert!(slices.iter().skip(1).all(|slice| is_recent(slice.from_ns)));
    }

    #[test]
    fn the_missing_permission_is_named() {
        let denied = std::io::Error::from(ErrorKind::PermissionDenied);
        let words = refused(3, &denied, "2");
        assert!(
            words.contains("core 3") && words.contains("kernel.perf_event_paranoid is 2"),
            "{words}"
        );
        assert!(words.contains("CAP_PERFMON"), "{words}");
        let none = refused(3, &std::io::Error::from(ErrorKind::Unsupported), "");
        assert!(none.contains("CONFIG_PERF_EVENTS"), "{none}");
    }

    #[test]
    fn a_thread_that_has_ended_has_its_number_and_names_are_bounded() {
        let mut names = Names::default();
        assert_eq!(names.of(0, 0), "swapper/");
        assert_eq!(names.of(u32::MAX, u32::MAX), format!("thread {}", u32::MAX));
        let own = std::process::id();
        let name = names.of(own, own).to_owned();
        assert!(!name.is_empty() && !name.starts_with("thread "), "{name}");
        for thread in 0..3000 {
            names.of(u32::MAX, u32::MAX - thread);
        }
        assert!(names.0.len() <= NAMES_MAX);
    }

    #[test]
    fn the_time_is_the_end_of_a_record() {
        let mut bytes = vec![9; 16];
        bytes.extend(77u64.to_ne_bytes());
        assert_eq!((time_ns(&bytes), time_ns(&[1])), (77, 0));
    }
}
