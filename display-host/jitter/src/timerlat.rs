//! Runs `rtla timerlat` and reads its histogram.

use std::process::{Command, Stdio};

use crate::turn::Turn;

/// Longest time of a line in the histogram, µs, as for cyclictest.
const ENTRIES: u32 = 100_000;
/// Files that name the kernel's tracers.
const TRACERS: [&str; 2] = [
    "/sys/kernel/tracing/available_tracers",
    "/sys/kernel/debug/tracing/available_tracers",
];

/// Command of one turn of `seconds`. A thread of the same priority on the same core wakes every ms.
pub(crate) fn command(core: usize, priority: u8, seconds: u64) -> Command {
    let mut command = Command::new("rtla");
    command.args([
        "timerlat",
        "hist",
        "--user-threads",
        "--period",
        "1000",
        "--no-aa",
    ]);
    for (option, value) in [
        ("--cpus", core.to_string()),
        ("--priority", format!("f:{priority}")),
        ("--duration", format!("{seconds}s")),
        ("--entries", ENTRIES.to_string()),
    ] {
        command.arg(option).arg(value);
    }
    command
}

/// Checks that `rtla` is installed and that the kernel has its tracer.
///
/// # Errors
///
/// The missing part and its remedy.
pub fn check() -> Result<(), String> {
    let quiet = Stdio::null;
    let tried = Command::new("rtla")
        .args(["timerlat", "hist", "--help"])
        .stdin(quiet())
        .stdout(quiet())
        .stderr(quiet())
        .status();
    if let Err(error) = tried {
        return Err(format!(
            "rtla timerlat did not take part: rtla: {error}; install it with `sudo apt install rtla` \
             or `linux-tools`"
        ));
    }
    let tracers = TRACERS.map(|path| std::fs::read_to_string(path).unwrap_or_default());
    in_kernel(&tracers.concat())
}

fn in_kernel(tracers: &str) -> Result<(), String> {
    match tracers.split_whitespace().collect::<Vec<_>>() {
        names if names.contains(&"timerlat") => Ok(()),
        names if names.is_empty() => Err(
            "rtla timerlat did not take part: the kernel's tracers cannot be read; run as root, \
             with tracefs mounted (`sudo mount -t tracefs nodev /sys/kernel/tracing`)"
                .to_owned(),
        ),
        names => Err(format!(
            "rtla timerlat did not take part: the kernel has only these tracers: {}; it needs \
             CONFIG_TIMERLAT_TRACER",
            names.join(", ")
        )),
    }
}

/// Reads the histogram of `rtla timerlat hist`. It has a column for the interrupt, one for the
/// kernel's thread, and one for the thread in user space. The last is compared with the station.
pub(crate) fn parse(text: &str) -> Turn {
    let mut turn = Turn::default();
    let mut column = None;
    let (mut over, mut max_us) = (0, 0);
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        let Some((&first, rest)) = words.split_first() else {
            continue;
        };
        if first == "Index" {
            let of = |kind: &str| rest.iter().position(|name| name.starts_with(kind));
            column = of("Usr").or_else(|| of("Thr"));
            continue;
        }
        let value = column.and_then(|column| rest.get(column)?.parse::<u64>().ok());
        let Some(value) = value else {
            continue;
        };
        match (first, first.parse::<u64>()) {
            // A time in µs stands for the middle of its bin.
            (_, Ok(us)) => turn.wake_latency.record_n(us * 1000 + 500, value),
            ("over:", _) => over = value,
            ("max:", _) => max_us = value,
            // A summary of all cores may follow.
            ("ALL:", _) => break,
            _ => {}
        }
    }
    turn.wake_latency.record_n(max_us * 1000, over);
    turn
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From the kernel's documentation (Documentation/tools/rtla/rtla-timerlat-hist.rst), with the
    /// columns of a thread in user space and two times beyond the last line.
    const TEXT: &str = "\
# RTLA timerlat histogram
# Time unit is microseconds (us)
# Duration:   0 00:10:00
Index   IRQ-001   Thr-001   Usr-001
0        276489         0         0
1        206089      9800       100
2          3511    500000    450000
30            0         1         2
over:         0         0         2
count:   486089    509801    450104
min:          0         1         1
avg:          0         2         2
max:          2        30     12000
ALL:        IRQ       Thr       Usr
count:   486089    509801    450104
max:          2        30     12000
";

    #[test]
    fn the_thread_in_user_space_is_compared() {
        let turn = parse(TEXT);
        let q = turn.wake_latency.quantiles();
        assert_eq!(q.count, 450_104);
        assert!(
            q.p50.abs_diff(2500) < 5 && q.max.abs_diff(12_000_000) < 10_000,
            "{q:?}"
        );
        assert!(turn.missed.is_none());
    }

    #[test]
    fn older_versions_have_only_the_kernels_thread() {
        let cut: Vec<&str> = TEXT
            .lines()
            .map(|line| line.get(..27).unwrap_or(line))
            .collect();
        let q = parse(&cut.join("\n")).wake_latency.quantiles();
        assert_eq!((q.count, q.max / 1000), (509_801, 30));
        assert_eq!(parse("nonsense\nIndex\n1 2 3").wake_latency.count(), 0);
    }

    #[test]
    fn a_missing_tracer_is_named_with_its_remedy() {
        assert_eq!(in_kernel("timerlat osnoise nop\n"), Ok(()));
        let lacks = in_kernel("blk function nop\n").unwrap_err();
        assert!(
            lacks.contains("only these tracers: blk, function, nop"),
            "{lacks}"
        );
        assert!(lacks.contains("CONFIG_TIMERLAT_TRACER"), "{lacks}");
        let unread = in_kernel("").unwrap_err();
        assert!(
            unread.contains("the kernel's tracers cannot be read"),
            "{unread}"
        );
    }

    #[test]
    fn a_turn_runs_at_the_ticks_priority_on_its_core() {
        let command = command(3, 80, 20);
        let words: Vec<_> = command
            .get_args()
            .filter_map(|word| word.to_str())
            .collect();
        let text = words.join(" ");
        assert!(
            text.contains("--cpus 3 --priority f:80 --duration 20s"),
            "{text}"
        );
    }
}
