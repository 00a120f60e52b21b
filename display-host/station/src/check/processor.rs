//! Findings about the tick's core: its isolation, interrupts, frequency and idle states.

use super::finding::{Finding, Verdict, finding};
use super::system::System;

/// An idle state with a longer exit latency counts as deep, µs.
const IDLE_EXIT_MAX_US: u64 = 10;

pub(super) fn isolation(system: &System, core: usize) -> Finding {
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

pub(super) fn interrupts(system: &System, core: usize) -> Finding {
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

pub(super) fn governor(system: &System, core: usize) -> Finding {
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

pub(super) fn idle(system: &System, core: usize) -> Finding {
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

/// Cores of a list such as `0-2,5`. Ignores malformed parts and cuts a range at 4096.
pub(super) fn parse_list(list: &str) -> Vec<usize> {
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
