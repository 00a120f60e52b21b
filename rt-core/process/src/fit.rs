//! Measures, before a scene runs, whether its worst tick fits this machine.
//!
//! The instrument jumps through a course of places: half of them have the most contact, half are
//! spread over the scene. So the organs are awake, and the contact lists are as full as the anatomy
//! makes them. The caches are emptied before every tick. The course is run several times from rest.
//! A simulation repeats itself bit for bit, so the time that a tick takes beyond its fastest run is
//! noise of the machine, not cost of the scene. Of each tick only the fastest run counts. The
//! slowest of these ticks must leave the margin free for devices, publishing and noise.

use core::time::Duration;
use std::sync::mpsc;

use bytemuck::Zeroable;
use nalgebra::UnitQuaternion;
use rt_core::math::{Pose, Vec3, norm};
use rt_core::port::{Buttons, DeviceSample, ForceCommand, PedalSample, Polled, TrackerSample};
use rt_core::scene::Scene;
use rt_core::sim::{Parameters, Ports, Samples, Stage, TickView};
use rt_core::tool::Kinematics;
use shared_mem::message::{STAGES, StateFrame, ToolFrame};

use crate::admission::{Admission, MARGIN};
use crate::config::{Realtime, RtConfig};
use crate::devices::FALLBACK_CAPABILITIES;
use crate::error::RtError;
use crate::frames;
use crate::realtime;
use crate::storage::Storage;
use crate::thread::{TICK_STACK_BYTES, join, spawn};
use crate::time_driver::monotonic_ns;

/// Number of runs of the course.
const RUNS: usize = 3;
/// Number of places that the instrument visits.
const PLACES: usize = 32;
/// Number of ticks at each place: the impact, and two after it.
const TICKS_EACH: usize = 3;
/// Bytes of memory that are changed before a tick to empty the caches: the size of a large
/// last-level cache.
const CACHE_BYTES: usize = 32 << 20;
/// Pause before each tick, in which the measuring realtime thread lets other threads run.
const PAUSE: Duration = Duration::from_micros(50);

/// Fastest measurement of one tick of the course.
#[derive(Debug, Clone, Copy)]
struct Cost {
    tick_ns: u64,
    stage_ns: [u64; STAGES],
}

/// Measures a scene in a thread that runs as the tick's thread will: same core, same priority.
pub(crate) fn measure(
    name: &str,
    scene: Scene<'static>,
    config: &RtConfig,
    core: usize,
) -> Result<Admission, RtError> {
    let asks = config.realtime == Realtime::Ask;
    let (priority, parameters) = (config.priority, config.parameters);
    let paper_iterations = config.paper_iterations;
    let (sender, receiver) = mpsc::sync_channel(1);
    let thread = spawn("admission", TICK_STACK_BYTES, move || {
        if asks {
            // Refusals are ignored here, because the tick's thread will report the same ones.
            let _ = realtime::pin_to(&[core]);
            let _ = realtime::take_fifo(priority);
        }
        let _ = sender.send(run_course(scene, parameters, paper_iterations));
    })?;
    let found = receiver.recv();
    join("admission", thread)?;
    let (mut costs, contacts_max) = found.unwrap_or_default();
    costs.sort_unstable_by_key(|cost| cost.tick_ns);
    let worst = costs.last().copied().unwrap_or(Cost {
        tick_ns: u64::MAX,
        stage_ns: [0; STAGES],
    });
    let budget_ns = (config.period_ns as f64 * (1.0 - MARGIN)) as u64;
    Ok(Admission {
        scene: name.to_owned(),
        spheres: scene.spheres().len(),
        worst_tick_ns: worst.tick_ns,
        worst_stage_ns: worst.stage_ns,
        median_tick_ns: costs.get(costs.len() / 2).map_or(0, |cost| cost.tick_ns),
        contacts_max,
        budget_ns,
        fits: worst.tick_ns <= budget_ns,
    })
}

/// Fastest measurement of every tick of the course, and the most contacts in a tick.
fn run_course(
    scene: Scene<'static>,
    parameters: Parameters,
    paper_iterations: u32,
) -> (Vec<Cost>, u32) {
    let handles = course(&scene);
    let mut costs: Vec<Cost> = Vec::new();
    let mut contacts_max = 0;
    let mut cache = vec![1u8; CACHE_BYTES];
    for run in 0..RUNS {
        let mut storage = Storage::new(paper_iterations);
        let mut sim = storage.sim(scene, FALLBACK_CAPABILITIES, parameters);
        let mut world = StandInPorts::new(&scene);
        for (tick, handle) in ticks(&handles).enumerate() {
            world.device_from_handle = *handle;
            world.now_ns += 1_000_000;
            empty_caches(&mut cache);
            std::thread::sleep(PAUSE);
            let start = monotonic_ns();
            world.last_stamp_ns = start;
            sim.tick(&mut world);
            let cost = Cost {
                tick_ns: monotonic_ns() - start,
                stage_ns: world.stage_ns,
            };
            contacts_max = contacts_max.max(world.contacts);
            match costs.get_mut(tick) {
                Some(fastest) if fastest.tick_ns <= cost.tick_ns => {}
                Some(fastest) => *fastest = cost,
                None if run == 0 => costs.push(cost),
                None => {}
            }
        }
    }
    (costs, contacts_max)
}

fn ticks(handles: &[Pose]) -> impl Iterator<Item = &Pose> {
    handles
        .iter()
        .flat_map(|handle| core::iter::repeat_n(handle, TICKS_EACH))
}

/// Handle poses, device frame: half of them where the shaft meets most spheres, half spread over
/// the scene.
fn course(scene: &Scene<'_>) -> Vec<Pose> {
    let room = scene.room();
    let spheres = scene.spheres();
    let kinematics = Kinematics {
        port_m: room.instrument_port_m,
        length_m: room.instrument_length_m,
    };
    let reach_m = 0.98 * room.instrument_length_m;
    let met = |tip_m: &Vec3| {
        let shaft = tip_m - room.instrument_port_m;
        let length_m = norm(&shaft).max(1e-6);
        let along = shaft / length_m;
        let meets = |center_m: &Vec3, radius_m: f32| {
            let from_port = center_m - room.instrument_port_m;
            let at_m = from_port.dot(&along).clamp(0.0, length_m);
            norm(&(from_port - along * at_m)) < radius_m + 0.005
        };
        let hits = spheres.iter().filter(|s| meets(&s.center_m, s.radius_m));
        hits.count()
    };
    let within = |tip_m: &&Vec3| norm(&(**tip_m - room.instrument_port_m)) < reach_m;
    // A subset of the spheres, because the search is quadratic.
    let step = spheres.len().div_ceil(1024).max(1);
    let candidates = spheres.iter().step_by(step).map(|s| &s.center_m);
    let mut tips: Vec<(usize, Vec3)> = candidates
        .filter(within)
        .map(|tip| (met(tip), *tip))
        .collect();
    let spread = tips.len().div_ceil(PLACES / 2).max(1);
    let mut places: Vec<Vec3> = tips.iter().step_by(spread).map(|(_, tip)| *tip).collect();
    tips.sort_by_key(|(hits, _)| core::cmp::Reverse(*hits));
    places.extend(tips.iter().take(PLACES / 2).map(|(_, tip)| *tip));
    let device_from_world = room.world_from_device.inverse();
    let up = Vec3::new(0.0, 1.0, 0.0);
    places
        .iter()
        .map(|tip| device_from_world * kinematics.handle_from_tip(tip, &up))
        .collect()
}

fn empty_caches(memory: &mut [u8]) {
    for byte in memory.iter_mut().step_by(64) {
        *byte = byte.wrapping_add(1);
    }
    core::hint::black_box(memory);
}

/// Stand-in for devices and display on the course: every device answers, and frames are filled and
/// discarded.
struct StandInPorts {
    now_ns: u64,
    device_from_handle: Pose,
    tracker_from_sensor: Pose,
    state: Box<StateFrame>,
    tools: Box<ToolFrame>,
    contacts: u32,
    last_stamp_ns: u64,
    stage_ns: [u64; STAGES],
}

impl StandInPorts {
    fn new(scene: &Scene<'_>) -> Self {
        let room = scene.room();
        Self {
            now_ns: 1_000_000_000,
            device_from_handle: Pose::from_parts(Vec3::zeros().into(), UnitQuaternion::identity()),
            tracker_from_sensor: room.world_from_tracker.inverse() * room.world_from_camera,
            state: Box::new(StateFrame::zeroed()),
            tools: Box::new(ToolFrame::zeroed()),
            contacts: 0,
            last_stamp_ns: 0,
            stage_ns: [0; STAGES],
        }
    }
}

impl Ports for StandInPorts {
    fn sample(&mut self) -> Samples {
        let at_ns = self.now_ns;
        Samples {
            now_ns: at_ns,
            device: Polled::Fresh(DeviceSample {
                opening: None,
                device_from_handle: self.device_from_handle,
                // Zero, so that jumps do not trip the speed limit.
                velocity_m_s: Some(Vec3::zeros()),
                buttons: Buttons::GRASP,
                sequence: 0,
                at_ns,
            }),
            tracker: Polled::Fresh(TrackerSample {
                tracker_from_sensor: self.tracker_from_sensor,
                at_ns,
            }),
            pedal: Polled::Fresh(PedalSample {
                at_ns,
                ..PedalSample::default()
            }),
            command: None,
        }
    }

    fn send_force(&mut self, command: ForceCommand) {
        core::hint::black_box(command);
    }

    fn publish(&mut self, view: &TickView<'_>) {
        self.contacts = view.tool.contact_count;
        core::hint::black_box(view.digest());
        frames::fill_state(&mut self.state, view, [0; 16], self.now_ns);
        frames::fill_tools(&mut self.tools, view, [None; 3], [0; 16], self.now_ns);
    }

    fn stamp(&mut self, stage: Stage) {
        let now = monotonic_ns();
        if let Some(place) = self.stage_ns.get_mut(stage as usize) {
            *place = now - self.last_stamp_ns;
        }
        self.last_stamp_ns = now;
    }
}
