//! Wake-up latency of the realtime loop next to cyclictest's, interleaved in the same minutes.
//!
//! `cargo run --release -p rt-process --example wake_latency -- [ROUNDS] [SECONDS] [CORE]
//! [WORK_US]` (as root or with raised realtime limits; needs the package `rt-tests`). On a machine
//! that does other work, absolute figures from p99 upwards are noise: compare the ratios over
//! several rounds. Every tick of our loops computes for WORK_US, while cyclictest does no work. So
//! the misses of our loops are those of a tick that takes WORK_US. With ROUNDS 0 the program
//! reports only the cost of the executor and of an empty tick.

use std::process::Command;

use rt_process::probe::{Loop, Probe, empty_tick_cost_ns, executor_cost_ns};
use rt_process::realtime::allowed_cores;

const PRIORITY: u8 = 80;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let mut number = |default: u64| args.next().map_or(Ok(default), |word| word.parse());
    let (rounds, seconds) = (number(3)?, number(10)?);
    let last = allowed_cores().last().copied().unwrap_or(0);
    let core = usize::try_from(number(last as u64)?)?;
    let work_ns = u32::try_from(number(0)? * 1000)?;
    let missed = std::cell::Cell::new(0);
    let probe = |kind| {
        let probe = Probe {
            kind,
            periods: seconds * 1000,
            core,
            priority: PRIORITY,
            work_ns: if work_ns > 0 {
                vec![work_ns]
            } else {
                Vec::new()
            },
        };
        let found = probe.run()?;
        if !found.standing.is_realtime() {
            eprintln!("NOT REALTIME: {:?}", found.standing.refused);
        }
        missed.set(found.misses.periods());
        Ok::<_, rt_process::RtError>(found.wake_latency_ns)
    };
    type Measure<'a> = Box<dyn Fn() -> Result<Vec<u32>, Box<dyn std::error::Error>> + 'a>;
    let variants: [(&str, Measure<'_>); 4] = [
        ("cyclictest", Box::new(|| cyclictest(seconds, core))),
        (
            "executor",
            Box::new(|| Ok(probe(Loop::Executor { spin_ns: 0 })?)),
        ),
        (
            "executor, spin 200 µs",
            Box::new(|| Ok(probe(Loop::Executor { spin_ns: 200_000 })?)),
        ),
        ("plain loop", Box::new(|| Ok(probe(Loop::Plain)?))),
    ];
    println!(
        "executor and schedule: {:.0} ns a tick (simulated time); a tick without work: {:.0} ns",
        executor_cost_ns(1_000_000),
        empty_tick_cost_ns(1_000_000)?
    );
    if rounds == 0 {
        return Ok(());
    }
    println!(
        "{rounds} rounds of {seconds} s each, core {core}, FIFO {PRIORITY}; µs, and ÷ cyclictest"
    );
    println!(
        "{:24}{:>10}{:>10}{:>10}{:>8}{:>8}{:>10}",
        "", "p50", "p99", "max", "p50 ÷", "p99 ÷", "missed ppm"
    );
    let mut ratios = vec![Vec::new(); variants.len()];
    for round in 0..rounds {
        let mut reference = None;
        for (i, (name, measure)) in variants.iter().enumerate() {
            missed.set(0);
            let mut ns = measure()?;
            let ticks = ns.len() as u64 + missed.get();
            let per_million = missed.get() * 1_000_000 / ticks;
            ns.sort_unstable();
            let us = |q: f64| f64::from(ns[((ns.len() - 1) as f64 * q) as usize]) / 1000.0;
            let (p50, p99, max) = (us(0.5), us(0.99), us(1.0));
            let (ref50, ref99) = *reference.get_or_insert((p50, p99));
            ratios[i].push((p50 / ref50, p99 / ref99));
            let (r50, r99) = (p50 / ref50, p99 / ref99);
            println!(
                "{round} {name:22}{p50:10.1}{p99:10.1}{max:10.1}{r50:8.2}{r99:8.2}{per_million:10}"
            );
        }
    }
    println!("median of the rounds' ratios:");
    for ((name, _), ratios) in variants.iter().zip(&mut ratios) {
        let mut median = |of: fn(&(f64, f64)) -> f64| {
            ratios.sort_by(|a, b| of(a).total_cmp(&of(b)));
            of(&ratios[ratios.len() / 2])
        };
        println!(
            "  {name:22} p50 {:.2}  p99 {:.2}",
            median(|r| r.0),
            median(|r| r.1)
        );
    }
    Ok(())
}

/// Latencies measured by cyclictest, ns. cyclictest counts whole µs.
fn cyclictest(seconds: u64, core: usize) -> Result<Vec<u32>, Box<dyn std::error::Error>> {
    let output = Command::new("cyclictest")
        .args(["-m", "-q", "-t1", "-i1000", "-h100000"])
        .args([
            format!("-p{PRIORITY}"),
            format!("-a{core}"),
            format!("-D{seconds}"),
        ])
        .output()
        .map_err(|error| format!("cyclictest: {error}; install the package rt-tests"))?;
    let text = String::from_utf8(output.stdout)?;
    let mut latencies = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let mut words = line.split_whitespace();
        if let (Some(us), Some(count)) = (words.next(), words.next())
            && let (Ok(us), Ok(count)) = (us.parse::<u32>(), count.parse::<usize>())
        {
            // The middle of the histogram's bin.
            latencies.extend(std::iter::repeat_n(us * 1000 + 500, count));
        }
    }
    if latencies.is_empty() {
        return Err(format!("cyclictest measured nothing; may it use FIFO {PRIORITY}?").into());
    }
    Ok(latencies)
}
