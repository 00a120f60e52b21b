//! A length of small intestine below the liver: loops that lie side by side.

use std::sync::LazyLock;

use super::primitive::Tube;
use crate::Vec3;

pub(super) const BOUNDS: [[f64; 3]; 2] = [[-0.115, 0.125, -0.130], [0.095, 0.240, -0.020]];
/// Length of a triangle's side.
pub(super) const EDGE_M: f64 = 0.0042;

const RADIUS_M: f64 = 0.0125;

static LOOPS: LazyLock<Tube> = LazyLock::new(|| {
    Tube::new(
        &[
            ([-0.085, 0.205, -0.095], RADIUS_M),
            ([-0.050, 0.212, -0.088], RADIUS_M * 1.04),
            ([-0.010, 0.206, -0.090], RADIUS_M),
            ([0.030, 0.214, -0.085], RADIUS_M * 0.96),
            ([0.064, 0.204, -0.082], RADIUS_M),
            ([0.072, 0.182, -0.072], RADIUS_M),
            ([0.045, 0.174, -0.062], RADIUS_M * 1.05),
            ([0.010, 0.180, -0.058], RADIUS_M),
            ([-0.030, 0.172, -0.062], RADIUS_M * 0.97),
            ([-0.066, 0.180, -0.064], RADIUS_M * 1.03),
            ([-0.092, 0.166, -0.066], RADIUS_M),
            ([-0.084, 0.146, -0.062], RADIUS_M),
            ([-0.052, 0.140, -0.056], RADIUS_M),
            ([-0.016, 0.147, -0.052], RADIUS_M * 1.03),
            ([0.024, 0.141, -0.054], RADIUS_M),
            ([0.058, 0.147, -0.056], RADIUS_M),
        ],
        6,
    )
});

pub(super) fn distance(p: &Vec3) -> f64 {
    LOOPS.distance(p)
}
