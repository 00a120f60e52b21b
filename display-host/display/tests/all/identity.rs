//! The identity image that judges a view, against the picture that is drawn.

use display_host::render::gpu::Gpu;
use display_host::render::{Quality, Renderer, Shown};
use glam::Vec3;
use session::identity::Identity;
use shared_mem::message::{StateFrame, ToolFrame};
use shared_mem::scene::SceneFile;

use crate::support;

/// Pixels along each side of the drawn picture, as many as the identity image has.
const SIDE: u32 = 160;
/// Tolerance of distances, as a share of the distance. A surface that is nearer than the organ
/// drawn alone by at most this share counts as the organ's. The picture keeps distances in half
/// precision.
const SAME: f32 = 0.004;

/// Visible share of an organ's pixels, and the share of the round picture that shows the organ, as
/// drawn: the organ is drawn alone, and with everything else.
fn drawn(scene: &SceneFile, organ: usize, state: &StateFrame, tools: &ToolFrame) -> [f64; 2] {
    let gpu = Gpu::open().expect("a driver: apt-get install mesa-vulkan-drivers");
    let quality = Quality {
        size: [SIDE; 2],
        ..Quality::SOFTWARE
    };
    let mut renderer = Renderer::new(&gpu, scene, quality).expect("the test's own set-up");
    // The circle touches the picture's edges.
    renderer.scope_mut().circle = 1.0;
    let mut distances = |shown: Shown| {
        renderer.show(shown);
        let spheres = state.spheres().expect("the test's own set-up");
        renderer.render(&gpu, spheres, tools, 0.0);
        renderer.distances(&gpu).expect("the test's own set-up")
    };
    let (alone, all) = (distances(Shown::Organ(organ)), distances(Shown::Everything));
    let (mut covered, mut visible, mut inside) = (0.0, 0.0, 0.0);
    let half = 0.5 * SIDE as f32;
    for (pixel, (alone, all)) in alone.iter().zip(&all).enumerate() {
        let [x, y] = [pixel as u32 % SIDE, pixel as u32 / SIDE].map(|it| it as f32 + 0.5 - half);
        if x.hypot(y) > half {
            continue;
        }
        inside += 1.0;
        // Where nothing is drawn, the distance is zero or infinite.
        let is_there = (0.001..1.0).contains(alone);
        covered += f64::from(is_there);
        visible += f64::from(is_there && *all >= alone * (1.0 - SAME));
    }
    [visible / f64::max(covered, 1.0), visible / inside]
}

/// From several sides, in which each organ hides the other, an instrument hides both, or nothing
/// hides anything.
#[test]
fn an_identity_image_tells_what_the_picture_shows() {
    let scene = support::scene(64);
    let mut identity = Identity::of(&scene);
    let state = support::state(&scene, 0.0);
    let mut hidden = [1.0f64; 2];
    for (eye, at) in [
        ([0.0, 0.012, 0.125], [0.0, 0.0, 0.0]),
        ([0.02, -0.09, 0.06], [0.01, -0.01, 0.01]),
        ([0.02, 0.12, 0.02], [0.01, -0.01, 0.01]),
        ([-0.13, 0.03, 0.02], [0.0, 0.0, 0.0]),
    ] {
        let mut tools = support::tools(&scene, 0.0, 0.5);
        tools.world_from_camera = support::looking(Vec3::from(eye), Vec3::from(at));
        // The drawn instruments have handles and jaws of their own shape.
        tools.capsule_count = 0;
        tools.world_from_instrument.position_m = [0.0, 0.0, 9.0];
        let seen = identity
            .look([0.0; 2], &state, &tools)
            .expect("a sound state");
        for (organ, hidden) in hidden.iter_mut().enumerate() {
            let [clear, size] = drawn(&scene, organ, &state, &tools);
            let own = seen.organs[organ];
            println!(
                "{eye:?} organ {organ}: clear {clear:.3} and {:.3}, size {size:.3} and {:.3}",
                own.clear(),
                own.size()
            );
            // At the seam of two organs their distances differ by less than `SAME`, so a hidden
            // organ seems a little clearer in the picture.
            assert!((own.clear() - clear).abs() < 0.06, "{eye:?} {organ}");
            assert!((own.size() - size).abs() < 0.02, "{eye:?} {organ}");
            *hidden = hidden.min(clear);
        }
    }
    assert!(
        hidden.iter().all(|it| *it < 0.8),
        "each is hidden once: {hidden:?}"
    );
}
