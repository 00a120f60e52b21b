//! Effects in the picture: blood runs down the skin and stays on it, smoke hides what is behind it.

use display_host::effects::fluid::VOXEL_M;
use display_host::effects::{Effect, Flow, Kind};
use display_host::render::gpu::Gpu;
use display_host::render::{Quality, Renderer};
use glam::Vec3;
use image::RgbaImage;

use crate::support;

/// Share of the picture that is redder than tissue: blood.
fn bloody(picture: &RgbaImage) -> f64 {
    let red =
        |p: &&image::Rgba<u8>| p.0[0] > 40 && u32::from(p.0[0]) > 3 * u32::from(p.0[1].max(1));
    picture.pixels().filter(red).count() as f64 / f64::from(picture.width() * picture.height())
}

fn mean(picture: &RgbaImage) -> f64 {
    let sum: f64 = picture.pixels().map(|p| f64::from(p.0[1])).sum();
    sum / f64::from(picture.width() * picture.height())
}

#[test]
fn blood_runs_down_and_sticks_and_smoke_hides() {
    let gpu = Gpu::open().expect("a driver: apt-get install mesa-vulkan-drivers");
    let scene = support::scene(40);
    let quality = Quality {
        size: [240, 180],
        ..Quality::SOFTWARE
    };
    let mut renderer = Renderer::new(&gpu, &scene, quality).expect("the scene can be drawn");
    renderer.exposure_mut().grain = 0.0;
    let state = support::state(&scene, 0.0);
    let spheres = state.spheres().expect("valid");
    let mut tools = support::tools(&scene, 0.0, 0.5);
    let eye = support::PRESSED_M + Vec3::new(0.0, 0.01, 0.07);
    tools.world_from_camera = support::looking(eye, support::PRESSED_M);
    // Move the instrument out of view.
    tools.world_from_instrument.position_m = [0.0, 0.0, 5.0];
    tools.capsule_count = 0;
    let take = |renderer: &mut Renderer| {
        renderer.render(&gpu, spheres, &tools, 0.0);
        renderer.read(&gpu).expect("a picture")
    };
    let clean = take(&mut renderer);
    let effect = |kind, lasts_s| Effect {
        kind,
        at_m: support::PRESSED_M,
        along: Vec3::Z,
        strength: 1.0,
        lasts_s,
        flow: Flow {
            ml_min: if kind == Kind::Blood { 20.0 } else { 0.0 },
            pulses: false,
        },
    };
    renderer.play(spheres, &[effect(Kind::Blood, 6.0)], 0.0);
    for _ in 0..200 {
        renderer.play(spheres, &[], 0.05);
    }
    let fluids = renderer.effects().fluids();
    let field = fluids.field().expect("blood on the skin");
    let [_, ys, _] = field.wet().expect("blood on the skin");
    let lowest = field.low_m().y + ys[0] as f32 * VOXEL_M;
    assert!(
        lowest < support::PRESSED_M.y - 0.005,
        "the blood ran down to {lowest} m"
    );
    let balance = fluids.balance();
    assert!(balance.lies_ml[0] > 0.3, "{balance:?}");
    let stained = take(&mut renderer);
    let (before, after) = (bloody(&clean), bloody(&stained));
    assert!(
        after > before + 0.005,
        "{before} of the picture, then {after}"
    );
    // The source is dry, but the stain stays until everything is cleared.
    assert!(renderer.effects_mut().particles().is_empty());
    renderer.effects_mut().clear();
    assert!((bloody(&take(&mut renderer)) - before).abs() < 0.002);

    renderer.play(spheres, &[effect(Kind::Smoke, 2.0)], 0.0);
    for _ in 0..40 {
        renderer.play(spheres, &[], 0.05);
    }
    renderer.exposure_mut().adapt = 0.0;
    let smoky = take(&mut renderer);
    let (before, after) = (mean(&clean), mean(&smoky));
    assert!(after > before * 1.1, "mean green {before}, then {after}");
}
