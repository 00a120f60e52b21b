//! A length of small intestine below the liver: loops that lie side by side.

use std::sync::LazyLock;

use super::primitive::Tube;
use crate::Vec3;

pub(super) const BOUNDS: [[f64; 3]; 2] = [[-0.125, 0.110, -0.125], [0.100, 0.240, -0.045]];
/// Length of a triangle's side.
pub(super) const EDGE_M: f64 = 0.0042;

const RADIUS_M: f64 = 0.0115;

static LOOPS: LazyLock<Tube> = LazyLock::new(|| {
    Tube::new(
        &[
            ([-0.092, 0.214, -0.104], RADIUS_M),
            ([-0.060, 0.222, -0.096], RADIUS_M * 1.05),
            ([-0.022, 0.212, -0.100], RADIUS_M * 0.96),
            ([0.014, 0.206, -0.096], RADIUS_M),
            ([0.046, 0.212, -0.100], RADIUS_M * 1.04),
            ([0.076, 0.200, -0.096], RADIUS_M),
            ([0.082, 0.176, -0.084], RADIUS_M * 0.97),
            ([0.056, 0.166, -0.074], RADIUS_M),
            ([0.018, 0.174, -0.068], RADIUS_M * 1.05),
            ([-0.018, 0.168, -0.074], RADIUS_M),
            ([-0.052, 0.178, -0.066], RADIUS_M * 0.96),
            ([-0.088, 0.176, -0.074], RADIUS_M * 1.03),
            ([-0.108, 0.156, -0.076], RADIUS_M),
            ([-0.092, 0.134, -0.072], RADIUS_M),
            ([-0.054, 0.138, -0.064], RADIUS_M * 1.04),
            ([-0.014, 0.130, -0.070], RADIUS_M),
            ([0.022, 0.136, -0.062], RADIUS_M * 0.97),
            ([0.056, 0.128, -0.068], RADIUS_M),
        ],
        6,
    )
});

pub(super) fn distance(p: &Vec3) -> f64 {
    LOOPS.distance(p)
}
