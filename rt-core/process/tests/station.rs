//! The realtime process over real shared memory, without devices.

use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use core::time::Duration;
use std::sync::Arc;
use std::thread;
use std::time::Instant;

use bytemuck::Zeroable;
use rt_process::{AdmissionPolicy, Ended, Realtime, RtConfig, RtError, RtSummary, Scheduler};
use shared_mem::message::{
    CommandMsg, DeviceHealth, ReplyMsg, StateFrame, TickRecord, TimingBatch, ToolFrame,
};
use shared_mem::service::{Host, ServiceError};

mod support;
use support::{Bench, SPHERES, host};

fn run(config: &RtConfig) -> Result<RtSummary, RtError> {
    rt_process::run(config, &AtomicBool::new(false), |_| ())
}

/// Runs the controller in a thread of its own. Returns the flag that stops it, and the thread.
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
    // This fails if the controller did not start. Joining the thread gives the error.
    let _ = told.recv();
    (stop, thread)
}

fn watch(host: &Host, batches: &mut Vec<TimingBatch>) {
    host.drain_timing(|batch| batches.push(*batch));
}

#[test]
fn two_seconds_of_ticks_cost_no_allocation_and_no_page_fault() {
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
    assert!(summary.ticks + summary.missed_periods >= 2000);
    assert!(summary.ticks > 0, "{summary:?}");
    assert_eq!(summary.allocations_after_start, Some(0));
    assert_eq!((summary.events_lost, summary.records_lost), (0, 0));
    let locked = batches.last().unwrap().realtime & TimingBatch::LOCKED != 0;
    if locked {
        assert_eq!(summary.page_faults_after_start, 0);
    }

    // Observations of the host.
    assert!(frames > 10, "{frames} state frames");
    assert_eq!(state.sphere_count as usize, SPHERES);
    assert!(state.spheres[0].center_m.iter().all(|x| x.is_finite()));
    assert_eq!(tools.health.map(|h| h.status), [DeviceHealth::ABSENT; 3]);
    assert_eq!(tools.scene_id, state.scene_id);
    let sequences: Vec<u64> = batches.iter().map(|b| b.sequence).collect();
    assert_eq!(sequences, (0..sequences.len() as u64).collect::<Vec<_>>());
    let last = batches.last().unwrap();
    assert_eq!(last.ticks, summary.ticks);
    assert_eq!(last.missed_periods, summary.missed_periods);
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
        let deadline = Instant::now() + Duration::from_secs(30);
        let mut seen = false;
        for round in 0.. {
            seen |= host.newest_state(&mut state);
            thread::sleep(Duration::from_millis(5));
            // At least ten rounds. A busy machine may need more.
            if (round >= 10 && seen) || Instant::now() > deadline {
                break;
            }
        }
        assert!(seen, "who joins gets the newest state");
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
    for _ in 0..12_000 {
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
fn controller_runs_without_realtime_and_every_report_says_so() {
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
fn deadline_scheduling_is_an_option() {
    let bench = Bench::new();
    let config = RtConfig {
        scheduler: Scheduler::Deadline,
        periods_max: Some(300),
        ..bench.config()
    };
    let summary = run(&config).unwrap();
    assert!(summary.ticks > 0);
    // The run is realtime, or the summary states the reason.
    let refused = summary
        .refused
        .iter()
        .any(|why| why.contains("SCHED_DEADLINE"));
    let locked = !summary.refused.iter().any(|why| why.contains("not locked"));
    assert_eq!(summary.realtime, !refused && locked, "{summary:?}");
}

#[test]
fn missing_scene_or_device_is_named_and_leaves_the_station_free() {
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

/// Number of iterations of the paper's method. With it, a tick of the block of 125 spheres takes
/// more than a period, and a tick of the block of 8 spheres takes less than half a period.
const HEAVY: u32 = 650;

fn heavy(bench: &Bench, admission: AdmissionPolicy) -> RtConfig {
    let mut config = bench.config();
    config.admission = admission;
    config.paper_iterations = HEAVY;
    config.periods_max = Some(20);
    config
}

#[test]
fn a_scene_that_fits_is_admitted_with_its_cost() {
    let bench = Bench::new();
    let config = RtConfig {
        admission: AdmissionPolicy::Strict,
        periods_max: Some(20),
        ..bench.config()
    };
    let admission = run(&config).unwrap().admission.unwrap();
    assert!(admission.fits, "{admission:?}");
    assert_eq!(
        (admission.scene.as_str(), admission.spheres),
        ("block", SPHERES)
    );
    assert_eq!(admission.budget_ns, 700_000);
    assert!(
        admission.contacts_max > 3,
        "the course touches: {admission:?}"
    );
    assert!(admission.median_tick_ns <= admission.worst_tick_ns);
    let stages: u64 = admission.worst_stage_ns.iter().sum();
    assert!(stages > 0 && stages <= admission.worst_tick_ns);
}

#[test]
fn a_scene_that_does_not_fit_gives_way_to_a_coarser_one() {
    let bench = Bench::new();
    let mut config = heavy(&bench, AdmissionPolicy::Strict);
    config.coarser = vec![bench.coarse_scene()];
    let summary = run(&config).unwrap();
    assert_eq!(summary.scene, "coarse block");
    let admission = summary.admission.unwrap();
    assert!(admission.fits);
    assert_eq!(admission.spheres, 8);
}

#[test]
fn a_scene_that_does_not_fit_gives_way_to_the_next_level_in_its_file() {
    let bench = Bench::new();
    let mut config = heavy(&bench, AdmissionPolicy::Strict);
    let mut levels = std::fs::read(bench.scene()).unwrap();
    levels.resize(levels.len().next_multiple_of(64), 0);
    levels.extend(std::fs::read(bench.coarse_scene()).unwrap());
    config.scene = bench.coarse_scene().with_file_name("levels.calot");
    std::fs::write(&config.scene, levels).unwrap();
    let summary = run(&config).unwrap();
    assert_eq!(summary.scene, "coarse block");
    assert_eq!(summary.admission.unwrap().spheres, 8);
}

#[test]
fn a_strict_run_refuses_what_does_not_fit_and_another_one_says_so() {
    let bench = Bench::new();
    let error = run(&heavy(&bench, AdmissionPolicy::Strict)).unwrap_err();
    assert!(
        matches!(&error, RtError::DoesNotFit(found) if !found.fits),
        "{error:?}"
    );
    let text = error.to_string();
    assert!(
        text.contains("DOES NOT FIT") && text.contains("--strict"),
        "{text}"
    );

    let summary = run(&heavy(&bench, AdmissionPolicy::Measure)).unwrap();
    assert!(!summary.admission.unwrap().fits);
}
