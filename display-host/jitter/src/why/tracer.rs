//! Lets the kernel note what runs on one core, and reads the notes.
//!
//! The kernel writes its events into a buffer of an instance that belongs to this run alone: no
//! setting of another tracer changes. A thread on another core reads them every 20 ms without
//! waiting on them, so that the tick's core never has to wake a reader.

use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Read as _};
use std::os::unix::fs::OpenOptionsExt as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use super::course::{Course, Event};
use super::parse;

/// Places where tracefs may be mounted.
const ROOTS: [&str; 2] = ["/sys/kernel/tracing", "/sys/kernel/debug/tracing"];
/// Beginning of an instance's name. The process's id follows.
const INSTANCE: &str = "calot-why-";
/// Events that tell what runs, by folder. A kernel may lack some of the later ones.
const EVENTS: [&str; 19] = [
    "sched/sched_switch",
    "irq/irq_handler_entry",
    "irq/irq_handler_exit",
    "irq/softirq_entry",
    "irq/softirq_exit",
    "nmi/nmi_handler",
    "irq_vectors/local_timer_entry",
    "irq_vectors/local_timer_exit",
    "irq_vectors/reschedule_entry",
    "irq_vectors/reschedule_exit",
    "irq_vectors/call_function_entry",
    "irq_vectors/call_function_exit",
    "irq_vectors/call_function_single_entry",
    "irq_vectors/call_function_single_exit",
    "irq_vectors/irq_work_entry",
    "irq_vectors/irq_work_exit",
    "irq_vectors/thermal_apic_entry",
    "irq_vectors/thermal_apic_exit",
    "irq_vectors/x86_platform_ipi_entry",
];
/// Number of the first `EVENTS` that are required: without them the trace says nothing.
const NEEDED: usize = 5;
/// Size of the buffer, KiB. It holds one second of a core with 60 000 events a second, each of some
/// 70 bytes.
const BUFFER_KIB: u32 = 4096;
/// Interval between two readings.
const READ_EVERY: Duration = Duration::from_millis(20);

/// A running trace of one core. It is taken down when dropped.
#[derive(Debug)]
pub struct Tracer {
    instance: PathBuf,
    course: Arc<Mutex<Course>>,
    stop: Arc<AtomicBool>,
    reader: Option<JoinHandle<()>>,
}

impl Tracer {
    /// Starts to trace a core.
    ///
    /// # Errors
    ///
    /// The permission or option that is missing, and its remedy.
    pub fn begin(core: usize) -> Result<Self, String> {
        let roots = ROOTS.map(PathBuf::from);
        let root = roots.iter().find(|root| root.join("instances").is_dir());
        let filesystems = fs::read_to_string("/proc/filesystems").unwrap_or_default();
        let root = root.ok_or_else(|| missing(Path::new(ROOTS[0]), &filesystems))?;
        Self::begin_in(root, core)
    }

    fn begin_in(root: &Path, core: usize) -> Result<Self, String> {
        remove_left(&root.join("instances"));
        let instance = root
            .join("instances")
            .join(format!("{INSTANCE}{}", std::process::id()));
        fs::create_dir(&instance).map_err(|error| refused(&instance, &error))?;
        let mut tracer = Self {
            instance,
            course: Arc::default(),
            stop: Arc::default(),
            reader: None,
        };
        tracer.set("trace_clock", "mono")?;
        tracer.set("buffer_size_kb", &BUFFER_KIB.to_string())?;
        tracer.set("tracing_cpumask", &mask(core))?;
        for (i, event) in EVENTS.iter().enumerate() {
            let outcome = tracer.set(&format!("events/{event}/enable"), "1");
            if i < NEEDED {
                outcome?;
            }
        }
        let pipe = tracer
            .instance
            .join(format!("per_cpu/cpu{core}/trace_pipe"));
        let pipe = OpenOptions::new()
            .read(true)
            .custom_flags(rustix::fs::OFlags::NONBLOCK.bits().cast_signed())
            .open(&pipe)
            .map_err(|error| refused(&pipe, &error))?;
        let (course, stop) = (tracer.course.clone(), tracer.stop.clone());
        let reader = std::thread::Builder::new()
            .name("calot-why".to_owned())
            .spawn(move || read(pipe, &course, &stop))
            .map_err(|error| format!("cannot start the thread that reads the trace: {error}"))?;
        tracer.reader = Some(reader);
        Ok(tracer)
    }

    /// Course of the core so far.
    pub fn course(&self) -> MutexGuard<'_, Course> {
        self.course.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A trace that has ended with this course.
    #[cfg(test)]
    pub(super) fn of(course: Course) -> Self {
        Self {
            instance: PathBuf::from("/nonexistent"),
            course: Arc::new(Mutex::new(course)),
            stop: Arc::default(),
            reader: None,
        }
    }

    fn set(&self, name: &str, value: &str) -> Result<(), String> {
        let path = self.instance.join(name);
        fs::write(&path, value).map_err(|error| refused(&path, &error))
    }
}

impl Drop for Tracer {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(reader) = self.reader.take() {
            let _ = reader.join();
        }
        // Without these two the kernel would go on noting until the instance is removed.
        let _ = self.set("tracing_on", "0");
        let _ = self.set("events/enable", "0");
        let _ = fs::remove_dir(&self.instance);
    }
}

/// Mask of one core in groups of 32 bits, as the kernel reads it: `2`, `1,00000000`.
fn mask(core: usize) -> String {
    let zeros = ",00000000".repeat(core / 32);
    format!("{:x}{zeros}", 1u32 << (core % 32))
}

/// Removes instances that a killed run has left.
fn remove_left(instances: &Path) {
    for entry in fs::read_dir(instances).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let process = name.to_str().and_then(|name| name.strip_prefix(INSTANCE));
        if process.is_some_and(|id| !Path::new("/proc").join(id).exists()) {
            let _ = fs::remove_dir(entry.path());
        }
    }
}

/// Reason why no tracefs was found, with its remedy.
fn missing(root: &Path, filesystems: &str) -> String {
    let place = root.display();
    if !filesystems.lines().any(|line| line.ends_with("tracefs")) {
        return "this kernel has no tracefs: it takes one with CONFIG_TRACING".to_owned();
    }
    match fs::read_dir(root) {
        Err(error) if error.kind() == ErrorKind::PermissionDenied => {
            format!("{place} may be read by root only: run `calot jitter --why` as root")
        }
        _ => format!(
            "tracefs is not mounted at {place}: `sudo mount -t tracefs nodev {place}`, then run \
             `calot jitter --why` as root"
        ),
    }
}

fn refused(path: &Path, error: &std::io::Error) -> String {
    let remedy = match error.kind() {
        ErrorKind::PermissionDenied => "run `calot jitter --why` as root",
        ErrorKind::NotFound => {
            "this kernel lacks the event: it takes one with CONFIG_EVENT_TRACING"
        }
        _ => "is another tracer at work?",
    };
    format!("{}: {error}; {remedy}", path.display())
}

/// Reads the pipe until it is stopped, and then what is left.
fn read(mut pipe: fs::File, course: &Mutex<Course>, stop: &AtomicBool) {
    let mut text = Vec::new();
    let mut chunk = [0; 64 * 1024];
    loop {
        let is_last = stop.load(Ordering::Relaxed);
        // All events before this time are in the pipe now.
        let now_ns = monotonic_ns();
        loop {
            match pipe.read(&mut chunk) {
                Ok(0) => break,
                Ok(length) => text.extend_from_slice(chunk.get(..length).unwrap_or_default()),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(_) => break,
            }
            take(&mut text, course);
        }
        let mut course = course.lock().unwrap_or_else(PoisonError::into_inner);
        course.known_to_ns = now_ns;
        drop(course);
        if is_last {
            return;
        }
        std::thread::sleep(READ_EVERY);
    }
}

/// Takes the whole lines of the text and keeps the beginning of the next one.
fn take(text: &mut Vec<u8>, course: &Mutex<Course>) {
    let Some(end) = text.iter().rposition(|&byte| byte == b'\n') else {
        return;
    };
    let lines: Vec<u8> = text.drain(..=end).collect();
    let lines = String::from_utf8_lossy(&lines);
    let mut course = course.lock().unwrap_or_else(PoisonError::into_inner);
    for (at_ns, event) in lines.lines().filter_map(parse::line) {
        // A note about lost events has no time of its own. It takes the time of the event before
        // it.
        let at_ns = match event {
            Event::Lost(_) => course.known_to_ns,
            _ => at_ns,
        };
        course.take(event, at_ns);
        course.known_to_ns = at_ns;
    }
}

/// Time of `CLOCK_MONOTONIC`, the clock of the ticks.
pub fn monotonic_ns() -> u64 {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
    u64::try_from(now.tv_sec).unwrap_or(0) * 1_000_000_000 + u64::try_from(now.tv_nsec).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::why::What;

    /// A folder with the files that a trace of core 1 writes and reads.
    fn kernel(text: &str) -> tempfile::TempDir {
        let root = tempfile::tempdir().unwrap();
        fs::create_dir(root.path().join("instances")).unwrap();
        fs::write(root.path().join("text"), text).unwrap();
        root
    }

    #[test]
    fn a_missing_permission_or_option_is_named_with_its_remedy() {
        let root = tempfile::tempdir().unwrap();
        let none = missing(root.path(), "nodev\tsysfs\n");
        assert!(none.contains("this kernel has no tracefs"), "{none}");
        let unmounted = missing(root.path(), "nodev\ttracefs\n");
        assert!(
            unmounted.contains("sudo mount -t tracefs nodev"),
            "{unmounted}"
        );
        let denied = std::io::Error::from(ErrorKind::PermissionDenied);
        let text = refused(Path::new("/sys/kernel/tracing/instances/x"), &denied);
        assert!(
            text.contains("instances/x") && text.contains("as root"),
            "{text}"
        );
        let busy = std::io::Error::from(ErrorKind::ResourceBusy);
        assert!(refused(root.path(), &busy).contains("is another tracer at work?"));
    }

    #[test]
    fn a_kernel_without_the_events_is_refused() {
        let root = kernel("");
        let error = Tracer::begin_in(root.path(), 1).unwrap_err();
        assert!(error.contains("sched_switch"), "{error}");
        assert!(error.contains("this kernel lacks the event"), "{error}");
    }

    #[test]
    fn what_a_killed_run_left_is_removed_and_a_living_ones_is_kept() {
        let root = kernel("");
        let instances = root.path().join("instances");
        // The id of a process is at most 2²².
        for name in [
            "calot-why-9999999".to_owned(),
            format!("calot-why-{}", std::process::id()),
            "theirs".to_owned(),
        ] {
            fs::create_dir(instances.join(name)).unwrap();
        }
        remove_left(&instances);
        let left = fs::read_dir(&instances).unwrap().count();
        assert_eq!(left, 2);
    }

    #[test]
    fn lines_that_come_in_parts_are_put_together() {
        let text = "a-1 [001] d..2. 1.000000: sched_switch: prev_comm=a ==> next_comm=b next_pid=2\n\
                    CPU:1 [LOST 3 EVENTS]\n\
                    b-2 [001] d..2. 1.000500: softirq_entry: vec=1 [action=TIMER]\n";
        let course = Mutex::new(Course::default());
        let mut waiting = Vec::new();
        for byte in text.bytes() {
            waiting.push(byte);
            take(&mut waiting, &course);
        }
        assert!(waiting.is_empty());
        let mut course = course.into_inner().unwrap();
        assert_eq!((course.events, course.lost_events), (3, 3));
        course.known_to_ns += 100;
        let slices = course.between(0, u64::MAX);
        assert_eq!(
            slices.last().map(|it| (it.what, it.for_ns)),
            Some((What::Softirq, 100))
        );
    }

    #[test]
    fn the_mask_of_a_core_has_groups_of_32_bits() {
        let masks = [0, 1, 5, 32, 67].map(mask);
        assert_eq!(masks, ["1", "2", "20", "1,00000000", "8,00000000,00000000"]);
    }

    #[test]
    fn a_pipe_is_read_to_its_end() {
        let root =
            kernel("b-2 [001] d..2. 1.5: sched_switch: prev_comm=a ==> next_comm=b next_pid=2\n");
        let pipe = fs::File::open(root.path().join("text")).unwrap();
        let course = Mutex::new(Course::default());
        read(pipe, &course, &AtomicBool::new(true));
        let course = course.into_inner().unwrap();
        assert!(course.events == 1 && course.known_to_ns > 0);
    }
}
