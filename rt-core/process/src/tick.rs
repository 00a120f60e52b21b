//! One control period (a tick), and its access to devices, clock and queues. Nothing here blocks
//! or allocates.

use core::ops::ControlFlow;
use core::sync::atomic::Ordering::{Relaxed, Release};
use std::sync::Arc;

use heapless::spsc::{Consumer, Producer};
use rt_core::fault::Fault;
use rt_core::port::{Findings, ForceCommand, Polled};
use rt_core::sim::{Command, Optional, Ports, Samples, Sim, Stage, TickView};
use rt_core::words::Status;
use shared_mem::inputs::InputRecord;
use shared_mem::message::{EventMsg, STAGES, StateFrame, TickRecord, ToolFrame};

use crate::budget::{self, PublishGate};
use crate::devices::Devices;
use crate::echoed::Echoed;
use crate::frames;
use crate::handover::Filler;
use crate::held_back::HeldBack;
use crate::inputs;
use crate::phase::Phase;
use crate::schedule::Due;
use crate::scope_line::Marks;
use crate::settings::Settings;
use crate::shared::Shared;
use crate::summary::Ended;
use crate::time_driver::now_ns;

/// The tick's ends of all queues.
pub(crate) struct Ends {
    pub(crate) state: Filler<StateFrame>,
    pub(crate) tools: Filler<ToolFrame>,
    pub(crate) events: Producer<'static, EventMsg>,
    pub(crate) records: Producer<'static, TickRecord>,
    pub(crate) inputs: Producer<'static, InputRecord>,
    pub(crate) commands: Consumer<'static, Command>,
    pub(crate) accepted: Producer<'static, u64>,
}

/// Everything that the tick uses outside the simulation: devices, queues, counters and budgets.
pub(crate) struct World {
    devices: Devices,
    ends: Ends,
    shared: Arc<Shared>,
    scene_id: [u8; 16],
    publish_every: u64,
    period_ns: u64,
    gate: PublishGate,
    /// Time that each stage needs, ns: measured at admission, or else its budget.
    needs_ns: [u64; STAGES],
    /// Time at which this tick must end, ns: the start of the next period.
    deadline_ns: u64,
    next_event: u64,
    /// Arrival time of the haptic device's sample, ns. `None` if this tick received none.
    fresh_at_ns: Option<u64>,
    echoed: Echoed,
    last_stamp_ns: u64,
    record: TickRecord,
    /// Inputs of this tick.
    input: InputRecord,
    /// Status of haptic device, tracker and pedal, as the last tick had it.
    device_status: [Status; 3],
    held_back: HeldBack,
    /// Loop that moves the ticks to just after the device's samples; `None`: they stay.
    phase: Option<Phase>,
    /// The oscilloscope's line.
    scope_line: Option<Marks>,
}

/// Simulation and world, advanced one control period at a time.
pub(crate) struct Tick {
    sim: Sim<'static>,
    world: World,
    shared: Arc<Shared>,
    periods_max: Option<u64>,
    /// Ticks and missed periods so far.
    periods: u64,
}

const NO_RECORD: TickRecord = TickRecord {
    tick: 0,
    scheduled_ns: 0,
    wake_latency_ns: 0,
    tick_ns: 0,
    motion_to_force_ns: 0,
    missed: 0,
    stage_ns: [0; STAGES],
    hand_to_force_ns: 0,
    echoed_ns: 0,
    bits: 0,
};

impl World {
    pub(crate) fn new(
        devices: Devices,
        ends: Ends,
        shared: Arc<Shared>,
        scene_id: [u8; 16],
        settings: &Settings,
    ) -> Self {
        Self {
            devices,
            ends,
            shared,
            scene_id,
            publish_every: u64::from(settings.publish_every).max(1),
            period_ns: settings.period_ns,
            gate: PublishGate::default(),
            needs_ns: settings.needs_ns,
            deadline_ns: 0,
            next_event: 0,
            fresh_at_ns: None,
            echoed: Echoed::default(),
            last_stamp_ns: 0,
            record: NO_RECORD,
            input: bytemuck::Zeroable::zeroed(),
            device_status: [Status::Absent; 3],
            held_back: HeldBack::default(),
            phase: settings
                .follows_device
                .then(|| Phase::new(settings.period_ns)),
            scope_line: None,
        }
    }

    /// Marks ticks on the oscilloscope's line, if there is one.
    pub(crate) fn marking(mut self, scope_line: Option<Marks>) -> Self {
        self.scope_line = scope_line;
        self
    }

    fn raise(&mut self, event: &rt_core::words::Event, tick: u64, at_ns: u64) {
        // The event is numbered before it is queued, so that the reader sees a gap if it is lost.
        let message = frames::event(event, self.next_event, tick, at_ns);
        self.next_event += 1;
        if self.ends.events.enqueue(message).is_err() {
            Shared::count(&self.shared.events_lost);
        }
    }
}

impl Ports for World {
    fn sample(&mut self) -> Samples {
        let now = now_ns();
        self.devices.take_reopened();
        let device = self.devices.poll_haptic(now);
        let tracker = self.devices.poll_tracker(now);
        let pedal = self.devices.poll_pedal(now);
        self.fresh_at_ns = match &device {
            Polled::Fresh(sample) => Some(sample.at_ns),
            _ => None,
        };
        if let Some(echo) = self.devices.echo() {
            self.record.hand_to_force_ns = saturate(u64::from(echo.took_us) * 1000).max(1);
            self.record.echoed_ns = self.echoed.of(echo.sample_at_ns);
        }
        let command = if self.shared.cut_force.swap(false, Relaxed) {
            Some(Command::EnableForce(false))
        } else {
            let command = self.ends.commands.dequeue();
            if command.is_some() {
                // The queue holds eight. The publishing thread empties it in each of its rounds.
                let _ = self.ends.accepted.enqueue(self.record.tick);
            }
            command
        };
        let samples = Samples {
            now_ns: now,
            device,
            tracker,
            pedal,
            command,
        };
        self.input = inputs::record(&samples);
        samples
    }

    fn findings(&mut self) -> Findings {
        let findings = self.devices.findings();
        if findings.leapt {
            self.input.bits |= InputRecord::LEAPT;
        }
        if findings.faults.contains(Fault::DeviceFault) {
            self.input.bits |= InputRecord::DEVICE_FAILED;
        }
        if findings.bundle_ms > 0 {
            self.shared.bundle_ms.store(findings.bundle_ms, Relaxed);
        }
        findings
    }

    fn send_force(&mut self, command: ForceCommand) {
        if self.devices.has_haptic() {
            self.devices.send(command, now_ns());
            if let Some(scope) = &self.scope_line {
                scope.force_left();
            }
            if let Some(arrived_ns) = self.fresh_at_ns {
                let took_ns = saturate(now_ns().saturating_sub(arrived_ns)).max(1);
                self.record.motion_to_force_ns = took_ns;
                self.echoed.note(arrived_ns, took_ns);
            }
        }
    }

    fn publish(&mut self, view: &TickView<'_>) {
        let now = now_ns();
        inputs::seal(&mut self.input, view.tick, view.digest());
        if self.ends.inputs.enqueue(self.input).is_err() {
            Shared::count(&self.shared.inputs_lost);
        }
        for event in view.events {
            self.raise(event, view.tick, now);
        }
        self.record.bits |= frames::record_bits(view);
        for (to, from) in self
            .shared
            .faults
            .iter()
            .zip(view.fault_counters.as_array())
        {
            to.store(*from, Relaxed);
        }
        if self.devices.has_haptic() {
            self.held_back.note(view, &self.shared);
        }
        let status = [view.device.status, view.tracker.status, view.pedal.status];
        if status != self.device_status {
            self.device_status = status;
            Shared::count(&self.shared.device_changes);
        }
        // The bits of non-negative floats, read as integers, have the same order as the floats.
        let force_n = rt_core::math::norm(&view.tool.force_n).max(0.0);
        self.shared
            .force_max_n
            .fetch_max(force_n.to_bits(), Relaxed);
        if !view.tick.is_multiple_of(self.publish_every) {
            return;
        }
        if !self
            .gate
            .may_publish(now_ns(), self.deadline_ns, self.period_ns)
        {
            self.record.bits |= TickRecord::DROPPED_PUBLISH;
            Shared::count(&self.shared.frames_dropped);
            return;
        }
        let id = self.scene_id;
        let lines = self.devices.counters();
        let shown = self
            .ends
            .state
            .fill(|frame| frames::fill_state(frame, view, id, now))
            & self
                .ends
                .tools
                .fill(|frame| frames::fill_tools(frame, view, lines, id, now));
        if !shown {
            self.record.bits |= TickRecord::NOT_PUBLISHED;
            Shared::count(&self.shared.frames_skipped);
        }
    }

    fn may(&mut self, work: Optional) -> bool {
        let (stage, bit, counter, input_bit) = match work {
            Optional::SelfCollision => (
                Stage::Contact,
                TickRecord::DROPPED_SELF_COLLISION,
                &self.shared.self_collisions_dropped,
                InputRecord::NO_SELF_COLLISION,
            ),
            Optional::FarOrgans => (
                Stage::Solve,
                TickRecord::DROPPED_FAR_ORGANS,
                &self.shared.far_organs_dropped,
                InputRecord::NO_FAR_ORGANS,
            ),
        };
        let done_ns = now_ns() + budget::until_force_ns(&self.needs_ns, stage);
        if done_ns <= self.deadline_ns {
            return true;
        }
        self.record.bits |= bit;
        self.input.bits |= input_bit;
        Shared::count(counter);
        false
    }

    fn stamp(&mut self, stage: Stage) {
        let now = now_ns();
        let taken_ns = now.saturating_sub(self.last_stamp_ns);
        if let Some(place) = self.record.stage_ns.get_mut(stage as usize) {
            *place = saturate(taken_ns);
        }
        if taken_ns > budget::stage_ns(stage as usize, self.period_ns)
            && let Some(counter) = self.shared.stages_over.get(stage as usize)
        {
            Shared::count(counter);
        }
        self.last_stamp_ns = now;
    }
}

impl Tick {
    pub(crate) fn new(sim: Sim<'static>, world: World, periods_max: Option<u64>) -> Self {
        Self {
            sim,
            shared: Arc::clone(&world.shared),
            world,
            periods_max,
            periods: 0,
        }
    }

    /// Runs one control period and writes its record.
    pub(crate) fn run(&mut self, due: Due) -> ControlFlow<()> {
        let world = &mut self.world;
        if let Some(scope) = &world.scope_line {
            scope.begin();
        }
        let start = now_ns();
        let shared = &*self.shared;
        world.last_stamp_ns = start;
        world.deadline_ns = due.deadline_ns;
        world.fresh_at_ns = None;
        world.record = TickRecord {
            tick: shared.ticks.load(Relaxed),
            scheduled_ns: due.scheduled_ns,
            wake_latency_ns: saturate(start.saturating_sub(due.scheduled_ns)),
            missed: due.missed,
            bits: match &world.phase {
                Some(phase) if phase.rests() => TickRecord::NOT_FOLLOWING,
                _ => 0,
            },
            ..NO_RECORD
        };
        shared.scheduled_ns.store(due.scheduled_ns, Relaxed);
        shared.missed_periods.fetch_add(due.missed.into(), Relaxed);

        self.sim.tick(world);

        let end = now_ns();
        world.record.tick_ns = saturate(end.saturating_sub(start));
        if end > due.deadline_ns {
            world.record.bits |= TickRecord::OVERRAN;
            Shared::count(&shared.late_ticks);
            self.sim.note_overrun();
        }
        if world.ends.records.enqueue(world.record).is_err() {
            Shared::count(&shared.records_lost);
        }
        let before = shared.heartbeat_ns.load(Relaxed);
        if before > 0 {
            // Written before the heartbeat. A watch that reads this heartbeat (`Acquire`) then also
            // sees the time since the one before.
            shared
                .stood_ns
                .fetch_max(end.saturating_sub(before), Relaxed);
        }
        shared.heartbeat_ns.store(end, Release);
        shared.ticks.fetch_add(1, Relaxed);
        if let Some(scope) = &self.world.scope_line {
            scope.end();
        }
        self.periods += 1 + u64::from(due.missed);
        if self.periods_max.is_some_and(|max| self.periods >= max) {
            shared.ask_to_end(Ended::Finished);
        }
        match shared.asked_to_end() {
            None => ControlFlow::Continue(()),
            Some(_) => ControlFlow::Break(()),
        }
    }

    /// Step of the next tick's start, ns. Call it after each tick.
    pub(crate) fn step_ns(&mut self) -> i64 {
        let world = &mut self.world;
        let (scheduled_ns, arrived_ns) = (world.record.scheduled_ns, world.fresh_at_ns);
        match &mut world.phase {
            Some(phase) => phase.step_ns(scheduled_ns, arrived_ns),
            None => 0,
        }
    }

    /// Sends zero force to the haptic device, three times.
    pub(crate) fn make_safe(&mut self) {
        self.world.devices.make_safe(now_ns());
    }
}

fn saturate(ns: u64) -> u32 {
    u32::try_from(ns).unwrap_or(u32::MAX)
}
