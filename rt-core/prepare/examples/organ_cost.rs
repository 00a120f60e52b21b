//! Measures the time of a tick's tissue in prepared scenes on this machine, and prints it with the
//! prediction of preparation (`scene_prepare::cost`): `cargo run --release -p scene-prepare
//! --example organ_cost`. Every organ is awake. Each tick is run many times and its fastest time
//! counts, so that the machine's other work does not.

#[path = "../tests/support/mod.rs"]
mod support;

use std::time::Instant;

use rt_core::study::Tissue;
use rt_core::tissue::{Bodies, Method};
use scene_prepare::cost::{self, Work};
use scene_prepare::{Prepared, Recipe, prepare};
use support::LoadedScene;

type Failure = Box<dyn std::error::Error>;

/// Ticks of a run. A run ends before any organ may sleep.
const TICKS: usize = 30;
const RUNS: usize = 40;

/// Median over the ticks of a run of each tick's fastest time, µs.
fn measure(prepared: &Prepared) -> f64 {
    let loaded = LoadedScene::new(&prepared.scene);
    let mut bodies = Box::new(Bodies::new());
    let mut tissue = Tissue::new(loaded.scene(), &mut bodies, Method::NeoHookean);
    let mut fastest_us = [f64::INFINITY; TICKS];
    for _ in 0..RUNS {
        tissue.rest();
        for fastest in &mut fastest_us {
            let begun = Instant::now();
            tissue.step();
            *fastest = fastest.min(begun.elapsed().as_secs_f64() * 1e6);
        }
    }
    fastest_us.sort_by(f64::total_cmp);
    fastest_us[TICKS / 2]
}

fn main() -> Result<(), Failure> {
    println!(
        "scene,spheres,tetrahedra,sphere_steps,tetra_steps,link_steps,tie_steps,measured_us,foretold_us"
    );
    let mut rows: Vec<(Work, f64)> = Vec::new();
    for (name, recipe) in [
        ("built-in", Recipe::built_in()?),
        ("triangle", Recipe::triangle(false)?),
    ] {
        for spheres in [400, 800, 1600, 3200, 6000] {
            let Ok(recipe) = recipe.clone().with_spheres(spheres) else {
                continue;
            };
            let prepared = match prepare(&recipe, &mut |_| {}) {
                Ok(prepared) => prepared,
                Err(error) => {
                    eprintln!("{name} with {spheres}: {error}");
                    continue;
                }
            };
            let work = cost::work(&prepared.scene);
            let measured_us = measure(&prepared);
            println!(
                "{name},{},{},{},{},{},{},{measured_us:.1},{:.1}",
                prepared.report.spheres,
                prepared.report.tetrahedra,
                work.sphere_steps,
                work.tetra_steps,
                work.link_steps,
                work.tie_steps,
                work.solve_us(),
            );
            rows.push((work, measured_us));
        }
    }
    let ratio = rows
        .iter()
        .map(|(work, measured)| work.solve_us() / measured);
    let (low, high) = ratio.fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), r| {
        (low.min(r), high.max(r))
    });
    println!("foretold over measured: {low:.2} to {high:.2}");
    Ok(())
}
