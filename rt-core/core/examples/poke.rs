//! Presses, grasps and pulls a synthetic liver with a scripted instrument, and prints the felt
//! force: `cargo run --release -p rt-core --example poke`.

#[path = "../tests/rig/mod.rs"]
mod rig;

use rig::{Anatomy, Bench, TOUCH};
use rt_core::fault::Fault;
use rt_core::math::{Vec3, norm};
use rt_core::port::Buttons;
use rt_core::sim::{Parameters, Sim};
use rt_core::state::State;

/// Height of the tip over the organ's top, m, and the buttons, at tick `t`.
fn hand(t: u32) -> (f32, Buttons) {
    let ramp = |from: u32, to: u32| ((t.clamp(from, to) - from) as f32) / (to - from) as f32;
    let height = 0.02 - 0.032 * ramp(500, 1500) + 0.032 * ramp(2500, 3500);
    // The closed jaws press; then they open on the tissue and grasp it.
    let grasps = t < 1750 || (2000..4500).contains(&t);
    (
        height,
        if grasps {
            Buttons::GRASP
        } else {
            Buttons::default()
        },
    )
}

fn main() {
    let anatomy = Anatomy::liver();
    let mut state = Box::new(State::new());
    let parameters = Parameters {
        force_ramp_s: 0.1,
        force_enabled: true,
    };
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, parameters);
    let mut bench = Bench::new();
    let top_m = anatomy
        .spheres
        .iter()
        .map(|s| s.center_m.z + s.radius_m)
        .fold(f32::MIN, f32::max);
    println!("   t ms  tip mm  force N      x      y      z  contacts  held  moved mm");
    for t in 0..5500 {
        let (height_m, buttons) = hand(t);
        bench.next_at(&Vec3::new(0.0, 0.0, top_m + height_m), buttons);
        sim.tick(&mut bench);
        if t % 250 == 249 {
            let moved = bench.centers_m.iter().zip(&anatomy.spheres);
            let moved_m = moved
                .map(|(c, s)| norm(&(c - s.center_m)))
                .fold(0.0, f32::max);
            let f = bench.force_n;
            println!(
                "{:7}  {:6.1}  {:7.3} {:6.3} {:6.3} {:6.3}  {:8}  {:4}  {:8.2}",
                t + 1,
                1000.0 * height_m,
                norm(&f),
                f.x,
                f.y,
                f.z,
                bench.contact_count,
                bench.grasped_count,
                1000.0 * moved_m,
            );
        }
    }
    for event in &bench.events {
        println!(
            "{:?} organ {:?} value {:.3}",
            event.kind, event.organ, event.value
        );
    }
    for fault in Fault::ALL {
        let ticks = sim.fault_counters().of(fault);
        if ticks > 0 {
            println!("{}: {ticks} ticks", fault.name());
        }
    }
    println!("state hash {:016x}", sim.state_hash());
}
