//! Runs the simulation with the emulated hand as fast as possible, without other processes, devices
//! or clocks. Equal scenes and equal movements give results that are equal bit by bit. This is for
//! tests, and for trying out a task.

use hardware::emulate::{HandScript, SteeredHand, Wish};
use hardware::rig::wire::{Capabilities, Switches};
use hardware::station::StationFile;
use rt_core::math::Vec3;
use rt_core::port::{Buttons, DeviceSample, ForceCommand, LineCounters};
use rt_core::port::{PedalSample, Polled, TrackerSample};
use rt_core::sim::{Digest, Parameters, Ports, Samples, Sim, Stage, TickView};
use rt_core::state::State;
use shared_mem::inputs::{InputRecord, RunSetup};
use shared_mem::message::{CommandMsg, EventMsg, HandMsg, StateFrame, ToolFrame};
use shared_mem::scene::{RoomRecord, SceneFile};
use shared_mem::words;

use crate::error::RtError;
use crate::scene::LoadedScene;
use crate::{frames, inputs};

/// Control period, ns.
const PERIOD_NS: u64 = 1_000_000;
/// Number of ticks per frame, as in a station.
const FRAME_EVERY: u64 = 4;
/// Number of ticks per sample of tracker and pedal, as in a station.
const SLOW_EVERY: u64 = 10;

/// A simulation and the hand that works in it.
#[derive(Debug)]
pub struct Rehearsal<'a> {
    sim: Sim<'a>,
    hand: SteeredHand,
    world: World,
    setup: RunSetup,
}

/// Inputs and outputs of the simulation.
#[derive(Debug)]
struct World {
    samples: Samples,
    ticks: u64,
    force_n: Vec3,
    state: Box<StateFrame>,
    tools: Box<ToolFrame>,
    events: Vec<EventMsg>,
    next_event: u64,
    scene_id: [u8; 16],
    hash: u64,
    records: Vec<InputRecord>,
}

/// Runs `work` on `scene`, from rest.
///
/// # Errors
/// When the core refuses the scene, or the emulated devices do not reach the scene's target.
pub fn rehearse<R>(
    scene: &SceneFile,
    work: impl FnOnce(&mut Rehearsal<'_>) -> R,
) -> Result<R, RtError> {
    let loaded = LoadedScene::from_file(scene, &StationFile::default())?;
    let mut state = Box::new(State::new());
    let parameters = Parameters {
        force_enabled: true,
        ..Parameters::default()
    };
    let device = (&Capabilities::touch_class()).into();
    let at_rest = loaded.scene()?;
    let room = at_rest.room();
    let trocar = loaded.trocar;
    let setup = inputs::setup(
        loaded.short_id,
        PERIOD_NS,
        room,
        &device,
        &parameters,
        trocar,
        0,
    );
    let sim = Sim::new(at_rest, &mut state, device, parameters);
    let hand = SteeredHand::new(script(scene.room()), &Wish::default());
    let hand = hand.map_err(|source| RtError::Device {
        device: "the emulated haptic device",
        source,
    })?;
    let samples = Samples {
        now_ns: 0,
        device: Polled::Nothing,
        tracker: Polled::Nothing,
        pedal: Polled::Nothing,
        command: None,
    };
    let world = World {
        samples,
        ticks: 0,
        force_n: Vec3::zeros(),
        state: bytemuck::zeroed_box(),
        tools: bytemuck::zeroed_box(),
        events: Vec::new(),
        next_event: 0,
        scene_id: loaded.short_id,
        hash: 0,
        records: Vec::new(),
    };
    Ok(work(&mut Rehearsal {
        sim,
        hand,
        world,
        setup,
    }))
}

impl Rehearsal<'_> {
    /// Runs a tick in which the hand moves as `asked`. [`Self::events`] returns the tick's events.
    pub fn tick(&mut self, asked: &HandMsg, command: Option<CommandMsg>) {
        let world = &mut self.world;
        world.ticks += 1;
        let at_ns = world.ticks * PERIOD_NS;
        let measured = self.hand.step(&wish(asked), world.force_n);
        let is_slow = world.ticks.is_multiple_of(SLOW_EVERY);
        world.samples = Samples {
            now_ns: at_ns,
            device: Polled::Fresh(DeviceSample {
                opening: None,
                device_from_handle: measured.device_from_handle,
                velocity_m_s: Some(measured.velocity_m_s),
                buttons: measured.buttons,
                sequence: world.ticks as u16,
                at_ns,
            }),
            tracker: slow(is_slow, || TrackerSample {
                tracker_from_sensor: measured.tracker_from_sensor,
                at_ns,
            }),
            pedal: slow(is_slow, || PedalSample {
                cut: measured.switches.cut,
                coagulate: measured.switches.coagulate,
                camera_lock: measured.switches.camera_lock,
                at_ns,
            }),
            command: command
                .and_then(|it| inputs::command(it.kind as u8 | (it.argument << 4) as u8)),
        };
        self.sim.tick(world);
    }

    /// Newest frame of the spheres.
    #[must_use]
    pub fn state(&self) -> &StateFrame {
        &self.world.state
    }

    /// Newest frame of the tools.
    #[must_use]
    pub fn tools(&self) -> &ToolFrame {
        &self.world.tools
    }

    /// Takes the events since the last call.
    pub fn events(&mut self) -> Vec<EventMsg> {
        core::mem::take(&mut self.world.events)
    }

    /// Start conditions of the run. With them, the scene and [`Self::records`],
    /// [`crate::replay::Replay`] repeats the run.
    #[must_use]
    pub fn setup(&self) -> RunSetup {
        self.setup
    }

    /// Takes the input records since the last call, with the digest of each tick.
    pub fn records(&mut self) -> Vec<InputRecord> {
        core::mem::take(&mut self.world.records)
    }

    /// Number of ticks so far.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.world.ticks
    }

    /// Hash over the results of all ticks.
    #[must_use]
    pub fn hash(&self) -> u64 {
        self.world.hash
    }
}

fn slow<T>(is_due: bool, sample: impl FnOnce() -> T) -> Polled<T> {
    if is_due {
        Polled::Fresh(sample())
    } else {
        Polled::Nothing
    }
}

impl Ports for World {
    fn sample(&mut self) -> Samples {
        self.samples
    }

    fn send_force(&mut self, command: ForceCommand) {
        self.force_n = command.force_n;
    }

    fn publish(&mut self, view: &TickView<'_>) {
        let at_ns = self.samples.now_ns;
        for event in view.events {
            let event = frames::event(event, self.next_event, view.tick, at_ns);
            self.events.push(event);
            self.next_event += 1;
        }
        let digest = view.digest();
        let mut record = inputs::record(&self.samples);
        inputs::seal(&mut record, view.tick, digest);
        self.records.push(record);
        let Digest { tools, spheres, .. } = digest;
        let mixed = self.hash.rotate_left(7) ^ u64::from(tools);
        self.hash = mixed.rotate_left(9) ^ u64::from(spheres);
        if view.tick.is_multiple_of(FRAME_EVERY) {
            let lines = [Some(LineCounters::default()); 3];
            frames::fill_state(&mut self.state, view, self.scene_id, at_ns);
            frames::fill_tools(&mut self.tools, view, lines, self.scene_id, at_ns);
        }
    }

    fn stamp(&mut self, _stage: Stage) {}
}

/// Script of the emulated hand for a scene's room.
#[must_use]
pub fn script(room: &RoomRecord) -> HandScript {
    HandScript {
        instrument_port_m: Vec3::from(room.instrument_port_m),
        instrument_length_m: room.instrument_length_m,
        world_from_device: inputs::pose(&room.world_from_device),
        world_from_tracker: inputs::pose(&room.world_from_tracker),
        world_from_camera: inputs::pose(&room.world_from_camera),
        endoscope_port_m: Vec3::from(room.endoscope_port_m),
        target_m: Vec3::from(room.target_m),
        target_normal: Vec3::from(room.target_normal),
    }
}

/// Movement of the emulated hand that a display asks for. A number that is not finite counts as no
/// movement.
#[must_use]
pub fn wish(message: &HandMsg) -> Wish {
    let number = |part: f64| if part.is_finite() { part } else { 0.0 };
    let asked = words::Switches::named(message.switches);
    Wish {
        moved_m: message.moved_m.map(number),
        rolled_rad: number(message.rolled_rad),
        scope_turned_rad: message.scope_turned_rad.map(number),
        scope_advanced_m: number(message.scope_advanced_m),
        buttons: Buttons((message.buttons & 0xff) as u8),
        switches: Switches {
            cut: asked.contains(words::Switches::CUT),
            coagulate: asked.contains(words::Switches::COAGULATE),
            camera_lock: asked.contains(words::Switches::CAMERA_LOCK),
        },
    }
}
