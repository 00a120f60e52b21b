//! The gallbladder: a pear 8 cm long that hangs under the liver, fundus to the front.

use std::sync::LazyLock;

use super::primitive::Tube;
use crate::Vec3;

pub(super) const BOUNDS: [[f64; 3]; 2] = [[-0.105, 0.230, -0.075], [-0.035, 0.315, 0.030]];
/// Length of a triangle's side.
pub(super) const EDGE_M: f64 = 0.0021;

/// Centre line and radius: fundus, body, infundibulum with its pouch, neck.
static BODY: LazyLock<Tube> = LazyLock::new(|| {
    Tube::new(
        &[
            ([-0.0725, 0.2618, -0.0068], 0.0125),
            ([-0.0694, 0.2665, -0.0127], 0.0150),
            ([-0.0648, 0.2735, -0.0214], 0.0158),
            ([-0.0595, 0.2815, -0.0314], 0.0145),
            ([-0.0548, 0.2886, -0.0401], 0.0118),
            ([-0.0514, 0.2930, -0.0466], 0.0098),
            ([-0.0483, 0.2971, -0.0524], 0.0088),
            ([-0.0455, 0.3022, -0.0577], 0.0060),
            ([-0.0434, 0.3070, -0.0618], 0.0038),
            ([-0.0415, 0.3108, -0.0653], 0.0030),
        ],
        8,
    )
});

pub(super) fn distance(p: &Vec3) -> f64 {
    BODY.distance(p)
}
