//! View of the model inside the organs, judged by its colours.

use display_host::render::gpu::Gpu;
use display_host::render::inside::{Inside, picture};
use display_host::render::{Quality, Renderer};
use image::RgbaImage;

use crate::support;

/// Share of the picture's pixels that are `like`.
fn share(picture: &RgbaImage, like: fn([u8; 4]) -> bool) -> f64 {
    let found = picture.pixels().filter(|p| like(p.0)).count();
    found as f64 / f64::from(picture.width() * picture.height())
}

fn is_blue([r, _, b, _]: [u8; 4]) -> bool {
    u32::from(b) > u32::from(r) + 20
}

fn is_green([r, g, b, _]: [u8; 4]) -> bool {
    g.saturating_sub(25) > r.max(b)
}

#[test]
fn a_prepared_scene_has_a_picture_of_spheres_and_of_springs() {
    let scene = support::scene(40);
    let picture =
        picture(&scene, [480, 200]).expect("a driver: apt-get install mesa-vulkan-drivers");
    assert_eq!(picture.dimensions(), (480, 200));
    let side = |x: u32| image::imageops::crop_imm(&picture, x, 0, 240, 200).to_image();
    let (spheres, springs) = (side(0), side(240));
    // Free spheres are blue, seen through red skin; springs are green.
    assert!(
        share(&spheres, is_blue) > 0.05,
        "{}",
        share(&spheres, is_blue)
    );
    assert!(
        share(&spheres, is_green) < 0.002,
        "{}",
        share(&spheres, is_green)
    );
    assert!(
        share(&springs, is_green) > 0.02,
        "{}",
        share(&springs, is_green)
    );
    assert!(share(&springs, is_blue) < share(&spheres, is_blue));
    // The whole model is in the picture, so the picture's edge is empty.
    let edge = |picture: &RgbaImage| {
        let (w, h) = picture.dimensions();
        let mut pixels = picture.enumerate_pixels();
        pixels.all(|(x, y, p)| {
            let inner = x > 0 && y > 0 && x + 1 < w && y + 1 < h;
            inner || p.0[..3].iter().all(|&c| c < 12)
        })
    };
    assert!(edge(&spheres) && edge(&springs));
}

#[test]
fn the_view_through_the_endoscope_shows_what_is_touched_and_goes_again() {
    let gpu = Gpu::open().expect("a driver: apt-get install mesa-vulkan-drivers");
    let scene = support::scene(40);
    let quality = Quality {
        size: [320, 180],
        ..Quality::SOFTWARE
    };
    let mut renderer = Renderer::new(&gpu, &scene, quality).expect("the scene can be drawn");
    renderer.exposure_mut().grain = 0.0;
    let mut state = support::state(&scene, 0.0);
    let tools = support::tools(&scene, 0.0, 0.5);
    for sphere in state.spheres.iter_mut().take(200) {
        sphere.bits |= shared_mem::message::SphereState::CONTACT;
    }
    let mut take = |inside| {
        renderer.set_inside(&gpu, inside);
        renderer.render(&gpu, state.spheres().expect("valid"), &tools, 0.0);
        renderer.read(&gpu).expect("a picture")
    };
    let outside = take(None);
    let inside = take(Some(Inside::VIEW));
    assert!(share(&outside, is_blue) < 0.001);
    assert!(
        share(&inside, is_blue) > 0.005,
        "{}",
        share(&inside, is_blue)
    );
    assert!(take(None) == outside, "the inside is left");
    gpu.check("drawing").expect("no fault");
}
