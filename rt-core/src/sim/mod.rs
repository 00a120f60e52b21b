//! The tick.

mod exchange;
mod procedure;
mod view;

pub use exchange::{Command, Optional, Ports, Samples, Stage};
pub use view::{Health, SphereView, Status, TickView};

use crate::capacity::MAX_ORGANS;
use crate::collision::tool_contact::ToolContacts;
use crate::event::Journal;
use crate::fault::{Fault, FaultCounters, FaultSet};
use crate::force;
use crate::grasp::Grasp;
use crate::hash::Hash;
use crate::math::{self, Vec3};
use crate::output_limit::{Demand, OutputLimit};
use crate::port::{DeviceCapabilities, ForceCommand};
use crate::sample::Inputs;
use crate::scene::Scene;
use crate::soft_body::pbd::PaperPbd;
use crate::soft_body::{Bounds, Solver};
use crate::state::State;
use crate::tool::{Kinematics, ToolState, capsules};

/// One control period, s.
pub const TICK_S: f32 = 0.001;

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
    solver: PaperPbd,
    kinematics: Kinematics,
    inputs: Inputs,
    tool: ToolState,
    bounds: [Bounds; MAX_ORGANS],
    contacts: ToolContacts,
    grasp: Grasp,
    limit: OutputLimit,
    journal: Journal,
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
        state.bodies.load(&scene);
        state.pairs.load(&scene);
        let mut limit = OutputLimit::new(&device, parameters.force_ramp_s);
        limit.enable(parameters.force_enabled);
        let room = scene.room();
        let mut sim = Self {
            solver: PaperPbd {
                iterations: parameters.iterations,
            },
            kinematics: Kinematics {
                port_m: room.instrument_port_m,
                length_m: room.instrument_length_m,
            },
            inputs: Inputs::default(),
            tool: ToolState::new(room.instrument_port_m, room.world_from_camera),
            bounds: [Bounds::EMPTY; MAX_ORGANS],
            contacts: ToolContacts::default(),
            grasp: Grasp::default(),
            limit,
            journal: Journal::default(),
            fault_counters: FaultCounters::ZERO,
            tick: 0,
            scene,
            state,
        };
        sim.measure_bounds();
        sim
    }

    /// One control period, in the data's order. What it costs is bounded by the scene's counts
    /// and by [`crate::capacity`]; it neither blocks, allocates nor panics.
    pub fn tick(&mut self, ports: &mut impl Ports) {
        let mut faults = FaultSet::NONE;
        self.journal.begin();

        let samples = ports.sample();
        self.inputs.take(&samples, &mut faults);
        if self.inputs.stood_still() {
            self.limit.restart();
        }
        self.obey(samples.command);
        ports.stamp(Stage::Sample);

        self.move_tool();
        ports.stamp(Stage::Tool);

        let self_collision = ports.may(Optional::SelfCollision);
        self.find_contacts(self_collision, &mut faults);
        ports.stamp(Stage::Contact);

        let far_organs = ports.may(Optional::FarOrgans);
        self.solve(self_collision, far_organs, &mut faults);
        ports.stamp(Stage::Solve);

        let command = self.render_force(&mut faults);
        ports.send_force(command);
        ports.stamp(Stage::Force);

        self.work_instrument(&mut faults);
        self.note_events(&mut faults);
        ports.stamp(Stage::Procedure);

        self.fault_counters.count(faults);
        ports.publish(&self.view(faults));
        ports.stamp(Stage::Publish);
        self.tick = self.tick.wrapping_add(1);
    }

    fn obey(&mut self, command: Option<Command>) {
        match command {
            Some(Command::Pause(paused)) => self.tool.switches.paused = paused,
            Some(Command::EnableForce(enabled)) => self.limit.enable(enabled),
            Some(Command::Instrument(instrument)) => self.change_instrument(instrument),
            Some(Command::Reset) => {
                self.let_go();
                self.contacts.clear();
                self.state.bodies.rest(&self.scene);
                self.state.pairs.load(&self.scene);
                self.measure_bounds();
            }
            None => {}
        }
    }

    /// Device pose → instrument pose through the port, and its shapes; tracker → camera.
    fn move_tool(&mut self) {
        let room = self.scene.room();
        if let Some(sample) = self.inputs.device.newest() {
            let tool = &mut self.tool;
            tool.world_from_handle = room.world_from_device * sample.device_from_handle;
            tool.handle_velocity_m_s = room.world_from_device.rotation * self.inputs.velocity_m_s;
            tool.buttons = sample.buttons;
            let handle = &tool.world_from_handle;
            let length = tool.instrument.jaw_length_m();
            tool.tip_m = self.kinematics.tip(handle);
            tool.world_from_instrument = self.kinematics.instrument(handle, length);
            tool.capsules = capsules(
                tool.instrument,
                &tool.world_from_instrument,
                &room.instrument_port_m,
                tool.jaw,
            );
        }
        let pedal = self.inputs.pedal();
        self.tool.switches.pedal = pedal;
        if let (Some(sample), false) = (self.inputs.tracker.newest(), pedal.camera_lock) {
            self.tool.world_from_camera = room.world_from_tracker * sample.tracker_from_sensor;
        }
    }

    fn find_contacts(&mut self, self_collision: bool, faults: &mut FaultSet) {
        let (scene, bodies) = (&self.scene, &mut self.state.bodies);
        let paused = self.tool.switches.paused;
        bodies.begin(scene, !paused);
        if paused {
            self.contacts.clear();
        } else {
            self.contacts
                .find(&self.tool.capsules, scene, &self.bounds, bodies, faults);
            if self_collision {
                self.state.pairs.find(scene, bodies, faults);
            }
        }
    }

    /// One position-based step of every organ, contacts included.
    fn solve(&mut self, self_collision: bool, far_organs: bool, faults: &mut FaultSet) {
        if self.tool.switches.paused {
            return;
        }
        let worked = self.worked_organs();
        let (scene, bodies) = (&self.scene, &mut self.state.bodies);
        let moves = |organ: &usize| far_organs || worked.get(*organ).copied().unwrap_or(true);
        let moving = || (0..).zip(scene.organs).filter(|(i, _)| moves(i));
        for (_, organ) in moving() {
            bodies.predict(scene, organ);
        }
        self.grasp.carry(&self.tool.world_from_instrument, bodies);
        for (_, organ) in moving() {
            self.solver.project(scene, organ, bodies);
        }
        // Projecting pairs would move organs that stand still.
        if self_collision && far_organs {
            self.state.pairs.project(bodies);
        }
        self.contacts.push_out(&self.tool.capsules, scene, bodies);
        for (i, (organ, bounds)) in scene.organs.iter().zip(&mut self.bounds).enumerate() {
            if !moves(&i) {
                bodies.stand(organ);
                continue;
            }
            let put_back;
            (*bounds, put_back) = bodies.advance(organ);
            faults.raise_if(put_back > 0, Fault::BadSphere);
        }
    }

    /// Whether the instrument is near each organ, or holds some of it.
    fn worked_organs(&self) -> [bool; MAX_ORGANS] {
        let mut worked = [false; MAX_ORGANS];
        let organs = &self.state.bodies.organ;
        for sphere in self.contacts.near_spheres().chain(self.grasp.spheres()) {
            if let Some(organ) = worked.get_mut(usize::from(*organs.at(sphere))) {
                *organ = true;
            }
        }
        worked
    }

    /// What the tissue does to the hand, through the limits, in the device's frame.
    fn render_force(&mut self, faults: &mut FaultSet) -> ForceCommand {
        let paused = self.tool.switches.paused;
        let pull = self
            .grasp
            .pull(&self.scene, &self.state.bodies)
            .filter(|_| !paused);
        let handle = &self.tool.world_from_handle;
        let felt = force::felt(&self.contacts.list, pull.as_ref(), &self.kinematics, handle);
        let world_from_device = &self.scene.room().world_from_device.rotation;
        let demand = Demand {
            force_n: world_from_device.inverse() * felt.force_n,
            stiffness_n_m: felt.stiffness_n_m,
            speed_m_s: math::norm(&self.tool.handle_velocity_m_s),
            device: self.inputs.device_health().status,
            paused,
        };
        let force_n = self.limit.apply(&demand, faults);
        self.tool.force_n = world_from_device * force_n;
        self.tool.switches.force_enabled = self.limit.is_open();
        ForceCommand {
            force_n,
            torque_n_m: Vec3::zeros(),
        }
    }

    fn measure_bounds(&mut self) {
        for (organ, bounds) in self.scene.organs.iter().zip(&mut self.bounds) {
            *bounds = self.state.bodies.bounds(organ);
        }
    }

    fn view(&self, faults: FaultSet) -> TickView<'_> {
        TickView {
            tick: self.tick,
            sample_ns: self.inputs.device.at_ns(),
            sample_is_fresh: self.inputs.device.is_fresh(),
            tool: &self.tool,
            events: self.journal.events(),
            faults,
            fault_counters: &self.fault_counters,
            device: self.inputs.device_health(),
            tracker: self.inputs.tracker_health(),
            pedal: self.inputs.pedal_health(),
            scene: &self.scene,
            bodies: &self.state.bodies,
        }
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

    /// Speed of the fastest sphere, m/s.
    #[must_use]
    pub fn speed_max_m_s(&self) -> f32 {
        let velocities = self
            .state
            .bodies
            .velocity_m_s
            .range(0, self.scene.spheres.len() as u32);
        math::sqrt(
            velocities
                .iter()
                .map(Vec3::norm_squared)
                .fold(0.0, f32::max),
        )
    }

    /// Hash of what the simulation computed: spheres, tool, force. Equal after equal inputs, bit
    /// for bit, in every build.
    #[must_use]
    pub fn state_hash(&self) -> u64 {
        let mut hash = Hash::new();
        let (bodies, count) = (&self.state.bodies, self.scene.spheres.len() as u32);
        for i in 0..count {
            hash.vector(bodies.displacement_m.at(i));
            hash.vector(bodies.velocity_m_s.at(i));
            hash.word(u32::from(bodies.bits.at(i).0));
        }
        hash.pose(&self.tool.world_from_handle);
        hash.pose(&self.tool.world_from_instrument);
        hash.pose(&self.tool.world_from_camera);
        hash.vector(&self.tool.force_n);
        hash.float(self.tool.jaw);
        hash.word(self.tick as u32);
        hash.finish()
    }
}
