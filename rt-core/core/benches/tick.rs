//! Cost of a tick on one core: the paper's liver (581 spheres) under the instrument, as tissue and
//! with the paper's method at 10 iterations; and of the solvers alone, for the liver and for as
//! many spheres as the paper's four organs have.

#[path = "../tests/rig/mod.rs"]
mod rig;

use criterion::{Criterion, criterion_group, criterion_main};
use rig::{Anatomy, Bench, PAPER, TOUCH};
use rt_core::math::Vec3;
use rt_core::port::Buttons;
use rt_core::sim::{Parameters, Sim};
use rt_core::state::State;
use rt_core::study::Tissue;
use rt_core::tissue::{Bodies, Method};

/// Places of the tip, m: far above the liver, and 8 mm below its top.
const AWAY: Vec3 = Vec3::new(0.0, 0.0, 0.1);
const PRESSED: Vec3 = Vec3::new(0.0, 0.0, 0.045);

fn bench_tick(c: &mut Criterion, name: &str, anatomy: &Anatomy, tip_m: &Vec3, method: Method) {
    let mut state = Box::new(State::new());
    let parameters = Parameters {
        method,
        force_ramp_s: 0.01,
        force_enabled: true,
    };
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, parameters);
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

/// Every organ, kept awake by a led sphere, without instrument, contacts and devices.
fn bench_tissue(c: &mut Criterion, name: &str, anatomy: &Anatomy, method: Method) {
    let mut bodies = Box::new(Bodies::new());
    let mut tissue = Tissue::new(anatomy.scene(), &mut bodies, method);
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
    bench_tick(c, "tick/liver/away", &liver, &AWAY, Method::NeoHookean);
    bench_tick(
        c,
        "tick/liver/pressed",
        &liver,
        &PRESSED,
        Method::NeoHookean,
    );
    bench_tick(c, "tick/liver/pressed/paper", &liver, &PRESSED, PAPER);
    bench_tissue(c, "tissue/liver", &liver, Method::NeoHookean);
    bench_tissue(c, "tissue/liver/paper", &liver, PAPER);
    bench_tissue(c, "tissue/four organs", &four, Method::NeoHookean);
    bench_tissue(c, "tissue/four organs/paper", &four, PAPER);
}

criterion_group!(benches, tick);
criterion_main!(benches);
