//! Measures the time of each stage of the tick in a whole scene with both tools at work: `cargo run
//! --release -p scene-prepare --example scene_stages`. With `-- --by-spheres`, measures the time of
//! the stage contact by the number of spheres.
//!
//! The instrument's tip is pressed 6 mm into the scene's target and slides over it. The shaft lies
//! on the organs below the shaft. The endoscope is pressed 6 mm into the largest organ. The example
//! also prints the largest step of the force in a tick, and the time that contact takes in three
//! parts: the search (stage contact), the pressing (stage solve, less its time with both tools away
//! and every organ awake), and the force (stage force).

#[path = "../tests/support/mod.rs"]
mod support;

use std::time::Instant;

use rt_core::math::{Pose, Quat, Vec3, norm};
use rt_core::port::{
    Buttons, DeviceCapabilities, DeviceSample, ForceCommand, Polled, TrackerSample,
};
use rt_core::sim::{Command, Parameters, Ports, Samples, Sim, Stage, TickView};
use rt_core::state::State;
use rt_core::tool::Kinematics;
use rt_core::words::SphereBits;
use scene_prepare::{Recipe, prepare};
use shared_mem::scene::SceneData;
use support::LoadedScene;

const TICKS: u32 = 6000;
/// Ticks in which the tools go in. Their times do not count.
const APPROACH: u32 = 1500;

/// Depth of both tools in the tissue, m.
const PRESSED_M: f32 = 0.006;

/// True for each tool that presses on tissue. A tool that does not press stays away from all
/// organs.
#[derive(Clone, Copy)]
struct At {
    instrument: bool,
    endoscope: bool,
}

impl At {
    const WORK: Self = Self {
        instrument: true,
        endoscope: true,
    };
    const REST: Self = Self {
        instrument: false,
        endoscope: false,
    };
}

/// Ticks from one reset to the next while both tools are away. A reset wakes all organs, so none of
/// them rests for the 50 ticks after which it would sleep.
const AWAKE: u32 = 25;

/// Distance between the target and the tip of an instrument that is away, m.
const AWAY_M: f32 = 0.05;

/// The endoscope presses on a sphere whose centre is farther than this from the axis of the
/// instrument's shaft, m.
const BESIDE_M: f32 = 0.05;

struct Timed {
    samples: Samples,
    last: Instant,
    stage_us: [Vec<f64>; 7],
    force_n: Vec3,
    step_n: f32,
    contacts: u32,
    /// Number of spheres that tools touch, and number of spheres that are awake.
    touched: [usize; 2],
}

impl Ports for Timed {
    fn sample(&mut self) -> Samples {
        self.last = Instant::now();
        self.samples
    }

    fn send_force(&mut self, command: ForceCommand) {
        self.step_n = norm(&(command.force_n - self.force_n));
        self.force_n = command.force_n;
    }

    fn publish(&mut self, view: &TickView<'_>) {
        self.contacts = view.tool.contact_count;
        if view.tick.is_multiple_of(100) {
            let count = |bit| view.spheres().filter(|it| it.bits.contains(bit)).count();
            self.touched = [SphereBits::CONTACT, SphereBits::AWAKE].map(count);
        }
    }

    fn stamp(&mut self, stage: Stage) {
        let now = Instant::now();
        self.stage_us[stage as usize].push((now - self.last).as_secs_f64() * 1.0e6);
        self.last = now;
    }
}

/// Results of a run.
struct Seen {
    timed: Timed,
    largest_n: [f32; 2],
    mean_n: f32,
    contacts: u32,
    /// Means of [`Timed::touched`] over the ticks after the approach.
    touched: [f32; 2],
}

impl Seen {
    /// Times of a stage in the ticks after the approach, sorted, µs.
    fn of(&self, stage: Stage) -> Vec<f64> {
        let mut times_us = self.timed.stage_us[stage as usize][APPROACH as usize..].to_vec();
        times_us.sort_by(f64::total_cmp);
        times_us
    }
}

fn middle(times_us: &[f64]) -> f64 {
    times_us[times_us.len() / 2]
}

fn work(scene: &SceneData, at: At) -> Seen {
    let room = scene.room.expect("every scene has a room");
    let loaded = LoadedScene::new(scene);
    let mut state = Box::new(State::new());
    let parameters = Parameters {
        force_ramp_s: 0.01,
        force_enabled: true,
    };
    let mut sim = Sim::new(
        loaded.scene(),
        &mut state,
        DeviceCapabilities::TOUCH,
        parameters,
    );
    let lever = Kinematics {
        port_m: Vec3::from(room.instrument_port_m),
        length_m: room.instrument_length_m,
    };
    let (target, normal) = (Vec3::from(room.target_m), Vec3::from(room.target_normal));
    let along = normal.cross(&(lever.port_m - target)).normalize();
    // The endoscope goes straight into the largest organ, beside the instrument's shaft.
    let scope_port_m = Vec3::from(room.endoscope_port_m);
    let largest = scene.organs.iter().max_by_key(|it| it.spheres[1]);
    let [first, count] = largest.expect("every scene has organs").spheres;
    let own = scene.spheres.iter().skip(first as usize);
    let shaft = (target - lever.port_m).normalize();
    let is_beside = |at_m: Vec3| (at_m - target).cross(&shaft).norm() > BESIDE_M;
    let own = own.take(count as usize);
    let ways_m = own.filter(|it| is_beside(it.center_m.into())).map(|it| {
        let way_m = Vec3::from(it.center_m) - scope_port_m;
        (way_m, way_m.norm() - it.radius_m)
    });
    let (way_m, there_m) = ways_m
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .expect("some of it lies beside the shaft");
    let tracker_from_world = loaded.scene().room().world_from_tracker.inverse();
    let camera_rotation =
        Quat::rotation_between(&-Vec3::z(), &way_m).unwrap_or_else(Quat::identity);
    let mut timed = Timed {
        samples: Samples {
            now_ns: 0,
            device: Polled::Nothing,
            tracker: Polled::Nothing,
            pedal: Polled::Nothing,
            command: None,
        },
        last: Instant::now(),
        stage_us: std::array::from_fn(|_| Vec::new()),
        force_n: Vec3::zeros(),
        step_n: 0.0,
        contacts: 0,
        touched: [0; 2],
    };
    let (mut largest_n, mut mean_n, mut contacts) = ([0.0f32; 2], 0.0, 0);
    let mut touched = [0.0; 2];
    for t in 0..TICKS {
        let share = (f64::from(t) / f64::from(APPROACH)).min(1.0) as f32;
        let slide = f64::from(t.saturating_sub(APPROACH)) * 1e-3;
        let off_m = 0.008 * libm::sin(slide * 2.0) as f32;
        let tip_m = match at.instrument {
            true => target + normal * (0.026 * (1.0 - share) - PRESSED_M) + along * off_m,
            false => target + normal * AWAY_M,
        };
        timed.samples.now_ns += 1_000_000;
        let is_away = !at.instrument && !at.endoscope;
        timed.samples.command = (is_away && t % AWAKE == 0).then_some(Command::Reset);
        let up = Vec3::y();
        if at.endoscope {
            let front_m =
                scope_port_m + way_m.normalize() * (there_m + PRESSED_M - 0.026 * (1.0 - share));
            let camera = Pose::from_parts(front_m.into(), camera_rotation);
            timed.samples.tracker = Polled::Fresh(TrackerSample {
                tracker_from_sensor: tracker_from_world * camera,
                at_ns: timed.samples.now_ns,
            });
        }
        timed.samples.device = Polled::Fresh(DeviceSample {
            opening: None,
            device_from_handle: lever.handle_from_tip(&tip_m, &up),
            velocity_m_s: None,
            buttons: Buttons::default(),
            sequence: t as u16,
            at_ns: timed.samples.now_ns,
        });
        sim.tick(&mut timed);
        let phase = usize::from(t >= APPROACH);
        largest_n[phase] = largest_n[phase].max(timed.step_n);
        if phase == 1 {
            mean_n += timed.force_n.norm() / (TICKS - APPROACH) as f32;
            contacts = contacts.max(timed.contacts);
            for (mean, count) in touched.iter_mut().zip(timed.touched) {
                *mean += count as f32 / (TICKS - APPROACH) as f32;
            }
        }
    }
    Seen {
        timed,
        largest_n,
        mean_n,
        contacts,
        touched,
    }
}

/// Prints the time of the stage contact by the number of spheres. The organs of the built-in scene
/// keep their shares of the spheres. A scene holds at most 4096 spheres. For a larger number, one
/// scene runs several times with tools of its own, and the times are added.
fn by_spheres(recipe: &Recipe) {
    println!("spheres   contact: least µs   p50 µs   p99 µs   p50 ns/sphere");
    for (spheres, scenes) in [
        (250, 1),
        (500, 1),
        (1000, 1),
        (2000, 1),
        (4000, 1),
        (3400, 3),
    ] {
        let Ok(recipe) = recipe.clone().with_spheres(spheres) else {
            eprintln!("some organ would have too few or too many spheres with {spheres}");
            continue;
        };
        let built = match prepare(&recipe, &mut |_| {}) {
            Ok(built) => built,
            Err(error) => {
                eprintln!("with {spheres} spheres: {error}");
                continue;
            }
        };
        let mut sum_us = vec![0.0; (TICKS - APPROACH) as usize];
        for _ in 0..scenes {
            for (sum_us, us) in sum_us
                .iter_mut()
                .zip(work(&built.scene, At::WORK).of(Stage::Contact))
            {
                *sum_us += us;
            }
        }
        let spheres = built.scene.spheres.len() * scenes;
        let late_us = sum_us[sum_us.len() * 99 / 100];
        println!(
            "{spheres:7} {:19.1} {:8.1} {late_us:8.1} {:15.1}",
            sum_us[0],
            middle(&sum_us),
            1e3 * middle(&sum_us) / spheres as f64
        );
    }
}

fn main() {
    let has = |flag: &str| std::env::args().any(|argument| argument == flag);
    if has("--by-spheres") {
        by_spheres(&Recipe::built_in().expect("a built-in recipe"));
        return;
    }
    let recipe = Recipe::triangle(has("--full")).expect("a built-in recipe");
    let built = prepare(&recipe, &mut |_| {}).expect("a built-in recipe");
    let scene = &built.scene;
    let seen = work(scene, At::WORK);
    let without_scope = At {
        endoscope: false,
        ..At::WORK
    };
    let alone = work(scene, without_scope);
    let rest = work(scene, At::REST);
    let Seen {
        largest_n,
        mean_n,
        contacts,
        ..
    } = seen;
    println!(
        "{}: {} spheres, {} tetrahedra, {} vertices of contact skin, up to {contacts} contacts, mean force {mean_n:.3} N",
        recipe.name,
        scene.spheres.len(),
        scene.tetrahedra.len(),
        scene.contact_vertices.len(),
    );
    println!(
        "largest step of the force in a tick: {:.1} mN going in at 17 mm/s, {:.1} mN sliding at up to 16 mm/s",
        1e3 * largest_n[0],
        1e3 * largest_n[1]
    );
    println!(
        "spheres touched by both tools {:.1}, by the instrument alone {:.1}, by none {:.1}; awake {:.0}, and {:.0} with both away",
        seen.touched[0], alone.touched[0], rest.touched[0], seen.touched[1], rest.touched[1]
    );
    let mut sum = (0.0, 0.0);
    for stage in Stage::ALL {
        let times_us = seen.of(stage);
        let (least, median) = (times_us[0], middle(&times_us));
        println!(
            "  {:<10} min {least:7.1} µs  p50 {median:7.1} µs",
            format!("{stage:?}")
        );
        sum = (sum.0 + least, sum.1 + median);
    }
    println!("  {:<10} min {:7.1} µs  p50 {:7.1} µs", "sum", sum.0, sum.1);
    let of = |seen: &Seen, stage| middle(&seen.of(stage));
    let parts_us = [
        of(&seen, Stage::Contact),
        (of(&seen, Stage::Solve) - of(&rest, Stage::Solve)).max(0.0),
        of(&seen, Stage::Force),
    ];
    println!(
        "contact in all: {:.1} µs at p50: found {:.1}, pressed {:.1}, felt {:.1}",
        parts_us.iter().sum::<f64>(),
        parts_us[0],
        parts_us[1],
        parts_us[2]
    );
}
