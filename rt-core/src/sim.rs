//! The tick.

use heapless::Vec;

use crate::capacity::MAX_EVENTS_PER_TICK;
use crate::event::Event;
use crate::fault::{Fault, FaultCounters, FaultSet};
use crate::math::Vec3;
use crate::port::{
    DeviceCapabilities, DeviceSample, ForceCommand, PedalSample, Polled, TimeNs, TrackerSample,
};
use crate::scene::Scene;
use crate::state::{SphereBits, State};
use crate::tool::{Instrument, ToolState};

/// One control period, s.
pub const TICK_S: f32 = 0.001;

/// What the world asks of the simulation; at most one a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Command {
    /// Stand still (true) or go on.
    Pause(bool),
    /// Put every organ back to rest and let go.
    Reset,
    /// Let force through (true; also after a trip) or cut it.
    EnableForce(bool),
    /// Put another instrument on the shaft.
    Instrument(Instrument),
}

/// What stage `sample` brings in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Samples {
    /// Host time now.
    pub now_ns: TimeNs,
    /// Haptic device.
    pub device: Polled<DeviceSample>,
    /// Endoscope's tracker.
    pub tracker: Polled<TrackerSample>,
    /// Foot pedal.
    pub pedal: Polled<PedalSample>,
    /// Next command of the host.
    pub command: Option<Command>,
}

/// Stages of a tick, in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
#[allow(missing_docs)]
pub enum Stage {
    Sample = 0,
    Tool = 1,
    Contact = 2,
    Solve = 3,
    Force = 4,
    Procedure = 5,
    Publish = 6,
}

impl Stage {
    /// All stages, in order.
    pub const ALL: [Self; 7] = [
        Self::Sample,
        Self::Tool,
        Self::Contact,
        Self::Solve,
        Self::Force,
        Self::Procedure,
        Self::Publish,
    ];
}

/// How the tick meets the world. No call may block or allocate.
pub trait Ports {
    /// Time, newest samples, command.
    fn sample(&mut self) -> Samples;
    /// Sends the force to the device; called once a tick, as soon as stage `force` knows it.
    fn send_force(&mut self, command: ForceCommand);
    /// Shows what the tick did.
    fn publish(&mut self, view: &TickView<'_>);
    /// Called at the end of each stage: the process reads its clock.
    fn stamp(&mut self, stage: Stage);
}

/// Whether a device can be relied on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Status {
    /// Nothing came from it since the start.
    #[default]
    Absent = 0,
    /// Samples arrive in time.
    Live = 1,
    /// The newest sample is older than its limit.
    Stale = 2,
    /// The line is gone.
    Lost = 3,
}

/// Health of one device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Health {
    /// Status.
    pub status: Status,
    /// Age of its newest sample, ns. 0 if there is none.
    pub age_ns: u64,
}

/// A sphere as a tick leaves it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SphereView {
    /// Centre, world frame, m.
    pub center_m: Vec3,
    /// What it is doing.
    pub bits: SphereBits,
}

/// What a tick shows.
#[derive(Debug)]
pub struct TickView<'a> {
    /// Number of the tick, from 0.
    pub tick: u64,
    /// When the device sample that this tick used was read; 0 before the first.
    pub sample_ns: TimeNs,
    /// Whether that sample is new in this tick.
    pub sample_is_fresh: bool,
    /// Tools and switches.
    pub tool: &'a ToolState,
    /// What happened, in order.
    pub events: &'a [Event],
    /// Faults of this tick.
    pub faults: FaultSet,
    /// Ticks that each fault happened in so far.
    pub fault_counters: &'a FaultCounters,
    /// Haptic device.
    pub device: Health,
    /// Tracker.
    pub tracker: Health,
    /// Pedal.
    pub pedal: Health,
    scene: &'a Scene<'a>,
    state: &'a State,
}

impl<'a> TickView<'a> {
    /// The spheres, in the scene's order.
    pub fn spheres(&self) -> impl ExactSizeIterator<Item = SphereView> + use<'a> {
        let moved = self.state.displacement_m.iter().zip(&self.state.bits);
        self.scene
            .spheres
            .iter()
            .zip(moved)
            .map(|(rest, (u, bits))| SphereView {
                center_m: rest.center_m + Vec3::new(u[0], u[1], u[2]),
                bits: SphereBits(*bits),
            })
    }
}

/// What can be chosen when the simulation starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Iterations of the constraints in a tick. The paper's stiffness grows with it.
    pub iterations: u32,
    /// Time over which the force rises after each enable, s.
    pub force_ramp_s: f32,
    /// Whether force may leave from the start, without [`Command::EnableForce`].
    pub force_enabled: bool,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            iterations: 10,
            force_ramp_s: 2.0,
            force_enabled: false,
        }
    }
}

/// The simulation: an immutable scene, its state, and the control law.
#[derive(Debug)]
pub struct Sim<'a> {
    scene: Scene<'a>,
    state: &'a mut State,
    tool: ToolState,
    events: Vec<Event, MAX_EVENTS_PER_TICK>,
    fault_counters: FaultCounters,
    tick: u64,
}

impl<'a> Sim<'a> {
    /// Puts `scene` at rest into `state`.
    #[must_use]
    pub fn new(
        scene: Scene<'a>,
        state: &'a mut State,
        device: DeviceCapabilities,
        parameters: Parameters,
    ) -> Self {
        let _ = (device, parameters);
        let tool = ToolState::new(scene.room.instrument_port_m, scene.room.world_from_camera);
        Self {
            scene,
            state,
            tool,
            events: Vec::new(),
            fault_counters: FaultCounters::ZERO,
            tick: 0,
        }
    }

    /// One control period.
    pub fn tick(&mut self, ports: &mut impl Ports) {
        let samples = ports.sample();
        ports.stamp(Stage::Sample);
        ports.stamp(Stage::Tool);
        ports.stamp(Stage::Contact);
        ports.stamp(Stage::Solve);
        ports.send_force(ForceCommand::default());
        ports.stamp(Stage::Force);
        ports.stamp(Stage::Procedure);
        let _ = samples;
        ports.publish(&TickView {
            tick: self.tick,
            sample_ns: 0,
            sample_is_fresh: false,
            tool: &self.tool,
            events: &self.events,
            faults: FaultSet::NONE,
            fault_counters: &self.fault_counters,
            device: Health::default(),
            tracker: Health::default(),
            pedal: Health::default(),
            scene: &self.scene,
            state: self.state,
        });
        ports.stamp(Stage::Publish);
        self.tick = self.tick.wrapping_add(1);
    }

    /// Told by the process: the last tick ended after its deadline.
    pub fn note_overrun(&mut self) {
        let mut set = FaultSet::NONE;
        set.raise(Fault::Overrun);
        self.fault_counters.count(set);
    }

    /// What each fault counted so far.
    #[must_use]
    pub const fn fault_counters(&self) -> &FaultCounters {
        &self.fault_counters
    }

    /// Hash of the whole mutable state: equal after equal inputs, bit for bit.
    #[must_use]
    pub fn state_hash(&self) -> u64 {
        0
    }
}
