//! Wake-up latency of embassy's stock std executor and time driver at 1 kHz, printed as a histogram
//! in cyclictest's form.
//!
//! Usage: `calot-embassy-std -p80 -a1 -D10` sets priority, core and seconds. The program accepts
//! and ignores cyclictest's other options. The driver's helper thread inherits the priority. A user
//! without realtime rights cannot run the program.

use std::collections::BTreeMap;
use std::io::Write as _;

use embassy_executor::Executor;
use embassy_time::{Instant, Timer};

const PERIOD_US: u64 = 1000;

fn main() {
    let (mut priority, mut core, mut seconds) = (80, 0, 10);
    for word in std::env::args().skip(1) {
        if word == "--help" {
            println!("calot-embassy-std -pPRIORITY -aCORE -DSECONDS");
            return;
        }
        let number = |text: &str| {
            text.parse()
                .unwrap_or_else(|_| fail(&format!("{word}: a number must follow, as in -p80")))
        };
        match word.split_at_checked(2) {
            Some(("-p", value)) => priority = number(value),
            Some(("-a", value)) => core = number(value),
            Some(("-D", value)) => seconds = number(value),
            _ => {}
        }
    }
    become_realtime(priority, core);
    // The open file keeps the processor from deep idle states until the end. If this user may not
    // open the file, the program runs without it, as cyclictest does.
    let _awake = std::fs::File::options()
        .write(true)
        .open("/dev/cpu_dma_latency")
        .and_then(|mut file| file.write_all(&[0; 4]).map(|()| file));
    let executor: &'static mut Executor = Box::leak(Box::new(Executor::new()));
    executor.run(move |spawner| {
        let token = measure(seconds.max(1) as u64 * 1_000_000 / PERIOD_US);
        spawner.spawn(token.unwrap_or_else(|_| fail("cannot start the measuring task")));
    });
}

#[embassy_executor::task]
async fn measure(periods: u64) {
    let mut latencies_ns = vec![1u32; periods as usize];
    latencies_ns.clear();
    // The first call starts the driver and its thread, which takes most of a millisecond.
    let _ = Instant::now();
    // Start of embassy's clock, which counts µs, on the monotonic clock.
    let zero_ns = monotonic_ns() - Instant::now().as_ticks() * 1000;
    let mut due_us = Instant::now().as_ticks() + 5 * PERIOD_US;
    let mut missed = 0;
    while latencies_ns.len() as u64 + missed < periods {
        Timer::at(Instant::from_ticks(due_us)).await;
        let late_ns = monotonic_ns().saturating_sub(zero_ns + due_us * 1000);
        latencies_ns.push(u32::try_from(late_ns).unwrap_or(u32::MAX));
        let skipped = late_ns / (PERIOD_US * 1000);
        missed += skipped;
        due_us += (skipped + 1) * PERIOD_US;
    }
    let mut histogram = BTreeMap::<u32, u64>::new();
    for ns in latencies_ns {
        *histogram.entry(ns).or_default() += 1;
    }
    let mut text = String::from("# Unit: ns\n");
    for (ns, count) in histogram {
        text += &format!("{ns} {count}\n");
    }
    println!("{text}# Missed: {missed}\n# Realtime: true");
    std::process::exit(0);
}

/// Locks memory, pins the thread and sets SCHED_FIFO, as `calot rt` does.
fn become_realtime(priority: i32, core: i32) {
    // SAFETY: plain calls; the structs are initialised and live on this stack.
    let refused = unsafe {
        let mut set: libc::cpu_set_t = core::mem::zeroed();
        libc::CPU_SET(core.clamp(0, libc::CPU_SETSIZE - 1) as usize, &mut set);
        let parameter = libc::sched_param {
            sched_priority: priority,
        };
        libc::mlockall(libc::MCL_CURRENT | libc::MCL_FUTURE) != 0
            || libc::sched_setaffinity(0, size_of::<libc::cpu_set_t>(), &set) != 0
            || libc::sched_setscheduler(0, libc::SCHED_FIFO, &parameter) != 0
    };
    if refused {
        fail(&format!(
            "not realtime: {}",
            std::io::Error::last_os_error()
        ));
    }
}

fn monotonic_ns() -> u64 {
    let mut now = libc::timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    // SAFETY: the pointer is to a local.
    unsafe { libc::clock_gettime(libc::CLOCK_MONOTONIC, &mut now) };
    now.tv_sec as u64 * 1_000_000_000 + now.tv_nsec as u64
}

fn fail(why: &str) -> ! {
    eprintln!("calot-embassy-std: {why}");
    std::process::exit(1)
}
