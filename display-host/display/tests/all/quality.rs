//! Quality changes at run time: every tier shows the same scene, and passes are timed.

use display_host::render::gpu::Gpu;
use display_host::render::timing::PASSES;
use display_host::render::{Quality, Renderer};

use crate::support;

#[test]
fn a_lost_device_says_what_it_was_doing() {
    let gpu = Gpu::open().expect("a driver: apt-get install mesa-vulkan-drivers");
    gpu.check("drawing").expect("it works");
    gpu.lose();
    let said = gpu.check("drawing").expect_err("it is lost").to_string();
    let words = "the display failed while drawing: the graphics device is lost";
    assert!(said.starts_with(words), "{said}");
    assert!(said.ends_with("start the display again"), "{said}");
}

#[test]
fn every_tier_shows_the_same_scene_in_the_same_size_and_is_timed() {
    let gpu = Gpu::open().expect("a driver: apt-get install mesa-vulkan-drivers");
    let scene = support::scene(32);
    let size = [200, 150];
    let small = |quality: Quality| Quality {
        size,
        shadow_side: quality.shadow_side.map(|side| side.min(512)),
        ..quality
    };
    let mut renderer =
        Renderer::new(&gpu, &scene, small(Quality::SOFTWARE)).expect("the scene can be drawn");
    renderer.exposure_mut().grain = 0.0;
    let state = support::state(&scene, 0.0);
    let spheres = state.spheres().expect("valid");
    let tools = support::tools(&scene, 0.0, 0.5);
    let mut best: Option<image::RgbaImage> = None;
    for tier in Quality::GPU_TIERS
        .into_iter()
        .chain(Quality::SOFTWARE_TIERS)
    {
        renderer
            .set_quality(&gpu, small(tier))
            .unwrap_or_else(|error| panic!("{tier:?}: {error}"));
        let mut times = None;
        for _ in 0..4 {
            renderer.render(&gpu, spheres, &tools, 0.0);
            gpu.wait("drawing").expect("it draws");
            times = renderer.take_pass_times().or(times);
        }
        assert_eq!(times.is_some(), gpu.has_clock());
        if let Some(times) = times {
            let scene = PASSES
                .iter()
                .position(|name| *name == "scene")
                .expect("a pass");
            assert!(times[scene] > 0.0, "{times:?}");
            assert!(
                times.iter().all(|t| (0.0..60_000.0).contains(t)),
                "{times:?}"
            );
        }
        let picture = renderer.read(&gpu).expect("a picture");
        assert_eq!(picture.dimensions(), (size[0], size[1]));
        let best = best.get_or_insert_with(|| picture.clone());
        let like = image_compare::rgba_hybrid_compare(best, &picture)
            .expect("pictures of one size")
            .score;
        // Light of half the size loses much of so small a picture.
        let least = if tier.part > 1 { 0.7 } else { 0.8 };
        assert!(like > least, "{tier:?} is like the best by {like}");
    }
}
