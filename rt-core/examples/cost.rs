//! What tissue costs: time against the number of spheres, and what sleep saves.
//!
//! ```text
//! cargo run --release -p rt-core --example cost              figures
//! cargo run --release -p rt-core --example cost -- liver N   N ticks of the liver's tissue
//! ```
//!
//! The second, under `valgrind --tool=callgrind` with two numbers, counts a tick's instructions.
//! Times are the smallest of many: what the code costs, not what else the machine does.

#[path = "../tests/rig/mod.rs"]
mod rig;

use std::time::Instant;

use rig::{Anatomy, Bench, TOUCH};
use rt_core::math::Vec3;
use rt_core::port::Buttons;
use rt_core::sim::{Parameters, Sim};
use rt_core::soft_body::{Bodies, Method, Tissue};
use rt_core::state::State;

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

/// A liver of `count` spheres, so many times. A scene holds 4096 spheres: more than that are
/// several bodies in turn, whose memory is as large as that of one would be.
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
    let (spheres, tetrahedra) = (spheres * times, anatomy.tetrahedra * times);
    println!(
        "{spheres:7} {tetrahedra:7} {us:9.1} {:9.1} {:9.1}",
        1e3 * us / spheres as f64,
        1e3 * us / tetrahedra as f64
    );
}

/// The tick with the instrument 8 mm in the first organ's top, after the others fell asleep.
fn touched_us(anatomy: &Anatomy) -> f64 {
    let mut state = Box::new(State::new());
    let parameters = Parameters {
        method: Method::NeoHookean,
        force_ramp_s: 0.01,
        force_enabled: true,
    };
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, parameters);
    let mut bench = Bench::new();
    let mut press = |step: f32| {
        let depth_m = 0.001 * (0.05 * step).sin() - 0.055 * (step / 500.0).min(1.0);
        bench.next_at(&Vec3::new(0.0, 0.0, 0.1 + depth_m), Buttons::default());
        sim.tick(&mut bench);
    };
    (0..1000u16).for_each(|step| press(f32::from(step)));
    let mut step = 1000.0;
    smallest_us(|| {
        step += 1.0;
        press(step);
    })
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
        println!("{ticks} ticks of {} tetrahedra", anatomy.tetrahedra);
        return;
    }
    println!("spheres    tets   µs/tick ns/sphere    ns/tet");
    for spheres in [100, 250, 581, 1200, 2000, 4000] {
        count(spheres, 1);
    }
    for times in [2, 4, 8] {
        count(4000, times);
    }
    let (liver, four) = (Anatomy::liver(), Anatomy::four_organs());
    println!(
        "tissue of four organs (1891), all moving: {:.1} µs",
        all_moving_us(&four)
    );
    println!(
        "whole tick, liver alone, touched:          {:.1} µs",
        touched_us(&liver)
    );
    println!(
        "whole tick, four organs, liver touched:    {:.1} µs",
        touched_us(&four)
    );
}
