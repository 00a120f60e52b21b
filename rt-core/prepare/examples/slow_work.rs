//! Smoothness of the force while a hand works slowly, in whole scenes: `cargo run --release -p
//! scene-prepare --example slow_work -- FILE.csv` (minutes). At four places of every organ of
//! Calot's triangle and of its variant, an instrument goes 4 mm into the tissue at 10 mm/s, rests
//! there, slides 5 mm to one side and 10 mm back, and leaves.

#[path = "../tests/support/mod.rs"]
mod support;

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use rt_core::tool::Instrument;
use scene_prepare::{Prepared, Recipe, prepare};
use support::hand::{Felt, Leg, OPEN, Site, work_at};

/// Parts of the hand's way with their names.
const LEGS: [(&str, Leg); 5] = [
    ("press", Leg(3600, [-4.0, 0.0], OPEN)),
    ("rest", Leg(500, [-4.0, 0.0], OPEN)),
    ("slide", Leg(750, [-4.0, 5.0], OPEN)),
    ("slide back", Leg(1500, [-4.0, -5.0], OPEN)),
    ("out", Leg(3600, [20.0, -5.0], OPEN)),
];

const INSTRUMENTS: [Instrument; 4] = [
    Instrument::Grasper,
    Instrument::Hook,
    Instrument::Scissors,
    Instrument::ClipApplier,
];

/// Places on each organ: four of its spheres, in eighths of their number.
const EIGHTHS: [u32; 4] = [1, 3, 5, 7];

/// Largest change of the force in a tick that counts as smooth, N.
const STEP_N: f32 = 0.005;

/// A hand that feels more than this in its first ticks began inside tissue, N.
const BEGAN_INSIDE_N: f32 = 0.003;

const STACK_BYTES: usize = 64 << 20;

/// One press with all its legs.
struct Work {
    scene: &'static str,
    organ: String,
    eighth: u32,
    instrument: Instrument,
    felt: Vec<Felt>,
}

impl Work {
    fn began_inside(&self) -> bool {
        self.felt[0].first_n > BEGAN_INSIDE_N
    }
}

/// Presses at every place of a scene, on as many threads as there are cores.
fn survey(scene: &'static str, built: &Prepared, with_all: bool) -> Vec<Work> {
    let mut asked = Vec::new();
    for (number, organ) in built.report.organs.iter().enumerate() {
        for (place, eighth) in EIGHTHS.into_iter().enumerate() {
            for (other, instrument) in INSTRUMENTS.into_iter().enumerate() {
                if with_all || other == (number + place) % INSTRUMENTS.len() {
                    asked.push((number, organ.name.clone(), eighth, instrument));
                }
            }
        }
    }
    let done = AtomicUsize::new(0);
    let work = |(number, organ, eighth, instrument): &(usize, String, u32, Instrument)| {
        let [first, count] = built.scene.organs[*number].spheres;
        let site = Site::facing_port(built, first + count * eighth / 8, *instrument);
        let felt = work_at(built, &site, &LEGS.map(|(_, leg)| leg));
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        eprint!("\r{scene}: {done} of {}  ", asked.len());
        Work {
            scene,
            organ: organ.clone(),
            eighth: *eighth,
            instrument: *instrument,
            felt,
        }
    };
    let all = asked.par_iter().map(work).collect();
    eprintln!();
    all
}

/// All presses as CSV, one row per leg.
fn csv(all: &[Work]) -> String {
    let mut text = "scene,organ,eighth,instrument,began_inside,leg,largest_step_mn_per_tick,\
                    largest_knock_mn_per_tick,largest_n,trips\n"
        .to_owned();
    for work in all {
        for ((leg, _), felt) in LEGS.iter().zip(&work.felt) {
            text += &format!(
                "{},{},{},{:?},{},{leg},{:.2},{:.2},{:.3},{}\n",
                work.scene,
                work.organ,
                work.eighth,
                work.instrument,
                work.began_inside(),
                felt.largest_step_n * 1.0e3,
                felt.largest_knock_n * 1.0e3,
                felt.largest_n,
                felt.trips,
            );
        }
    }
    text
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let Some(file) = arguments.next() else {
        eprintln!("usage: slow_work FILE.csv [all]; `all`: every instrument at every place");
        std::process::exit(2);
    };
    // Each thread builds a state on its stack.
    let threads = rayon::ThreadPoolBuilder::new().stack_size(STACK_BYTES);
    threads.build_global().expect("threads");
    let with_all = arguments.next().is_some();
    let mut all = Vec::new();
    for (scene, variant) in [("triangle", false), ("variant", true)] {
        let recipe = Recipe::triangle(variant).expect("a built-in recipe");
        let built = prepare(&recipe, &mut |_| {}).expect("it can be prepared");
        all.extend(survey(scene, &built, with_all));
    }
    std::fs::write(&file, csv(&all)).expect("written");
    let legs = || {
        let outside = all.iter().filter(|work| !work.began_inside());
        outside.flat_map(|work| LEGS.iter().zip(&work.felt).map(move |it| (work, it)))
    };
    let mut rough: Vec<_> = legs()
        .filter(|(_, (_, felt))| felt.largest_knock_n > STEP_N)
        .collect();
    rough.sort_by(|a, b| b.1.1.largest_knock_n.total_cmp(&a.1.1.largest_knock_n));
    let even = |(_, (_, felt)): &(&Work, (_, &Felt))| felt.largest_step_n > STEP_N;
    println!(
        "{} presses, of which {} began inside tissue and are not counted; of the others' {} legs {} have a knock \
         above {} mN a tick, and {} a step",
        all.len(),
        all.iter().filter(|work| work.began_inside()).count(),
        legs().count(),
        rough.len(),
        STEP_N * 1.0e3,
        legs().filter(even).count(),
    );
    for (work, ((leg, _), felt)) in rough {
        println!(
            "{:>8} {:<22} {}/8 {:<11} {leg:<10} knock {:6.1} mN, step {:6.1} mN, at most {:.2} N",
            work.scene,
            work.organ,
            work.eighth,
            format!("{:?}", work.instrument),
            felt.largest_knock_n * 1.0e3,
            felt.largest_step_n * 1.0e3,
            felt.largest_n,
        );
    }
}
