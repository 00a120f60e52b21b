//! Measures how smooth the force is while a hand works slowly in whole scenes: `cargo run --release
//! -p scene-prepare --example slow_work -- FILE.csv` (minutes). An instrument works at four places
//! of every organ of Calot's triangle and of its variant. It goes 4 mm into the tissue at up to
//! 10 mm/s, rests there, slides 5 mm to one side and 10 mm back, and leaves.

#[path = "../tests/support/mod.rs"]
mod support;

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use rt_core::tool::Instrument;
use scene_prepare::{Prepared, Recipe, prepare};
use support::hand::{Felt, Hand, Site, Work, mm, s};

/// The work at each place.
fn hand() -> Hand {
    Hand::new()
        .press(mm(4.0), s(3.6))
        .rest(s(0.5))
        .slide(mm(5.0), s(0.75))
        .slide(mm(-5.0), s(1.5))
        .named("slide back")
        .lift(mm(20.0), s(3.6))
        .named("out")
}

const INSTRUMENTS: [Instrument; 4] = [
    Instrument::Grasper,
    Instrument::Hook,
    Instrument::Scissors,
    Instrument::ClipApplier,
];

/// Places on each organ: the spheres at these eighths of the organ's list of spheres.
const EIGHTHS: [u32; 4] = [1, 3, 5, 7];

/// Largest change of the force in a tick that counts as smooth, N.
const STEP_N: f32 = 0.005;

/// If a hand feels more than this in its first ticks, the instrument began inside tissue, N.
const BEGAN_INSIDE_N: f32 = 0.003;

const STACK_BYTES: usize = 64 << 20;

/// The work at one place.
struct Press {
    scene: &'static str,
    organ: String,
    eighth: u32,
    instrument: Instrument,
    work: Work,
}

impl Press {
    fn began_inside(&self) -> bool {
        self.work.leg("press").first_n > BEGAN_INSIDE_N
    }
}

/// Presses at all places of a scene, on as many threads as there are cores.
fn survey(scene: &'static str, built: &Prepared, with_all: bool) -> Vec<Press> {
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
    let hand = hand();
    let done = AtomicUsize::new(0);
    let work = |(number, organ, eighth, instrument): &(usize, String, u32, Instrument)| {
        let [first, count] = built.scene.organs[*number].spheres;
        let site = Site::facing_port(built, first + count * eighth / 8, *instrument);
        let work = hand.work(built, &site);
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        eprint!("\r{scene}: {done} of {}  ", asked.len());
        Press {
            scene,
            organ: organ.clone(),
            eighth: *eighth,
            instrument: *instrument,
            work,
        }
    };
    let all = asked.par_iter().map(work).collect();
    eprintln!();
    all
}

/// One row for each leg (such as press, rest or slide) of each press.
fn csv(all: &[Press]) -> String {
    let mut text = "scene,organ,eighth,instrument,began_inside,leg,largest_step_mn_per_tick,\
                    largest_knock_mn_per_tick,largest_n,trips\n"
        .to_owned();
    for press in all {
        for felt in &press.work.legs {
            text += &format!(
                "{},{},{},{:?},{},{},{:.2},{:.2},{:.3},{}\n",
                press.scene,
                press.organ,
                press.eighth,
                press.instrument,
                press.began_inside(),
                felt.leg.name,
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
        let outside = all.iter().filter(|press| !press.began_inside());
        outside.flat_map(|press| press.work.legs.iter().map(move |felt| (press, felt)))
    };
    let mut rough: Vec<_> = legs()
        .filter(|(_, felt)| felt.largest_knock_n > STEP_N)
        .collect();
    rough.sort_by(|a, b| b.1.largest_knock_n.total_cmp(&a.1.largest_knock_n));
    let even = |(_, felt): &(&Press, &Felt)| felt.largest_step_n > STEP_N;
    println!(
        "{} presses, of which {} began inside tissue and are not counted; of the others' {} legs {} have a knock \
         above {} mN a tick, and {} a step",
        all.len(),
        all.iter().filter(|press| press.began_inside()).count(),
        legs().count(),
        rough.len(),
        STEP_N * 1.0e3,
        legs().filter(even).count(),
    );
    for (press, felt) in rough {
        println!(
            "{:>8} {:<22} {}/8 {:<11} {:<10} knock {:6.1} mN, step {:6.1} mN, at most {:.2} N",
            press.scene,
            press.organ,
            press.eighth,
            format!("{:?}", press.instrument),
            felt.leg.name,
            felt.largest_knock_n * 1.0e3,
            felt.largest_step_n * 1.0e3,
            felt.largest_n,
        );
    }
}
