//! Measures the cost of a frame, pass by pass, in every quality: `cargo run --release -p
//! display-host --example frame_cost -- [SCENE.calot] [--size WxH] [--frames N]`. Times are the
//! graphics device's own (timestamp queries); "whole" is from submission until the device is idle.
//! Without a scene it draws the tests' blobs.

#[path = "../tests/support/mod.rs"]
mod support;

use std::time::Instant;

use display_host::effects::{Effect, Kind};
use display_host::render::gpu::Gpu;
use display_host::render::timing::PASSES;
use display_host::render::{Quality, Renderer};
use glam::Vec3;
use shared_mem::scene::SceneFile;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let (mut scene, mut size, mut frames) = (None, [1920, 1080], 40usize);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--size" => {
                let text = value()?;
                let (w, h) = text.split_once('x').ok_or("--size is WxH")?;
                size = [w.parse()?, h.parse()?];
            }
            "--frames" => frames = value()?.parse()?,
            path => scene = Some(SceneFile::open(path.as_ref())?),
        }
    }
    let scene = scene.unwrap_or_else(|| support::scene(72));
    let gpu = Gpu::open()?;
    let tiers = if gpu.is_software() {
        vec![
            Quality::SOFTWARE,
            Quality::SOFTWARE_LIVE,
            Quality::SOFTWARE_TIERS[1],
        ]
    } else {
        Quality::GPU_TIERS.to_vec()
    };
    println!(
        "{}; {}, {} vertices, {} triangles; {}x{}, median of {frames} frames, ms",
        gpu.describe(),
        scene.name(),
        scene.vertices().len(),
        scene.triangles().len(),
        size[0],
        size[1]
    );
    print!("tier ");
    PASSES.iter().for_each(|name| print!("{name:>10}"));
    println!("{:>10}", "whole");
    let mut renderer = Renderer::new(&gpu, &scene, Quality { size, ..tiers[0] })?;
    let tools = support::tools(&scene, 0.0, 0.5);
    let state = support::state(&scene, 0.0);
    let spheres = state.spheres().ok_or("state is malformed")?;
    // Everything on: smoke before the target, blood on it.
    for kind in [Kind::Smoke, Kind::Blood] {
        let effect = Effect {
            kind,
            at_m: Vec3::from(scene.room().target_m),
            along: Vec3::from(scene.room().target_normal),
            strength: 1.0,
            lasts_s: 1e4,
        };
        renderer.play(spheres, &[effect], 0.0);
    }
    for (number, tier) in tiers.iter().enumerate() {
        renderer.set_quality(&gpu, *tier)?;
        let (mut passes, mut whole) = (vec![Vec::new(); PASSES.len()], Vec::new());
        for frame in 0..frames + 4 {
            renderer.play(spheres, &[], 0.02);
            let start = Instant::now();
            renderer.render(&gpu, spheres, &tools, frame as f32 * 0.02);
            gpu.wait("drawing")?;
            let ms = start.elapsed().as_secs_f32() * 1e3;
            // The first frames compile shaders.
            if frame >= 4 {
                whole.push(ms);
                if let Some(times) = renderer.take_pass_times() {
                    passes
                        .iter_mut()
                        .zip(times)
                        .for_each(|(all, t)| all.push(t));
                }
            }
        }
        print!("{number:4} ");
        for all in passes.iter_mut().chain([&mut whole]) {
            all.sort_by(f32::total_cmp);
            match all.get(all.len() / 2) {
                Some(ms) => print!("{ms:10.3}"),
                None => print!("{:>10}", "-"),
            }
        }
        println!();
    }
    Ok(())
}
