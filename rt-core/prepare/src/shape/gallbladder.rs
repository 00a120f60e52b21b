//! The gallbladder, a pear 8 cm long that hangs under the liver with its fundus to the front.

use super::bodies::Bodies;
use super::primitive::{ROUNDING_M, Through, ball, join};
use crate::Vec3;

/// Length of a triangle's side, m.
pub(super) const EDGE_M: f64 = 0.0021;

/// Gap between the gallbladder and the wall of the fossa in which it lies, m.
pub(super) const FOSSA_GAP_M: f64 = 0.0026;

/// Centre line and radius: fundus, body, infundibulum, neck.
pub(super) const LINE: &[Through] = &[
    ([-0.0725, 0.2618, -0.0068], 0.0125),
    ([-0.0694, 0.2665, -0.0127], 0.0150),
    ([-0.0648, 0.2735, -0.0214], 0.0158),
    ([-0.0595, 0.2815, -0.0314], 0.0145),
    ([-0.0548, 0.2886, -0.0401], 0.0118),
    ([-0.0514, 0.2930, -0.0466], 0.0096),
    ([-0.0483, 0.2971, -0.0524], 0.0082),
    ([-0.0455, 0.3022, -0.0577], 0.0056),
    ([-0.0428, 0.3052, -0.0625], 0.0036),
    ([-0.0405, 0.3062, -0.0655], 0.0026),
];
/// Centre and radius of Hartmann's pouch, the infundibulum's bulge towards the duodenum.
pub(super) const POUCH: ([f64; 3], f64) = ([-0.0470, 0.2925, -0.0545], 0.0072);

pub(super) fn distance(bodies: &Bodies, p: &Vec3) -> f64 {
    distance_below(bodies, p, f64::INFINITY)
}

/// The result of [`distance`] if that is below `limit_m`, else any number from `limit_m` upwards.
pub(super) fn distance_below(bodies: &Bodies, p: &Vec3, limit_m: f64) -> f64 {
    const BLEND_M: f64 = 0.007;
    let (pouch, radius) = bodies.pouch;
    let pouch = ball(p, pouch.into(), radius);
    // At this distance from the pear or more, either `join` returns `pouch`, or pear and pouch are
    // so far away that their join is at least `limit_m`.
    let reach_m = pouch.min(limit_m) + BLEND_M + ROUNDING_M;
    let pear = bodies.gallbladder.distance_below(p, reach_m);
    join(pear, pouch, BLEND_M)
}
