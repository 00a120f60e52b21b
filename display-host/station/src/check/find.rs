//! Findings about a [`System`].

use super::finding::Finding;
use super::system::System;
use super::{granted, kernel, processor, serial};

/// Every finding about `system`, the most important first.
pub(crate) fn all(system: &System, core: usize) -> Vec<Finding> {
    vec![
        granted::priority(system),
        granted::memory(system),
        granted::affinity(system, core),
        granted::runaway(system),
        granted::quota(system),
        kernel::compaction(system),
        granted::group_scheduling(system),
        kernel::preemption(system),
        kernel::throttling(system),
        kernel::clock(system),
        processor::isolation(system, core),
        processor::interrupts(system, core),
        processor::governor(system, core),
        processor::idle(system, core),
        kernel::virtual_machine(system),
        serial::serial(system),
    ]
}

#[cfg(test)]
mod tests {
    use rt_process::refusal::{Call, Cause, Circumstances};
    use rt_process::trial::Trial;
    use rustix::io::Errno;

    use super::super::finding::Verdict;
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
    fn findings_have_the_results_of_the_calls() {
        let (_folder, mut system) = machine(&[]);
        let found = |system: &System| {
            [
                granted::priority(system),
                granted::memory(system),
                granted::affinity(system, 3),
            ]
        };
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
        assert!(
            granted::memory(&system)
                .is
                .contains("the limit memlock is 8192 KiB")
        );
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
        assert_eq!(granted::quota(&new).is, "50000 µs of every 100000 µs");
        let (_folder, old) = machine(&[
            ("proc/self/cgroup", "4:cpu,cpuacct:/user\n0::/"),
            ("sys/fs/cgroup/cpu/user/cpu.cfs_quota_us", "20000"),
            ("sys/fs/cgroup/cpu/user/cpu.cfs_period_us", "100000"),
        ]);
        assert_eq!(granted::quota(&old).verdict, Verdict::Better);
        let (_folder, free) = machine(&[
            ("proc/self/cgroup", "0::/box"),
            ("sys/fs/cgroup/box/cpu.max", "max 100000"),
        ]);
        assert_eq!(granted::quota(&free).verdict, Verdict::Good);
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
            let found = kernel::throttling(&system);
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
    fn a_latency_timer_that_is_too_long_or_cannot_be_read_is_found() {
        const FIRST: &str = "sys/bus/usb-serial/devices/ttyUSB0/latency_timer";
        const SECOND: &str = "sys/bus/usb-serial/devices/ttyUSB1/latency_timer";
        for (timers, verdict, is) in [
            (&[(FIRST, "1"), (SECOND, "0")][..], Verdict::Good, "1 ms"),
            (
                &[(FIRST, "1"), (SECOND, "")],
                Verdict::Unknown,
                "ttyUSB1 cannot be read",
            ),
            (
                &[(FIRST, "16"), (SECOND, "none")],
                Verdict::Better,
                "ttyUSB0 16 ms, ttyUSB1 cannot be read",
            ),
            (&[], Verdict::Good, "no such adapter plugged in"),
        ] {
            let (_folder, system) = machine(timers);
            let found = serial::serial(&system);
            assert_eq!((found.verdict, &*found.is), (verdict, is));
            assert_eq!(found.mend.is_some(), verdict != Verdict::Good);
        }
    }

    #[test]
    fn lists_of_cores() {
        assert_eq!(processor::parse_list("0-2,5\n"), [0, 1, 2, 5]);
        assert!(processor::parse_list("").is_empty());
        assert_eq!(processor::parse_list("x,3-1,-,7"), [7]);
        assert!(processor::parse_list("0-99999999999").len() < 5000);
    }
}
