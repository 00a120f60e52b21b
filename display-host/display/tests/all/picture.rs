//! Pictures of the tests' scene against committed ones. A software driver draws the same on every
//! machine, up to rounding; a graphics card filters a little differently.
//! `UPDATE_PICTURES=1 cargo test -p display-host --test all picture` writes them anew; look at them
//! before you commit them.

use std::path::PathBuf;

use display_host::render::gpu::Gpu;
use display_host::render::{Quality, Renderer};
use glam::Vec3;
use image::RgbaImage;
use shared_mem::message::ToolFrame;

use crate::support;

/// Least similarity of equal pictures (1: identical).
const SAME: f64 = 0.995;
/// Depth of the dent in the pictures, m.
const DENT_M: f32 = 0.012;

struct Studio {
    gpu: Gpu,
    renderer: Renderer,
    scene: shared_mem::scene::SceneFile,
}

impl Studio {
    fn new(quality: Quality) -> Self {
        let gpu = Gpu::open().expect("a driver: apt-get install mesa-vulkan-drivers");
        let scene = support::scene(64);
        let mut renderer = Renderer::new(&gpu, &scene, quality).expect("the test's own set-up");
        renderer.exposure_mut().grain = 0.0;
        Self {
            gpu,
            renderer,
            scene,
        }
    }

    fn small() -> Self {
        Self::new(Quality {
            size: [320, 180],
            ..Quality::SOFTWARE
        })
    }

    fn take(&mut self, dent_m: f32, tools: &ToolFrame) -> RgbaImage {
        let state = support::state(&self.scene, dent_m);
        self.renderer.render(
            &self.gpu,
            state.spheres().expect("the test's own set-up"),
            tools,
            0.0,
        );
        self.renderer
            .read(&self.gpu)
            .expect("the test's own set-up")
    }
}

fn close_up(scene: &shared_mem::scene::SceneFile, dent_m: f32, instrument: u32) -> ToolFrame {
    let mut tools = support::tools(scene, dent_m, 0.5);
    let eye = support::PRESSED_M + Vec3::new(-0.035, 0.035, 0.060);
    tools.world_from_camera = support::looking(eye, support::PRESSED_M);
    tools.instrument = instrument;
    tools
}

fn likeness(a: &RgbaImage, b: &RgbaImage) -> f64 {
    image_compare::rgba_hybrid_compare(a, b)
        .expect("pictures of one size")
        .score
}

fn compare(name: &str, picture: &RgbaImage) {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("tests/pictures")
        .join(format!("{name}.png"));
    if std::env::var_os("UPDATE_PICTURES").is_some() {
        picture.save(&path).expect("the test's own set-up");
    }
    let wanted = image::open(&path)
        .unwrap_or_else(|error| panic!("{}: {error}", path.display()))
        .to_rgba8();
    let score = likeness(picture, &wanted);
    if score < SAME {
        let made = std::env::temp_dir().join(format!("calot-{name}-made.png"));
        picture.save(&made).expect("the test's own set-up");
        panic!(
            "{name} is like its reference by {score:.4}; see {}",
            made.display()
        );
    }
}

#[test]
fn the_scene_looks_as_it_did_and_a_dent_shows() {
    let mut studio = Studio::small();
    let tools = close_up(&studio.scene, DENT_M, 0);
    let dented = studio.take(DENT_M, &tools);
    compare("dent", &dented);
    let again = studio.take(DENT_M, &tools);
    assert!(likeness(&dented, &again) >= SAME);
    // Only the tissue differs, not the tool. The picture must show this difference.
    let flat = studio.take(0.0, &tools);
    let score = likeness(&dented, &flat);
    assert!(
        score < SAME - 0.003,
        "without the dent it is like it by {score:.4}"
    );
}

/// Inner spheres are too coarse to show the dent of a tip. The contact law knows it.
#[test]
fn a_press_is_seen_at_first_glance_even_if_no_sphere_moves() {
    let mut studio = Studio::small();
    let mut tools = close_up(&studio.scene, DENT_M, 0);
    tools.dents[0].depth_m = DENT_M;
    let pressed = studio.take(0.0, &tools);
    let again = studio.take(0.0, &tools);
    // The same tool at the same place, without contact.
    (tools.contact_count, tools.dent_count) = (0, 0);
    let free = studio.take(0.0, &tools);
    let changed = changed_share(&free, &pressed);
    let noise = changed_share(&pressed, &again);
    assert!(noise < 0.001, "{noise} of the picture changes by itself");
    assert!(changed > 0.01, "{changed} of the picture shows the press");
}

/// Share of the picture whose brightness differs by at least a tenth of white.
fn changed_share(a: &RgbaImage, b: &RgbaImage) -> f64 {
    let bright = |p: &image::Rgba<u8>| p.0[..3].iter().map(|&c| i32::from(c)).sum::<i32>();
    let pairs = a.pixels().zip(b.pixels());
    let changed = pairs.filter(|(a, b)| bright(a).abs_diff(bright(b)) > 76);
    changed.count() as f64 / f64::from(a.width() * a.height())
}

#[test]
fn the_whole_view_looks_as_it_did() {
    let mut studio = Studio::small();
    let tools = support::tools(&studio.scene, DENT_M, 0.5);
    compare("view", &studio.take(DENT_M, &tools));
}

#[test]
fn instruments_look_different() {
    let mut studio = Studio::small();
    let pictures: Vec<RgbaImage> = (0..4)
        .map(|instrument| {
            let tools = close_up(&studio.scene, DENT_M, instrument);
            studio.take(DENT_M, &tools)
        })
        .collect();
    for (i, a) in pictures.iter().enumerate() {
        for b in &pictures[..i] {
            assert!(likeness(a, b) < SAME);
        }
    }
    // An unknown instrument number draws some instrument and does not panic.
    let tools = close_up(&studio.scene, DENT_M, 77);
    studio.take(DENT_M, &tools);
}

#[test]
fn both_skinnings_draw_the_same_picture() {
    let tiers = [true, false].map(|skin_on_cpu| {
        let mut studio = Studio::new(Quality {
            size: [320, 180],
            skin_on_cpu,
            ..Quality::SOFTWARE
        });
        let tools = close_up(&studio.scene, DENT_M, 0);
        studio.take(DENT_M, &tools)
    });
    let score = likeness(&tiers[0], &tiers[1]);
    assert!(score > 0.999, "{score}");
}

#[test]
fn sizes_change_and_hostile_poses_do_not_panic() {
    let mut studio = Studio::small();
    studio.renderer.resize(&studio.gpu, [200, 150]).unwrap();
    let mut tools = support::tools(&studio.scene, 0.0, 0.5);
    assert_eq!(studio.take(0.0, &tools).dimensions(), (200, 150));
    assert!(studio.renderer.resize(&studio.gpu, [0, 100]).is_err());
    assert!(studio.renderer.resize(&studio.gpu, [100, 100_000]).is_err());
    // The camera is inside an organ, and the jaws are out of range.
    tools.world_from_camera.position_m = [0.0, 0.0, 0.0];
    tools.jaw = 1e30;
    tools.capsule_count = 0;
    studio.take(0.0, &tools);
    studio.gpu.check("drawing").unwrap();
}

#[test]
fn the_circle_is_there_and_dark_outside() {
    let mut studio = Studio::small();
    let tools = support::tools(&studio.scene, 0.0, 0.5);
    let picture = studio.take(0.0, &tools);
    let bright = |x: u32, y: u32| {
        picture.get_pixel(x, y).0[..3]
            .iter()
            .map(|&c| u32::from(c))
            .sum::<u32>()
    };
    for corner in [(0, 0), (319, 0), (0, 179), (319, 179), (20, 90), (300, 90)] {
        assert!(bright(corner.0, corner.1) < 12, "{corner:?}");
    }
    let middle: u32 = (140..180).map(|x| bright(x, 90)).sum::<u32>() / 40;
    assert!(middle > 80, "{middle}");
}
