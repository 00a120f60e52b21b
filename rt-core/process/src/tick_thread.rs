//! The tick's thread: becomes realtime, builds the simulation, arms the counters, runs.

use core::cell::RefCell;
use core::ops::ControlFlow;
use core::sync::atomic::Ordering::{Relaxed, Release};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::mpsc::SyncSender;

use embassy_sync::blocking_mutex::raw::NoopRawMutex;
use embassy_sync::signal::Signal;
use rt_core::scene::Scene;
use rt_core::sim::{Parameters, Sim};
use rt_core::state::State;
use shared_mem::message::{TIMING_BATCH, TimingBatch};

use crate::alloc_counter::{self, OnAllocation};
use crate::config::{Realtime, RtConfig};
use crate::control::control;
use crate::devices::Devices;
use crate::executor::Executor;
use crate::realtime::{self, Standing, ThreadUsage};
use crate::schedule::{Due, Schedule};
use crate::shared::Shared;
use crate::tick::{Ends, Tick, World};
use crate::time_driver::now_ns;

/// From the end of the preparation to the first tick.
const START_DELAY_NS: u64 = 5_000_000;

/// What the thread is started with.
pub(crate) struct Start {
    pub(crate) scene: Scene<'static>,
    pub(crate) scene_id: [u8; 16],
    pub(crate) devices: Devices,
    pub(crate) ends: Ends,
    pub(crate) shared: Arc<Shared>,
    pub(crate) core: usize,
    /// How realtime the process is so far; the thread adds its own.
    pub(crate) standing: Standing,
    pub(crate) settings: Settings,
}

/// The numbers of [`RtConfig`] that the thread needs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Settings {
    realtime: Realtime,
    priority: u8,
    period_ns: u64,
    spin_ns: u64,
    publish_every: u32,
    periods_max: Option<u64>,
    parameters: Parameters,
    on_allocation: OnAllocation,
}

impl From<&RtConfig> for Settings {
    fn from(config: &RtConfig) -> Self {
        Self {
            realtime: config.realtime,
            priority: config.priority,
            period_ns: config.period_ns,
            spin_ns: config.spin_ns,
            publish_every: config.publish_every,
            periods_max: config.periods_max,
            parameters: config.parameters,
            on_allocation: config.on_allocation,
        }
    }
}

/// Body of the thread. Tells its standing just before the first tick. The force is zero when it
/// returns or unwinds.
pub(crate) fn run(start: Start, told: &SyncSender<Standing>) {
    let shared = Arc::clone(&start.shared);
    let settings = start.settings;
    realtime::leave_signals_to_main();
    let standing = become_realtime(start.standing, settings, start.core);
    shared.realtime.store(standing.bits, Relaxed);
    let thread = rustix::thread::gettid();
    shared
        .tick_thread
        .store(thread.as_raw_nonzero().get(), Relaxed);

    // Both live as long as the process: embassy's tasks must.
    let state: &'static mut State = Box::leak(Box::new(State::new()));
    let capabilities = start.devices.capabilities();
    let sim = Sim::new(start.scene, state, capabilities, settings.parameters);
    let world = World::new(
        start.devices,
        start.ends,
        Arc::clone(&shared),
        start.scene_id,
        settings.publish_every,
    );
    let tick = Rc::new(RefCell::new(Tick::new(sim, world, settings.periods_max)));

    let executor = Executor::new();
    let batch_done: Rc<BatchDone> = Rc::new(Signal::new());
    let first_ns = now_ns() + START_DELAY_NS;
    let schedule = Schedule::new(first_ns, settings.period_ns);
    executor.spawn(control(
        schedule,
        ticking(Rc::clone(&tick), Rc::clone(&batch_done)),
    ));
    executor.spawn(account(
        batch_done,
        Arc::clone(&shared),
        settings.on_allocation,
    ));
    let _ = told.send(standing);
    realtime::prefault_stack();

    let outcome = catch_unwind(AssertUnwindSafe(|| executor.run(settings.spin_ns)));
    alloc_counter::disarm();
    // Unwinding has given back the borrow that a panicking tick held.
    if let Ok(mut tick) = tick.try_borrow_mut() {
        tick.make_safe();
    }
    shared.tick_ended.store(true, Release);
    if let Err(panic) = outcome {
        resume_unwind(panic);
    }
}

/// Steps from an ordinary thread to a realtime one.
fn become_realtime(mut standing: Standing, settings: Settings, core: usize) -> Standing {
    if settings.realtime == Realtime::Ask {
        standing.note(TimingBatch::PINNED, realtime::pin_to(&[core]));
        standing.note(TimingBatch::FIFO, realtime::take_fifo(settings.priority));
    }
    standing
}

/// Wakes the accounting; true with the last batch.
type BatchDone = Signal<NoopRawMutex, bool>;

/// The body of the control task.
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

/// The accounting task: what only the kernel and the allocator know of this thread, once a batch,
/// in the gap after a tick. Its first run arms the counters, just before the first tick.
async fn account(batch_done: Rc<BatchDone>, shared: Arc<Shared>, on_allocation: OnAllocation) {
    let counts = alloc_counter::arm(on_allocation);
    let start = ThreadUsage::now();
    let mut last = false;
    loop {
        let allocations = if counts {
            alloc_counter::count()
        } else {
            u64::MAX
        };
        let usage = ThreadUsage::now().since(start);
        shared.allocations.store(allocations, Relaxed);
        shared.page_faults.store(usage.page_faults, Relaxed);
        shared
            .involuntary_switches
            .store(usage.involuntary_switches, Relaxed);
        if last {
            // What follows frees the tasks.
            alloc_counter::disarm();
            return;
        }
        last = batch_done.wait().await;
    }
}
