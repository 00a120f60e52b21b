//! The tick's thread: it becomes realtime, builds the simulation and runs the executor. The
//! executor's accounting task arms the counters.

use core::cell::RefCell;
use core::ops::ControlFlow;
use core::sync::atomic::Ordering::{Relaxed, Release};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::mpsc::SyncSender;

use embassy_sync::signal::Signal;
use rt_core::scene::Scene;
use rt_core::sim::Sim;
use shared_mem::message::{TIMING_BATCH, TimingBatch};

use crate::account::{BatchDone, account};
use crate::alloc_counter;
use crate::config::{Realtime, Scheduler};
use crate::control::following;
use crate::devices::Devices;
use crate::executor::Executor;
use crate::inputs;
use crate::realtime::{self, Standing};
use crate::schedule::{Due, Schedule};
use crate::scope_line::Marks;
use crate::settings::Settings;
use crate::shared::Shared;
use crate::storage::Storage;
use crate::tick::{Ends, Tick, World};
use crate::time_driver::now_ns;

/// Delay from the end of the preparation to the first tick, ns.
const START_DELAY_NS: u64 = 5_000_000;

/// Arguments of the thread.
pub(crate) struct Start {
    pub(crate) scene: Scene<'static>,
    pub(crate) scene_id: [u8; 16],
    pub(crate) devices: Devices,
    pub(crate) ends: Ends,
    pub(crate) shared: Arc<Shared>,
    pub(crate) core: usize,
    /// Realtime privileges of the process so far; the thread adds its own.
    pub(crate) standing: Standing,
    pub(crate) scope_line: Option<Marks>,
    pub(crate) settings: Settings,
}

/// Body of the thread. It sends its realtime privileges to `ready` when everything is built, before
/// the first tick. It commands zero force before it returns or unwinds.
pub(crate) fn run(start: Start, ready: &SyncSender<Standing>) {
    let shared = Arc::clone(&start.shared);
    let settings = start.settings;
    let mut devices = start.devices;
    let prepared = catch_unwind(AssertUnwindSafe(|| {
        realtime::leave_signals_to_main();
        let standing = become_realtime(start.standing, settings, start.core);
        shared.realtime.store(standing.bits, Relaxed);
        let thread = rustix::thread::gettid();
        shared
            .tick_thread
            .store(thread.as_raw_nonzero().get(), Relaxed);
        let sim = prepare(start.scene, start.scene_id, &devices, &shared, settings);
        (standing, sim)
    }));
    let (standing, sim) = prepared.unwrap_or_else(|panic| {
        devices.make_safe(now_ns());
        shared.tick_ended.store(true, Release);
        resume_unwind(panic)
    });
    // From here to the next `catch_unwind` values are only moved.
    let world = World::new(
        devices,
        start.ends,
        Arc::clone(&shared),
        start.scene_id,
        &settings,
    )
    .marking(start.scope_line);
    let tick = Rc::new(RefCell::new(Tick::new(sim, world, settings.periods_max)));

    let outcome = catch_unwind(AssertUnwindSafe(|| {
        let executor = spawned(&tick, &shared, settings);
        let _ = ready.send(standing);
        realtime::prefault_stack();
        executor.run(settings.spin_ns);
    }));
    alloc_counter::disarm();
    // A tick that panicked has released its borrow while it unwound.
    if let Ok(mut tick) = tick.try_borrow_mut() {
        tick.make_safe();
    }
    shared.tick_ended.store(true, Release);
    if let Err(panic) = outcome {
        resume_unwind(panic);
    }
}

/// Makes the simulation, and notes the setup of the run.
fn prepare(
    scene: Scene<'static>,
    scene_id: [u8; 16],
    devices: &Devices,
    shared: &Shared,
    settings: Settings,
) -> Sim<'static> {
    // The storage is leaked, because embassy's tasks must be `'static` and one of them borrows it.
    let storage: &'static mut Storage =
        Box::leak(Box::new(Storage::new(settings.paper_iterations)));
    let capabilities = devices.capabilities();
    let _ = shared.setup.set(inputs::setup(
        scene_id,
        settings.period_ns,
        scene.room(),
        &capabilities,
        &settings.parameters,
        settings.trocar,
        settings.paper_iterations,
    ));
    storage.sim(scene, capabilities, settings.parameters)
}

/// Makes the executor with its two tasks: the tick, and the accounting.
fn spawned(tick: &Rc<RefCell<Tick>>, shared: &Arc<Shared>, settings: Settings) -> Executor {
    let executor = Executor::new();
    let batch_done: Rc<BatchDone> = Rc::new(Signal::new());
    let first_ns = now_ns() + START_DELAY_NS;
    let schedule = Schedule::new(first_ns, settings.period_ns);
    let steps = Rc::clone(tick);
    executor.spawn(following(
        schedule,
        ticking(Rc::clone(tick), Rc::clone(&batch_done)),
        // The tick has ended, so nobody else borrows it.
        move || steps.try_borrow_mut().map_or(0, |mut tick| tick.step_ns()),
    ));
    executor.spawn(account(
        batch_done,
        Arc::clone(shared),
        settings.on_violation,
    ));
    executor
}

/// Asks Linux to make the calling thread realtime, and notes in `standing` what it granted.
fn become_realtime(mut standing: Standing, settings: Settings, core: usize) -> Standing {
    match (settings.realtime, settings.scheduler) {
        (Realtime::Never, _) => {}
        (Realtime::Ask, Scheduler::Fifo) => {
            standing.note(TimingBatch::PINNED, realtime::pin_to(&[core]));
            standing.note(TimingBatch::FIFO, realtime::take_fifo(settings.priority));
        }
        (Realtime::Ask, Scheduler::Deadline) => {
            let taken = realtime::take_deadline(settings.period_ns);
            if taken.is_ok() {
                standing.note(TimingBatch::PINNED, Ok(()));
            }
            standing.note(TimingBatch::FIFO, taken);
        }
    }
    standing
}

/// Returns the body of the control task: one tick. It wakes the accounting task after each batch of
/// ticks and after the last tick.
fn ticking(
    tick: Rc<RefCell<Tick>>,
    batch_done: Rc<BatchDone>,
) -> impl FnMut(Due) -> ControlFlow<()> {
    let mut in_batch = 0;
    move |due| {
        let flow = tick.borrow_mut().run(due);
        in_batch += 1;
        if in_batch == TIMING_BATCH || flow.is_break() {
            in_batch = 0;
            batch_done.signal(flow.is_break());
        }
        flow
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alloc_counter::OnViolation;
    use crate::config::RtConfig;
    use crate::devices::Device;
    use crate::replay::{self, Difference};
    use crate::run::queues;
    use crate::scope_line::Mark;
    use crate::summary::Ended;
    use crate::time_driver::{advance_simulated, simulate_from};
    use rt_core::math::{Pose, Vec3};
    use rt_core::port::{
        DeviceCapabilities, DeviceSample, ForceCommand, HapticDevice, LineCounters, Polled,
    };
    use rt_core::scene::{Room, Trocar};
    use shared_mem::inputs::InputRecord;
    use shared_mem::message::TickRecord;
    use std::sync::{Mutex, mpsc};

    /// A device that answers every poll with a sample and stores each force that it receives.
    /// `step` runs in each poll; it may stall or panic.
    struct Fake<F> {
        polls: u64,
        capabilities: fn() -> DeviceCapabilities,
        step: F,
        forces: Arc<Mutex<Vec<ForceCommand>>>,
    }

    impl<F: FnMut(u64)> HapticDevice for Fake<F> {
        fn capabilities(&self) -> DeviceCapabilities {
            (self.capabilities)()
        }
        fn poll(&mut self, now_ns: u64) -> Polled<DeviceSample> {
            let poll = self.polls;
            self.polls += 1;
            (self.step)(poll);
            Polled::Fresh(DeviceSample {
                opening: None,
                device_from_handle: Pose::translation(0.0, 0.0, 0.1),
                velocity_m_s: None,
                buttons: rt_core::port::Buttons(0),
                sequence: poll as u16,
                at_ns: now_ns,
            })
        }
        fn send(&mut self, command: ForceCommand, _now_ns: u64) {
            self.forces.lock().unwrap().push(command);
        }
        fn counters(&self) -> LineCounters {
            LineCounters::default()
        }
    }

    fn room() -> Room {
        Room {
            gravity_m_s2: Vec3::zeros(),
            world_from_device: Pose::identity(),
            world_from_tracker: Pose::identity(),
            instrument_port_m: Vec3::zeros(),
            instrument_length_m: 0.3,
            endoscope_port_m: Vec3::zeros(),
            world_from_camera: Pose::identity(),
            breath_s: 0.0,
            trocar: Trocar::NONE,
        }
    }

    /// Changes of the oscilloscope's line: time, ns, and level.
    type Scoped = Arc<Mutex<Vec<(u64, bool)>>>;

    #[global_allocator]
    static ALLOCATOR: alloc_counter::CountingAllocator = alloc_counter::CountingAllocator::new();

    struct ThreadOutcome {
        scoped: Scoped,
        panicked: bool,
        shared: Arc<Shared>,
        forces: Vec<ForceCommand>,
        ends: crate::publisher::Ends,
    }

    /// Runs the whole thread in simulated time over an empty room.
    fn simulate(periods: u64, step: impl FnMut(u64) + Send + 'static) -> ThreadOutcome {
        let prepare = || simulate_from(1_000_000_000);
        run_in_room(periods, Standing::default(), prepare, step)
    }

    /// Runs the thread. `prepare` may switch it to simulated time.
    fn run_in_room(
        periods: u64,
        standing: Standing,
        prepare: impl FnOnce() + Send + 'static,
        step: impl FnMut(u64) + Send + 'static,
    ) -> ThreadOutcome {
        run_marked(periods, standing, Mark::Tick, prepare, step)
    }

    fn run_marked(
        periods: u64,
        standing: Standing,
        mark: Mark,
        prepare: impl FnOnce() + Send + 'static,
        step: impl FnMut(u64) + Send + 'static,
    ) -> ThreadOutcome {
        let capabilities = || crate::devices::FALLBACK_CAPABILITIES;
        run_device(periods, standing, mark, prepare, step, capabilities)
    }

    fn run_device(
        periods: u64,
        standing: Standing,
        mark: Mark,
        prepare: impl FnOnce() + Send + 'static,
        step: impl FnMut(u64) + Send + 'static,
        capabilities: fn() -> DeviceCapabilities,
    ) -> ThreadOutcome {
        let room_for = |each: usize| each * usize::try_from(periods).unwrap_or(0).min(25_000);
        let forces = Arc::new(Mutex::new(Vec::with_capacity(room_for(1))));
        let scoped: Scoped = Arc::new(Mutex::new(Vec::with_capacity(room_for(3))));
        let scope = Arc::clone(&scoped);
        let fake = Fake {
            polls: 0,
            capabilities,
            step,
            forces: Arc::clone(&forces),
        };
        let shared = Arc::<Shared>::default();
        let mut devices = Devices::default();
        devices.put(Device::Haptic(Box::new(fake)));
        let (ends, publisher_ends) = queues();
        let mut config = RtConfig::new("simulated", "none");
        config.realtime = Realtime::Never;
        config.periods_max = Some(periods);
        // The fake device may allocate in a poll or in a send.
        if standing.bits == 0 {
            config.on_violation = OnViolation::Count;
        }
        let start = Start {
            scene: Scene::new(&[], &[], &[], room()).unwrap(),
            scene_id: [7; 16],
            devices,
            ends,
            shared: Arc::clone(&shared),
            core: 0,
            standing,
            scope_line: Some(Marks {
                set: Box::new(move |high| {
                    scope.lock().unwrap().push((now_ns(), high));
                }),
                mark,
            }),
            settings: Settings::new(&config, None),
        };
        let (ready, _receiver) = mpsc::sync_channel(1);
        let thread = std::thread::Builder::new()
            .stack_size(crate::thread::TICK_STACK_BYTES)
            .spawn(move || {
                prepare();
                run(start, &ready);
            })
            .unwrap();
        let panicked = thread.join().is_err();
        assert!(shared.tick_ended.load(Relaxed));
        let forces = forces.lock().unwrap().clone();
        ThreadOutcome {
            scoped,
            panicked,
            shared,
            forces,
            ends: publisher_ends,
        }
    }

    /// The recorded inputs repeat the run; a handle moved in a single tick changes it.
    #[test]
    fn recorded_run_is_replayed_bit_by_bit() {
        let mut outcome = simulate(800, |_| ());
        let setup = *outcome.shared.setup.get().unwrap();
        let records: Vec<_> = core::iter::from_fn(|| outcome.ends.inputs.dequeue()).collect();
        assert_eq!(records.len(), 800);
        let first_difference = |records: &[InputRecord]| {
            let mut found = None;
            let scene = Scene::new(&[], &[], &[], room()).unwrap();
            replay::run_scene(scene, &setup, records.iter().copied(), |replayed| {
                found = replayed.differs().map(|it| (replayed.record.tick, it));
                found.is_none()
            });
            found
        };
        assert_eq!(first_difference(&records), None);
        let mut altered = records;
        altered[321].device_from_handle.position_m[0] += 1.0e-4;
        assert_eq!(first_difference(&altered), Some((321, Difference::Tools)));
    }

    const ZERO: ForceCommand = ForceCommand {
        opening_n: 0.0,
        force_n: Vec3::new(0.0, 0.0, 0.0),
        torque_nm: Vec3::new(0.0, 0.0, 0.0),
    };

    #[test]
    fn every_tick_sends_one_force_and_the_end_sends_zero() {
        let outcome = simulate(500, |_| ());
        assert!(!outcome.panicked);
        assert_eq!(outcome.shared.asked_to_end(), Some(Ended::Finished));
        assert_eq!(outcome.shared.ticks.load(Relaxed), 500);
        assert_eq!(outcome.forces.len(), 500 + 3, "three zeros at the end");
        assert_eq!(outcome.forces[500..], [ZERO; 3]);
    }

    #[test]
    fn scope_line_is_high_for_the_duration_of_each_tick() {
        let outcome = simulate(100, |poll| {
            advance_simulated(if poll == 3 { 400_000 } else { 70_000 });
        });
        let scoped = outcome.scoped.lock().unwrap();
        assert_eq!(scoped.len(), 2 * 100);
        for (tick, edges) in scoped.chunks(2).enumerate() {
            let (rises_ns, falls_ns) = (edges[0].0, edges[1].0);
            assert_eq!((edges[0].1, edges[1].1), (true, false));
            assert_eq!(
                rises_ns,
                scoped[0].0 + tick as u64 * 1_000_000,
                "on the grid"
            );
            let took_ns = if tick == 3 { 400_000 } else { 70_000 };
            assert_eq!(falls_ns - rises_ns, took_ns);
        }
    }

    #[test]
    fn scope_line_falls_when_the_force_has_left() {
        let (none, step) = (Standing::default(), |_| advance_simulated(70_000));
        let prepare = || simulate_from(1_000_000_000);
        let outcome = run_marked(100, none, Mark::Force, prepare, step);
        let scoped = outcome.scoped.lock().unwrap();
        assert_eq!(scoped.len(), 3 * 100);
        for edges in scoped.chunks(3) {
            let levels: Vec<bool> = edges.iter().map(|edge| edge.1).collect();
            assert_eq!(levels, [true, false, false], "low once the force has left");
            // In this room only the poll takes time, which is before the force.
            assert_eq!(edges[1].0 - edges[0].0, 70_000);
        }
    }

    /// Body of a process whose tick breaks one rule in each poll from the 200th on, in real time.
    #[test]
    #[ignore = "started by another test as a process"]
    fn breaks_a_rule() {
        let rule = std::env::var("RT_TEST_RULE").unwrap_or_default();
        let mut standing = Standing::default();
        standing.note(TimingBatch::LOCKED, Ok(()));
        if rule != "page fault" && realtime::lock_memory().is_err() {
            return;
        }
        let mut untouched = vec![0u8; 256 << 20];
        let outcome = run_in_room(
            20_000,
            standing,
            || (),
            move |poll| match rule.as_str() {
                _ if poll < 200 => {}
                "allocation" => drop(core::hint::black_box(Box::new(poll))),
                "page fault" => untouched[poll as usize * 8192] = 1,
                "block" => std::thread::sleep(core::time::Duration::from_micros(10)),
                other => panic!("{other}"),
            },
        );
        assert!(!outcome.panicked);
    }

    #[test]
    fn a_debug_run_ends_at_the_first_allocation_page_fault_or_block() {
        use std::os::unix::process::ExitStatusExt as _;
        let may_lock = realtime::lock_memory().is_ok();
        let _ = rustix::mm::munlockall();
        if OnViolation::BUILD_DEFAULT == OnViolation::Count || !may_lock {
            return; // a release build only counts; faults in unlocked memory end no run
        }
        for (rule, message) in [
            ("allocation", "allocated after its start"),
            ("page fault", "took too many page faults after its start"),
            ("block", "waited for something other"),
        ] {
            let name = "tick_thread::tests::breaks_a_rule";
            let output = std::process::Command::new(std::env::current_exe().unwrap())
                .args(["--exact", name, "--ignored", "--nocapture"])
                .env("RT_TEST_RULE", rule)
                .output()
                .unwrap();
            let stderr = String::from_utf8_lossy(&output.stderr);
            assert!(stderr.contains(message), "{rule}: {stderr}");
            assert_eq!(output.status.signal(), Some(libc::SIGABRT), "{rule}");
        }
    }

    #[test]
    fn an_hour_of_the_whole_tick_runs_in_seconds_and_repeats() {
        let hour = || {
            let outcome = simulate(3_600_000, |_| advance_simulated(100_000));
            let shared = &outcome.shared;
            assert_eq!(shared.ticks.load(Relaxed), 3_600_000);
            assert_eq!(shared.missed_periods.load(Relaxed), 0);
            shared.faults.each_ref().map(|fault| fault.load(Relaxed))
        };
        let wall = std::time::Instant::now();
        let faults = hour();
        println!("{} ns a tick", wall.elapsed().as_nanos() / 3_600_000);
        assert_eq!(faults, hour());
    }

    #[test]
    fn a_panic_in_the_tick_still_sends_zero_force() {
        let outcome = simulate(500, |poll| assert!(poll < 40, "injected"));
        assert!(outcome.panicked);
        assert_eq!(outcome.shared.ticks.load(Relaxed), 40);
        assert_eq!(outcome.forces[40..], [ZERO; 3]);
    }

    #[test]
    fn a_panic_before_the_first_tick_still_sends_zero_force() {
        let prepare = || simulate_from(1_000_000_000);
        let none = Standing::default();
        let outcome = run_device(
            500,
            none,
            Mark::Tick,
            prepare,
            |_| (),
            || panic!("injected"),
        );
        assert!(outcome.panicked);
        assert_eq!(outcome.shared.ticks.load(Relaxed), 0);
        assert_eq!(outcome.forces, [ZERO; 3]);
    }

    #[test]
    fn a_slow_tick_is_an_overrun_and_its_lost_periods_are_counted() {
        let mut outcome = simulate(100, |poll| {
            advance_simulated(if poll == 50 { 7_300_000 } else { 200_000 });
        });
        assert_eq!(outcome.shared.late_ticks.load(Relaxed), 1);
        // The slow tick is due at 0 ms and ends at 7.3 ms. The tick that was due at 1 ms starts at
        // 7.3 ms. No tick runs for the periods that begin at 2 ms to 7 ms.
        assert_eq!(outcome.shared.missed_periods.load(Relaxed), 6);
        assert_eq!(outcome.shared.ticks.load(Relaxed), 94);
        let overruns = &outcome.shared.faults[rt_core::fault::Fault::Overrun.code() as usize];
        assert_eq!(overruns.load(Relaxed), 1);
        let mut records = Vec::new();
        while let Some(record) = outcome.ends.records.dequeue() {
            records.push(record);
        }
        assert_eq!(records.len(), 94);
        assert_eq!((records[50].tick_ns, records[50].missed), (7_300_000, 0));
        assert_eq!(
            records[50].stage_ns[0], 7_300_000,
            "the time was lost in the stage `sample`"
        );
        assert_eq!(records[51].wake_latency_ns, 6_300_000);
        assert_eq!(records[51].missed, 6);
        assert_eq!(records[52].wake_latency_ns, 0, "back on the grid");
        assert!(records.iter().all(|r| r.motion_to_force_ns > 0));
    }

    #[test]
    fn force_starts_again_after_a_standstill() {
        let outcome = simulate(200, |poll| {
            advance_simulated(if poll == 100 { 60_000_000 } else { 0 });
        });
        let stale = &outcome.shared.faults[rt_core::fault::Fault::StaleDevice.code() as usize];
        assert_eq!(stale.load(Relaxed), 1);
    }

    #[test]
    fn a_tick_short_of_time_drops_frames_and_never_a_force() {
        let mut outcome = simulate(400, |_| advance_simulated(950_000));
        let shared = &outcome.shared;
        assert_eq!(shared.ticks.load(Relaxed), 400);
        assert_eq!(outcome.forces.len(), 400 + 3);
        // 100 frames are due. After 25 dropped ones the next is published in any case.
        assert_eq!(shared.frames_dropped.load(Relaxed), 97);
        assert_eq!(
            shared.stages_over[0].load(Relaxed),
            400,
            "sampling exceeds its budget"
        );
        let mut dropped = 0;
        while let Some(record) = outcome.ends.records.dequeue() {
            dropped += u64::from(record.bits & TickRecord::DROPPED_PUBLISH != 0);
        }
        assert_eq!(dropped, 97);
        // Sampling alone took the time, so all optional work was dropped.
        assert_eq!(shared.self_collisions_dropped.load(Relaxed), 400);
        assert_eq!(shared.far_organs_dropped.load(Relaxed), 400);
    }

    #[test]
    fn optional_work_is_dropped_in_its_order() {
        // After 250 µs the budgets of contact, solve and force still fit into the period. After
        // 400 µs only the budgets of solve and force fit. After 600 µs not even these fit.
        for (taken_us, self_collision, far) in [(250, 0, 0), (400, 50, 0), (600, 50, 50)] {
            let outcome = simulate(50, move |_| advance_simulated(taken_us * 1000));
            let shared = &outcome.shared;
            assert_eq!(shared.self_collisions_dropped.load(Relaxed), self_collision);
            assert_eq!(shared.far_organs_dropped.load(Relaxed), far);
            assert_eq!(shared.frames_dropped.load(Relaxed), 0);
            assert_eq!(outcome.forces.len(), 50 + 3);
        }
    }

    #[test]
    fn frames_without_a_publishing_thread_are_counted_as_lost() {
        let mut outcome = simulate(3000, |_| ());
        let shared = &outcome.shared;
        assert_eq!(shared.frames_skipped.load(Relaxed), 3000 / 4);
        let mut kept = 0;
        while outcome.ends.records.dequeue().is_some() {
            kept += 1;
        }
        assert_eq!(shared.records_lost.load(Relaxed) + kept, 3000);
        assert!(kept > 1000);
    }
}
