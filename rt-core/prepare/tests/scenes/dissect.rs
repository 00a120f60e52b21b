//! The hook with current removes layered tissue: fat disappears cell by cell at the hook's tip, the
//! force on the hand has no step, and the same motion gives the same bits.

use crate::support::LoadedScene;
use std::path::Path;

use rt_core::math::{Vec3, norm};
use rt_core::port::{Buttons, DeviceCapabilities, DeviceSample, ForceCommand, PedalSample, Polled};
use rt_core::sim::{Command, Parameters, Ports, Samples, Sim, Stage, TickView};
use rt_core::state::State;
use rt_core::tissue::cells::REMOVED;
use rt_core::tool::{Instrument, Kinematics};
use rt_core::words::EventKind;
use scene_prepare::{Recipe, prepare};
use shared_mem::scene::SceneData;

const RECIPE: &str = r#"
name = "fat"

[[organ]]
name = "gallbladder"
kind = "gallbladder"
shape = { form = "gallbladder" }
spheres = 40
held = [{ base = 1.0 }]

[[organ]]
name = "bile duct"
kind = "bile-duct"
shape = { form = "bile-duct" }
spheres = 24
held = [{ base = 1.0 }]

[[organ]]
name = "fat"
kind = "fat"
material = { young_pa = 6000.0 }
held = [{ near = { organ = "bile duct", within_m = 0.003 } }]
shape = { form = "fat" }
spheres = 160
attached = [{ to = "bile duct", within_m = 0.0015 }]
layers = { around = "bile duct", count = 6, cell_m = 0.0014 }
"#;

struct Hand {
    samples: Samples,
    force_n: Vec3,
    step_n: f32,
    removed: Vec<u16>,
    cells: Vec<u8>,
    digest: u64,
}

impl Ports for Hand {
    fn sample(&mut self) -> Samples {
        self.samples
    }

    fn send_force(&mut self, command: ForceCommand) {
        self.step_n = norm(&(command.force_n - self.force_n));
        self.force_n = command.force_n;
    }

    fn publish(&mut self, view: &TickView<'_>) {
        let removed = view
            .events
            .iter()
            .filter(|it| it.kind == EventKind::Removed);
        self.removed.extend(removed.map(|it| it.value as u16));
        self.cells.clear();
        self.cells.extend_from_slice(view.cells());
        let digest = view.digest();
        let mixed = self.digest.rotate_left(7) ^ u64::from(digest.tools);
        self.digest = mixed.rotate_left(9) ^ u64::from(digest.spheres);
    }

    fn stamp(&mut self, _: Stage) {}
}

/// Results of a motion: the hand comes down on the fat, stays there with or without current, waits
/// without current, and leaves.
struct Found {
    removed: Vec<u16>,
    cells: Vec<u8>,
    digest: u64,
    largest_step_n: f32,
    /// Force on the hand at the fat before the current, N.
    before_n: f32,
    /// Force on the hand at the same place after the current, N.
    after_n: f32,
    /// State of the cells after a reset.
    reset: Vec<u8>,
}

/// A part of the hand's motion, with zero speed at its beginning and end.
#[derive(Clone, Copy)]
struct Leg {
    ticks: u16,
    /// Height of the tip above the target at the end of this part, m.
    height_m: f32,
    /// True while the pedal for cutting is pressed.
    cuts: bool,
}

/// Height of the tip above the target at which the hand begins, m.
const START_M: f32 = 0.012;

/// Centre of the cell nearest to the instrument's port, and the direction from the cell to the
/// port.
fn nearest_to_the_port(scene: &SceneData) -> (Vec3, Vec3) {
    let port = Vec3::from(scene.room.expect("a room").instrument_port_m);
    let places = scene.cells.iter().map(|cell| Vec3::from(cell.center_m));
    let off = |p: &Vec3| norm(&(p - port));
    let nearest = places.min_by(|a, b| off(a).total_cmp(&off(b)));
    let nearest = nearest.expect("cells");
    (nearest, (port - nearest).normalize())
}

fn dissect(scene: &SceneData, current: bool, depth_m: f32) -> Found {
    let room = scene.room.expect("a room");
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
    let (target, normal) = nearest_to_the_port(scene);
    let mut hand = Hand {
        samples: Samples {
            now_ns: 0,
            device: Polled::Nothing,
            tracker: Polled::Nothing,
            pedal: Polled::Nothing,
            command: Some(Command::Instrument(Instrument::Hook)),
        },
        force_n: Vec3::zeros(),
        step_n: 0.0,
        removed: Vec::new(),
        cells: Vec::new(),
        digest: 0,
    };
    let mut found = Found {
        removed: Vec::new(),
        cells: Vec::new(),
        digest: 0,
        largest_step_n: 0.0,
        before_n: 0.0,
        after_n: 0.0,
        reset: Vec::new(),
    };
    let come_down = Leg {
        ticks: 1500,
        height_m: -depth_m,
        cuts: false,
    };
    let stay = Leg {
        ticks: 2500,
        cuts: current,
        ..come_down
    };
    let stay_without_current = Leg {
        ticks: 500,
        ..come_down
    };
    let leave = Leg {
        ticks: 1000,
        height_m: START_M,
        cuts: false,
    };
    let mut from = START_M;
    let mut sequence = 0u16;
    for (number, leg) in [come_down, stay, stay_without_current, leave]
        .iter()
        .enumerate()
    {
        for tick in 1..=leg.ticks {
            let share = f32::from(tick) / f32::from(leg.ticks);
            let share = share * share * (3.0 - 2.0 * share);
            let tip_m = target + normal * (from + (leg.height_m - from) * share);
            sequence = sequence.wrapping_add(1);
            hand.samples.now_ns += 1_000_000;
            let at_ns = hand.samples.now_ns;
            hand.samples.device = Polled::Fresh(DeviceSample {
                opening: None,
                device_from_handle: lever.handle_from_tip(&tip_m, &Vec3::y()),
                velocity_m_s: None,
                buttons: Buttons(0),
                sequence,
                at_ns,
            });
            hand.samples.pedal = Polled::Fresh(PedalSample {
                cut: leg.cuts,
                at_ns,
                ..PedalSample::default()
            });
            sim.tick(&mut hand);
            hand.samples.command = None;
            found.largest_step_n = found.largest_step_n.max(hand.step_n);
        }
        match number {
            0 => found.before_n = norm(&hand.force_n),
            2 => found.after_n = norm(&hand.force_n),
            _ => {}
        }
        from = leg.height_m;
    }
    found.digest = hand.digest;
    found.removed = hand.removed.clone();
    found.cells = hand.cells.clone();
    hand.samples.command = Some(Command::Reset);
    sim.tick(&mut hand);
    found.reset = hand.cells.clone();
    found
}

#[test]
fn fat_goes_under_the_hook_and_only_there() {
    let recipe = Recipe::parse(RECIPE, "test", Path::new(".")).expect("a good recipe");
    let mut scene = prepare(&recipe, &mut |_| {})
        .expect("it can be built")
        .scene;
    // Fat lies behind the ducts, so the instrument comes from behind.
    if let Some(room) = &mut scene.room {
        room.instrument_port_m = [-0.03, 0.25, -0.24];
    }
    let (target, _) = nearest_to_the_port(&scene);
    let cold = dissect(&scene, false, 0.002);
    assert!(cold.removed.is_empty() && cold.cells.iter().all(|cell| *cell == 0));
    assert!(cold.before_n > 0.02, "fat pushes back: {} N", cold.before_n);
    let hot = dissect(&scene, true, 0.002);
    println!(
        "{} cells gone, {} warm; {} N, then {} N, {} N without current; steps {} and {} N",
        hot.removed.len(),
        hot.cells
            .iter()
            .filter(|cell| (1..REMOVED).contains(cell))
            .count(),
        hot.before_n,
        hot.after_n,
        cold.after_n,
        hot.largest_step_n,
        cold.largest_step_n,
    );
    assert!(hot.removed.len() >= 8, "{} cells", hot.removed.len());
    // Each removed cell was reported once, and is marked as removed.
    let gone = (0u16..)
        .zip(&hot.cells)
        .filter(|(_, cell)| **cell == REMOVED);
    let mut told = hot.removed.clone();
    told.sort_unstable();
    assert_eq!(told, gone.map(|(i, _)| i).collect::<Vec<u16>>());
    // All removed cells together took less energy than 15 W give in the 2.5 s of the current.
    let energy_j: f32 = told
        .iter()
        .map(|&i| scene.cells[usize::from(i)].energy_j)
        .sum();
    assert!(energy_j < 37.5, "{energy_j} J");
    for &cell in &told {
        let at = Vec3::from(scene.cells[usize::from(cell)].center_m);
        let off_m = norm(&(at - target));
        assert!(off_m < 0.012, "cell {cell} {off_m} m off the tip");
    }
    // Removed fat does not push back, and its removal causes no step of the force.
    assert!(
        hot.after_n < 0.7 * cold.after_n,
        "{} N, without current {} N",
        hot.after_n,
        cold.after_n
    );
    assert!(hot.largest_step_n < 0.005, "{} N", hot.largest_step_n);
    assert!(hot.reset.iter().all(|cell| *cell == 0));
    let again = dissect(&scene, true, 0.002);
    assert_eq!((again.digest, again.cells), (hot.digest, hot.cells));
}
