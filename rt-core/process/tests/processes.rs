//! The realtime process as a process of its own: it is killed, stopped, has no privileges, or runs
//! away.

use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use core::time::Duration;
use std::io::{BufRead, BufReader};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::thread;

use bytemuck::Zeroable;
use rt_process::time_driver::monotonic_ns;
use rt_process::{AdmissionPolicy, RtConfig};
use rustix::process::{Pid, Signal, kill_process};
use shared_mem::message::ToolFrame;
use shared_mem::service::{Host, Station};

mod support;
use support::{Bench, Emulated, host};

/// Time over which the force rises after each enable, s.
const RAMP_S: f32 = 0.4;

/// Starts a controller in a process of its own, which is this test program again.
fn spawn_controller(bench: &Bench, periods: u64, change: impl FnOnce(&mut Command)) -> Child {
    let mut command = Command::new(std::env::current_exe().expect("the test's own set-up"));
    command
        .args(["--exact", "controller_process", "--ignored", "--nocapture"])
        .env("RT_TEST_STATION", &bench.station)
        .env("RT_TEST_SCENE", bench.scene())
        .env("RT_TEST_PERIODS", periods.to_string())
        .stdout(Stdio::piped());
    change(&mut command);
    command.spawn().expect("the test's own set-up")
}

/// Body of the controller's process.
#[test]
#[ignore = "started by other tests as a process"]
fn controller_process() {
    let Ok(station) = std::env::var("RT_TEST_STATION") else {
        return;
    };
    let mut config = RtConfig::new(station, std::env::var("RT_TEST_SCENE").unwrap());
    config.periods_max = Some(std::env::var("RT_TEST_PERIODS").unwrap().parse().unwrap());
    config.admission = AdmissionPolicy::Skip;
    // On a busy machine samples go stale now and then, and the force starts again.
    config.parameters.force_ramp_s = RAMP_S;
    config.haptic = std::env::var_os("RT_TEST_HAPTIC").map(Into::into);
    let stop = Arc::new(AtomicBool::new(false));
    signal_hook::flag::register(signal_hook::consts::SIGTERM, Arc::clone(&stop)).unwrap();
    match rt_process::run(&config, &stop, |_| println!("\nready")) {
        Ok(summary) => {
            println!("\nrealtime {} {:?}", summary.realtime, summary.refused);
            println!("\nended {:?} faults {:?}", summary.ended, summary.faults);
        }
        Err(error) => println!("\nerror {error}"),
    }
}

fn signal(child: &Child, signal: Signal) {
    let pid = Pid::from_raw(child.id().cast_signed()).expect("the test's own set-up");
    kill_process(pid, signal).expect("the test's own set-up");
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
fn a_killed_controller_is_replaced_and_the_host_sees_the_new_one() {
    let bench = Bench::new();
    let host = host(&bench);
    let mut first = spawn_controller(&bench, u64::MAX, |_| ());
    assert!(line_with(&mut first, "ready").is_some());
    first.kill().unwrap();
    first.wait().unwrap();
    let (mut before, mut tools) = (ToolFrame::zeroed(), ToolFrame::zeroed());
    host.newest_tools(&mut before);

    let mut second = spawn_controller(&bench, u64::MAX, |_| ());
    assert!(line_with(&mut second, "ready").is_some());
    let mut seen = false;
    for _ in 0..12_000 {
        seen = host.newest_tools(&mut tools) && tools.at_ns > before.at_ns;
        if seen {
            break;
        }
        thread::sleep(Duration::from_millis(5));
    }
    signal(&second, Signal::TERM);
    let end = line_with(&mut second, "ended").unwrap();
    assert!(
        end.starts_with("ended Asked"),
        "SIGTERM ends it in order: {end}"
    );
    assert!(second.wait().unwrap().success());
    assert!(seen, "the old host follows the new controller");
}

#[test]
fn an_ordinary_user_gets_a_run_that_says_what_is_missing() {
    if !rustix::process::geteuid().is_root() {
        return; // covered by every other test: they then run as an ordinary user
    }
    let bench = Bench::new();
    let open = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    std::fs::set_permissions(bench.folder.path(), open).unwrap();
    let nobody = 65534;
    let mut child = spawn_controller(&bench, 200, |command| {
        command.uid(nobody).gid(nobody).current_dir("/");
    });
    let line = line_with(&mut child, "realtime").unwrap();
    assert!(child.wait().unwrap().success());
    assert!(line.starts_with("realtime false"), "{line}");
    for word in ["SCHED_FIFO priority 80", "memory is not locked", "setcap"] {
        assert!(line.contains(word), "{line}");
    }
}

#[test]
fn thread_that_takes_the_core_from_the_tick_is_reported() {
    let bench = Bench::new();
    let mut child = spawn_controller(&bench, 6000, |_| ());
    assert!(line_with(&mut child, "ready").is_some());
    let tasks = format!("/proc/{}/task", child.id());
    let is_tick = |task: &std::path::Path| {
        std::fs::read_to_string(task.join("comm")).is_ok_and(|name| name.trim() == "calot-tick")
    };
    let task = std::fs::read_dir(tasks)
        .unwrap()
        .find_map(|entry| Some(entry.unwrap().path()).filter(|path| is_tick(path)))
        .unwrap();
    let id: i32 = task.file_name().unwrap().to_str().unwrap().parse().unwrap();
    let thread = rustix::thread::Pid::from_raw(id);
    let pinned = rustix::thread::sched_getaffinity(thread).unwrap();
    let mut wider = rustix::thread::sched_getaffinity(None).unwrap();
    if pinned.count() != 1 || wider.count() < 2 {
        child.kill().unwrap();
        child.wait().unwrap();
        return; // nothing to take: one core, or not allowed to pin
    }
    wider.set(0);
    rustix::thread::sched_setaffinity(thread, &wider).unwrap();
    let line = line_with(&mut child, "realtime").unwrap();
    assert!(child.wait().unwrap().success());
    assert!(line.starts_with("realtime false"), "{line}");
    assert!(line.contains("more than one core"), "{line}");
}

#[test]
fn a_stopped_controller_goes_on_without_a_jolt() {
    let bench = Bench::new();
    let devices = Emulated::start(&bench);
    let host = host(&bench);
    let mut child = spawn_controller(&bench, u64::MAX, |command| {
        command.env("RT_TEST_HAPTIC", &devices.lines.haptic);
    });
    assert!(line_with(&mut child, "ready").is_some());

    // Wait until the hand presses: the script takes some seconds to get there.
    let mut tools = ToolFrame::zeroed();
    let force_n = |tools: &ToolFrame| tools.force_n.iter().map(|f| f * f).sum::<f32>().sqrt();
    for _ in 0..30_000 {
        if host.newest_tools(&mut tools) && force_n(&tools) > 0.3 {
            break;
        }
        thread::sleep(Duration::from_millis(1));
    }
    let before_n = force_n(&tools);
    if before_n <= 0.3 {
        signal(&child, Signal::TERM);
        let end = line_with(&mut child, "ended");
        let (tick, contacts, health) = (tools.tick, tools.contact_count, tools.health[0]);
        panic!(
            "the hand presses: {before_n} N, tick {tick}, {contacts} contacts, {health:?}; {end:?}"
        );
    }
    signal(&child, Signal::STOP);
    thread::sleep(Duration::from_millis(300));
    while host.newest_tools(&mut tools) {} // skips what was published before the stop
    let last_tick = tools.tick;
    let continued_ns = monotonic_ns();
    signal(&child, Signal::CONT);
    // Frames of ticks from before the stop may still arrive.
    let is_later = |frame: &ToolFrame| frame.tick > last_tick && frame.sample_ns >= continued_ns;
    let mut first = tools;
    for _ in 0..12_000 {
        if host.newest_tools(&mut first) && is_later(&first) {
            break;
        }
        thread::sleep(Duration::from_millis(1));
    }
    assert!(is_later(&first), "the controller goes on");
    // If the first frame comes late, the force has already risen further.
    let ticks = first.tick - last_tick;
    let after_n = force_n(&first);
    assert!(
        ticks as f32 > 1000.0 * RAMP_S / 8.0 || after_n < before_n / 2.0,
        "{after_n} N after {ticks} ticks"
    );

    signal(&child, Signal::TERM);
    let end = line_with(&mut child, "ended").unwrap();
    assert!(end.contains("stale_device"), "{end}");
    assert!(child.wait().unwrap().success());
    devices.unplug();
}

/// Body of a process whose realtime thread never sleeps.
#[test]
#[ignore = "started by another test as a process"]
fn runaway_process() {
    let guard = rt_process::runaway::RunawayGuard::arm().unwrap();
    let told = Arc::new(AtomicBool::new(false));
    let core = rt_process::realtime::allowed_cores()[0];
    let flag = Arc::clone(&told);
    thread::spawn(move || {
        let _ = rt_process::realtime::pin_to(&[core]);
        let fifo = rt_process::realtime::take_fifo(50);
        println!("\nfifo {}", fifo.is_ok());
        while !flag.load(Relaxed) {
            core::hint::spin_loop();
        }
    });
    while !guard.tripped() {
        thread::sleep(Duration::from_millis(1));
    }
    told.store(true, Relaxed);
    println!("\ntripped");
}

#[test]
fn a_realtime_thread_that_never_sleeps_is_noticed() {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "runaway_process", "--ignored", "--nocapture"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let fifo = line_with(&mut child, "fifo").unwrap();
    if fifo == "fifo false" {
        child.kill().unwrap(); // an ordinary user has no realtime threads
        child.wait().unwrap();
        return;
    }
    let told = line_with(&mut child, "tripped").is_some();
    let status = child.wait().unwrap();
    // If not even the main thread gets a core, the kernel ends the process.
    let killed = status.signal() == Some(Signal::KILL.as_raw());
    assert!(if told { status.success() } else { killed }, "{status}");
}

/// Body of a display that watches until it is killed.
#[test]
#[ignore = "started by another test as a process"]
fn display_process() {
    let station = Station::new(&std::env::var("RT_TEST_STATION").unwrap()).unwrap();
    let host = Host::open(&station).unwrap();
    let mut tools = ToolFrame::zeroed();
    let mut told = false;
    loop {
        if host.newest_tools(&mut tools) && !told {
            println!("\nsees");
            told = true;
        }
        host.drain_timing(|_| ());
        thread::sleep(Duration::from_millis(5));
    }
}

/// `RT_TEST_SECONDS=600 cargo test --release -p rt-process --test processes -- --ignored --exact \
/// --nocapture displays_that_join_leave_and_are_killed_cost_the_tick_nothing`; with
/// `RT_TEST_SCENE` on a scene of your own.
#[test]
#[ignore = "takes a minute; a longer run is for the report"]
fn displays_that_join_leave_and_are_killed_cost_the_tick_nothing() {
    let number = |name: &str| std::env::var(name).ok()?.parse().ok();
    let seconds: u64 = number("RT_TEST_SECONDS").unwrap_or(60);
    let bench = Bench::new();
    let devices = Emulated::start(&bench);
    let mut config = devices.config(&bench);
    if let Some(scene) = std::env::var_os("RT_TEST_SCENE") {
        config.scene = scene.into();
    }
    config.admission = AdmissionPolicy::Measure;
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    let controller = thread::spawn(move || rt_process::run(&config, &flag, |_| ()));
    let start = std::time::Instant::now();
    let mut killed = 0;
    while start.elapsed().as_secs() < seconds && !controller.is_finished() {
        let mut display = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "display_process", "--ignored", "--nocapture"])
            .env("RT_TEST_STATION", &bench.station)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let leaving = host(&bench);
        assert!(line_with(&mut display, "sees").is_some());
        thread::sleep(Duration::from_millis(400));
        drop(leaving);
        display.kill().unwrap();
        display.wait().unwrap();
        killed += 1;
    }
    stop.store(true, Relaxed);
    let summary = controller.join().unwrap().unwrap();
    println!("{killed} displays killed; {summary:#?}");
    assert!(killed > seconds / 3);
    assert_eq!(summary.allocations_after_start, Some(0));
    if summary.realtime {
        // If the kernel may move locked pages, it does so now and then.
        let allowed = std::fs::read_to_string("/proc/sys/vm/compact_unevictable_allowed");
        let most = if allowed.is_ok_and(|it| it.trim() != "0") {
            16
        } else {
            0
        };
        assert!(summary.page_faults_after_start <= most, "{summary:?}");
    }
    devices.unplug();
}
