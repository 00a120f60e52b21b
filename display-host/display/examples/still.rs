//! Draws one picture of a compiled scene, whose tissue is pressed in at the target of the scripted
//! hand: `cargo run -p display-host --example still -- [SCENE] [--size WxH] [--dent M] [--jaw 0..1]
//! [--instrument 0..3] [--eye X,Y,Z] [--at X,Y,Z] [--live] [--out FILE]`. Without a scene the
//! example draws the round organs of the tests.

#[path = "../tests/support/mod.rs"]
mod support;

use std::path::PathBuf;
use std::time::Instant;

use display_host::render::gpu::Gpu;
use display_host::render::{Quality, Renderer};
use glam::{Quat, Vec3};
use shared_mem::message::{CapsuleMsg, PoseMsg};
use shared_mem::scene::SceneFile;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut scene = None;
    let (mut dent_m, mut jaw, mut instrument) = (0.010f32, 0.4f32, 0u32);
    let (mut out, mut size) = (PathBuf::from("still.png"), None);
    let (mut eye, mut at, mut live) = (None, None, false);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--dent" => dent_m = value()?.parse()?,
            "--live" => live = true,
            "--jaw" => jaw = value()?.parse()?,
            "--instrument" => instrument = value()?.parse()?,
            "--out" => out = value()?.into(),
            "--eye" => eye = Some(vector(&value()?)?),
            "--at" => at = Some(vector(&value()?)?),
            "--size" => {
                let text = value()?;
                let (w, h) = text.split_once('x').ok_or("--size is WxH")?;
                size = Some([w.parse()?, h.parse()?]);
            }
            _ => scene = Some(PathBuf::from(argument)),
        }
    }
    let scene = match scene {
        Some(path) => SceneFile::open(&path)?,
        None => support::scene(72),
    };
    let room = *scene.room();
    let target = Vec3::from(room.target_m);
    let normal = Vec3::from(room.target_normal).normalize_or(Vec3::Y);

    let mut state = support::state(&scene, 0.0);
    for (now, rest) in state.spheres.iter_mut().zip(scene.spheres()) {
        let from = Vec3::from(rest.center_m);
        let near = (-(from.distance(target) / 0.013).powi(2)).exp();
        now.center_m = (from - normal * dent_m * near).to_array();
    }
    let mut tools = support::tools(&scene, 0.0, jaw);
    tools.contact_count = u32::from(dent_m > 0.0);
    let tip = target - normal * dent_m * 0.62;
    let back = (Vec3::from(room.instrument_port_m) - tip).normalize();
    let joint = tip + back * 0.019;
    let turn = Quat::from_rotation_arc(Vec3::Z, back);
    tools.world_from_instrument = PoseMsg {
        position_m: joint.to_array(),
        orientation: turn.to_array(),
    };
    for (capsule, angle) in tools.capsules[1..3].iter_mut().zip([0.4 * jaw, -0.4 * jaw]) {
        let along = turn * Quat::from_rotation_x(angle) * Vec3::NEG_Z;
        capsule.a_m = joint.to_array();
        capsule.b_m = (joint + along * 0.020).to_array();
    }
    tools.capsules[0] = CapsuleMsg {
        a_m: (joint + back * 0.3).to_array(),
        b_m: joint.to_array(),
        radius_m: 0.0025,
        role: 0,
    };
    tools.instrument = instrument;
    if eye.is_some() || at.is_some() {
        let from = eye.unwrap_or(Vec3::from(room.world_from_camera.position_m));
        tools.world_from_camera = support::looking(from, at.unwrap_or(target));
    }

    let start = Instant::now();
    let gpu = Gpu::open()?;
    let mut quality = match live {
        true => Quality::live(&gpu),
        false => Quality::for_adapter(&gpu),
    };
    quality.size = size.unwrap_or(quality.size);
    let mut renderer = Renderer::new(&gpu, &scene, quality)?;
    println!("{}: ready after {:.2?}", gpu.describe(), start.elapsed());
    let spheres = state.spheres().ok_or("state is malformed")?;
    for _ in 0..4 {
        let start = Instant::now();
        renderer.render(&gpu, spheres, &tools, 0.0);
        gpu.wait("drawing")?;
        println!("frame in {:.2?}", start.elapsed());
    }
    renderer.read(&gpu)?.save(&out)?;
    println!("{}", out.display());
    Ok(())
}

fn vector(text: &str) -> Result<Vec3, Box<dyn std::error::Error>> {
    let numbers: Result<Vec<f32>, _> = text.split(',').map(str::parse).collect();
    let [x, y, z] = numbers?[..] else {
        return Err(format!("'{text}' is not X,Y,Z").into());
    };
    Ok(Vec3::new(x, y, z))
}
