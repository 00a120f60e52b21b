//! Findings about what Linux grants the controller: priority, memory, core and time.

use super::finding::{Finding, Verdict, finding, tried};
use super::system::{System, TICK_PRIORITY};

/// Least limit `rttime`, µs: Calot stops a runaway tick by itself after this time.
const RTTIME_MIN_US: u64 = 200_000;

pub(super) fn priority(system: &System) -> Finding {
    let granted = format!("SCHED_FIFO {TICK_PRIORITY} granted");
    let should = "SCHED_FIFO 80 for the tick: tried, and taken back";
    tried("realtime priority", &system.trial.fifo, granted, should)
}

pub(super) fn memory(system: &System) -> Finding {
    let should = "all of it: the tick must not wait for a page; tried, and taken back";
    tried("locked memory", &system.trial.locked, "granted", should)
}

pub(super) fn affinity(system: &System, core: usize) -> Finding {
    let granted = format!("core {core} granted");
    let should = "one core for the tick: tried, and taken back";
    tried("core of the tick", &system.trial.pinned, granted, should)
}

/// Calot stops a runaway tick itself after 200 ms. With a lower limit, the kernel would end the
/// process first.
pub(super) fn runaway(system: &System) -> Finding {
    let should = "200 ms or more: Calot stops a runaway tick by itself after 200 ms";
    let name = "limit rttime";
    let mend = "prlimit --pid $$ --rttime=unlimited";
    match system.rttime_us {
        Some(us) if us < RTTIME_MIN_US => finding(
            name,
            Verdict::Better,
            format!("a realtime thread may run for {us} µs, then the kernel ends the program"),
            should,
            mend,
        ),
        Some(us) => finding(name, Verdict::Good, format!("{us} µs"), should, ""),
        None => finding(name, Verdict::Good, "none", should, ""),
    }
}

/// A quota that is used up stops the threads that are not realtime: those of the display, and the
/// tick if it has no realtime priority.
pub(super) fn quota(system: &System) -> Finding {
    let name = "processor quota";
    let should =
        "none: when it is used up, the display stands still, and without realtime the tick";
    let groups = system.read("proc/self/cgroup").unwrap_or_default();
    for line in groups.lines() {
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (parts.next(), parts.next()) else {
            continue;
        };
        let of_cpu = controllers.split(',').any(|it| it == "cpu");
        let (quota, period) = match controllers.is_empty() {
            true => {
                let text = system.read(&format!("sys/fs/cgroup{path}/cpu.max"));
                let text = text.unwrap_or_default();
                let mut words = text.split_whitespace().map(|word| word.parse::<i64>().ok());
                (words.next().flatten(), words.next().flatten())
            }
            false if of_cpu => {
                let number = |file: &str| system.number(&format!("sys/fs/cgroup/cpu{path}/{file}"));
                (number("cpu.cfs_quota_us"), number("cpu.cfs_period_us"))
            }
            false => (None, None),
        };
        if let (Some(quota @ 1..), Some(period @ 1..)) = (quota, period) {
            let is = format!("{quota} µs of every {period} µs");
            let mend = "start the container without --cpus, or systemd-run -p CPUQuota= …";
            return finding(name, Verdict::Better, is, should, mend);
        }
    }
    finding(name, Verdict::Good, "none", should, "")
}

/// With group scheduling, a control group without runtime refuses SCHED_FIFO.
pub(super) fn group_scheduling(system: &System) -> Finding {
    let name = "control group";
    let should = "one whose cpu.rt_runtime_us is not 0, else SCHED_FIFO is refused";
    let group = system.read("proc/self/cgroup").unwrap_or_default();
    let path = group.lines().find_map(|line| {
        let mut parts = line.splitn(3, ':').skip(1);
        let controllers = parts.next()?;
        controllers
            .split(',')
            .any(|c| c == "cpu")
            .then(|| parts.next())?
    });
    let Some(path) = path else {
        return finding(
            name,
            Verdict::Good,
            "no realtime share of its own",
            should,
            "",
        );
    };
    let file = format!("sys/fs/cgroup/cpu{path}/cpu.rt_runtime_us");
    match system.number(&file) {
        Some(0) => {
            let mend = format!("echo 950000 | sudo tee /{file}");
            finding(name, Verdict::Bad, "no realtime runtime", should, mend)
        }
        Some(us) => finding(name, Verdict::Good, format!("{us} µs"), should, ""),
        None => finding(
            name,
            Verdict::Good,
            "no realtime share of its own",
            should,
            "",
        ),
    }
}
