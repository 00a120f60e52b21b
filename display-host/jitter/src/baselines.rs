//! Programs that the station is compared with. Each runs for a turn and prints a histogram in
//! cyclictest's format.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::ValueEnum;

use crate::problem::Problem;
use crate::timerlat;

pub use crate::turn::Turn;

/// Program of the package `tests/embassy-std`. It is separate because one program cannot link both
/// embassy's time driver and ours.
const EMBASSY_STD: &str = "calot-embassy-std";

/// Programs to compare the station with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Baseline {
    /// The kernel community's wake-up latency test (Debian package rt-tests)
    Cyclictest,
    /// The executor without the station: the cost of the loop itself
    Executor,
    /// A bare loop of clock_nanosleep
    Sleep,
    /// The bare loop with work, which takes in each period as long as the same tick of the
    /// station's last turn
    Burn,
    /// The kernel's own wake-up test, from its timer interrupt on (`rtla timerlat`). With any
    /// --compare it takes turns too if the machine has it
    Timerlat,
    /// Embassy's stock driver for std (install: `cargo install --path tests/embassy-std`)
    EmbassyStd,
}

impl Baseline {
    /// Name in JSON keys and reports. On the command line it has `-` instead of `_`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Cyclictest => "cyclictest",
            Self::Executor => "executor",
            Self::Sleep => "sleep",
            Self::Burn => "burn",
            Self::Timerlat => "timerlat",
            Self::EmbassyStd => "embassy_std",
        }
    }
}

/// Core, priority and work of the loops. They are those of the station's tick.
#[derive(Debug, Clone, Copy)]
pub struct Terms<'a> {
    /// Core of the loop.
    pub core: usize,
    /// `SCHED_FIFO` priority.
    pub priority: u8,
    /// Time spent spinning instead of sleeping before each period, µs.
    pub spin_us: u64,
    /// File with the working time of `burn` in each period, ns, one per line.
    pub work: &'a Path,
}

/// Runs one turn of a baseline. Returns `None` if the user stopped it.
pub fn turn(
    baseline: Baseline,
    terms: Terms<'_>,
    seconds: f64,
    stop: &AtomicBool,
) -> Result<Option<Turn>, Problem> {
    run(command(baseline, terms, seconds)?, baseline, stop)
}

/// Runs a command to its end and reads its histogram. Returns `None` if the user stopped it.
fn run(
    mut command: Command,
    baseline: Baseline,
    stop: &AtomicBool,
) -> Result<Option<Turn>, Problem> {
    let mut child = command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| format!("{}: {error}; {}", baseline.name(), mend(baseline)))?;
    // Read both pipes at once so that neither fills up.
    let stdout = child.stdout.take().map(read_all);
    let stderr = child.stderr.take().map(read_all);
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if stop.load(Ordering::Relaxed) {
            let _ = child.kill();
            let _ = child.wait();
            return Ok(None);
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    let text = |pipe: Option<std::thread::JoinHandle<String>>| {
        pipe.and_then(|thread| thread.join().ok())
            .unwrap_or_default()
    };
    let (said, complained) = (text(stdout), text(stderr));
    let turn = match baseline {
        Baseline::Timerlat => timerlat::parse(&said),
        _ => parse(&said),
    };
    if !status.success() || turn.wake_latency.count() == 0 {
        let complaint = complained.lines().next().unwrap_or("it said nothing");
        let name = baseline.name();
        return Err(format!(
            "{name} measured nothing ({status}): {complaint}; {}",
            mend(baseline)
        )
        .into());
    }
    Ok(Some(turn))
}

/// Checks before the measurement that a program is installed.
pub fn check(baseline: Baseline) -> Result<(), Problem> {
    let program = match baseline {
        Baseline::Cyclictest => PathBuf::from("cyclictest"),
        Baseline::EmbassyStd => beside(EMBASSY_STD),
        Baseline::Timerlat => return timerlat::check().map_err(Problem::from),
        Baseline::Executor | Baseline::Sleep | Baseline::Burn => return Ok(()),
    };
    let quiet = Stdio::null;
    let tried = Command::new(&program)
        .arg("--help")
        .stdin(quiet())
        .stdout(quiet())
        .stderr(quiet())
        .status();
    tried.map(|_| ()).map_err(|error| {
        let name = program.display();
        format!("cannot compare with {name}: {error}; {}", mend(baseline)).into()
    })
}

fn read_all(mut pipe: impl std::io::Read + Send + 'static) -> std::thread::JoinHandle<String> {
    std::thread::spawn(move || {
        let mut text = String::new();
        let _ = pipe.read_to_string(&mut text);
        text
    })
}

fn command(baseline: Baseline, terms: Terms<'_>, seconds: f64) -> Result<Command, Problem> {
    let Terms { core, priority, .. } = terms;
    // cyclictest takes whole seconds.
    let whole = seconds.ceil().max(1.0) as u64;
    let as_cyclictest = |program: PathBuf| {
        let mut command = Command::new(program);
        command.args(["-m", "-q", "-t1", "-i1000", "-h100000"]);
        command.args([
            format!("-p{priority}"),
            format!("-a{core}"),
            format!("-D{whole}"),
        ]);
        command
    };
    let own = |kind: &str, work: Option<&Path>| -> Result<Command, Problem> {
        let mut command = Command::new(std::env::current_exe()?);
        command.arg("bare-loop").arg(kind);
        for (name, value) in [
            ("--seconds", seconds.to_string()),
            ("--core", core.to_string()),
            ("--priority", priority.to_string()),
            ("--spin", terms.spin_us.to_string()),
            ("--with-parent", std::process::id().to_string()),
        ] {
            command.arg(name).arg(value);
        }
        if let Some(work) = work {
            command.arg("--work").arg(work);
        }
        Ok(command)
    };
    match baseline {
        Baseline::Cyclictest => Ok(as_cyclictest("cyclictest".into())),
        Baseline::EmbassyStd => Ok(as_cyclictest(beside(EMBASSY_STD))),
        Baseline::Timerlat => Ok(timerlat::command(core, priority, whole)),
        Baseline::Executor => own("executor", None),
        Baseline::Sleep => own("sleep", None),
        Baseline::Burn => own("sleep", Some(terms.work)),
    }
}

/// Path of a program in the folder of this program. If that folder lacks it, its bare name, which
/// the system looks up in PATH.
fn beside(name: &str) -> PathBuf {
    let here = std::env::current_exe().ok();
    here.and_then(|path| Some(path.parent()?.join(name)))
        .filter(|path| path.exists())
        .unwrap_or_else(|| name.into())
}

fn mend(baseline: Baseline) -> &'static str {
    match baseline {
        Baseline::Cyclictest => {
            "install it with `sudo apt install rt-tests`; may this user have that priority \
             (`calot check`)?"
        }
        Baseline::EmbassyStd => "install it with `cargo install --path tests/embassy-std`",
        Baseline::Timerlat => "it needs root and a kernel with CONFIG_TIMERLAT_TRACER",
        _ => "check that this user may have that priority (`calot check`)",
    }
}

/// Reads a histogram of lines `time count …`. Lines with `#` give the unit (µs if absent), the
/// longest time and the missed periods.
pub(crate) fn parse(text: &str) -> Turn {
    let mut turn = Turn::default();
    // A time in µs stands for the middle of its bin; times in ns are exact.
    let (mut scale, mut half) = (1000, 500);
    let mut counted = Vec::new();
    let (mut over, mut max_us) = (0u64, 0u64);
    for line in text.lines() {
        if let Some((name, value)) = line.strip_prefix('#').and_then(|l| l.split_once(':')) {
            let value = value.trim();
            let number = value.split_whitespace().next().and_then(|w| w.parse().ok());
            match (name.trim(), number) {
                ("Unit", _) if value == "ns" => (scale, half) = (1, 0),
                ("Max Latencies", Some(max)) => max_us = max,
                ("Histogram Overflows", Some(count)) => over = count,
                ("Work", Some(ns)) => {
                    let count = value.split_whitespace().nth(1).and_then(|w| w.parse().ok());
                    turn.burnt.record_n(ns, count.unwrap_or(0));
                }
                ("Missed, woken late", Some(n)) => turn.missed_mut().woken_late = n,
                ("Missed, at work", Some(n)) => turn.missed_mut().at_work = n,
                ("Occasions", Some(n)) => turn.missed_mut().occasions = n,
                ("Overruns", Some(n)) => turn.missed_mut().late_ticks = n,
                ("Realtime", _) => turn.realtime = Some(value == "true"),
                _ => {}
            }
            continue;
        }
        let mut words = line.split_whitespace().map(str::parse::<u64>);
        if let (Some(Ok(time)), Some(Ok(count))) = (words.next(), words.next()) {
            counted.push((time, count));
        }
    }
    for (time, count) in counted.into_iter().filter(|(_, count)| *count > 0) {
        let ns = time.saturating_mul(scale).saturating_add(half);
        turn.wake_latency.record_n(ns, count);
    }
    turn.wake_latency.record_n(max_us * 1000, over);
    let ticks = turn.wake_latency.count();
    if let Some(missed) = &mut turn.missed {
        missed.ticks = ticks;
    }
    turn
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::misses::Missed;

    #[test]
    fn cyclictests_histogram_is_read_with_what_did_not_fit_it() {
        let text = "# /dev/cpu_dma_latency set to 0us\n# Histogram\n000000 000000\n000010 000098\n\
                    000020 000001\n# Total: 000000100\n# Min Latencies: 00010\n\
                    # Max Latencies: 250000\n# Histogram Overflows: 00001\n\
                    # Histogram Overflow at cycle number:\n# Thread 0: 00007\n";
        let turn = parse(text);
        let q = turn.wake_latency.quantiles();
        assert_eq!(q.count, 100);
        assert!(q.p50.abs_diff(10_500) < 20, "{q:?}");
        assert!(q.max.abs_diff(250_000_000) < 300_000, "{q:?}");
        assert_eq!((turn.missed, turn.realtime), (None, None));
    }

    #[test]
    fn our_own_loops_count_ns_and_misses() {
        let turn = parse(
            "# Unit: ns\n1234 5\n99 1\n# Work: 70 2\n# Missed, woken late: 3\n# Missed, at work: 4\n\
             # Occasions: 2\n# Overruns: 9\n# Realtime: false",
        );
        assert_eq!(turn.wake_latency.counts(), [(99, 1), (1234, 5)]);
        assert_eq!(turn.burnt.counts(), [(70, 2)]);
        let missed = Missed {
            ticks: 6,
            woken_late: 3,
            at_work: 4,
            occasions: 2,
            late_ticks: 9,
        };
        assert_eq!((turn.missed, turn.realtime), (Some(missed), Some(false)));
        assert_eq!(parse("nonsense\n#\n1 x").wake_latency.count(), 0);
    }

    /// A program that is called `rtla` and runs the shell commands `does`.
    fn rtla(folder: &Path, does: &str) -> PathBuf {
        use std::os::unix::fs::PermissionsExt as _;
        let path = folder.join("rtla");
        std::fs::write(&path, format!("#!/bin/sh\n{does}\n")).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        path
    }

    #[test]
    fn a_turn_of_rtla_is_what_it_prints_and_its_complaint_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let asked = folder.path().join("asked");
        let prints = format!(
            "echo \"$@\" > {}; printf 'Index IRQ-001 Thr-001 Usr-001\\n3 1 2 5\\n9 0 0 1\\n'",
            asked.display()
        );
        let stop = AtomicBool::new(false);
        let turn = |does: &str| {
            let asked = timerlat::command(1, 80, 2);
            let mut fake = Command::new(rtla(folder.path(), does));
            fake.args(asked.get_args());
            run(fake, Baseline::Timerlat, &stop)
        };
        let q = turn(&prints).unwrap().unwrap().wake_latency.quantiles();
        assert_eq!((q.count, q.p50 / 1000, q.max / 1000), (6, 3, 9));
        let asked = std::fs::read_to_string(&asked).unwrap();
        assert!(asked.starts_with("timerlat hist --user-threads"), "{asked}");
        let failed = turn("echo 'Could not enable timerlat' >&2; exit 1").unwrap_err();
        let words = failed.to_string();
        assert!(
            words.contains("Could not enable timerlat") && words.contains("CONFIG_TIMERLAT_TRACER"),
            "{words}"
        );
    }
}
