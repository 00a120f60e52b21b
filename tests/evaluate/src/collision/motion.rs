//! Two instruments of three parts each, and their motion. All ways get the same motion.

use nalgebra::Vector3;
use rt_core::tool::{Capsule, Role};
use scene_prepare::field::Nearest;
use scene_prepare::mesh::Mesh;

type Point = Vector3<f64>;

const SHAFT_RADIUS_M: f64 = 0.0025;
const JAW_RADIUS_M: f64 = 0.0015;
const JAW_M: f64 = 0.018;
const SHAFT_M: f64 = 0.15;
/// Half the opening of the jaws, m.
const OPEN_M: f64 = 0.004;
/// Amplitude of the tips' height above the surface, m.
const SWING_M: f64 = 0.007;
/// Mean height of the tips over the surface, m.
const MIDDLE_M: f64 = 0.003;

/// The parts of both instruments in each of `ticks` ticks. Their tips move around the organ, in and
/// out of its surface.
pub(crate) fn motion(mesh: &Mesh, ticks: usize) -> Option<Vec<Vec<Capsule>>> {
    let nearest = Nearest::new(mesh)?;
    let [min, max] = mesh.bounds();
    let (middle, half) = ((min + max) / 2.0, (max - min) / 2.0);
    let tick = |i: usize| {
        let turn = i as f64 / ticks as f64 * std::f64::consts::TAU;
        let one = |phase: f64| {
            let (a, b) = (2.0 * turn + phase, 0.9 * (3.0 * turn + phase).sin());
            let way = Point::new(a.cos() * b.cos(), a.sin() * b.cos(), b.sin());
            let far = middle + half.component_mul(&way) * 1.5;
            let site = nearest.point(&far);
            let out = (far - site).normalize();
            let height = MIDDLE_M + SWING_M * (17.0 * turn + phase).sin();
            instrument(&(site + out * height), &out)
        };
        [one(0.0), one(2.2)].concat()
    };
    Some((0..ticks).map(tick).collect())
}

/// Shaft and two open blades of an instrument that comes from `out`.
fn instrument(tip: &Point, out: &Point) -> Vec<Capsule> {
    let side = out.cross(&Point::new(0.31, 0.87, 0.39)).normalize();
    let joint = tip + out * JAW_M;
    let part = |a: Point, b: Point, radius_m: f64, role| Capsule {
        a_m: a.cast(),
        b_m: b.cast(),
        radius_m: radius_m as f32,
        role,
    };
    vec![
        part(joint + out * SHAFT_M, joint, SHAFT_RADIUS_M, Role::Shaft),
        part(joint, tip + side * OPEN_M, JAW_RADIUS_M, Role::UpperJaw),
        part(joint, tip - side * OPEN_M, JAW_RADIUS_M, Role::LowerJaw),
    ]
}
