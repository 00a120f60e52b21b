//! Keeps a display off the core of the realtime tick.

use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

/// Lowers the calling thread's priority among threads without realtime priority (nice). Keeps the
/// thread off `tick_cpu` if it may use another core. Threads that this thread starts later inherit
/// both, such as those of a software graphics driver (one per CPU). If the operating system
/// refuses, nothing is reported: the run becomes less smooth, but stays safe.
pub fn step_aside(tick_cpu: Option<usize>) {
    let _ = rustix::process::nice(10);
    let Some(tick_cpu) = tick_cpu else { return };
    let Ok(allowed) = sched_getaffinity(None) else {
        return;
    };
    let mut others = CpuSet::new();
    for cpu in (0..CpuSet::MAX_CPU).filter(|&cpu| cpu != tick_cpu && allowed.is_set(cpu)) {
        others.set(cpu);
    }
    if others.count() > 0 {
        let _ = sched_setaffinity(None, &others);
    }
}
