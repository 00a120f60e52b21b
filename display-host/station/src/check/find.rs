//! Functions that examine the machine, one per finding. They see it only through [`System`], so
//! that tests can show them another machine.

use std::path::{Path, PathBuf};

use rt_process::refusal::Refusal;
use rt_process::trial::Trial;
use rustix::process::{Resource, getrlimit};

use super::finding::{Finding, Verdict};

/// Priority of the tick unless another is asked for.
const TICK_PRIORITY: u8 = 80;
/// Time after which calot stops a runaway tick, µs.
const RTTIME_MIN_US: u64 = 200_000;
/// Share of each period that the kernel grants realtime threads by default.
const RT_SHARE: f64 = 0.95;
/// Longest exit latency of an idle state that is not deep, µs.
const IDLE_EXIT_MAX_US: u64 = 10;
/// Longest good setting of an FTDI chip's latency timer, ms. The chip holds bytes back that long.
const LATENCY_TIMER_MAX_MS: u64 = 1;

/// The machine as files, tried calls and limits.
#[derive(Debug, Clone)]
pub(crate) struct System {
    /// `/`, or a folder of the same layout.
    root: PathBuf,
    /// Outcomes of the calls that were tried.
    trial: Trial,
    /// Time without sleep after which the kernel ends the process of a realtime thread, µs; `None`:
    /// unlimited.
    rttime_us: Option<u64>,
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

    fn read(&self, path: &str) -> Option<String> {
        let text = std::fs::read_to_string(self.root.join(path)).ok()?;
        Some(text.trim().to_owned())
    }

    fn number(&self, path: &str) -> Option<i64> {
        self.read(path)?.parse().ok()
    }

    fn entries(&self, folder: &str) -> Vec<PathBuf> {
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

/// Findings of this module, the most important first.
pub(crate) fn all(system: &System, core: usize) -> Vec<Finding> {
    vec![
        priority(system),
        memory(system),
        affinity(system, core),
        runaway(system),
        quota(system),
        compaction(system),
        group_scheduling(system),
        preemption(system),
        throttling(system),
        clock(system),
        isolation(system, core),
        interrupts(system, core),
        governor(system, core),
        idle(system, core),
        virtual_machine(system),
        serial(system),
    ]
}

pub(super) fn finding(
    name: &'static str,
    verdict: Verdict,
    is: impl Into<String>,
    should: &'static str,
    mend: impl Into<String>,
) -> Finding {
    let mend = Some(mend.into()).filter(|m| verdict != Verdict::Good && !m.is_empty());
    Finding {
        name,
        verdict,
        is: is.into(),
        should,
        mend,
        cause: None,
    }
}

/// Finding about a call that was tried. A refused one has its cause and remedy.
fn tried(
    name: &'static str,
    outcome: &Result<(), Refusal>,
    granted: impl Into<String>,
    should: &'static str,
) -> Finding {
    match outcome {
        Ok(()) => finding(name, Verdict::Good, granted, should, ""),
        Err(refusal) => Finding {
            cause: Some(refusal.cause),
            ..finding(
                name,
                Verdict::Bad,
                format!("refused: {}", refusal.why),
                should,
                refusal.mend.clone(),
            )
        },
    }
}

fn priority(system: &System) -> Finding {
    let granted = format!("SCHED_FIFO {TICK_PRIORITY} granted");
    let should = "SCHED_FIFO 80 for the tick: tried, and taken back";
    tried("realtime priority", &system.trial.fifo, granted, should)
}

fn memory(system: &System) -> Finding {
    let should = "all of it: the tick must not wait for a page; tried, and taken back";
    tried("locked memory", &system.trial.locked, "granted", should)
}

fn affinity(system: &System, core: usize) -> Finding {
    let granted = format!("core {core} granted");
    let should = "one core for the tick: tried, and taken back";
    tried("core of the tick", &system.trial.pinned, granted, should)
}

/// Calot stops a runaway tick itself after 200 ms. A lower limit would end the process first.
fn runaway(system: &System) -> Finding {
    let should = "200 ms or more: calot itself stops a runaway tick by then";
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

/// A quota stops the threads that are not realtime: the display, and without realtime the tick.
fn quota(system: &System) -> Finding {
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
fn group_scheduling(system: &System) -> Finding {
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

fn preemption(system: &System) -> Finding {
    let version = system.read("proc/sys/kernel/version").unwrap_or_default();
    let dynamic = system
        .read("sys/kernel/debug/sched/preempt")
        .unwrap_or_default();
    let chosen = dynamic
        .split_whitespace()
        .find_map(|word| word.strip_prefix('(')?.strip_suffix(')'))
        .map(ToOwned::to_owned);
    let asked = system.read("proc/cmdline").unwrap_or_default();
    let asked = asked
        .split_whitespace()
        .find_map(|word| word.strip_prefix("preempt=").map(ToOwned::to_owned));
    let realtime = version.contains("PREEMPT_RT")
        || system.read("sys/kernel/realtime").as_deref() == Some("1");
    let model = match (realtime, chosen.or(asked)) {
        (true, _) => "PREEMPT_RT".to_owned(),
        (false, Some(model)) => format!("PREEMPT_DYNAMIC, {model}"),
        (false, None) if version.contains("PREEMPT_DYNAMIC") => {
            "PREEMPT_DYNAMIC, current choice unreadable".to_owned()
        }
        (false, None) if version.contains("PREEMPT") => "PREEMPT".to_owned(),
        (false, None) => "none or voluntary".to_owned(),
    };
    let verdict = match realtime {
        true => Verdict::Good,
        false => Verdict::Better,
    };
    let mend = match model.contains("full") {
        true => {
            "sudo apt install linux-image-rt-amd64   # Debian; Ubuntu: sudo pro enable realtime-kernel"
        }
        false => {
            "sudo apt install linux-image-rt-amd64   # Debian; or at once: echo full | sudo tee \
             /sys/kernel/debug/sched/preempt"
        }
    };
    let should = "PREEMPT_RT; full preemption is the next best";
    finding("preemption", verdict, model, should, mend)
}

fn compaction(system: &System) -> Finding {
    let name = "memory compaction";
    let should = "no: otherwise the kernel sometimes moves locked pages, with a page fault each";
    let mend = "sudo sysctl vm.compact_unevictable_allowed=0";
    match system.number("proc/sys/vm/compact_unevictable_allowed") {
        Some(0) => finding(name, Verdict::Good, "no", should, ""),
        // The kernel was built without compaction.
        None if system.read("proc/sys/vm/compact_memory").is_none() => {
            finding(name, Verdict::Good, "no", should, "")
        }
        None => finding(name, Verdict::Unknown, "cannot be read", should, ""),
        Some(_) => finding(name, Verdict::Better, "allowed", should, mend),
    }
}

fn throttling(system: &System) -> Finding {
    let name = "realtime throttling";
    let should = "95 % or off: calot itself stops a runaway tick";
    let mend = "sudo sysctl kernel.sched_rt_period_us=1000000 kernel.sched_rt_runtime_us=950000";
    let number = |name: &str| system.number(&format!("proc/sys/kernel/{name}"));
    let period = number("sched_rt_period_us").filter(|us| *us > 0);
    match (number("sched_rt_runtime_us"), period) {
        (Some(0), _) => finding(
            name,
            Verdict::Bad,
            "realtime threads may not run at all",
            should,
            mend,
        ),
        (Some(us), _) if us < 0 => finding(name, Verdict::Good, "off", should, ""),
        (Some(us), Some(period_us)) => {
            let share = us as f64 / period_us as f64;
            let verdict = match share >= RT_SHARE {
                true => Verdict::Good,
                false => Verdict::Better,
            };
            let is = format!("after {us} of each {period_us} µs ({:.0} %)", share * 100.0);
            finding(name, verdict, is, should, mend)
        }
        _ => finding(name, Verdict::Unknown, "cannot be read", should, ""),
    }
}

fn clock(system: &System) -> Finding {
    let folder = "sys/devices/system/clocksource/clocksource0";
    let source = system.read(&format!("{folder}/current_clocksource"));
    let available = system
        .read(&format!("{folder}/available_clocksource"))
        .unwrap_or_default();
    let should =
        "read in user space: tsc, kvm-clock, hyperv or arch_sys_counter; others cost µs per read";
    let Some(source) = source else {
        return finding(
            "clock source",
            Verdict::Unknown,
            "cannot be read",
            should,
            "",
        );
    };
    let fast = ["tsc", "kvm-clock", "arch_sys_counter"].contains(&source.as_str())
        || source.starts_with("hyperv");
    let verdict = match fast {
        true => Verdict::Good,
        false => Verdict::Better,
    };
    let mend = match available.split_whitespace().any(|s| s == "tsc") {
        true => format!("echo tsc | sudo tee /{folder}/current_clocksource"),
        false => String::new(),
    };
    finding("clock source", verdict, source, should, mend)
}

fn isolation(system: &System, core: usize) -> Finding {
    let isolated = system
        .read("sys/devices/system/cpu/isolated")
        .unwrap_or_default();
    let online = system
        .read("sys/devices/system/cpu/online")
        .unwrap_or_default();
    let (verdict, is) = match in_list(&isolated, core) {
        true => (Verdict::Good, format!("core {core} is (of {isolated})")),
        false if isolated.is_empty() => (Verdict::Better, format!("none of {online}")),
        false => (
            Verdict::Better,
            format!("{isolated}, not the tick's core {core}"),
        ),
    };
    let mend = match parse_list(&online).len() {
        0 | 1 => String::new(),
        _ => format!(
            "sudo sed -i 's/^GRUB_CMDLINE_LINUX=\"/&isolcpus={core} nohz_full={core} \
             rcu_nocbs={core} /' /etc/default/grub && sudo update-grub && sudo reboot"
        ),
    };
    let should = "the tick's core, so that nothing else runs on it";
    finding("isolated cores", verdict, is, should, mend)
}

fn interrupts(system: &System, core: usize) -> Finding {
    let name = "interrupt affinity";
    let should = "device interrupts on other cores than the tick's";
    let mut here = Vec::new();
    let mut seen = 0;
    for folder in system.entries("proc/irq") {
        let list = std::fs::read_to_string(folder.join("effective_affinity_list"))
            .or_else(|_| std::fs::read_to_string(folder.join("smp_affinity_list")));
        let number = folder.file_name().map(|n| n.to_string_lossy().into_owned());
        if let (Ok(list), Some(number)) = (list, number) {
            seen += 1;
            if in_list(list.trim(), core) {
                here.push(number);
            }
        }
    }
    if seen == 0 {
        return finding(name, Verdict::Unknown, "cannot be read", should, "");
    }
    let others = parse_list(
        &system
            .read("sys/devices/system/cpu/online")
            .unwrap_or_default(),
    )
    .into_iter()
    .filter(|&c| c != core)
    .map(|c| c.to_string())
    .collect::<Vec<_>>()
    .join(",");
    let verdict = match here.is_empty() {
        true => Verdict::Good,
        false => Verdict::Better,
    };
    let is = format!("{} of {seen} may come to core {core}", here.len());
    let mend = match others.is_empty() {
        true => String::new(),
        false => format!(
            "for i in {}; do echo {others} | sudo tee /proc/irq/$i/smp_affinity_list; done; sudo \
             systemctl disable --now irqbalance",
            here.join(" ")
        ),
    };
    finding(name, verdict, is, should, mend)
}

fn governor(system: &System, core: usize) -> Finding {
    let path = format!("sys/devices/system/cpu/cpu{core}/cpufreq/scaling_governor");
    let should = "performance: the clock does not ramp up within a tick";
    match system.read(&path) {
        None => finding(
            "governor",
            Verdict::Unknown,
            "not visible (the host of a virtual machine sets it)",
            should,
            "",
        ),
        Some(governor) => {
            let verdict = match governor == "performance" {
                true => Verdict::Good,
                false => Verdict::Better,
            };
            let mend =
                "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor";
            finding("governor", verdict, governor, should, mend)
        }
    }
}

fn idle(system: &System, core: usize) -> Finding {
    let name = "idle states";
    let should =
        "none deeper than 10 µs, or /dev/cpu_dma_latency writable so that calot can forbid them";
    let mut deep = Vec::new();
    let folder = format!("sys/devices/system/cpu/cpu{core}/cpuidle");
    for state in system.entries(&folder) {
        let read = |file: &str| std::fs::read_to_string(state.join(file)).unwrap_or_default();
        let latency_us: u64 = read("latency").trim().parse().unwrap_or(0);
        if latency_us > IDLE_EXIT_MAX_US && read("disable").trim() != "1" {
            deep.push(format!("{} ({latency_us} µs)", read("name").trim()));
        }
    }
    let latency_file = system.root.join("dev/cpu_dma_latency");
    let writable = std::fs::File::options()
        .write(true)
        .open(&latency_file)
        .is_ok();
    let (verdict, is) = match (deep.is_empty(), writable) {
        (_, true) => (Verdict::Good, "calot may forbid deep ones".to_owned()),
        (true, false) => (Verdict::Good, "no deep ones".to_owned()),
        (false, false) => (Verdict::Better, deep.join(", ")),
    };
    let mend = "calot check --install | sudo sh   # a udev rule for /dev/cpu_dma_latency";
    finding(name, verdict, is, should, mend)
}

fn virtual_machine(system: &System) -> Finding {
    let cpuinfo = system.read("proc/cpuinfo").unwrap_or_default();
    let flags = cpuinfo.lines().find(|line| line.starts_with("flags"));
    let guest = flags.is_some_and(|line| line.split_whitespace().any(|flag| flag == "hypervisor"));
    let (verdict, is) = match guest {
        true => (
            Verdict::Better,
            "yes: its host adds delays that no setting of the guest removes",
        ),
        false => (Verdict::Good, "no"),
    };
    finding("virtual machine", verdict, is, "no, for a rig", "")
}

fn serial(system: &System) -> Finding {
    let name = "USB serial latency";
    let should = "latency timer of 1 ms: FTDI chips hold bytes back for 16 ms by default";
    let mut slow = Vec::new();
    let mut seen = 0;
    for port in system.entries("sys/bus/usb-serial/devices") {
        let timer = std::fs::read_to_string(port.join("latency_timer"));
        let Ok(timer) = timer else { continue };
        seen += 1;
        let ms: u64 = timer.trim().parse().unwrap_or(u64::MAX);
        if ms > LATENCY_TIMER_MAX_MS {
            slow.push((file_name(&port), ms));
        }
    }
    match (seen, slow.as_slice()) {
        (0, _) => finding(
            name,
            Verdict::Good,
            "no such adapter plugged in",
            should,
            "",
        ),
        (_, []) => finding(name, Verdict::Good, "1 ms", should, ""),
        (_, slow) => {
            let is: Vec<String> = slow
                .iter()
                .map(|(port, ms)| format!("{port} {ms} ms"))
                .collect();
            let mend: Vec<String> = slow
                .iter()
                .map(|(port, _)| {
                    format!("echo 1 | sudo tee /sys/bus/usb-serial/devices/{port}/latency_timer")
                })
                .collect();
            finding(
                name,
                Verdict::Better,
                is.join(", "),
                should,
                mend.join("; "),
            )
        }
    }
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default()
}

/// Cores of a list such as `0-2,5`. Ignores malformed parts and cuts a range at 4096.
fn parse_list(list: &str) -> Vec<usize> {
    let mut cores = Vec::new();
    for part in list.trim().split(',') {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        if let (Ok(first), Ok(last)) = (first.parse::<usize>(), last.parse::<usize>()) {
            cores.extend(first..=last.min(4096));
        }
    }
    cores
}

fn in_list(list: &str, core: usize) -> bool {
    parse_list(list).contains(&core)
}

#[cfg(test)]
mod tests {
    use rt_process::refusal::{Call, Cause, Circumstances};
    use rustix::io::Errno;

    use super::*;

    /// A machine made of a few files.
    fn machine(files: &[(&str, &str)]) -> (tempfile::TempDir, System) {
        let folder = tempfile::tempdir().unwrap();
        for (path, text) in files {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        let system = System {
            root: folder.path().to_owned(),
            trial: refused(),
            rttime_us: Some(100_000),
        };
        (folder, system)
    }

    fn granted() -> Trial {
        Trial {
            fifo: Ok(()),
            pinned: Ok(()),
            locked: Ok(()),
        }
    }

    /// Outcomes for an ordinary user who may not use the core.
    fn refused() -> Trial {
        let poor = Circumstances {
            rtprio: Some(0),
            memlock: Some(8 << 20),
            cores: "0-1".to_owned(),
            ..Circumstances::default()
        };
        Trial {
            fifo: Err(poor.judge(Call::Fifo(80), Errno::PERM)),
            pinned: Err(poor.judge(Call::Pin(vec![3]), Errno::INVAL)),
            locked: Err(poor.judge(Call::Lock, Errno::NOMEM)),
        }
    }

    #[test]
    fn findings_are_what_the_calls_returned() {
        let (_folder, mut system) = machine(&[]);
        let found = |system: &System| [priority(system), memory(system), affinity(system, 3)];
        for (finding, (cause, mend)) in found(&system).iter().zip([
            (Cause::Limit, "--install"),
            (Cause::Limit, "--install"),
            (Cause::CpuSet, "--core"),
        ]) {
            assert_eq!(
                (finding.verdict, finding.cause),
                (Verdict::Bad, Some(cause))
            );
            assert!(finding.mend.as_ref().unwrap().contains(mend), "{finding:?}");
        }
        assert!(memory(&system).is.contains("the limit memlock is 8192 KiB"));
        system.trial = granted();
        for finding in found(&system) {
            assert_eq!((finding.verdict, finding.mend), (Verdict::Good, None));
        }
    }

    #[test]
    fn a_processor_quota_is_found_in_either_hierarchy() {
        let (_folder, new) = machine(&[
            ("proc/self/cgroup", "0::/box"),
            ("sys/fs/cgroup/box/cpu.max", "50000 100000"),
        ]);
        assert_eq!(quota(&new).is, "50000 µs of every 100000 µs");
        let (_folder, old) = machine(&[
            ("proc/self/cgroup", "4:cpu,cpuacct:/user\n0::/"),
            ("sys/fs/cgroup/cpu/user/cpu.cfs_quota_us", "20000"),
            ("sys/fs/cgroup/cpu/user/cpu.cfs_period_us", "100000"),
        ]);
        assert_eq!(quota(&old).verdict, Verdict::Better);
        let (_folder, free) = machine(&[
            ("proc/self/cgroup", "0::/box"),
            ("sys/fs/cgroup/box/cpu.max", "max 100000"),
        ]);
        assert_eq!(quota(&free).verdict, Verdict::Good);
    }

    #[test]
    fn throttling_is_a_share_of_the_machines_own_period() {
        for (runtime, period, verdict, words) in [
            (
                "950000",
                "2000000",
                Verdict::Better,
                "950000 of each 2000000 µs (48 %)",
            ),
            ("95000", "100000", Verdict::Good, "(95 %)"),
            ("-1", "100000", Verdict::Good, "off"),
            ("0", "100000", Verdict::Bad, "not run at all"),
            ("950000", "", Verdict::Unknown, "cannot be read"),
        ] {
            let (_folder, system) = machine(&[
                ("proc/sys/kernel/sched_rt_period_us", period),
                ("proc/sys/kernel/sched_rt_runtime_us", runtime),
            ]);
            let found = throttling(&system);
            assert_eq!(found.verdict, verdict, "{found:?}");
            assert!(found.is.contains(words), "{found:?}");
        }
    }

    #[test]
    fn a_well_kept_machine_is_good_in_everything() {
        let (_folder, mut system) = machine(&[
            ("proc/sys/kernel/version", "#1 SMP PREEMPT_RT Debian"),
            ("proc/sys/kernel/sched_rt_period_us", "1000000"),
            ("proc/sys/kernel/sched_rt_runtime_us", "950000"),
            ("proc/sys/vm/compact_unevictable_allowed", "0"),
            ("proc/cpuinfo", "flags\t\t: fpu tsc"),
            ("proc/irq/24/smp_affinity_list", "0-2"),
            (
                "sys/devices/system/clocksource/clocksource0/current_clocksource",
                "tsc",
            ),
            ("sys/devices/system/cpu/isolated", "3"),
            ("sys/devices/system/cpu/online", "0-3"),
            (
                "sys/devices/system/cpu/cpu3/cpufreq/scaling_governor",
                "performance",
            ),
            ("sys/bus/usb-serial/devices/ttyUSB0/latency_timer", "1"),
        ]);
        system.trial = granted();
        system.rttime_us = None;
        for finding in all(&system, 3) {
            assert_eq!(finding.verdict, Verdict::Good, "{finding:?}");
        }
    }

    #[test]
    fn each_fault_is_found_with_its_command() {
        let (_folder, system) = machine(&[
            ("proc/sys/kernel/version", "#1 SMP PREEMPT_DYNAMIC"),
            ("sys/kernel/debug/sched/preempt", "none (voluntary) full"),
            ("proc/sys/kernel/sched_rt_runtime_us", "0"),
            ("proc/sys/vm/compact_unevictable_allowed", "1"),
            ("proc/self/cgroup", "4:cpu,cpuacct:/user\n1:name=systemd:/"),
            ("sys/fs/cgroup/cpu/user/cpu.rt_runtime_us", "0"),
            ("sys/fs/cgroup/cpu/user/cpu.cfs_quota_us", "20000"),
            ("sys/fs/cgroup/cpu/user/cpu.cfs_period_us", "100000"),
            ("proc/cpuinfo", "flags\t\t: fpu hypervisor"),
            ("proc/irq/24/smp_affinity_list", "0-3"),
            ("proc/irq/25/smp_affinity_list", "1"),
            (
                "sys/devices/system/clocksource/clocksource0/current_clocksource",
                "hpet",
            ),
            (
                "sys/devices/system/clocksource/clocksource0/available_clocksource",
                "tsc hpet",
            ),
            ("sys/devices/system/cpu/isolated", ""),
            ("sys/devices/system/cpu/online", "0-3"),
            (
                "sys/devices/system/cpu/cpu3/cpufreq/scaling_governor",
                "powersave",
            ),
            ("sys/devices/system/cpu/cpu3/cpuidle/state2/latency", "120"),
            ("sys/devices/system/cpu/cpu3/cpuidle/state2/name", "C6"),
            ("sys/bus/usb-serial/devices/ttyUSB0/latency_timer", "16"),
        ]);
        let found = all(&system, 3);
        for finding in &found {
            assert!(finding.verdict != Verdict::Good, "{finding:?}");
            let no_command = ["virtual machine"].contains(&finding.name);
            assert_eq!(finding.mend.is_none(), no_command, "{finding:?}");
        }
        let of = |name: &str| found.iter().find(|f| f.name == name).unwrap();
        assert_eq!(of("preemption").is, "PREEMPT_DYNAMIC, voluntary");
        assert_eq!(of("control group").verdict, Verdict::Bad);
        assert_eq!(of("realtime throttling").verdict, Verdict::Bad);
        assert!(of("interrupt affinity").is.starts_with("1 of 2"));
        assert!(of("idle states").is.contains("C6 (120 µs)"));
        assert!(
            of("USB serial latency")
                .mend
                .as_ref()
                .unwrap()
                .contains("ttyUSB0/latency_timer")
        );
    }

    #[test]
    fn lists_of_cores() {
        assert_eq!(parse_list("0-2,5\n"), [0, 1, 2, 5]);
        assert!(parse_list("").is_empty());
        assert_eq!(parse_list("x,3-1,-,7"), [7]);
        assert!(parse_list("0-99999999999").len() < 5000);
    }
}
