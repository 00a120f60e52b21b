//! Findings about the kernel: preemption, throttling, clock.

use super::finding::{Finding, Verdict, finding};
use super::system::System;

/// Share of each period that the kernel grants realtime threads by default.
const RT_SHARE: f64 = 0.95;

pub(super) fn compaction(system: &System) -> Finding {
    let name = "memory compaction";
    let should = "no: otherwise the kernel sometimes moves locked pages, with a page fault each";
    let mend = "sudo sysctl vm.compact_unevictable_allowed=0";
    match system.number("proc/sys/vm/compact_unevictable_allowed") {
        Some(0) => finding(name, Verdict::Good, "no", should, ""),
        // Neither file exists: the kernel was built without compaction.
        None if system.read("proc/sys/vm/compact_memory").is_none() => {
            finding(name, Verdict::Good, "no", should, "")
        }
        None => finding(name, Verdict::Unknown, "cannot be read", should, ""),
        Some(_) => finding(name, Verdict::Better, "allowed", should, mend),
    }
}

pub(super) fn preemption(system: &System) -> Finding {
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

pub(super) fn throttling(system: &System) -> Finding {
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

pub(super) fn clock(system: &System) -> Finding {
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

pub(super) fn virtual_machine(system: &System) -> Finding {
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
