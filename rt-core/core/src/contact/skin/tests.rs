//! Tools against an octahedron of free spheres whose skin goes through their centres.

extern crate std;

use std::boxed::Box;
use std::vec::Vec as List;

use proptest::prelude::*;

use crate::math::{self, Vec3};
use crate::scene::tests::{organ, room, sphere};
use crate::scene::{Organ, RestSphere, SKIN_BINDINGS, Scene, Skin, SkinVertex};
use crate::study::Tissue;
use crate::testing::vector;
use crate::tissue::{Bodies, Method};
use crate::tool::{Capsule, Role};

/// Distance from the middle to each corner, m.
const SIZE_M: f32 = 0.02;
const MASS_KG: f32 = 0.002;
const BALL_M: f32 = 0.003;

struct Octahedron {
    organs: [Organ; 1],
    spheres: List<RestSphere>,
    vertices: List<SkinVertex>,
    fans: List<[u16; 2]>,
    nearest: List<u16>,
}

impl Octahedron {
    fn new() -> Self {
        let corners = [
            Vec3::x(),
            -Vec3::x(),
            Vec3::y(),
            -Vec3::y(),
            Vec3::z(),
            -Vec3::z(),
        ];
        let spheres = corners.map(|corner| sphere(corner * SIZE_M, 0.01)).to_vec();
        let (mut vertices, mut fans) = (List::new(), List::new());
        for (i, up) in (0u16..).zip(corners) {
            // The four corners around this one, anticlockwise seen from outside.
            let x = math::perpendicular(&up);
            let ring = [x, up.cross(&x), -x, -up.cross(&x)];
            let ring = ring.map(|direction| {
                let nearest = |(_, corner): &(u16, Vec3)| corner.dot(&direction) > 0.9;
                (0u16..).zip(corners).find(nearest).map_or(0, |(j, _)| j)
            });
            vertices.push(SkinVertex {
                spheres: [i; SKIN_BINDINGS],
                weights: core::array::from_fn(|k| if k == 0 { 1.0 } else { 0.0 }),
                fan_start: fans.len() as u32,
                fan_count: 4,
                patch_m: 0.01,
                curvature_per_m: 0.0,
            });
            for k in 0..4 {
                fans.push([ring[k], ring[(k + 1) % 4]]);
            }
        }
        let mut organs = [organ(0, 6, 0, 0)];
        organs[0].gravity_share = 0.0;
        organs[0].material.damping_per_s = 0.0;
        organs[0].material.friction = 0.1;
        Self {
            organs,
            spheres,
            vertices,
            fans,
            nearest: (0..6).collect(),
        }
    }

    fn scene(&self) -> Scene<'_> {
        let skin = Skin {
            vertices: &self.vertices,
            fans: &self.fans,
            nearest: &self.nearest,
        };
        let scene = Scene::new(&self.organs, &self.spheres, &[], room()).unwrap();
        scene.with_skin(skin).unwrap()
    }
}

fn ball(center_m: Vec3) -> [Capsule; 1] {
    [Capsule {
        a_m: center_m,
        b_m: center_m,
        radius_m: BALL_M,
        role: Role::Tip,
    }]
}

/// Moves a ball by `steps`, one a tick, from a place over the middle of the face (1, 1, 1). Returns
/// the force and the momentum of the spheres after every tick.
fn follow(steps: &[Vec3]) -> List<(Vec3, Vec3)> {
    let octahedron = Octahedron::new();
    let mut bodies = Box::new(Bodies::new());
    let mut tissue = Tissue::new(octahedron.scene(), &mut bodies, Method::NeoHookean);
    let out = Vec3::new(1.0, 1.0, 1.0).normalize();
    let mut center_m = Vec3::new(1.0, 1.0, 1.0) * (SIZE_M / 3.0) + out * (BALL_M + 0.001);
    let mut ticks = List::new();
    for step_m in steps {
        center_m += step_m;
        let force_n = tissue.press(&ball(center_m)).force_n;
        let momentum: Vec3 = (0..6).map(|i| tissue.velocity_m_s(i) * MASS_KG).sum();
        ticks.push((force_n, momentum));
    }
    ticks
}

#[test]
fn ball_drawn_along_the_skin_is_held_back() {
    let (inward, along) = (
        Vec3::new(-1.0, -1.0, -1.0).normalize(),
        Vec3::new(1.0, -1.0, 0.0),
    );
    let mut steps = List::from([inward * 1.0e-4; 15]);
    steps.extend([along * 5.0e-5; 5]);
    let ticks = follow(&steps);
    let (pressed, drawn) = (ticks[14].0, ticks[19].0);
    assert!(math::norm(&pressed) > 1.0e-4, "{pressed}");
    assert!(
        pressed.dot(&along).abs() < 0.01 * math::norm(&pressed),
        "{pressed}"
    );
    assert!(drawn.dot(&along) < 0.0, "{drawn}");
}

/// The push turns gradually, even when the skin under it turns suddenly, as in a jump to the other
/// side of a fold.
#[test]
fn turning_push_has_no_step() {
    for force_n in [0.01f32, 0.1, 1.0, 3.0] {
        let (mut push, to) = (Vec3::z(), -Vec3::z());
        for tick in 0..8000 {
            let next = math::rotated_towards(&push, &to, super::turn_max_at_rest_rad(force_n));
            let step_n = math::norm(&(next - push)) * force_n;
            assert!(
                step_n < 1.05 * super::TURN_STEP_N,
                "tick {tick} at {force_n} N: {step_n} N"
            );
            push = next;
        }
        assert!(math::norm(&(push - to)) < 1.0e-5, "{push}");
    }
}

/// A wide ball on fine spheres spreads its load over all spheres under it, about 130.
#[test]
fn spheres_under_a_wide_ball_share_its_load() {
    const SIDE: u16 = 26;
    const SPACING_M: f32 = 0.001_5;
    let at = |x: u16, y: u16| Vec3::new(f32::from(x) - 12.5, f32::from(y) - 12.5, 0.0) * SPACING_M;
    let number = |x: u16, y: u16| y * SIDE + x;
    let places = || (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y)));
    let spheres: List<_> = places().map(|(x, y)| sphere(at(x, y), 0.001)).collect();
    let (mut vertices, mut fans) = (List::new(), List::new());
    for (x, y) in places() {
        let fan_start = fans.len() as u32;
        let ring = [(1, 0), (1, 1), (0, 1), (-1, 0), (-1, -1), (0, -1)];
        let ring = ring.map(|(i, j)| x.checked_add_signed(i).zip(y.checked_add_signed(j)));
        let ring = ring.map(|to| to.filter(|(x, y)| *x < SIDE && *y < SIDE));
        for k in 0..6 {
            if let (Some(b), Some(c)) = (ring[k], ring[(k + 1) % 6]) {
                fans.push([number(b.0, b.1), number(c.0, c.1)]);
            }
        }
        // A vertex at a corner of the grid repeats a triangle, because a fan needs three.
        while fans.len() as u32 - fan_start < 3 {
            fans.push(fans[fan_start as usize]);
        }
        let (low_x, low_y) = (
            x.saturating_sub(1).min(SIDE - 4),
            y.saturating_sub(1).min(SIDE - 3),
        );
        vertices.push(SkinVertex {
            spheres: core::array::from_fn(|k| number(low_x + k as u16 % 4, low_y + k as u16 / 4)),
            weights: [1.0 / SKIN_BINDINGS as f32; SKIN_BINDINGS],
            fan_start,
            fan_count: fans.len() as u32 - fan_start,
            patch_m: 0.002,
            curvature_per_m: 0.0,
        });
    }
    let nearest: List<u16> = (0..SIDE * SIDE).collect();
    let mut organs = [organ(0, u32::from(SIDE * SIDE), 0, 0)];
    organs[0].gravity_share = 0.0;
    let skin = Skin {
        vertices: &vertices,
        fans: &fans,
        nearest: &nearest,
    };
    let scene = Scene::new(&organs, &spheres, &[], room()).unwrap();
    let scene = scene.with_skin(skin).unwrap();
    let mut bodies = Box::new(Bodies::new());
    let mut tissue = Tissue::new(scene, &mut bodies, Method::NeoHookean);
    for tick in 0u8..10 {
        let mut wide = ball(Vec3::z() * (0.010_2 - 1.0e-4 * f32::from(tick)));
        wide[0].radius_m = 0.010;
        let _ = tissue.press(&wide);
    }
    let speeds: List<f32> = (0..u32::from(SIDE * SIDE))
        .map(|i| -tissue.velocity_m_s(i).z)
        .collect();
    let sum: f32 = speeds.iter().sum();
    let speed_max = speeds.iter().copied().fold(0.0, f32::max);
    let pressed = speeds.iter().filter(|v| **v > 1.0e-3 * speed_max).count();
    assert!(sum > 0.0 && pressed > 100, "{pressed} of {sum} m/s");
    assert!(speed_max < 0.06 * sum, "{} of all", speed_max / sum);
}

proptest! {
    /// Newton's third law: the impulse on the tool in a tick is opposite to the impulse on the
    /// spheres, friction included.
    #[test]
    fn spheres_and_tool_take_equal_momentum(
        steps in prop::collection::vec(vector(2.0e-4), 1..40), inward in 0.0f32..2.0e-4,
    ) {
        let inward = Vec3::new(-1.0, -1.0, -1.0) * inward;
        let steps: List<Vec3> = steps.iter().map(|step| step + inward).collect();
        let mut before = Vec3::zeros();
        for (force_n, momentum) in follow(&steps) {
            let received_n = (momentum - before) / 0.001;
            let difference_n = math::norm(&(received_n + force_n));
            prop_assert!(difference_n < 1.0e-4 + 1.0e-3 * math::norm(&force_n), "{received_n} {force_n}");
            before = momentum;
        }
    }
}
