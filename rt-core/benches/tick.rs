//! What a tick costs on one core: the paper's liver (581 spheres, 3588 links) at 10 iterations,
//! untouched and under the instrument; with the gallbladder; and the solver alone.

#[path = "../tests/rig/mod.rs"]
mod rig;

use criterion::{Criterion, criterion_group, criterion_main};
use rig::{Anatomy, Bench, TOUCH};
use rt_core::math::Vec3;
use rt_core::port::Buttons;
use rt_core::sim::{Parameters, Sim};
use rt_core::state::State;

/// Tip of the instrument, m: far above the liver, and 8 mm in its top.
const AWAY: Vec3 = Vec3::new(0.0, 0.0, 0.1);
const PRESSED: Vec3 = Vec3::new(0.0, 0.0, 0.045);

fn bench_tick(c: &mut Criterion, name: &str, anatomy: &Anatomy, tip_m: &Vec3, iterations: u32) {
    let mut state = Box::new(State::new());
    let parameters = Parameters {
        iterations,
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

fn tick(c: &mut Criterion) {
    let (liver, both) = (Anatomy::liver(), Anatomy::liver_and_gallbladder());
    bench_tick(c, "liver/away", &liver, &AWAY, 10);
    bench_tick(c, "liver/pressed", &liver, &PRESSED, 10);
    bench_tick(c, "liver/pressed/1 iteration", &liver, &PRESSED, 1);
    bench_tick(c, "liver+gallbladder/pressed", &both, &PRESSED, 10);
}

criterion_group!(benches, tick);
criterion_main!(benches);
