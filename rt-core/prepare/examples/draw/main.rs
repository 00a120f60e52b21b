//! Draws a prepared scene into a PNG: `cargo run -p scene-prepare --example draw -- OUT.png
//! RECIPE|MESH|built-in|triangle|variant [MESHES_DIR]`.
//!
//! There are four views: the endoscope's, from the front, from below, from the right. The first row
//! shows the skins, the second row the spheres and links. Held spheres are blue.

mod canvas;

use std::path::Path;

use canvas::{Canvas, View};
use scene_prepare::{Recipe, Vec3, prepare};
use shared_mem::scene::{OrganKind, OrganRecord, SceneData};

const SIZE: usize = 620;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [out, recipe, rest @ ..] = arguments.as_slice() else {
        return Err(
            "usage: draw OUT.png RECIPE|MESH|built-in|triangle|variant [MESHES_DIR]".into(),
        );
    };
    let recipe = match recipe.as_str() {
        "built-in" => Recipe::built_in()?,
        "triangle" => Recipe::triangle(false)?,
        "variant" => Recipe::triangle(true)?,
        file if file.ends_with(".toml") => {
            Recipe::load(Path::new(file), rest.first().map(Path::new))?
        }
        mesh => Recipe::from_mesh(Path::new(mesh), &Default::default())?,
    };
    let prepared = prepare(&recipe, &mut |p| {
        eprintln!("{:3.0} % {}", 100.0 * p.done, p.doing);
    })?;
    print!("{}", prepared.report);
    draw(&prepared.scene, Path::new(out))
}

fn draw(scene: &SceneData, out: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let room = scene.room.ok_or("no room")?;
    let positions = scene
        .vertices
        .iter()
        .map(|v| Vec3::from(v.position_m.map(f64::from)));
    let low = positions
        .clone()
        .reduce(|a, b| a.inf(&b))
        .ok_or("no skin")?;
    let high = positions.reduce(|a, b| a.sup(&b)).ok_or("no skin")?;
    let middle = (low + high) / 2.0;
    let half = (high - low).max() * 0.55;
    let views = [
        View::camera(&room.world_from_camera),
        View::along(middle, -Vec3::z(), Vec3::y(), half),
        View::along(middle, Vec3::y(), Vec3::z(), half),
        View::along(middle, Vec3::x(), Vec3::y(), half),
    ];
    let mut canvas = Canvas::new(SIZE, views.len(), 2);
    for (column, view) in views.iter().enumerate() {
        for organ in &scene.organs {
            let color = color_of(organ);
            let [first, count] = organ.triangles.map(|x| x as usize);
            for t in &scene.triangles[first..first + count] {
                let corners = t.map(|i| {
                    let v = &scene.vertices[i as usize];
                    (
                        Vec3::from(v.position_m.map(f64::from)),
                        Vec3::from(v.normal.map(f64::from)),
                    )
                });
                canvas.triangle(column, 0, view, corners, color);
            }
            let [first, count] = organ.spheres.map(|x| x as usize);
            for s in &scene.spheres[first..first + count] {
                let center = Vec3::from(s.center_m.map(f64::from));
                let color = if s.held == 1 { [90, 140, 255] } else { color };
                canvas.ball(column, 1, view, center, 0.45 * f64::from(s.radius_m), color);
            }
            let [first, count] = organ.links.map(|x| x as usize);
            for link in &scene.links[first..first + count] {
                let end = |i: u32| Vec3::from(scene.spheres[i as usize].center_m.map(f64::from));
                canvas.line(column, 1, view, end(link.a), end(link.b), [235, 235, 235]);
            }
        }
        let at = Vec3::from(room.target_m.map(f64::from));
        let tip = at + Vec3::from(room.target_normal.map(f64::from)) * 0.02;
        for row in 0..2 {
            canvas.line(column, row, view, at, tip, [60, 255, 60]);
            let port = Vec3::from(room.instrument_port_m.map(f64::from));
            canvas.line(column, row, view, port, at, [240, 240, 60]);
        }
    }
    canvas.save(out)
}

fn color_of(organ: &OrganRecord) -> [u8; 3] {
    match OrganKind::from_u32(organ.kind) {
        Some(OrganKind::Liver) => [150, 62, 52],
        Some(OrganKind::Gallbladder) => [138, 158, 96],
        Some(OrganKind::CysticDuct | OrganKind::BileDuct) => [176, 186, 110],
        Some(OrganKind::CysticArtery | OrganKind::Vessel) => [205, 50, 50],
        Some(OrganKind::Fat) => [226, 196, 110],
        _ => [205, 140, 130],
    }
}
