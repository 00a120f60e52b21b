//! Squares before a camera. The camera is at the origin and looks along −z.

use bytemuck::Zeroable as _;
use shared_mem::message::CapsuleMsg;

use super::canvas::Canvas;
use super::counted::Counted;
use super::*;

fn canvas() -> Canvas {
    let mut canvas = Canvas::new();
    canvas.begin(&PoseMsg::IDENTITY);
    canvas
}

/// Draws a square of an organ across the line of sight.
fn square(canvas: &mut Canvas, organ: u8, [x, y, depth_m]: Vec3, half_m: f32) {
    let corner = |right: f32, up: f32| [x + right * half_m, y + up * half_m, -depth_m];
    let corners = [
        corner(-1.0, -1.0),
        corner(1.0, -1.0),
        corner(1.0, 1.0),
        corner(-1.0, 1.0),
    ];
    let [a, b, c, d] = corners.map(|it| canvas.project(it));
    canvas.triangle([a, b, c], organ);
    canvas.triangle([a, c, d], organ);
}

fn clear_share(counted: &Counted, organ: usize) -> f64 {
    OrganSeen::of(1.0, counted, organ).clear()
}

fn assert_near(found: f64, expected: f64, within: f64) {
    assert!((found - expected).abs() < within, "{found}, not {expected}");
}

#[test]
fn the_nearer_surface_hides_the_farther_in_any_order() {
    for order in [[0u8, 1], [1, 0]] {
        let mut canvas = canvas();
        for organ in order {
            // The second lies in front of the right half of the first.
            let (at, half_m) = match organ {
                0 => ([0.0, 0.0, 0.1], 0.02),
                _ => ([0.01, 0.0, 0.05], 0.01),
            };
            square(&mut canvas, organ, at, half_m);
        }
        let counted = canvas.count();
        assert_near(clear_share(&counted, 0), 0.5, 0.03);
        assert_near(clear_share(&counted, 1), 1.0, 1e-9);
        let seen = OrganSeen::of(1.0, &counted, 1);
        // A square of 2 cm at 5 cm fills its share of a round picture of 70°.
        let radius_m = 0.05 * 0.61f64.tan();
        assert_near(
            seen.size(),
            4e-4 / (std::f64::consts::PI * radius_m * radius_m),
            0.02,
        );
        assert_near(seen.off(), 0.01 / radius_m, 0.02);
        let first = OrganSeen::of(0.5, &counted, 0);
        assert_near(first.visible(), 0.25, 0.02);
    }
}

#[test]
fn an_instrument_hides_organs_and_counts_as_none() {
    let mut canvas = canvas();
    square(&mut canvas, 3, [0.0, 0.0, 0.1], 0.02);
    canvas.capsule(&CapsuleMsg {
        a_m: [-0.1, 0.0, -0.05],
        b_m: [0.1, 0.0, -0.05],
        radius_m: 0.005,
        ..CapsuleMsg::zeroed()
    });
    let counted = canvas.count();
    // A shaft of 1 cm at 5 cm hides 2 of the 4 cm at 10 cm.
    assert_near(clear_share(&counted, 3), 0.5, 0.04);
    let (side, pixels) = canvas.pixels();
    assert_eq!(pixels[side * side / 2 + side / 2], None, "the shaft");
    assert!(pixels.contains(&Some(3)));
}

#[test]
fn a_place_is_open_until_a_surface_hides_it() {
    let mut canvas = canvas();
    let place = [0.0, 0.0, -0.1];
    assert!(canvas.is_open(place, 0.001));
    square(&mut canvas, 0, [0.0, 0.0, 0.12], 0.02);
    assert!(canvas.is_open(place, 0.001), "the square lies behind");
    square(&mut canvas, 0, [0.0, 0.0, 0.0995], 0.02);
    assert!(
        canvas.is_open(place, 0.001),
        "the square lies within the cell"
    );
    square(&mut canvas, 0, [0.0, 0.0, 0.08], 0.02);
    assert!(!canvas.is_open(place, 0.001));
    for outside in [[0.2, 0.0, -0.1], [0.0, 0.0, 0.1], [0.0, 0.0, 0.0]] {
        assert!(!canvas.is_open(outside, 0.001) && !canvas.has(outside));
    }
}

#[test]
fn an_angled_endoscope_sees_what_is_below_its_shaft() {
    let half = 0.5f32.sqrt();
    let see = |sight_rad: [f32; 2], place: Vec3| {
        let mut canvas = Canvas::new();
        canvas.begin(&view_of(&PoseMsg::IDENTITY, sight_rad));
        canvas.has(place)
    };
    let below = [0.0, -half * 0.1, -half * 0.1];
    assert!(!see([0.0; 2], below) && see([0.7, 0.0], below));
    assert!(!see([0.7, core::f32::consts::PI], below), "turned up");
}

#[test]
fn malformed_frames_have_no_image() {
    let scene = crate::tests::scene();
    let mut identity = Identity::of(&scene);
    let mut state: Box<StateFrame> = bytemuck::zeroed_box();
    let mut tools = ToolFrame::zeroed();
    tools.world_from_camera = PoseMsg::IDENTITY;
    assert!(
        identity.look([0.0; 2], &state, &tools).is_none(),
        "no spheres"
    );
    state.sphere_count = 2;
    let seen = identity.look([0.0; 2], &state, &tools).expect("an image");
    assert_eq!(seen.side_rad.to_bits(), 0, "no duct and artery");
    tools.world_from_camera.orientation = [f32::NAN; 4];
    assert!(
        identity.look([0.0; 2], &state, &tools).is_none(),
        "no camera"
    );
}
