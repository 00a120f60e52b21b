//! The steps that make a thread realtime on Linux. Each refusal is a sentence with the command that
//! remedies it.
#![expect(
    unsafe_code,
    reason = "libc calls that rustix does not have: scheduler, signal mask, malloc, rusage"
)]

use std::fs::File;
use std::io::{self, Write};

use rustix::io::Errno;
use rustix::mm::{MapFlags, MlockAllFlags, MlockFlags, ProtFlags};
use rustix::process::{Resource, getrlimit};
use rustix::thread::CpuSet;
use shared_mem::message::TimingBatch;

use crate::refusal::{Call, Circumstances, Refusal};

/// Part of the tick's stack that is touched before the tick starts, bytes.
const STACK_BYTES: usize = 512 * 1024;
/// Memory that a finite lock limit must leave for growth, bytes. With less, later mappings would
/// fail.
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
    pub fn note(&mut self, bit: u32, outcome: Result<(), Refusal>) {
        match outcome {
            Ok(()) => self.bits |= bit,
            Err(refusal) => self.refused.push(refusal.to_string()),
        }
    }

    /// Removes privileges that `thread` no longer has; returns a sentence for each.
    pub(crate) fn lose(&mut self, thread: libc::pid_t) -> Vec<String> {
        let still = [
            (
                TimingBatch::FIFO,
                is_realtime(thread),
                "the tick's realtime scheduler was changed",
            ),
            (
                TimingBatch::LOCKED,
                locked_bytes() > 0,
                "the memory was unlocked",
            ),
            (
                TimingBatch::PINNED,
                is_pinned(thread),
                "the tick was allowed on more than one core",
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

/// True if the thread has a realtime scheduler. A thread that has ended counts as realtime.
fn is_realtime(thread: libc::pid_t) -> bool {
    policy(thread).is_none_or(|policy| [libc::SCHED_FIFO, libc::SCHED_DEADLINE].contains(&policy))
}

fn policy(thread: libc::pid_t) -> Option<libc::c_int> {
    // SAFETY: no pointers.
    let policy = unsafe { libc::sched_getscheduler(thread) };
    (policy >= 0).then_some(policy)
}

/// True if the thread is pinned to one core. A thread that has ended counts as pinned.
fn is_pinned(thread: libc::pid_t) -> bool {
    if policy(thread) == Some(libc::SCHED_DEADLINE) {
        return true; // the kernel guarantees the thread's time without a reserved core
    }
    let thread = rustix::thread::Pid::from_raw(thread);
    rustix::thread::sched_getaffinity(thread).map_or(true, |set| set.count() == 1)
}

/// Keeps freed memory in the process, then locks all memory, present and future.
///
/// # Errors
/// The rule that refused, and the remedy.
pub fn lock_memory() -> Result<(), Refusal> {
    // SAFETY: two valid settings; glibc applies them under its own lock.
    unsafe {
        libc::mallopt(libc::M_TRIM_THRESHOLD, -1);
        libc::mallopt(libc::M_MMAP_MAX, 0);
    }
    let refused = |error| Circumstances::read().judge(Call::Lock, error);
    // The limit is tested before all memory is locked. After that, the kernel would touch all pages
    // of the test's mapping at once.
    let limit = getrlimit(Resource::Memlock).current;
    let limit = limit.filter(|limit| limit_holds(*limit));
    rustix::mm::mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE).map_err(refused)?;
    // Under a finite limit, the lock can succeed now and make later mappings fail.
    if let Some(limit) = limit
        && locked_bytes().saturating_add(LOCK_HEADROOM_BYTES) > limit
    {
        unlock_memory();
        return Err(refused(Errno::NOMEM));
    }
    Ok(())
}

/// Undoes the lock of [`lock_memory`].
pub(crate) fn unlock_memory() {
    let _ = rustix::mm::munlockall();
}

/// True if this process may not lock more than `limit` bytes. The function finds out by a trial,
/// because a capability may not count in a user namespace. The trial locks only pages that are
/// touched, and it touches none. If the trial cannot map its memory, the limit counts as binding.
fn limit_holds(limit: u64) -> bool {
    let Some(length) = usize::try_from(limit)
        .ok()
        .and_then(|it| it.checked_add(1 << 20))
    else {
        return true;
    };
    // SAFETY: the kernel chooses the place; the mapping is private, never touched, and unmapped.
    unsafe {
        let null = core::ptr::null_mut();
        let (access, kind) = (ProtFlags::READ, MapFlags::PRIVATE | MapFlags::NORESERVE);
        let Ok(place) = rustix::mm::mmap_anonymous(null, length, access, kind) else {
            return true;
        };
        let locked = rustix::mm::mlock_with(place, length, MlockFlags::ONFAULT);
        let _ = rustix::mm::munmap(place, length);
        locked.is_err()
    }
}

/// A number from `/proc/self/status`.
fn status_field(name: &str) -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix(name))?;
    let word = line.trim_start_matches(':').split_whitespace().next()?;
    word.parse().ok()
}

fn locked_bytes() -> u64 {
    status_field("VmLck").unwrap_or(0) << 10
}

/// Touches the stack that the tick will use, so that the tick causes no page fault there.
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
/// The rule that refused, and the remedy.
pub fn pin_to(cores: &[usize]) -> Result<(), Refusal> {
    let mut set = CpuSet::new();
    for &core in cores.iter().filter(|&&core| core < CpuSet::MAX_CPU) {
        set.set(core);
    }
    rustix::thread::sched_setaffinity(None, &set)
        .map_err(|error| Circumstances::read().judge(Call::Pin(cores.to_vec()), error))
}

/// Gives the calling thread `SCHED_FIFO` at a priority of 1 to 99.
///
/// # Errors
/// The rule that refused, and the remedy.
pub fn take_fifo(priority: u8) -> Result<(), Refusal> {
    let parameter = libc::sched_param {
        sched_priority: libc::c_int::from(priority),
    };
    // SAFETY: 0 is the calling thread; the parameter is a valid, initialised struct.
    let rc = unsafe { libc::sched_setscheduler(0, libc::SCHED_FIFO, &raw const parameter) };
    if rc == 0 {
        return Ok(());
    }
    Err(Circumstances::read().judge(Call::Fifo(priority), last_errno()))
}

fn last_errno() -> Errno {
    Errno::from_io_error(&io::Error::last_os_error()).unwrap_or(Errno::INVAL)
}

/// Prepares the calling thread for work next to the tick: cores other than the tick's, if there are
/// any, and `SCHED_FIFO`.
///
/// # Errors
/// The rule that refused, and the remedy.
pub fn work_beside_tick(cores: &[usize], tick_core: usize, priority: u8) -> Result<(), Refusal> {
    let cores = cores.iter().copied();
    let others: Vec<usize> = cores.filter(|&core| core != tick_core).collect();
    if !others.is_empty() {
        pin_to(&others)?;
    }
    take_fifo(priority)
}

/// Gives the calling thread `SCHED_DEADLINE`: nine tenths of every period, to be received before
/// the period's end.
///
/// # Errors
/// The rule that refused, and the remedy.
pub fn take_deadline(period_ns: u64) -> Result<(), Refusal> {
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
    Err(Circumstances::read().judge(Call::Deadline, last_errno()))
}

/// Returns a thread of this process to the ordinary scheduler. This stops a runaway tick from
/// blocking its core.
pub(crate) fn demote(thread: libc::pid_t) {
    let parameter = libc::sched_param { sched_priority: 0 };
    // SAFETY: a thread id of this process; the parameter is a valid, initialised struct.
    unsafe { libc::sched_setscheduler(thread, libc::SCHED_OTHER, &raw const parameter) };
}

/// Blocks signals in the calling thread, so that the main thread gets them all. Signals for errors
/// of the thread itself, such as `SIGSEGV`, are not blocked.
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
    fn realtime_needs_fifo_locked_memory_and_a_pinned_core() {
        let mut standing = Standing::default();
        standing.note(TimingBatch::FIFO, Ok(()));
        standing.note(TimingBatch::LOCKED, Ok(()));
        assert!(!standing.is_realtime());
        let refusal = Circumstances::default().judge(Call::Pin(vec![7]), Errno::INVAL);
        standing.note(TimingBatch::PINNED, Err(refusal.clone()));
        assert!(!standing.is_realtime());
        assert_eq!(standing.refused, [refusal.to_string()]);
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
    fn missing_core_is_refused_with_the_remedy() {
        let why = std::thread::spawn(|| pin_to(&[1023])).join().unwrap();
        assert!(why.unwrap_err().to_string().contains("--core"));
    }
}
