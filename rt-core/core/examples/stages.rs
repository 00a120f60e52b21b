//! Cost of each stage of the tick on this machine, with the liver under the instrument and the
//! gallbladder next to it: `cargo run --release -p rt-core --example stages`. The smallest time is
//! the cost of the code; the median includes other load of the machine.

#[path = "../tests/rig/mod.rs"]
mod rig;

use std::time::Instant;

use rig::{Anatomy, Bench, PAPER, TOUCH, method, paper};
use rt_core::math::Vec3;
use rt_core::port::{Buttons, ForceCommand};
use rt_core::sim::{Parameters, Ports, Samples, Sim, Stage, TickView};
use rt_core::state::State;

/// Ticks of a measurement. The instrument sinks 20 mm into the liver meanwhile.
const TICKS: u32 = 4000;

/// Ports of a bench, with the time of each stage.
struct Timed {
    inner: Bench,
    /// End of the last stage.
    last: Instant,
    /// Times of each stage in all ticks.
    stage_us: [Vec<f64>; 7],
}

impl Ports for Timed {
    fn sample(&mut self) -> Samples {
        self.last = Instant::now();
        self.inner.samples
    }

    fn send_force(&mut self, _: ForceCommand) {}

    fn publish(&mut self, view: &TickView<'_>) {
        self.inner.publish(view);
    }

    fn stamp(&mut self, stage: Stage) {
        let now = Instant::now();
        self.stage_us[stage as usize].push((now - self.last).as_secs_f64() * 1.0e6);
        self.last = now;
    }
}

/// Measures the stages and prints them. With `iterations` the paper's method solves, with so many
/// iterations in a tick; with `None` Calot's method solves.
fn measure(name: &str, anatomy: &Anatomy, iterations: Option<u32>) {
    let (mut state, mut paper) = (Box::new(State::new()), paper(iterations));
    let parameters = Parameters {
        force_ramp_s: 0.01,
        force_enabled: true,
    };
    let mut sim = Sim::new(anatomy.scene(), &mut state, TOUCH, parameters);
    sim.solve_by(method(&mut paper));
    let stage_us = std::array::from_fn(|_| Vec::new());
    let mut timed = Timed {
        inner: Bench::new(),
        last: Instant::now(),
        stage_us,
    };
    for t in 0..TICKS {
        let depth_m = 0.02 * (f64::from(t) / f64::from(TICKS)) as f32;
        timed
            .inner
            .next_at(&Vec3::new(0.0, 0.0, 0.054 - depth_m), Buttons::default());
        sim.tick(&mut timed);
    }
    println!(
        "{name}, {}: {} spheres, {} links, {} tetrahedra",
        iterations.map_or("neo-Hookean", |_| "the paper's method"),
        anatomy.spheres.len(),
        anatomy.links.len(),
        anatomy.tetrahedra.len()
    );
    // Sums of the smallest times and of the medians.
    let mut sum = (0.0, 0.0);
    for (stage, times_us) in Stage::ALL.iter().zip(&mut timed.stage_us) {
        times_us.sort_by(f64::total_cmp);
        let (least, median) = (times_us[0], times_us[times_us.len() / 2]);
        println!(
            "  {:<10} min {least:7.1} µs  p50 {median:7.1} µs",
            format!("{stage:?}")
        );
        sum = (sum.0 + least, sum.1 + median);
    }
    println!("  {:<10} min {:7.1} µs  p50 {:7.1} µs", "sum", sum.0, sum.1);
}

fn main() {
    for iterations in [None, Some(PAPER)] {
        measure("liver", &Anatomy::liver(), iterations);
        let both = Anatomy::liver_and_gallbladder();
        measure("liver and gallbladder", &both, iterations);
    }
}
