//! The engineering view coincides with the picture.

use display_host::render::camera::Scope;
use display_host::render::gpu::Gpu;
use display_host::render::{Quality, Renderer};
use display_host::ui::{Mark, Overlay};
use glam::{Vec2, Vec3};
use shared_mem::message::SphereState;

use crate::support;

#[test]
fn point_straight_ahead_is_in_the_middle_and_the_edge_is_the_circle() {
    let scope = Scope::default();
    assert_eq!(scope.project(Vec3::new(0.0, 0.0, -0.1)), Some(Vec2::ZERO));
    let edge = Vec3::new(
        (scope.half_angle * 0.999).sin(),
        0.0,
        -(scope.half_angle * 0.999).cos(),
    );
    let at = scope.project(edge).expect("inside the circle");
    assert!(
        (at.x - 0.999 * scope.circle).abs() < 1e-4 && at.y.abs() < 1e-6,
        "{at}"
    );
    assert_eq!(scope.project(Vec3::new(0.0, 0.2, -0.1)), None);
    assert_eq!(scope.project(Vec3::new(0.0, 0.0, 0.1)), None);
}

#[test]
fn marks_tell_what_spheres_do() {
    let scene = support::scene(12);
    let mut state = support::state(&scene, 0.0);
    let tools = support::tools(&scene, 0.0, 0.5);
    state.spheres[0].bits = 0;
    state.spheres[1].bits = SphereState::AWAKE | SphereState::CONTACT;
    state.spheres[2].bits = SphereState::AWAKE | SphereState::CONTACT | SphereState::GRASPED;
    let spheres = state.spheres().expect("valid");
    let overlay = Overlay::of(&scene, spheres, &tools, &Scope::default());
    let count = |mark: Mark| overlay.circles.iter().filter(|c| c.mark == mark).count();
    assert_eq!(count(Mark::Contact), 1);
    assert_eq!(count(Mark::Grasped), 1);
    assert_eq!(count(Mark::Asleep), 1);
    assert!(count(Mark::Awake) > 50);
    let capsules = overlay.lines.iter().filter(|line| line.mark == Mark::Tool);
    assert!(capsules.count() >= 2);
}

/// The picture's lens and the view's projection must agree. The end of the gallbladder, a small
/// disc, is located in the picture and compared.
#[test]
fn the_view_lies_on_the_picture() {
    let gpu = Gpu::open().expect("a driver: apt-get install mesa-vulkan-drivers");
    let scene = support::scene(40);
    let quality = Quality {
        size: [320, 240],
        // Without shadows only the gallbladder itself changes.
        shadow_side: None,
        bloom: false,
        ..Quality::SOFTWARE
    };
    let mut renderer = Renderer::new(&gpu, &scene, quality).expect("the scene can be drawn");
    let state = support::state(&scene, 0.0);
    let mut tools = support::tools(&scene, 0.0, 0.5);
    // The gallbladder is near the right edge, where the lens distorts most.
    let eye = Vec3::new(-0.030, -0.022, 0.125);
    tools.world_from_camera = support::looking(eye, eye + Vec3::NEG_Z);
    tools.world_from_instrument.position_m = [0.0, 0.0, 1.0];
    tools.capsule_count = 0;
    let spheres = state.spheres().expect("valid");
    // A picture without the gallbladder differs only where the gallbladder is.
    let first = scene.organs()[1].spheres[0] as usize;
    let mut away = spheres.to_vec();
    away[first..].iter_mut().for_each(|s| s.center_m[2] += 0.9);
    renderer.render(&gpu, spheres, &tools, 0.0);
    renderer.exposure_mut().adapt = 0.0;
    renderer.exposure_mut().grain = 0.0;
    let [picture, without] = [spheres, &away].map(|spheres| {
        renderer.render(&gpu, spheres, &tools, 0.0);
        renderer.read(&gpu).expect("a picture")
    });
    let (mut sum, mut count) = (Vec2::ZERO, 0.0);
    for (x, y, p) in picture.enumerate_pixels() {
        let change = |c: usize| p.0[c].abs_diff(without.get_pixel(x, y).0[c]);
        if (0..3).any(|c| change(c) > 12) {
            sum += Vec2::new(x as f32 - 159.5, 119.5 - y as f32) / 120.0;
            count += 1.0;
        }
    }
    assert!(count > 60.0, "the gallbladder is in the picture: {count}");
    let overlay = Overlay::of(&scene, spheres, &tools, renderer.scope());
    let camera = display_host::render::camera::matrix(&tools.world_from_camera).inverse();
    let (mut middle, mut seen) = (Vec2::ZERO, 0.0);
    for sphere in &spheres[first..] {
        let at = camera.transform_point3(Vec3::from(sphere.center_m));
        if let Some(at) = renderer.scope().project(at) {
            middle += at;
            seen += 1.0;
        }
    }
    let (found, wanted) = (sum / count, middle / seen);
    assert!(
        found.distance(wanted) < 0.08,
        "picture {found}, view {wanted}"
    );
    assert!(wanted.x > 0.4, "towards the edge: {wanted}");
    assert!(!overlay.circles.is_empty());
}

#[test]
fn the_engineering_view_goes_from_off_to_marks_to_inside_and_off() {
    let mut ui = display_host::ui::UiState::default();
    let states: Vec<_> = (0..4)
        .map(|_| {
            ui.turn_engineering();
            (ui.overlay.is_some(), ui.inside)
        })
        .collect();
    assert_eq!(
        states,
        [(true, false), (true, true), (false, false), (true, false)]
    );
}

#[test]
fn inside_marks_leave_to_the_picture_what_it_shows() {
    let scene = support::scene(16);
    let mut state = support::state(&scene, 0.0);
    state.spheres[0].bits = SphereState::CONTACT;
    let tools = support::tools(&scene, 0.01, 0.5);
    let spheres = state.spheres().expect("valid");
    let mut overlay = Overlay::of(&scene, spheres, &tools, &Scope::default());
    assert!(overlay.lines.iter().any(|l| l.mark == Mark::Link));
    overlay.leave_to_picture();
    assert!(overlay.lines.iter().all(|l| l.mark != Mark::Link));
    assert!(overlay.lines.iter().any(|l| l.mark == Mark::Force));
    assert!(overlay.circles.iter().all(|c| c.mark == Mark::Contact));
}
