//! The tick: `sample → tool → contact → solve → force → procedure → publish`.
//!
//! | stage | does |
//! |---|---|
//! | sample | reads the newest poses, buttons and commands; checks their values and their age |
//! | tool | computes the poses and capsules of instrument and endoscope |
//! | contact | finds the contacts of organs with tools, with each other and with themselves |
//! | solve | moves the tissue, in substeps, with every constraint |
//! | force | sums the wrench on the handle, limits it, and sends it to the device at once |
//! | procedure | moves the jaws; grasps, cuts, clips, sews, burns, tears and leaks; raises events |
//! | publish | passes the results to `Ports::publish` |
//!
//! # Determinism
//!
//! Every input of a tick passes through `Ports::sample`, `Ports::findings` and `Ports::may`. From a
//! recording of these, a run can be reproduced bit for bit. The core calls no maths library and
//! uses no fused multiply-add; square roots are correctly rounded. The core reads no clock: the
//! time, and the decision to omit work, are inputs like the samples.
//!
//! # Digest
//!
//! The digest of a tick holds a hash of the tools, a hash of the checksums of all organs' spheres,
//! and eight bits of each organ's checksum. Every sphere counts in every tick. So a comparison of
//! two runs finds the first tick that differs, and the organ. The checksums are plain sums, because
//! a hash of every number would take too long for a tick. Results that affect neither tools nor
//! spheres, such as the flow of a leak, are not in the digest.
//!
//! # Checkpoints
//!
//! `Sim::checkpoint` copies the state between two ticks (about 4 MB). From the copy, equal inputs
//! reproduce all later ticks bit for bit.
//!
//! # Prepared tasks
//!
//! `Command::Start` resets the scene and does the work of the earlier tasks: it removes cells,
//! closes clips and divides tubes. (For the first task it takes the sutures down instead.) The
//! reset raises an event; the prepared work does not.

mod buried;
mod checkpoint;
mod complicate;
mod coupling;
mod digest;
mod exchange;
mod procedure;
mod sample;
mod sew;
mod start;
mod stones;
mod unrest;
mod view;

pub use crate::contact::dent::Dent;
pub use checkpoint::Checkpoint;
pub use digest::Digest;
pub use exchange::{Command, Complication, Optional, Ports, Samples, Stage, Task};
pub use view::{SphereView, TickView};

use coupling::OuterConstraints;
use heapless::Vec;

use crate::capacity::{MAX_CAPSULES, MAX_ORGANS};
use crate::contact::tool_contact::ToolContacts;
use crate::fault::{Fault, FaultCounters, FaultSet};
use crate::haptics::handle_force;
use crate::haptics::output_limit::{Demand, OutputLimit};
use crate::haptics::proxy::Proxy;
use crate::haptics::transition::Transition;
use crate::haptics::trocar::{TrocarForce, TrocarLaw};
use crate::hash::Hash;
use crate::math::{self, Vec3};
use crate::port::{DeviceCapabilities, Findings, ForceCommand};
use crate::procedure::cautery::Cautery;
use crate::procedure::clip::Clips;
use crate::procedure::grasp::Grasp;
use crate::procedure::journal::Journal;
use crate::procedure::opening::JawDrive;
use crate::procedure::unrest::Unrest;
use crate::scene::{Anchor, Attachment, Scene};
use crate::sim::sample::Inputs;
use crate::state::State;
use crate::tissue::sleep::Sleep;
use crate::tissue::{Bounds, Method, Node, substeps};
use crate::tool::{Capsule, Kinematics, ToolState, Wrench, capsules, endoscope};
use crate::words::{Event, EventKind};

/// Gap between the bounding boxes of two organs below which a moving organ wakes a sleeping organ,
/// m. With a larger gap, organs wake earlier, and cost more time.
const WAKE_GAP_M: f32 = 0.002;

/// Parameters of a simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Time in which the force rises from zero to full, s.
    pub force_ramp_s: f32,
    /// True if force is enabled from the start, without [`Command::EnableForce`].
    pub force_enabled: bool,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
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
    method: Method<'a>,
    sleep: Sleep,
    unrest: Unrest,
    kinematics: Kinematics,
    inputs: Inputs,
    tool: ToolState,
    proxy: Proxy,
    drive: JawDrive,
    bounds: [Bounds; MAX_ORGANS],
    contacts: ToolContacts,
    grasp: Grasp,
    cautery: Cautery,
    clips: Clips,
    transition: Transition,
    trocar: TrocarLaw,
    limit: OutputLimit,
    renders_torque: bool,
    /// True if tissue or jaws demanded a force in this tick.
    asks_force: bool,
    journal: Journal,
    fault_counters: FaultCounters,
    tick: u64,
}

impl<'a> Sim<'a> {
    /// A simulation of `scene` at rest, in the storage `state`, with tissue as a neo-Hookean solid.
    #[must_use]
    pub fn new(
        scene: Scene<'a>,
        state: &'a mut State,
        device: DeviceCapabilities,
        parameters: Parameters,
    ) -> Self {
        state.bodies.load(&scene);
        state.pairs.load(&scene);
        state.between.forget();
        state.vessels.reset();
        state.heat.load(&scene);
        state.stones.reset();
        let mut limit = OutputLimit::new(&device, parameters.force_ramp_s);
        limit.enable(parameters.force_enabled);
        let room = scene.room();
        let mut sim = Self {
            method: Method::NeoHookean,
            sleep: Sleep::AWAKE,
            unrest: Unrest::NONE,
            kinematics: Kinematics {
                port_m: room.instrument_port_m,
                length_m: room.instrument_length_m,
            },
            inputs: Inputs::of(&device),
            tool: ToolState::new(room.instrument_port_m, room.world_from_camera),
            proxy: Proxy::NONE,
            drive: JawDrive::new(device.opening),
            bounds: [Bounds::EMPTY; MAX_ORGANS],
            contacts: ToolContacts::default(),
            grasp: Grasp::default(),
            cautery: Cautery::default(),
            clips: Clips::default(),
            transition: Transition::NONE,
            trocar: TrocarLaw::new(&room.trocar, limit.stiffness_max_n_m()),
            limit,
            renders_torque: device.renders_torque(),
            asks_force: false,
            journal: Journal::default(),
            fault_counters: FaultCounters::ZERO,
            tick: 0,
            scene,
            state,
        };
        sim.measure_bounds();
        sim.load_unrest();
        sim
    }

    /// Solves tissue by `method` from the next tick on.
    pub fn solve_by(&mut self, method: Method<'a>) {
        self.method = method;
    }

    /// Advances one control period, stage by stage. The scene's counts and [`crate::capacity`]
    /// bound its cost. A tick neither blocks, allocates nor panics.
    pub fn tick(&mut self, ports: &mut impl Ports) {
        let mut faults = FaultSet::NONE;
        self.journal.begin();

        let samples = ports.sample();
        self.inputs.take(&samples, &mut faults);
        let findings = ports.findings();
        faults = faults.with(findings.faults);
        if self.inputs.is_settling() {
            self.limit.restart();
        }
        if self.inputs.may_have_jumped() || findings.leapt {
            self.limit.restart();
            self.transition = Transition::NONE;
            self.trocar.release();
            self.contacts.clear();
        }
        self.execute(samples.command);
        ports.stamp(Stage::Sample);

        self.move_tool();
        ports.stamp(Stage::Tool);

        let self_collision = ports.may(Optional::SelfCollision);
        self.find_contacts(self_collision, &mut faults);
        ports.stamp(Stage::Contact);

        let far_organs = ports.may(Optional::FarOrgans);
        self.solve(far_organs, &mut faults);
        ports.stamp(Stage::Solve);

        let command = self.render_force(&findings, &mut faults);
        ports.send_force(command);
        ports.stamp(Stage::Force);

        self.work_instrument(&mut faults);
        // The journal is bounded. Fault events come first, so that burns and tears cannot displace
        // them.
        self.note_events(&mut faults);
        self.note_buried();
        self.burn();
        self.tear();
        self.leak();
        self.spread_heat();
        self.move_stones();
        self.note_unrest();
        let has_lost_leak = self.state.vessels.take_lost_leak();
        faults.raise_if(
            has_lost_leak || self.journal.is_full(),
            Fault::EventOverflow,
        );
        ports.stamp(Stage::Procedure);

        self.fault_counters.count(faults);
        ports.publish(&self.view(faults));
        ports.stamp(Stage::Publish);
        self.tick = self.tick.wrapping_add(1);
    }

    fn execute(&mut self, command: Option<Command>) {
        match command {
            Some(Command::Pause(paused)) => {
                self.tool.switches.paused = paused;
                self.transition.discontinuity();
            }
            Some(Command::EnableForce(enabled)) => self.limit.enable(enabled),
            Some(Command::Instrument(instrument)) => self.change_instrument(instrument),
            Some(Command::Reset) => self.reset(),
            Some(Command::Start(task)) => self.start(task),
            Some(Command::Complication(complication)) => self.complicate(complication),
            None => {}
        }
    }

    /// Puts every organ back to rest without damage, releases grasped tissue, and removes all
    /// clips.
    fn reset(&mut self) {
        self.release_tissue();
        self.contacts.clear();
        self.sleep = Sleep::AWAKE;
        self.proxy = Proxy::NONE;
        self.cautery = Cautery::default();
        self.clips = Clips::default();
        self.state.vessels.reset();
        self.state.heat.load(&self.scene);
        self.state.stones.reset();
        self.state.bodies.reset(&self.scene);
        self.state.pairs.load(&self.scene);
        self.state.between.forget();
        self.measure_bounds();
        self.unrest.start(&self.scene, &self.bounds);
        self.journal.raise(Event {
            kind: EventKind::Reset,
            organ: None,
            at_m: self.tool.tip_m,
            value: 0.0,
        });
    }

    /// Computes pose and capsules of the instrument from the device's pose, and pose and capsule of
    /// the endoscope from the tracker's.
    fn move_tool(&mut self) {
        let room = self.scene.room();
        if let Some(sample) = self.inputs.device.newest() {
            let tool = &mut self.tool;
            tool.world_from_handle = room.world_from_device * sample.device_from_handle;
            tool.handle_velocity_m_s = room.world_from_device.rotation * self.inputs.velocity_m_s;
            tool.buttons = sample.buttons;
            let is_first_after_gap = self.inputs.is_first_after_gap() && self.grasp.count() == 0;
            // In a pause the jaws stay. After the pause, they follow the handle's opening no faster
            // than jaws can move.
            if !tool.switches.paused {
                self.drive.follow(sample.opening, is_first_after_gap);
                if let (Some(opening), true) = (self.drive.handle_opening(), is_first_after_gap) {
                    tool.jaw = opening; // after a gap the jaws jump to it, without bite or cut
                }
            }
            let handle = &self.proxy.handle(&tool.world_from_handle);
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
            let camera = room.world_from_tracker * sample.tracker_from_sensor;
            self.tool.world_from_camera = camera;
            self.tool.endoscope = endoscope(&room.endoscope_port_m, &camera);
        }
    }

    fn find_contacts(&mut self, self_collision: bool, faults: &mut FaultSet) {
        let (scene, bodies) = (&self.scene, &mut self.state.bodies);
        let paused = self.tool.switches.paused;
        bodies.begin(scene, !paused);
        if paused {
            self.contacts.clear();
        } else {
            let mut parts: Vec<Capsule, MAX_CAPSULES> = Vec::new();
            for part in self.tool.capsules.iter().chain(&self.tool.endoscope) {
                let _ = parts.push(*part); // both tools together have fewer
            }
            self.contacts
                .find(&parts, scene, &self.bounds, bodies, faults);
            let mut organs = 0..scene.organs.len();
            let sleeps = |organ| self.sleep.is_asleep(organ);
            self.state.between.skip();
            if self_collision && !organs.all(sleeps) {
                self.state.pairs.find(bodies, faults);
                let near = self.state.pairs.near();
                self.state.between.choose(near, scene, bodies, faults);
            }
        }
    }

    /// Advances every organ that moves in this tick in its substeps, with contacts.
    fn solve(&mut self, far_organs: bool, faults: &mut FaultSet) {
        if self.tool.switches.paused {
            return;
        }
        let moves = self.moving_organs(far_organs);
        let (scene, bodies) = (&self.scene, &mut self.state.bodies);
        let jaws = &self.tool.world_from_instrument;
        for (organ, moves) in scene.organs.iter().zip(moves) {
            match moves {
                true => bodies.breathe(scene, organ, self.tick),
                false => bodies.mark_asleep(organ),
            }
        }
        let mut coupling = OuterConstraints {
            scene,
            jaws,
            between: &mut self.state.between,
            contacts: &mut self.contacts,
            clips: &mut self.clips,
            grasp: &mut self.grasp,
        };
        let quarantined = substeps::run(scene, &mut self.method, &moves, &mut coupling, bodies);
        faults.raise_if(quarantined > 0, Fault::BadSphere);
        // All organs have reached the end of the tick.
        self.clips.carry(None, scene, bodies);
        self.grasp.carry(None, 1.0, jaws, scene, bodies);
        self.contacts.push_out(scene, bodies);
        for ((i, organ), moves) in (0u8..).zip(scene.organs).zip(moves) {
            if !moves {
                continue;
            }
            let quarantined = bodies.advance(scene, organ, scene.step_s_of(i));
            bodies.stop_leading(organ);
            faults.raise_if(quarantined > 0, Fault::BadSphere);
            let net_speed_m_s = bodies.net_speed_m_s(organ);
            self.unrest.record_speed(i.into(), net_speed_m_s);
            if self.sleep.record_speed(i.into(), net_speed_m_s) {
                bodies.halt(organ);
            }
            if let Some(bounds) = self.bounds.get_mut(usize::from(i)) {
                *bounds = bodies.bounds(organ);
            }
        }
        bodies.move_spheres_without_cells(scene);
    }

    /// Organs that are simulated in this tick: the organs near a tool or in the jaws and, if
    /// `far_organs`, all other organs that are awake. Wakes organs that are near a tool, in the
    /// jaws, moved by breathing, pulled by a suture, or next to a moving organ.
    fn moving_organs(&mut self, far_organs: bool) -> [bool; MAX_ORGANS] {
        let at_tools = self.organs_at_tools();
        let mut moves = at_tools;
        let bodies = &mut self.state.bodies;
        for sphere in bodies.sutures.waking_spheres(&self.scene, &bodies.damage) {
            self.sleep.wake((*bodies.organ.at(sphere)).into());
        }
        for (i, (organ, moves)) in self.scene.organs.iter().zip(&mut moves).enumerate() {
            let breathes = self.scene.room.breath_s > 0.0 && organ.breath_m != Vec3::zeros();
            if *moves || breathes || self.must_wake(i) {
                self.sleep.wake(i);
            }
            *moves |= far_organs && !self.sleep.is_asleep(i);
        }
        moves
    }

    /// True if this organ sleeps, and a moving organ is near it or attached to it.
    fn must_wake(&self, organ: usize) -> bool {
        let Some(own) = self.bounds.get(organ) else {
            return false;
        };
        let others = self.bounds.iter().enumerate().take(self.scene.organs.len());
        let near = |(i, bounds): (usize, &Bounds)| {
            i != organ && self.sleep.wakes_neighbours(i) && own.is_near(bounds, WAKE_GAP_M)
        };
        let organ_of = |sphere: u32| usize::from(*self.state.bodies.organ.at(sphere));
        let pulls = |tie: &Attachment| match tie.to {
            Anchor::Sphere(other) => {
                let ends = (organ_of(tie.sphere), organ_of(other));
                (ends.0 == organ && self.sleep.wakes_neighbours(ends.1))
                    || (ends.1 == organ && self.sleep.wakes_neighbours(ends.0))
            }
            Anchor::World(_) => false,
        };
        self.sleep.is_asleep(organ)
            && (others.into_iter().any(near) || self.scene.attachments.iter().any(pulls))
    }

    /// For each organ, true if a tool is near it or the jaws hold part of it.
    fn organs_at_tools(&self) -> [bool; MAX_ORGANS] {
        let mut at_tools = [false; MAX_ORGANS];
        let bodies = &self.state.bodies;
        let organs = &bodies.organ;
        for sphere in (self.contacts.near_spheres(bodies)).chain(self.grasp.spheres()) {
            if let Some(organ) = at_tools.get_mut(usize::from(*organs.at(sphere))) {
                *organ = true;
            }
        }
        at_tools
    }

    /// Force of the tissue on the hand, through the limits, in the device's frame.
    fn render_force(&mut self, findings: &Findings, faults: &mut FaultSet) -> ForceCommand {
        let paused = self.tool.switches.paused;
        let pull = self.grasp.pull(&self.state.bodies).filter(|_| !paused);
        let felt = handle_force::felt(
            &self.contacts.forces,
            pull.as_ref(),
            &self.kinematics,
            &self.proxy.handle(&self.tool.world_from_handle),
            self.renders_torque,
        );
        let wrench = self.transition.felt(&felt.wrench);
        let trocar = self.rub(felt.stiffness_n_m);
        self.drive.settle(&procedure::jaws(&self.tool), &self.grasp);
        let world_from_device = &self.scene.room().world_from_device.rotation;
        let demand = Demand {
            force_n: world_from_device.inverse() * wrench.force_n,
            torque_nm: world_from_device.inverse() * wrench.torque_nm,
            opening_n: self.drive.force_n(),
            stiffness_n_m: felt.stiffness_n_m,
            trocar_n: world_from_device.inverse() * trocar.force_n,
            trocar_n_m: trocar.stiffness_n_m,
            handle_m: self.inputs.fresh_handle_m(),
            speed_m_s: math::norm(&self.tool.handle_velocity_m_s),
            device: self.inputs.device_health().status,
            device_fails: findings.faults.contains(Fault::DeviceFault),
            paused,
        };
        self.asks_force = (wrench != Wrench::ZERO || demand.opening_n > 0.0) && !paused;
        let command = self.limit.apply(&demand, faults);
        if let (Some(limit_n), false) = (self.limit.rendered_n(), paused) {
            let force_n = &felt.wrench.force_n;
            self.proxy
                .update(force_n, felt.instant_stiffness_n_m, limit_n);
        }
        self.tool.force_n = world_from_device * (command.force_n - self.limit.trocar_n());
        self.tool.torque_nm = world_from_device * command.torque_nm;
        self.tool.opening_n = command.opening_n;
        self.tool.switches.force_enabled = self.limit.is_open();
        command
    }

    /// Force of the trocar on the hand. In a pause, and before the first sample of the device, the
    /// shaft does not rub.
    fn rub(&mut self, tissue_n_m: f32) -> TrocarForce {
        let is_held = self.inputs.device.newest().is_some() && !self.tool.switches.paused;
        if !is_held || self.inputs.is_first_after_gap() {
            self.trocar.release();
        }
        if !is_held {
            return TrocarForce::NONE;
        }
        let handle = &self.tool.world_from_handle;
        self.trocar.felt(&self.kinematics, handle, tissue_n_m)
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
            energy_j: self.limit.energy_j(),
            asks_force: self.asks_force,
            force_share: self.limit.share(),
            faults,
            fault_counters: &self.fault_counters,
            device: self.inputs.device_health(),
            tracker: self.inputs.tracker_health(),
            pedal: self.inputs.pedal_health(),
            clips: self.clips.on_tubes(),
            clips_left: self.clips.remaining(),
            contacts: &self.contacts,
            scene: &self.scene,
            bodies: &self.state.bodies,
            heat: &self.state.heat,
            stones: &self.state.stones,
        }
    }

    /// Records that the last tick ended after its deadline; called by the process.
    pub fn note_overrun(&mut self) {
        let mut set = FaultSet::NONE;
        set.raise(Fault::Overrun);
        self.fault_counters.count(set);
    }

    /// Counters of all faults.
    #[must_use]
    pub const fn fault_counters(&self) -> &FaultCounters {
        &self.fault_counters
    }

    /// Speed of the fastest sphere, m/s.
    #[must_use]
    pub fn speed_max_m_s(&self) -> f32 {
        let count = self.scene.spheres.len() as u32;
        let nodes = self.state.bodies.nodes.range(0, count).iter();
        let squared = |node: &Node| node.velocity_m_s().norm_squared();
        math::sqrt(nodes.map(squared).fold(0.0, f32::max))
    }

    /// Hash of the results (spheres, tool, force, cells, sutures). Equal inputs give equal hashes
    /// in every build.
    #[must_use]
    pub fn state_hash(&self) -> u64 {
        let mut hash = Hash::new();
        let (bodies, count) = (&self.state.bodies, self.scene.spheres.len() as u32);
        for i in 0..count {
            hash.vector(&bodies.nodes.at(i).moved_m());
            hash.vector(&bodies.nodes.at(i).velocity_m_s());
            hash.word(u32::from(bodies.bits.at(i).0));
        }
        hash.pose(&self.tool.world_from_handle);
        hash.pose(&self.tool.world_from_instrument);
        hash.pose(&self.tool.world_from_camera);
        hash.vector(&self.tool.force_n);
        hash.vector(&self.tool.torque_nm);
        hash.float(self.tool.jaw);
        hash.word(self.tick as u32);
        if !self.scene.layers.cells.is_empty() {
            hash.word(bodies.cells.history());
        }
        bodies.sutures.hash_into(&mut hash);
        self.state.stones.hash_into(&self.scene, &mut hash);
        hash.finish()
    }
}
