//! The stomach: a J from the left diaphragm to the pylorus, under the left lobe of the liver.

use std::sync::LazyLock;

use super::liver;
use super::primitive::{Tube, carve};
use crate::Vec3;

pub(super) const BOUNDS: [[f64; 3]; 2] = [[-0.045, 0.205, -0.130], [0.140, 0.420, 0.020]];
/// Length of a triangle's side.
pub(super) const EDGE_M: f64 = 0.0045;

/// The liver rests on it with this gap.
const GAP_M: f64 = 0.002;

/// Centre line and radius: fundus, body, antrum, pylorus.
static BODY: LazyLock<Tube> = LazyLock::new(|| {
    Tube::new(
        &[
            ([0.078, 0.365, -0.088], 0.028),
            ([0.080, 0.340, -0.084], 0.038),
            ([0.078, 0.310, -0.074], 0.040),
            ([0.070, 0.280, -0.062], 0.036),
            ([0.056, 0.256, -0.055], 0.031),
            ([0.038, 0.245, -0.057], 0.026),
            ([0.020, 0.246, -0.064], 0.021),
            ([0.006, 0.250, -0.073], 0.015),
            ([-0.006, 0.254, -0.081], 0.010),
        ],
        6,
    )
});

pub(super) fn distance(p: &Vec3) -> f64 {
    let body = BODY.distance(p);
    // Far off, the liver takes nothing from it.
    if body > 0.01 {
        body
    } else {
        carve(body, liver::distance(p) - GAP_M, 0.006)
    }
}
