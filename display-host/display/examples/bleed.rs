//! Draws how an organ bleeds or leaks bile: pictures of a compiled scene at several times, with the
//! volumes and the processor's time: `cargo run -p display-host --example bleed -- [SCENE.calot]
//! [--organ NAME] [--every S] [--pictures N] [--stops S] [--near 0..1] [--place 0..1]
//! [--from X,Y,Z] [--size WxH] [--rinse S] [--suck S] [--heat 0..255] [--stones MM]
//! [--out FOLDER]`.
//! The leak is at a visible place of the organ, `--place` along it, and stops after `--stops` s.
//! The irrigator rinses from `--rinse` s on and sucks from `--suck` s on. `--heat` denatures the
//! tissue around the place to this share. `--stones` lays stones of this diameter around the place.

#[path = "../tests/support/mod.rs"]
mod support;

use std::path::PathBuf;

use display_host::effects::{Effect, Flow, Kind};
use display_host::gallery;
use display_host::render::gpu::Gpu;
use display_host::render::{Quality, Renderer};
use glam::Vec3;
use shared_mem::message::ToolFrame;
use shared_mem::scene::{OrganKind, OrganRecord, SceneFile, str_from_name};
use shared_mem::words::{CapsuleRole, Instrument, Switches};

type Error = Box<dyn std::error::Error>;

/// Time from one picture to the next, as at 30 pictures a second, s.
const FRAME_S: f32 = 1.0 / 30.0;
/// Distance from the place at which `--heat` has fallen to a third, m.
const HEATED_M: f32 = 0.012;

fn main() -> Result<(), Error> {
    let (mut scene, mut organ, mut out) = (None, "gallbladder".to_owned(), PathBuf::from("."));
    let (mut every_s, mut pictures, mut stops_s, mut near) = (2.0f32, 4u32, f32::INFINITY, 0.5f32);
    let (mut size, mut place, mut from) = ([640, 480], 0.5f32, None::<Vec3>);
    let (mut rinse_s, mut suck_s, mut heat) = (f32::INFINITY, f32::INFINITY, 0u8);
    let mut stone_mm = 0.0f32;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--organ" => organ = value()?,
            "--every" => every_s = value()?.parse()?,
            "--pictures" => pictures = value()?.parse()?,
            "--stops" => stops_s = value()?.parse()?,
            "--near" => near = value()?.parse()?,
            "--place" => place = value()?.parse()?,
            "--from" => {
                let numbers: Result<Vec<f32>, _> = value()?.split(',').map(str::parse).collect();
                from = Some(Vec3::from_slice(
                    numbers?.get(..3).ok_or("--from is X,Y,Z")?,
                ));
            }
            "--rinse" => rinse_s = value()?.parse()?,
            "--suck" => suck_s = value()?.parse()?,
            "--heat" => heat = value()?.parse()?,
            "--stones" => stone_mm = value()?.parse()?,
            "--out" => out = value()?.into(),
            "--size" => {
                let text = value()?;
                let (w, h) = text.split_once('x').ok_or("--size is WxH")?;
                size = [w.parse()?, h.parse()?];
            }
            path => scene = Some(SceneFile::open(path.as_ref())?),
        }
    }
    let scene = scene.unwrap_or_else(|| support::scene(72));
    let named = |it: &&OrganRecord| str_from_name(&it.name) == Some(organ.as_str());
    let record = scene.organs().iter().find(named).ok_or("no such organ")?;
    let kind = OrganKind::from_u32(record.kind).ok_or("an organ of no kind")?;
    let eye = Vec3::from(scene.room().world_from_camera.position_m);
    let (at_m, along) = visible(&scene, record, eye, place).ok_or("no visible place")?;
    let gpu = Gpu::open()?;
    let quality = Quality {
        size,
        ..Quality::for_adapter(&gpu)
    };
    let mut renderer = Renderer::new(&gpu, &scene, quality)?;
    renderer.exposure_mut().grain = 0.0;
    if stone_mm > 0.0 {
        let radius_m = 0.000_5 * stone_mm;
        renderer.set_stones(&gallery::lying(&scene, at_m, 12, radius_m));
    }
    let mut state = support::state(&scene, 0.0);
    for sphere in &mut state.spheres {
        let off = Vec3::from(sphere.center_m).distance(at_m) / HEATED_M;
        let denatured = f32::from(heat) * (-off * off).exp();
        *sphere = sphere.with_heat([0, denatured as u8, 0]);
    }
    let spheres = state.spheres().ok_or("state is malformed")?;
    let mut tools = support::tools(&scene, 0.0, 0.5);
    tools.world_from_instrument.position_m = [0.0, 0.0, 5.0];
    tools.capsule_count = 0;
    // The view of the endoscope at its start, moved towards the leak.
    let pose = scene.room().world_from_camera;
    let ahead = glam::Quat::from_array(pose.orientation) * Vec3::NEG_Z;
    let down = Vec3::from(scene.room().gravity_m_s2).normalize_or(Vec3::NEG_Y);
    let far_m = (at_m - eye).length() * (1.0 - near);
    let back = from.map_or(-ahead, Vec3::normalize);
    tools.world_from_camera = pose;
    if from.is_some() {
        let right = back.cross(down).normalize();
        let turn = glam::Mat3::from_cols(right, back.cross(right), back);
        tools.world_from_camera.orientation = glam::Quat::from_mat3(&turn).to_array();
    }
    tools.world_from_camera.position_m = (at_m + down * 0.008 + back * far_m).to_array();
    let leaks_bile = [
        OrganKind::Gallbladder,
        OrganKind::CysticDuct,
        OrganKind::BileDuct,
    ];
    let mut leak = Effect {
        kind: match leaks_bile.contains(&kind) {
            true => Kind::Bile,
            false => Kind::Blood,
        },
        at_m,
        along,
        strength: 1.0,
        lasts_s: Effect::LEAK_S,
        flow: Flow::of_organ(&assess::Rules::default(), kind),
    };
    let mut begin = vec![leak];
    let (mut now_s, mut is_open) = (0.0f32, true);
    for number in 0..pictures {
        let began_s = thread_s();
        let mut steps = 0u32;
        while now_s < every_s * (number + 1) as f32 {
            if is_open && now_s >= stops_s {
                leak.strength = 0.0;
                begin.push(leak);
                is_open = false;
            }
            if now_s >= rinse_s.min(suck_s) {
                let sucks = now_s >= suck_s;
                hold_irrigator(&mut tools, &scene, at_m, along, [now_s >= rinse_s, sucks]);
                begin.extend(Effect::of_irrigator(&tools, FRAME_S));
            }
            renderer.play(spheres, &begin, FRAME_S);
            begin.clear();
            now_s += FRAME_S;
            steps += 1;
        }
        let each_ms = (thread_s() - began_s) * 1e3 / f64::from(steps.max(1));
        // Only the first of the pictures uploads the films.
        let mut render_ms = [0.0f64; 4];
        for cost_ms in &mut render_ms {
            let began_s = thread_s();
            renderer.render(&gpu, spheres, &tools, 0.0);
            *cost_ms = (thread_s() - began_s) * 1e3;
            gpu.wait("drawing")?;
        }
        let fluids = renderer.effects().fluids();
        let volumes = fluids.balance();
        let upload_ms = render_ms[0] - render_ms[1..].iter().sum::<f64>() / 3.0;
        println!(
            "{now_s:.1} s: {:?} parcels and drops, {each_ms:.2} ms of the processor a picture, \
             {upload_ms:.2} ms for the upload of the films; {volumes:.3?}",
            fluids.counts()
        );
        renderer
            .read(&gpu)?
            .save(out.join(format!("{}-{number}.png", organ.replace(' ', "-"))))?;
    }
    Ok(())
}

/// Puts the irrigator to work at a place: near it to suck, and farther away to rinse alone.
fn hold_irrigator(
    tools: &mut ToolFrame,
    scene: &SceneFile,
    at_m: Vec3,
    along: Vec3,
    [rinses, sucks]: [bool; 2],
) {
    let tip_m = at_m + along.normalize_or(Vec3::Y) * if sucks { 0.003 } else { 0.012 };
    let back = (Vec3::from(scene.room().instrument_port_m) - tip_m).normalize_or(Vec3::Y);
    let joint_m = tip_m + back * 0.012;
    tools.instrument = Instrument::Irrigator.number();
    tools.world_from_instrument.position_m = joint_m.to_array();
    tools.world_from_instrument.orientation =
        glam::Quat::from_rotation_arc(Vec3::Z, back).to_array();
    tools.capsule_count = 1;
    let capsule = &mut tools.capsules[0];
    capsule.a_m = joint_m.to_array();
    capsule.b_m = (tip_m + back * 0.0025).to_array();
    (capsule.radius_m, capsule.role) = (0.0025, CapsuleRole::Tip.number());
    let switches = Switches::CUT.when(rinses) | Switches::COAGULATE.when(sucks);
    tools.switches = switches.bits();
}

/// Time that the processor gave to this thread, s.
fn thread_s() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// A place of an organ that faces the eye and that no other organ covers.
fn visible(scene: &SceneFile, organ: &OrganRecord, eye: Vec3, place: f32) -> Option<(Vec3, Vec3)> {
    let own = organ.spheres[0]..organ.spheres[0] + organ.spheres[1];
    let spheres = (0u32..).zip(scene.spheres());
    let others: Vec<_> = spheres
        .filter(|(i, _)| !own.contains(i))
        .map(|(_, it)| *it)
        .collect();
    let [first, count] = organ.vertices.map(|it| it as usize);
    let vertices = scene.vertices().get(first..first + count)?;
    let faces = vertices
        .iter()
        .map(|it| (Vec3::from(it.position_m), Vec3::from(it.normal)));
    let free = faces.filter(|(at, normal)| {
        let towards = (eye - *at).normalize();
        normal.dot(towards) > 0.5
            && others.iter().all(|it| {
                let to = Vec3::from(it.center_m) - *at;
                let along = to.dot(towards);
                let off2 = to.length_squared() - along * along;
                along < -it.radius_m || off2 > it.radius_m * it.radius_m
            })
    });
    let mut free: Vec<_> = free.collect();
    free.sort_by(|a, b| (a.0.x + 0.01 * a.0.y).total_cmp(&(b.0.x + 0.01 * b.0.y)));
    free.get(((free.len() as f32 - 1.0) * place) as usize)
        .copied()
}
