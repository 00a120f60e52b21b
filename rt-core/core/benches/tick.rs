//! Cost of a tick on one core: the liver of the inner-sphere paper (581 spheres) under the
//! instrument, with Calot's solver and with the paper's method at 10 iterations. Also the cost of
//! the solvers alone, for the liver and for four organs with the paper's numbers of spheres.

#[path = "../tests/rig/mod.rs"]
mod rig;

use criterion::{Criterion, criterion_group, criterion_main};
use rig::{Anatomy, Bench, PAPER, TOUCH, method, paper};
use rt_core::math::Vec3;
use rt_core::port::Buttons;
use rt_core::sim::{Parameters, Sim};
use rt_core::state::State;
use rt_core::study::Tissue;
use rt_core::tissue::Bodies;

/// Place of the tip far above the liver, m.
const AWAY: Vec3 = Vec3::new(0.0, 0.0, 0.1);
/// Place of the tip 3 mm below the top of the liver's ellipsoid, m.
const PRESSED: Vec3 = Vec3::new(0.0, 0.0, 0.045);

/// Measures a tick with the tip at `tip_m`. `iterations` is the number for the paper's method;
/// `None` uses Calot's method.
fn bench_tick(
    c: &mut Criterion,
    name: &str,
    anatomy: &Anatomy,
    tip_m: &Vec3,
    iterations: Option<u32>,
) {
    let (mut state, mut paper) = (Box::new(State::new()), paper(iterations));
    let parameters = Parameters {
        force_ramp_s: 0.01,
        force_enabled: true,
    };
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, parameters);
    sim.solve_by(method(&mut paper));
    let mut bench = Bench::new();
    for step in 0..500 {
        let tip = AWAY + (tip_m - AWAY) * (step as f32 / 499.0);
        bench.next_at(&tip, Buttons::default());
        sim.tick(&mut bench);
    }
    c.bench_function(name, |b| {
        b.iter(|| {
            bench.next_at(tip_m, Buttons::default());
            sim.tick(&mut bench);
        });
    });
}

/// Measures the tissue of all organs, without instrument, contacts and devices. A sphere that is
/// led back and forth keeps the tissue moving.
fn bench_tissue(c: &mut Criterion, name: &str, anatomy: &Anatomy, iterations: Option<u32>) {
    let (mut bodies, mut paper) = (Box::new(Bodies::new()), paper(iterations));
    let mut tissue = Tissue::new(anatomy.scene(), &mut bodies, method(&mut paper));
    let mut tick = 0.0;
    tissue.hold(0, true);
    c.bench_function(name, |b| {
        b.iter(|| {
            tick += 1.0;
            tissue.lead(0, &Vec3::new(0.0, 0.0, 0.005 * (0.01f32 * tick).sin()));
            tissue.step()
        });
    });
}

fn tick(c: &mut Criterion) {
    let (liver, four) = (Anatomy::liver(), Anatomy::four_organs());
    bench_tick(c, "tick/liver/away", &liver, &AWAY, None);
    bench_tick(c, "tick/liver/pressed", &liver, &PRESSED, None);
    bench_tick(c, "tick/liver/pressed/paper", &liver, &PRESSED, Some(PAPER));
    bench_tissue(c, "tissue/liver", &liver, None);
    bench_tissue(c, "tissue/liver/paper", &liver, Some(PAPER));
    bench_tissue(c, "tissue/four organs", &four, None);
    bench_tissue(c, "tissue/four organs/paper", &four, Some(PAPER));
}

criterion_group!(benches, tick);
criterion_main!(benches);
