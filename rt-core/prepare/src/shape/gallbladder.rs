//! The gallbladder: a pear 8 cm long that hangs under the liver, fundus to the front.

use std::sync::LazyLock;

use super::primitive::Tube;
use crate::Vec3;

pub(super) const BOUNDS: [[f64; 3]; 2] = [[-0.115, 0.225, -0.085], [-0.025, 0.325, 0.015]];
/// Length of a triangle's side.
pub(super) const EDGE_M: f64 = 0.0021;

/// Centre line and radius: fundus, body, infundibulum with its pouch, neck.
static BODY: LazyLock<Tube> = LazyLock::new(|| {
    Tube::new(
        &[
            ([-0.0790, 0.2590, 0.0040], 0.0120),
            ([-0.0770, 0.2610, -0.0040], 0.0142),
            ([-0.0735, 0.2645, -0.0140], 0.0146),
            ([-0.0695, 0.2690, -0.0250], 0.0134),
            ([-0.0655, 0.2740, -0.0350], 0.0112),
            ([-0.0620, 0.2780, -0.0430], 0.0095),
            ([-0.0590, 0.2810, -0.0495], 0.0082),
            ([-0.0560, 0.2845, -0.0545], 0.0058),
            ([-0.0530, 0.2875, -0.0570], 0.0038),
            ([-0.0500, 0.2890, -0.0590], 0.0030),
        ],
        8,
    )
});

pub(super) fn distance(p: &Vec3) -> f64 {
    BODY.distance(p)
}
