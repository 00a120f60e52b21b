//! Fat in and over Calot's triangle: lumps around the bile duct and towards the gallbladder's neck.
//! The ducts emerge from the fat.

use super::bodies::Bodies;
use super::primitive::{Through, carve};
use super::{gallbladder, liver, stomach};
use crate::Vec3;

/// Length of a triangle's side, m.
pub(super) const EDGE_M: f64 = 0.0012;

/// Clearance around the organs that lie in the fat, m.
const GAP_M: f64 = 0.0006;
/// Height of a lump, m.
const LUMP_M: f64 = 0.0009;
/// Width of a lump, m.
const LUMP_WIDTH_M: f64 = 0.0060;

/// Centre line and radius, from the gallbladder's neck to the bile duct and down along it.
pub(super) const LINE: &[Through] = &[
    ([-0.0400, 0.3005, -0.0725], 0.0036),
    ([-0.0370, 0.2985, -0.0755], 0.0058),
    ([-0.0320, 0.2950, -0.0775], 0.0070),
    ([-0.0270, 0.2880, -0.0780], 0.0076),
    ([-0.0270, 0.2790, -0.0780], 0.0072),
    ([-0.0290, 0.2710, -0.0780], 0.0050),
];

pub(super) fn distance(bodies: &Bodies, p: &Vec3) -> f64 {
    let body = bodies.fat.distance(p);
    if body > 0.006 {
        return body;
    }
    let turn = p * (std::f64::consts::TAU / LUMP_WIDTH_M);
    let (sin, cos) = (turn.map(libm::sin), turn.map(libm::cos));
    let lumps = sin.x * cos.y + sin.y * cos.z + sin.z * cos.x;
    let mut d = body - LUMP_M / 2.0 * lumps;
    let tubes = [
        &bodies.bile_duct,
        &bodies.cystic_duct,
        &bodies.hepatic_artery,
        &bodies.cystic_artery,
    ];
    for tube in tubes {
        d = carve(d, tube.distance(p) - GAP_M, 0.001);
    }
    d = carve(d, gallbladder::distance(bodies, p) - GAP_M, 0.001);
    d = carve(d, liver::distance(bodies, p) - GAP_M, 0.001);
    carve(d, stomach::duodenum(bodies, p) - GAP_M, 0.001)
}
