//! The steps that make a thread realtime on Linux. Each refusal is a sentence with the command that
//! remedies it.
#![expect(
    unsafe_code,
    reason = "libc calls that rustix does not have: scheduler, signal mask, malloc, rusage"
)]

use std::fs::File;
use std::io::{self, Write};

use rustix::mm::MlockAllFlags;
use rustix::process::{Resource, getrlimit};
use rustix::thread::CpuSet;
use shared_mem::message::TimingBatch;

/// Stack of the tick that is touched before it starts, bytes.
const STACK_BYTES: usize = 512 * 1024;
/// Memory that a finite lock limit must leave for growth; otherwise later mappings would fail.
const LOCK_HEADROOM_BYTES: u64 = 256 << 20;

/// Realtime privileges of this process.
#[derive(Debug, Clone, Default)]
pub struct Standing {
    /// [`TimingBatch::FIFO`], [`TimingBatch::LOCKED`], [`TimingBatch::PINNED`].
    pub bits: u32,
    /// One sentence per refusal, with the remedy.
    pub refused: Vec<String>,
}

impl Standing {
    /// True with all three privileges.
    #[must_use]
    pub fn is_realtime(&self) -> bool {
        let all = TimingBatch::FIFO | TimingBatch::LOCKED | TimingBatch::PINNED;
        self.bits & all == all
    }

    /// Adds the outcome of one step.
    pub fn note(&mut self, bit: u32, outcome: Result<(), String>) {
        match outcome {
            Ok(()) => self.bits |= bit,
            Err(why) => self.refused.push(why),
        }
    }

    /// Removes privileges that `thread` no longer has; returns a sentence for each.
    pub(crate) fn lose(&mut self, thread: libc::pid_t) -> Vec<String> {
        let still = [
            (
                TimingBatch::FIFO,
                is_realtime(thread),
                "its scheduler was taken from the tick",
            ),
            (
                TimingBatch::LOCKED,
                locked_bytes() > 0,
                "its memory was unlocked",
            ),
            (
                TimingBatch::PINNED,
                is_pinned(thread),
                "it was allowed on more than one core",
            ),
        ];
        let mut lost = Vec::new();
        for (bit, has, what) in still {
            if self.bits & bit != 0 && !has {
                self.bits &= !bit;
                let why = format!("{what} from outside (chrt, taskset, a cgroup?)");
                self.refused.push(why.clone());
                lost.push(why);
            }
        }
        lost
    }
}

/// A thread that has ended counts as realtime.
fn is_realtime(thread: libc::pid_t) -> bool {
    policy(thread).is_none_or(|policy| [libc::SCHED_FIFO, libc::SCHED_DEADLINE].contains(&policy))
}

fn policy(thread: libc::pid_t) -> Option<libc::c_int> {
    // SAFETY: no pointers.
    let policy = unsafe { libc::sched_getscheduler(thread) };
    (policy >= 0).then_some(policy)
}

/// A thread that has ended counts as pinned.
fn is_pinned(thread: libc::pid_t) -> bool {
    if policy(thread) == Some(libc::SCHED_DEADLINE) {
        return true; // the kernel's admission takes the place of a core of one's own
    }
    let thread = rustix::thread::Pid::from_raw(thread);
    rustix::thread::sched_getaffinity(thread).map_or(true, |set| set.count() == 1)
}

/// Keeps freed memory in the process, then locks all memory, present and future.
///
/// # Errors
/// A sentence with the remedy.
pub fn lock_memory() -> Result<(), String> {
    // SAFETY: two valid settings; glibc makes them under its own lock.
    unsafe {
        libc::mallopt(libc::M_TRIM_THRESHOLD, -1);
        libc::mallopt(libc::M_MMAP_MAX, 0);
    }
    const MEND: &str = "run `sudo setcap cap_ipc_lock,cap_sys_nice+ep $(command -v calot)`, or \
                        set memlock to unlimited in /etc/security/limits.d and log in again";
    let refused = |why: String| format!("memory is not locked: {why}; {MEND}");
    rustix::mm::mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE)
        .map_err(|error| refused(error.to_string()))?;
    // Under a finite limit, the lock can succeed now and make later mappings fail.
    let limit = getrlimit(Resource::Memlock).current;
    if let Some(limit) = limit
        && !may_lock_without_limit()
        && locked_bytes().saturating_add(LOCK_HEADROOM_BYTES) > limit
    {
        let _ = rustix::mm::munlockall();
        let limit_mib = limit >> 20;
        return Err(refused(format!(
            "the limit of {limit_mib} MiB is too tight"
        )));
    }
    Ok(())
}

/// A number from `/proc/self/status`.
fn status_field(name: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    let word = line.trim_start_matches(':').split_whitespace().next()?;
    u64::from_str_radix(word, if name.starts_with("Cap") { 16 } else { 10 }).ok()
}

fn may_lock_without_limit() -> bool {
    const CAP_IPC_LOCK: u64 = 1 << 14;
    status_field("CapEff").is_some_and(|caps| caps & CAP_IPC_LOCK != 0)
}

fn locked_bytes() -> u64 {
    status_field("VmLck").unwrap_or(0) << 10
}

/// Touches the stack that the tick will use, so that it causes no page fault.
#[inline(never)]
pub fn prefault_stack() {
    let mut stack = [0u8; STACK_BYTES];
    for byte in stack.iter_mut().step_by(4096) {
        // SAFETY: a valid reference; volatile so that the touch is not optimised away.
        unsafe { core::ptr::write_volatile(byte, 1) };
    }
    core::hint::black_box(&stack);
}

/// Cores that this thread may use.
#[must_use]
pub fn allowed_cores() -> Vec<usize> {
    match rustix::thread::sched_getaffinity(None) {
        Ok(set) => (0..CpuSet::MAX_CPU).filter(|&c| set.is_set(c)).collect(),
        Err(_) => vec![0],
    }
}

/// Pins the calling thread to these cores.
///
/// # Errors
/// A sentence with the remedy.
pub fn pin_to(cores: &[usize]) -> Result<(), String> {
    let mut set = CpuSet::new();
    for &core in cores.iter().filter(|&&core| core < CpuSet::MAX_CPU) {
        set.set(core);
    }
    rustix::thread::sched_setaffinity(None, &set).map_err(|error| {
        format!(
            "the thread is not pinned to core {cores:?}: {error}; `nproc --all` and \
             `taskset -p $$` show what is allowed, choose with --core"
        )
    })
}

/// Gives the calling thread `SCHED_FIFO` at a priority of 1 to 99.
///
/// # Errors
/// A sentence with the remedy.
pub fn take_fifo(priority: u8) -> Result<(), String> {
    let parameter = libc::sched_param {
        sched_priority: libc::c_int::from(priority),
    };
    // SAFETY: 0 is the calling thread; the parameter is a valid, initialised struct.
    let rc = unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &raw const parameter) };
    if rc == 0 {
        return Ok(());
    }
    let error = io::Error::last_os_error();
    let limit = getrlimit(Resource::Rtprio)
        .current
        .map_or("unlimited".to_owned(), |limit| limit.to_string());
    Err(format!(
        "SCHED_FIFO priority {priority} was refused: {error} (limit {limit}); run `sudo setcap \
         cap_ipc_lock,cap_sys_nice+ep $(command -v calot)`, or set rtprio to 95 in \
         /etc/security/limits.d and log in again"
    ))
}

/// Prepares the calling thread for work next to the tick: cores other than the tick's, if there are
/// any, and `SCHED_FIFO`.
///
/// # Errors
/// A sentence with the remedy.
pub fn work_beside_tick(cores: &[usize], tick_core: usize, priority: u8) -> Result<(), String> {
    let cores = cores.iter().copied();
    let others: Vec<usize> = cores.filter(|&core| core != tick_core).collect();
    if !others.is_empty() {
        pin_to(&others)?;
    }
    take_fifo(priority)
}

/// Gives the calling thread `SCHED_DEADLINE`: nine tenths of every period, due at its end.
///
/// # Errors
/// A sentence with the remedy.
pub fn take_deadline(period_ns: u64) -> Result<(), String> {
    let attributes = libc::sched_attr {
        size: size_of::<libc::sched_attr>() as u32,
        sched_policy: libc::SCHED_DEADLINE.cast_unsigned(),
        sched_flags: 0,
        sched_nice: 0,
        sched_priority: 0,
        sched_runtime: period_ns / 10 * 9,
        sched_deadline: period_ns,
        sched_period: period_ns,
    };
    // SAFETY: 0 is the calling thread; the attributes are a valid, initialised struct.
    let rc = unsafe { libc::syscall(libc::SYS_sched_setattr, 0, &raw const attributes, 0) };
    if rc == 0 {
        return Ok(());
    }
    let error = io::Error::last_os_error();
    Err(format!(
        "SCHED_DEADLINE was refused: {error}; EPERM: run as root or with cap_sys_nice, and let the \
         process use all cores (`taskset -p $$`); EBUSY: other deadline threads have the time"
    ))
}

/// Returns a thread of this process to the ordinary scheduler: the answer to a runaway tick.
pub(crate) fn demote(thread: libc::pid_t) {
    let parameter = libc::sched_param { sched_priority: 0 };
    // SAFETY: a thread id of this process; the parameter is a valid, initialised struct.
    unsafe { libc::sched_setscheduler(thread, libc::SCHED_OTHER, &raw const parameter) };
}

/// Blocks signals in the calling thread, so that the main thread gets them all. Faults of the
/// thread itself stay deliverable.
pub(crate) fn leave_signals_to_main() {
    // SAFETY: the set is initialised by `sigfillset` before use; pointers are to locals.
    unsafe {
        let mut set = core::mem::zeroed::<libc::sigset_t>();
        libc::sigfillset(&raw mut set);
        for own in [
            libc::SIGSEGV,
            libc::SIGBUS,
            libc::SIGFPE,
            libc::SIGILL,
            libc::SIGABRT,
        ] {
            libc::sigdelset(&raw mut set, own);
        }
        libc::pthread_sigmask(libc::SIG_BLOCK, &raw const set, core::ptr::null_mut());
    }
}

/// The kernel's counters of the calling thread.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ThreadUsage {
    /// Page faults, minor and major.
    pub page_faults: u64,
    /// Involuntary context switches: something of higher priority took the core.
    pub involuntary_switches: u64,
    /// Voluntary context switches: the thread waited.
    pub waits: u64,
}

impl ThreadUsage {
    /// Reads the counters: one system call, no allocation.
    #[must_use]
    pub fn now() -> Self {
        // SAFETY: all-zero is a valid rusage; the pointer is to a local.
        let usage = unsafe {
            let mut usage = core::mem::zeroed::<libc::rusage>();
            libc::getrusage(libc::RUSAGE_THREAD, &raw mut usage);
            usage
        };
        let faults = usage.ru_minflt.max(0) + usage.ru_majflt.max(0);
        Self {
            page_faults: faults.cast_unsigned(),
            involuntary_switches: usage.ru_nivcsw.max(0).cast_unsigned(),
            waits: usage.ru_nvcsw.max(0).cast_unsigned(),
        }
    }

    /// Difference since `start`.
    #[must_use]
    pub fn since(self, start: Self) -> Self {
        Self {
            page_faults: self.page_faults.saturating_sub(start.page_faults),
            involuntary_switches: self
                .involuntary_switches
                .saturating_sub(start.involuntary_switches),
            waits: self.waits.saturating_sub(start.waits),
        }
    }
}

/// Keeps the processor out of deep idle states while it lives.
#[derive(Debug)]
pub struct NoDeepIdle(#[expect(dead_code, reason = "the open file is the request")] File);

impl NoDeepIdle {
    /// Requests a wake-up latency of 0 µs.
    ///
    /// # Errors
    /// A sentence with the remedy.
    pub fn ask() -> Result<Self, String> {
        let path = "/dev/cpu_dma_latency";
        let ask = || -> io::Result<File> {
            let mut file = File::options().write(true).open(path)?;
            file.write_all(&0i32.to_ne_bytes())?;
            Ok(file)
        };
        ask().map(Self).map_err(|error| {
            format!("deep idle states stay on: {path}: {error}; make it writable by a udev rule")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn realtime_needs_all_three() {
        let mut standing = Standing::default();
        standing.note(TimingBatch::FIFO, Ok(()));
        standing.note(TimingBatch::LOCKED, Ok(()));
        assert!(!standing.is_realtime());
        standing.note(TimingBatch::PINNED, Err("no core 7".into()));
        assert!(!standing.is_realtime());
        assert_eq!(standing.refused, ["no core 7"]);
        standing.note(TimingBatch::PINNED, Ok(()));
        assert!(standing.is_realtime());
    }

    #[test]
    fn page_faults_of_this_thread_are_seen() {
        let before = ThreadUsage::now();
        let mut fresh = vec![0u8; 64 << 20];
        for byte in fresh.iter_mut().step_by(4096) {
            *byte = 1;
        }
        core::hint::black_box(&fresh);
        assert!(ThreadUsage::now().since(before).page_faults > 0);
    }

    #[test]
    fn a_core_that_does_not_exist_is_refused_in_words() {
        let why = std::thread::spawn(|| pin_to(&[1023])).join().unwrap();
        assert!(why.unwrap_err().contains("--core"));
    }
}
