//! The connective tissue between the gallbladder and its bed.

use super::bodies::Bodies;
use super::gallbladder::{self, FOSSA_GAP_M};
use super::liver;
use super::primitive::{ROUNDING_M, meet};
use crate::Vec3;

/// Length of a triangle's side, m. It is short, because the tissue is thin.
pub(super) const EDGE_M: f64 = 0.0012;
/// Gap between the connective tissue and the gallbladder, and between the tissue and the liver, m.
const GAP_M: f64 = 0.0002;

/// Distance to the layer of connective tissue in the fossa. The layer ends 3 mm below the surface
/// that the liver would have without the fossa.
pub(super) fn distance(bodies: &Bodies, p: &Vec3) -> f64 {
    distance_below(bodies, p, f64::INFINITY)
}

/// The result of [`distance`] if that is below `limit_m`, else any number from `limit_m` upwards.
pub(super) fn distance_below(bodies: &Bodies, p: &Vec3, limit_m: f64) -> f64 {
    let room = FOSSA_GAP_M - 2.0 * GAP_M;
    let thickness = room * bodies.anatomy.connective_tissue.width.min(1.0);
    let middle = GAP_M + room / 2.0;
    let reach_m = limit_m + thickness / 2.0 + middle + ROUNDING_M;
    let from_gallbladder = gallbladder::distance_below(bodies, p, reach_m);
    let layer = (from_gallbladder - middle).abs() - thickness / 2.0;
    // Far from the layer the liver cannot matter, so its distance is not computed. It only adds to
    // the distance.
    if layer > 0.004 || layer >= limit_m {
        layer
    } else {
        meet(layer, liver::body(p, &bodies.anatomy.liver) + 0.003, 0.001)
    }
}
