//! Cost of tissue: time as a function of the number of spheres, and the time that sleep saves.
//!
//! ```text
//! cargo run --release -p rt-core --example cost              figures
//! cargo run --release -p rt-core --example cost -- liver N   N ticks of the liver's tissue
//! ```
//!
//! To count the instructions of a tick, run the second form under `valgrind --tool=callgrind` with
//! two numbers of ticks. A time is the smallest of many, which excludes other load of the machine.

#[path = "../tests/rig/mod.rs"]
mod rig;

use std::time::Instant;

use rig::{Anatomy, Bench, TOUCH};
use rt_core::math::Vec3;
use rt_core::port::Buttons;
use rt_core::scene::Organ;
use rt_core::sim::{Parameters, Sim};
use rt_core::state::State;
use rt_core::study::Tissue;
use rt_core::tissue::{Bodies, Method};

const ROUNDS: usize = 300;

/// Smallest time of a call, µs.
fn smallest_us(mut call: impl FnMut()) -> f64 {
    let time = |_| {
        let start = Instant::now();
        call();
        start.elapsed().as_secs_f64() * 1e6
    };
    (0..ROUNDS).map(time).fold(f64::INFINITY, f64::min)
}

fn swing(tissue: &mut Tissue<'_>, tick: f32) {
    tissue.lead(0, &Vec3::new(0.0, 0.0, 0.005 * (0.01 * tick).sin()));
    tissue.step();
}

/// Measures `times` livers of `spheres` spheres. A scene holds 4096 spheres at most, so a larger
/// number is split into several bodies, solved in turn. Together they need as much memory as one
/// body would.
fn count(spheres: usize, times: usize) {
    let anatomy =
        Anatomy::default().with_ellipsoid(Vec3::zeros(), Vec3::new(0.1, 0.06, 0.048), spheres, 0);
    let mut bodies: Vec<Box<Bodies>> = (0..times).map(|_| Box::new(Bodies::new())).collect();
    let mut tissues: Vec<Tissue<'_>> = bodies
        .iter_mut()
        .map(|bodies| Tissue::new(anatomy.scene(), bodies, Method::NeoHookean))
        .collect();
    tissues.iter_mut().for_each(|tissue| tissue.hold(0, true));
    let mut tick = 0.0;
    let us = smallest_us(|| {
        tick += 1.0;
        tissues.iter_mut().for_each(|tissue| swing(tissue, tick));
    });
    let (spheres, tetrahedra) = (spheres * times, anatomy.tetrahedra.len() * times);
    println!(
        "{spheres:7} {tetrahedra:7} {us:9.1} {:9.1} {:9.1}",
        1e3 * us / spheres as f64,
        1e3 * us / tetrahedra as f64
    );
}

/// A run with the tip of the instrument about 3 mm below the top of the first organ's ellipsoid.
struct Touched {
    tick_us: f64,
    /// Sphere centres and force after 4000 ticks.
    centers_m: Vec<Vec3>,
    force_n: Vec3,
}

impl Touched {
    fn new(anatomy: &Anatomy) -> Self {
        let mut state = Box::new(State::new());
        let parameters = Parameters {
            force_ramp_s: 0.01,
            force_enabled: true,
        };
        let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, parameters);
        let mut bench = Bench::new();
        let press = |sim: &mut Sim<'_>, bench: &mut Bench, step: f32| {
            let depth_m = 0.001 * (0.05 * step).sin() - 0.055 * (step / 500.0).min(1.0);
            bench.next_at(&Vec3::new(0.0, 0.0, 0.1 + depth_m), Buttons::default());
            sim.tick(bench);
        };
        (0..4000u16).for_each(|step| press(&mut sim, &mut bench, f32::from(step)));
        let (centers_m, force_n) = (bench.centers_m.clone(), bench.force_n);
        let mut step = 4000.0;
        let tick_us = smallest_us(|| {
            step += 1.0;
            press(&mut sim, &mut bench, step);
        });
        Self {
            tick_us,
            centers_m,
            force_n,
        }
    }

    /// A run without sleep: organs that breathe, if only by a picometre, stay awake.
    fn sleepless(anatomy: &Anatomy) -> Self {
        let mut anatomy = anatomy.clone();
        anatomy.breath_s = 4.0;
        for organ in &mut anatomy.organs {
            organ.breath_m = Vec3::new(0.0, 0.0, 1.0e-12);
        }
        Self::new(&anatomy)
    }

    /// Prints this run, compared with the run `all`, in which no organ sleeps.
    fn tell(&self, what: &str, all: &Self) {
        let apart = self.centers_m.iter().zip(&all.centers_m);
        let most_m = apart.map(|(a, b)| (a - b).norm()).fold(0.0, f32::max);
        println!(
            "{what:35} {:9.1} {:14.4} {:12.2}",
            self.tick_us,
            1e3 * most_m,
            1e3 * (self.force_n - all.force_n).norm()
        );
    }
}

fn all_moving_us(anatomy: &Anatomy) -> f64 {
    let mut bodies = Box::new(Bodies::new());
    let mut tissue = Tissue::new(anatomy.scene(), &mut bodies, Method::NeoHookean);
    tissue.hold(0, true);
    let mut tick = 0.0;
    smallest_us(|| {
        tick += 1.0;
        swing(&mut tissue, tick);
    })
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    if arguments.next().as_deref() == Some("liver") {
        let ticks = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(1);
        let anatomy = Anatomy::liver();
        let mut bodies = Box::new(Bodies::new());
        let mut tissue = Tissue::new(anatomy.scene(), &mut bodies, Method::NeoHookean);
        (0..ticks).for_each(|_| _ = tissue.step());
        println!("{ticks} ticks of {} tetrahedra", anatomy.tetrahedra.len());
        return;
    }
    println!("spheres    tets   µs/tick ns/sphere    ns/tet");
    for spheres in [100, 250, 581, 1200, 2000, 4000] {
        count(spheres, 1);
    }
    for times in [2, 4, 8] {
        count(4000, times);
    }
    let (liver, mut four) = (Anatomy::liver(), Anatomy::four_organs());
    println!(
        "tissue of four organs (1891), all moving: {:.1} µs",
        all_moving_us(&four)
    );
    println!("\nwhole tick, liver touched             µs/tick   spheres off mm  force off mN");
    // The other organs sink under their weight before they sleep. Sleep stops them before they have
    // sunk fully, and the missing part is the error of sleep.
    let sinks = |organ: &mut Organ| organ.gravity_share = 0.3;
    four.organs.iter_mut().skip(1).for_each(sinks);
    let sleepless = Touched::sleepless(&four);
    sleepless.tell("four organs, all awake", &sleepless);
    Touched::new(&four).tell("four organs, three asleep", &sleepless);
    let liver = Touched::new(&liver);
    liver.tell("liver alone", &liver);
    let coarse = |spheres| {
        let half_axes_m = Vec3::new(0.1, 0.06, 0.048);
        let coarse = Anatomy::default().with_ellipsoid(Vec3::zeros(), half_axes_m, spheres, 0);
        println!(
            "{:35} {:9.1}   (accuracy: evaluate)",
            format!("liver alone of {spheres} spheres"),
            Touched::new(&coarse).tick_us
        );
    };
    [100, 250, 1200].into_iter().for_each(coarse);
}
