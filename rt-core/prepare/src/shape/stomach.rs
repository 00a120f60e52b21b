//! The stomach, a J from the left diaphragm to the pylorus under the liver's left lobe, and the
//! duodenum that begins at the pylorus.

use super::bodies::Bodies;
use super::liver;
use super::primitive::{ROUNDING_M, Through, carve, carve_tube};
use crate::Vec3;

/// Length of a triangle's side, m.
pub(super) const EDGE_M: f64 = 0.0045;
/// Length of a triangle's side of the duodenum, m.
pub(super) const DUODENUM_EDGE_M: f64 = 0.0036;

/// Gap between the liver and the organs under it, m.
const GAP_M: f64 = 0.002;
/// Gap between the pylorus and the duodenum, m.
const PYLORUS_GAP_M: f64 = 0.0003;

/// Centre line and radius: fundus, body, antrum, pylorus.
pub(super) const LINE: &[Through] = &[
    ([0.078, 0.365, -0.088], 0.028),
    ([0.080, 0.340, -0.084], 0.038),
    ([0.078, 0.310, -0.074], 0.040),
    ([0.070, 0.280, -0.062], 0.036),
    ([0.056, 0.256, -0.055], 0.031),
    ([0.038, 0.245, -0.057], 0.026),
    ([0.020, 0.246, -0.064], 0.021),
    ([0.006, 0.250, -0.073], 0.015),
    ([-0.006, 0.254, -0.081], 0.010),
];
/// The duodenum's bulb, descending and horizontal part: a C to the right.
pub(super) const DUODENUM: &[Through] = &[
    ([-0.0190, 0.2545, -0.0850], 0.0090),
    ([-0.0290, 0.2530, -0.0860], 0.0118),
    ([-0.0410, 0.2500, -0.0870], 0.0125),
    ([-0.0520, 0.2430, -0.0890], 0.0124),
    ([-0.0585, 0.2310, -0.0915], 0.0122),
    ([-0.0600, 0.2160, -0.0940], 0.0122),
    ([-0.0560, 0.2020, -0.0960], 0.0122),
    ([-0.0450, 0.1930, -0.0975], 0.0120),
    ([-0.0280, 0.1900, -0.0985], 0.0120),
    ([-0.0080, 0.1905, -0.0985], 0.0118),
    ([0.0120, 0.1930, -0.0980], 0.0116),
];

pub(super) fn distance(bodies: &Bodies, p: &Vec3) -> f64 {
    under_the_liver(bodies, bodies.stomach.distance(p), p)
}

pub(super) fn duodenum(bodies: &Bodies, p: &Vec3) -> f64 {
    duodenum_below(bodies, p, f64::INFINITY)
}

/// The result of [`duodenum`] if that is below `limit_m`, else any number from `limit_m` upwards.
pub(super) fn duodenum_below(bodies: &Bodies, p: &Vec3, limit_m: f64) -> f64 {
    let tube = bodies.duodenum.distance_below(p, limit_m);
    // Carving only adds to the distance.
    if tube >= limit_m {
        return tube;
    }
    let body = under_the_liver(bodies, tube, p);
    carve_tube(body, &bodies.stomach, PYLORUS_GAP_M, 0.001, p)
}

fn under_the_liver(bodies: &Bodies, body: f64, p: &Vec3) -> f64 {
    // Far from the organ the liver cannot matter, so its distance is not computed.
    if body > 0.01 {
        body
    } else {
        const BLEND_M: f64 = 0.006;
        // At this distance from the liver or more, `carve` returns `body`.
        let reach_m = BLEND_M - body + GAP_M + ROUNDING_M;
        carve(
            body,
            liver::distance_below(bodies, p, reach_m) - GAP_M,
            BLEND_M,
        )
    }
}
