//! The realtime process over real shared memory, without devices.
#![allow(clippy::unwrap_used)] // a panic is how a test fails

use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use core::time::Duration;
use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::thread;

use bytemuck::Zeroable;
use rt_process::{Ended, Realtime, RtConfig, RtError, RtSummary};
use shared_mem::message::{
    CommandMsg, DeviceHealth, ReplyMsg, StateFrame, TickRecord, TimingBatch, ToolFrame,
};
use shared_mem::service::{Host, ServiceError, Station};

mod support;
use support::{Bench, SPHERES};

fn host(bench: &Bench) -> Host {
    Host::open(&Station::new(&bench.station).unwrap()).unwrap()
}

fn run(config: &RtConfig) -> Result<RtSummary, RtError> {
    rt_process::run(config, &AtomicBool::new(false), |_| ())
}

/// Runs in a thread of its own; gives the flag that stops it.
fn start(
    config: RtConfig,
) -> (
    Arc<AtomicBool>,
    thread::JoinHandle<Result<RtSummary, RtError>>,
) {
    let stop = Arc::new(AtomicBool::new(false));
    let (ready, told) = std::sync::mpsc::channel();
    let flag = Arc::clone(&stop);
    let thread = thread::spawn(move || {
        rt_process::run(&config, &flag, |_| ready.send(()).unwrap_or_default())
    });
    // An error when it did not start: the join tells.
    let _ = told.recv();
    (stop, thread)
}

fn watch(host: &Host, batches: &mut Vec<TimingBatch>) {
    host.drain_timing(|batch| batches.push(*batch));
}

#[test]
fn two_seconds_tick_publish_and_cost_no_allocation_and_no_page_fault() {
    let bench = Bench::new();
    let host = host(&bench);
    let config = RtConfig {
        periods_max: Some(2000),
        ..bench.config()
    };
    let (_, thread) = start(config);
    let (mut state, mut tools) = (StateFrame::zeroed(), ToolFrame::zeroed());
    let (mut frames, mut batches) = (0, Vec::new());
    while !thread.is_finished() {
        watch(&host, &mut batches);
        frames += u32::from(host.newest_state(&mut state));
        host.newest_tools(&mut tools);
        thread::sleep(Duration::from_millis(10));
    }
    let summary = thread.join().unwrap().unwrap();
    watch(&host, &mut batches);
    host.newest_state(&mut state);

    assert_eq!(summary.ended, Ended::Finished);
    assert!(summary.ticks + summary.deadline_misses >= 2000);
    assert!(summary.ticks > 0, "{summary:?}");
    assert_eq!(summary.allocations_after_start, Some(0));
    assert_eq!((summary.events_lost, summary.records_lost), (0, 0));
    let locked = batches.last().unwrap().realtime & TimingBatch::LOCKED != 0;
    if locked {
        assert_eq!(summary.page_faults_after_start, 0);
    }

    // What the host saw of it.
    assert!(frames > 10, "{frames} state frames");
    assert_eq!(state.sphere_count as usize, SPHERES);
    assert!(state.spheres[0].center_m.iter().all(|x| x.is_finite()));
    assert_eq!(tools.health.map(|h| h.status), [DeviceHealth::ABSENT; 3]);
    assert_eq!(tools.scene_id, state.scene_id);
    let sequences: Vec<u64> = batches.iter().map(|b| b.sequence).collect();
    assert_eq!(sequences, (0..sequences.len() as u64).collect::<Vec<_>>());
    let last = batches.last().unwrap();
    assert_eq!(last.ticks, summary.ticks);
    assert_eq!(last.deadline_misses, summary.deadline_misses);
    let records: Vec<TickRecord> = batches
        .iter()
        .flat_map(|b| b.records[..b.count as usize].to_vec())
        .collect();
    assert_eq!(records.len() as u64, summary.ticks);
    for (i, pair) in records.windows(2).enumerate() {
        assert_eq!(pair[1].tick, i as u64 + 1);
        let step_ns = pair[1].scheduled_ns - pair[0].scheduled_ns;
        assert_eq!(step_ns, 1_000_000 * (1 + u64::from(pair[0].missed)));
        let stages: u32 = pair[0].stage_ns.iter().sum();
        assert!(stages <= pair[0].tick_ns, "stages are parts of their tick");
    }
}

#[test]
fn hosts_that_join_and_leave_cost_the_tick_nothing() {
    let bench = Bench::new();
    let (stop, thread) = start(bench.config());
    let mut state = StateFrame::zeroed();
    for _ in 0..10 {
        let host = host(&bench);
        let mut frames = 0;
        for _ in 0..10 {
            frames += u32::from(host.newest_state(&mut state));
            thread::sleep(Duration::from_millis(5));
        }
        assert!(frames > 0, "who joins gets the newest state");
    }
    stop.store(true, Relaxed);
    let summary = thread.join().unwrap().unwrap();
    assert_eq!(summary.allocations_after_start, Some(0));
    if summary.realtime {
        assert_eq!(summary.page_faults_after_start, 0);
    }
}

#[test]
fn a_second_controller_is_refused_by_name_and_the_first_goes_on() {
    let bench = Bench::new();
    let (stop, first) = start(bench.config());
    let error = run(&bench.config()).unwrap_err();
    assert!(
        matches!(&error, RtError::Service(ServiceError::SecondController(name)) if *name == bench.station),
        "{error:?}"
    );
    assert!(error.to_string().contains("--station"));
    let host = host(&bench);
    let mut tools = ToolFrame::zeroed();
    for _ in 0..500 {
        if host.newest_tools(&mut tools) && tools.tick > 20 {
            break;
        }
        thread::sleep(Duration::from_millis(5));
    }
    assert!(tools.tick > 20, "the first one ticks on");
    stop.store(true, Relaxed);
    assert_eq!(first.join().unwrap().unwrap().ended, Ended::Asked);
}

#[test]
fn commands_are_answered_and_stop_ends_it() {
    let bench = Bench::new();
    let (_, thread) = start(bench.config());
    let host = host(&bench);
    let ask = |kind, argument| {
        let patience = Duration::from_secs(20);
        host.command(CommandMsg { kind, argument }, patience)
            .unwrap()
    };
    let paused = ask(CommandMsg::PAUSE, 1);
    assert_eq!(paused.outcome, ReplyMsg::DONE);
    let chosen = ask(CommandMsg::INSTRUMENT, 2);
    assert_eq!(chosen.outcome, ReplyMsg::DONE);
    assert!(
        chosen.tick > paused.tick,
        "a reply names the tick of its effect"
    );
    assert_eq!(
        ask(CommandMsg::INSTRUMENT, 9).outcome,
        ReplyMsg::OUT_OF_RANGE
    );
    assert_eq!(ask(77, 0).outcome, ReplyMsg::UNKNOWN);
    assert_eq!(ask(CommandMsg::STOP, 0).outcome, ReplyMsg::DONE);
    assert_eq!(thread.join().unwrap().unwrap().ended, Ended::Commanded);
}

#[test]
fn without_realtime_it_runs_and_every_report_says_so() {
    let bench = Bench::new();
    let host = host(&bench);
    let config = RtConfig {
        realtime: Realtime::Never,
        periods_max: Some(300),
        ..bench.config()
    };
    let (_, thread) = start(config);
    let mut batches = Vec::new();
    while !thread.is_finished() {
        watch(&host, &mut batches);
        thread::sleep(Duration::from_millis(5));
    }
    watch(&host, &mut batches);
    let summary = thread.join().unwrap().unwrap();
    assert!(!summary.realtime);
    assert!(!summary.refused.is_empty());
    assert!(!batches.is_empty());
    assert!(batches.iter().all(|batch| batch.realtime == 0));
}

#[test]
fn what_is_missing_is_named_and_leaves_the_station_free() {
    let bench = Bench::new();
    let no_scene = RtConfig::new(&bench.station, bench.folder.path().join("none.calot"));
    let error = run(&no_scene).unwrap_err().to_string();
    assert!(
        error.contains("none.calot") && error.contains("calot prepare"),
        "{error}"
    );
    for device in 0..3 {
        let mut config = bench.config();
        let path = Some(bench.folder.path().join("tty-none"));
        let places = [&mut config.haptic, &mut config.tracker, &mut config.pedal];
        let [haptic, tracker, pedal] = places;
        *[haptic, tracker, pedal][device] = path;
        let error = run(&config).unwrap_err();
        let name = ["haptic device", "tracker", "pedal"][device];
        let text = error.to_string();
        assert!(
            matches!(error, RtError::Device { device, .. } if device == name),
            "{text}"
        );
        assert!(text.contains("tty-none"), "{text}");
    }
    let config = RtConfig {
        periods_max: Some(10),
        ..bench.config()
    };
    assert!(run(&config).is_ok());
}

/// A controller in a process of its own, which is this test program again.
fn spawn_controller(bench: &Bench, periods: u64, change: impl FnOnce(&mut Command)) -> Child {
    let mut command = Command::new(std::env::current_exe().unwrap());
    command
        .args(["--exact", "controller_process", "--ignored", "--nocapture"])
        .env("RT_TEST_STATION", &bench.station)
        .env("RT_TEST_SCENE", bench.scene())
        .env("RT_TEST_PERIODS", periods.to_string())
        .stdout(Stdio::piped());
    change(&mut command);
    command.spawn().unwrap()
}

/// Body of that process.
#[test]
#[ignore = "started by other tests as a process"]
fn controller_process() {
    let Ok(station) = std::env::var("RT_TEST_STATION") else {
        return;
    };
    let mut config = RtConfig::new(station, std::env::var("RT_TEST_SCENE").unwrap());
    config.periods_max = Some(std::env::var("RT_TEST_PERIODS").unwrap().parse().unwrap());
    let summary = rt_process::run(&config, &AtomicBool::new(false), |_| println!("\nready"));
    match summary {
        Ok(summary) => println!("\nrealtime {} {:?}", summary.realtime, summary.refused),
        Err(error) => println!("\nerror {error}"),
    }
}

/// The first line of its output that starts with `word`.
fn line_with(child: &mut Child, word: &str) -> Option<String> {
    let lines = BufReader::new(child.stdout.as_mut()?).lines();
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

    let (stop, second) = start(bench.config());
    let mut seen = false;
    for _ in 0..2000 {
        seen = host.newest_tools(&mut tools) && tools.at_ns > before.at_ns;
        if seen {
            break;
        }
        thread::sleep(Duration::from_millis(5));
    }
    stop.store(true, Relaxed);
    second.join().unwrap().unwrap();
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
fn who_takes_the_core_from_the_tick_is_reported() {
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

/// Body of a process whose realtime thread never sleeps.
#[test]
#[ignore = "started by another test as a process"]
fn runaway_process() {
    let guard = rt_process::runaway::RunawayGuard::arm().unwrap();
    let told = std::sync::Arc::new(AtomicBool::new(false));
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
    assert!(line_with(&mut child, "tripped").is_some());
    assert!(child.wait().unwrap().success());
}
