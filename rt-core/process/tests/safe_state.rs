//! The force that a device renders when its controller fails: it must be zero within the stated
//! time in every case. The test emulates the device and measures the force that the device renders.

use core::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering::Relaxed};
use core::time::Duration;
use std::io::{BufRead, BufReader};
use std::os::unix::ffi::OsStrExt as _;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};

use hardware::rig::device::{Device, Motion};
use hardware::rig::wire::Capabilities;
use rt_process::time_driver::monotonic_ns;
use rt_process::{AdmissionPolicy, FORCE_ZERO_WITHIN, RtConfig};
use rustix::process::{Pid, Signal, kill_process};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

mod support;
use support::Bench;

/// Height of the handle in the device's frame at which the tip is 2 cm above the tissue, m.
const ABOVE_M: f32 = 0.06;
/// Height of the handle in the device's frame at which the tip is 1 cm inside the tissue, m.
const PRESSED_M: f32 = 0.03;
/// Tests in parallel would disturb each other's core and timing.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// Force that the device renders.
#[derive(Debug, Default)]
struct Seen {
    force_n: AtomicU32,
    /// Time at which the motors last had a force.
    last_force_ns: AtomicU64,
    /// Longest time for which an ordinary thread got no core, ns.
    gap_ns: AtomicU64,
    pull_the_plug: AtomicBool,
    end: AtomicBool,
}

impl Seen {
    fn force_n(&self) -> f32 {
        f32::from_bits(self.force_n.load(Relaxed))
    }
}

/// A rig's firmware on a pty, with a hand that presses and stays.
struct Rig {
    seen: Arc<Seen>,
    threads: [JoinHandle<()>; 2],
    tty: PathBuf,
}

impl Rig {
    fn start() -> Self {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC);
        let master = master.expect("the test's own set-up");
        grantpt(&master).expect("the test's own set-up");
        unlockpt(&master).expect("the test's own set-up");
        let name = ptsname(&master, Vec::new()).expect("the test's own set-up");
        let tty = PathBuf::from(std::ffi::OsStr::from_bytes(name.as_bytes()));
        let slave = std::fs::File::options()
            .read(true)
            .write(true)
            .open(&tty)
            .expect("the test's own set-up");
        let mut raw = tcgetattr(&slave).expect("the test's own set-up");
        raw.make_raw();
        tcsetattr(&slave, OptionalActions::Now, &raw).expect("the test's own set-up");
        rustix::fs::fcntl_setfl(&master, rustix::fs::OFlags::NONBLOCK)
            .expect("the test's own set-up");
        let seen = Arc::<Seen>::default();
        let shared = Arc::clone(&seen);
        let waiting = Arc::clone(&seen);
        let waits = thread::spawn(move || {
            let mut last_ns = monotonic_ns();
            while !waiting.end.load(Relaxed) {
                thread::sleep(Duration::from_micros(300));
                let now_ns = monotonic_ns();
                waiting.gap_ns.fetch_max(now_ns - last_ns, Relaxed);
                last_ns = now_ns;
            }
        });
        let device = thread::spawn(move || {
            support::have_own_processor();
            let mut line = Some((master, slave));
            let mut device = Device::new(Capabilities::touch_class());
            let mut motion = Motion::default();
            motion.position_m[2] = ABOVE_M;
            let mut next_state_ns = 0;
            let mut buffer = [0; 4096];
            while !shared.end.load(Relaxed) {
                thread::sleep(Duration::from_micros(300));
                let now_ns = monotonic_ns();
                let now_us = (now_ns / 1000) as u32;
                if shared.pull_the_plug.load(Relaxed) {
                    line = None;
                }
                if let Some((master, _)) = &line {
                    let heard = rustix::io::read(master, &mut buffer).unwrap_or(0);
                    device.receive(&buffer[..heard], now_us);
                    if let Some(answer) = device.answer() {
                        let _ = rustix::io::write(master, answer.as_bytes());
                    }
                    if now_ns >= next_state_ns {
                        next_state_ns = now_ns + 1_000_000;
                        if let Some(state) = device.state(&motion, now_us) {
                            let _ = rustix::io::write(master, state.as_bytes());
                            // 5 cm/s down, once a host listens.
                            motion.position_m[2] = (motion.position_m[2] - 5e-5).max(PRESSED_M);
                        }
                    }
                }
                let force_n = device.force(now_us).force_n;
                let force_n = force_n.iter().map(|f| f * f).sum::<f32>().sqrt();
                shared.force_n.store(force_n.to_bits(), Relaxed);
                if force_n > 0.0 {
                    shared.last_force_ns.store(now_ns, Relaxed);
                }
            }
        });
        Self {
            seen,
            threads: [device, waits],
            tty,
        }
    }
}

/// Body of the controller's process.
#[test]
#[ignore = "started by other tests as a process"]
fn controller_process() {
    let Some(tty) = std::env::var_os("RT_TEST_HAPTIC") else {
        return;
    };
    let mut config = RtConfig::new(
        std::env::var("RT_TEST_STATION").unwrap(),
        std::env::var_os("RT_TEST_SCENE").unwrap(),
    );
    config.admission = AdmissionPolicy::Skip;
    // On a busy machine samples go stale now and then, and the force starts again.
    config.parameters.force_ramp_s = 0.2;
    config.haptic = Some(tty.into());
    let flag = |signal| {
        let flag = Arc::new(AtomicBool::new(false));
        signal_hook::flag::register(signal, Arc::clone(&flag)).unwrap();
        flag
    };
    let stop = flag(signal_hook::consts::SIGTERM);
    let unlock = flag(signal_hook::consts::SIGUSR1);
    let starve = flag(signal_hook::consts::SIGUSR2);
    let core = rt_process::realtime::allowed_cores()
        .last()
        .copied()
        .unwrap();
    thread::spawn(move || {
        loop {
            thread::sleep(Duration::from_millis(1));
            if unlock.swap(false, Relaxed) {
                rustix::mm::munlockall().unwrap();
            }
            if starve.swap(false, Relaxed) {
                rt_process::realtime::pin_to(&[core]).unwrap();
                let fifo = rt_process::realtime::take_fifo(90);
                let start_ns = monotonic_ns();
                while fifo.is_ok() && monotonic_ns() < start_ns + 400_000_000 {
                    core::hint::spin_loop();
                }
                return;
            }
        }
    });
    let outcome = rt_process::run(&config, &stop, |ready| {
        println!("\nready {}", ready.realtime);
    });
    match outcome {
        Ok(summary) => println!("\nended {:?} {:?}", summary.ended, summary.refused),
        Err(error) => println!("\nended {error}"),
    }
}

/// A controller whose device renders a force.
struct Pressing {
    rig: Rig,
    child: Child,
    /// True if Linux granted realtime.
    realtime: bool,
    _bench: Bench,
}

impl Pressing {
    /// Starts controllers until one renders a force. On a very busy machine, samples come in jumps,
    /// and the speed trip holds the force back for good.
    fn start() -> Self {
        (0..5).find_map(|_| Self::try_start()).expect("a force")
    }

    fn try_start() -> Option<Self> {
        let (bench, rig) = (Bench::new(), Rig::start());
        let mut child = Command::new(std::env::current_exe().expect("the test's own set-up"))
            .args(["--exact", "controller_process", "--ignored", "--nocapture"])
            .env("RT_TEST_STATION", &bench.station)
            .env("RT_TEST_SCENE", bench.scene())
            .env("RT_TEST_HAPTIC", &rig.tty)
            .stdout(Stdio::piped())
            .spawn()
            .expect("the test's own set-up");
        let ready = line_with(&mut child, "ready").expect("the test's own set-up");
        let station = Self {
            rig,
            child,
            realtime: ready == "ready true",
            _bench: bench,
        };
        for _ in 0..10_000 {
            if station.rig.seen.force_n() > 0.1 {
                return Some(station);
            }
            thread::sleep(Duration::from_millis(1));
        }
        station.signal(Signal::KILL);
        station.end();
        None
    }

    fn signal(&self, signal: Signal) {
        kill_process(Pid::from_child(&self.child), signal).expect("the test's own set-up");
    }

    /// Applies `harm`. The force must become zero in time and stay zero.
    fn is_safe_after(&mut self, what: &str, harm: impl FnOnce(&Self)) {
        let seen = &self.rig.seen;
        seen.gap_ns.store(0, Relaxed);
        let start_ns = monotonic_ns();
        harm(self);
        thread::sleep(FORCE_ZERO_WITHIN * 4);
        assert!(seen.force_n() == 0.0, "{what}: {} N", seen.force_n());
        let last_ns = seen.last_force_ns.load(Relaxed);
        let took_ms = last_ns.saturating_sub(start_ns) as f64 / 1e6;
        // Waiting time of ordinary threads for a core, here and in the controller.
        let noise_ms = 2.0 * seen.gap_ns.load(Relaxed) as f64 / 1e6;
        println!("{what}: force zero after {took_ms:.1} ms (noise {noise_ms:.1} ms)");
        let stated_ms = FORCE_ZERO_WITHIN.as_secs_f64() * 1e3;
        assert!(
            took_ms <= stated_ms + noise_ms,
            "{what}: {took_ms} ms, noise {noise_ms} ms"
        );
    }

    fn end(mut self) -> Option<String> {
        let said = line_with(&mut self.child, "ended");
        self.child.wait().expect("the test's own set-up");
        self.rig.seen.end.store(true, Relaxed);
        for thread in self.rig.threads {
            thread.join().expect("the test's own set-up");
        }
        said
    }
}

/// First line of the process's output that starts with `word`.
fn line_with(child: &mut Child, word: &str) -> Option<String> {
    // One byte at a time, because bytes read ahead would be lost to the next call.
    let lines = BufReader::with_capacity(1, child.stdout.as_mut()?).lines();
    lines
        .map_while(Result::ok)
        .find(|line| line.starts_with(word))
}

#[test]
fn signals_leave_no_force() {
    let _turn = ONE_AT_A_TIME.lock();
    for signal in [Signal::TERM, Signal::KILL, Signal::ABORT] {
        let mut station = Pressing::start();
        station.is_safe_after(&format!("{signal:?}"), |s| s.signal(signal));
        let said = station.end();
        assert_eq!(said.is_some(), signal == Signal::TERM, "{said:?}");
    }
}

#[test]
fn a_stopped_controller_leaves_no_force_and_starts_again_from_none() {
    let _turn = ONE_AT_A_TIME.lock();
    let mut station = Pressing::start();
    let before_n = station.rig.seen.force_n();
    station.is_safe_after("SIGSTOP", |s| s.signal(Signal::STOP));
    station.signal(Signal::CONT);
    let (seen, start_ns) = (Arc::clone(&station.rig.seen), monotonic_ns());
    while seen.force_n() == 0.0 && monotonic_ns() < start_ns + 10_000_000_000 {
        thread::sleep(Duration::from_micros(300));
    }
    let back_n = seen.force_n();
    let after_ms = (monotonic_ns() - start_ns) / 1_000_000;
    println!("SIGCONT: {back_n} N of {before_n} N after {after_ms} ms");
    assert!(back_n > 0.0, "the force comes back");
    assert!(after_ms > 500 || back_n < before_n / 2.0, "{back_n} N");
    station.signal(Signal::TERM);
    assert!(station.end().is_some());
}

#[test]
fn an_unplugged_device_renders_no_force() {
    let _turn = ONE_AT_A_TIME.lock();
    let mut station = Pressing::start();
    station.is_safe_after("unplugged", |s| {
        s.rig.seen.pull_the_plug.store(true, Relaxed);
    });
    station.signal(Signal::TERM);
    assert!(station.end().unwrap().starts_with("ended Asked"));
}

#[test]
fn unlocked_memory_cuts_the_force() {
    let _turn = ONE_AT_A_TIME.lock();
    let mut station = Pressing::start();
    if station.realtime {
        station.is_safe_after("memory unlocked", |s| s.signal(Signal::USR1));
    }
    station.signal(Signal::TERM);
    let realtime = station.realtime;
    let said = station.end().unwrap();
    assert_eq!(said.contains("memory was unlocked"), realtime, "{said}");
}

#[test]
fn a_starved_tick_leaves_no_force_and_ends() {
    let _turn = ONE_AT_A_TIME.lock();
    let mut station = Pressing::start();
    let one_core = rt_process::realtime::allowed_cores().len() < 2;
    if !station.realtime || one_core {
        station.signal(Signal::TERM);
        station.end();
        return; // no right to starve the tick, or only one core for all
    }
    station.is_safe_after("tick starved", |s| s.signal(Signal::USR2));
    let said = station.end().unwrap();
    assert!(said.starts_with("ended Runaway"), "{said}");
}
