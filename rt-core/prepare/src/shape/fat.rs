//! Fat in and over Calot's triangle: lumps around the bile duct and towards the gallbladder's neck.
//! The ducts emerge from the fat.
//!
//! With a cover ([`Anatomy::cover_mm`]) fat and peritoneum also wrap cystic duct and cystic artery
//! from end to end, and the gallbladder's neck, so that nobody sees the two before the dissection.

use super::anatomy::Anatomy;
use super::bodies::Bodies;
use super::primitive::{Through, Tube, carve, join, meet};
use super::{connective_tissue, gallbladder, liver, stomach};
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

/// Clearance under a cover around organs at which duct and artery end, m. It is small, so that no
/// gap shows the two.
const COVER_GAP_M: f64 = 0.0002;
/// Parts of a cover blend over this distance, m.
const BLEND_M: f64 = 0.004;
/// The cover also wraps the hepatic artery up to this far from where the cystic artery rises, m.
const COLLAR_M: f64 = 0.004;
/// Part of the gallbladder's neck that every cover wraps, m.
const NECK_M: f64 = 0.009;

/// The part of the gallbladder's `line` that the cover wraps, as thick as the cover's outside.
pub(super) fn cloak(line: &[Through], anatomy: &Anatomy) -> Vec<Through> {
    let Some((end, _)) = line.last() else {
        return Vec::new();
    };
    let reach_m = NECK_M + 1e-3 * anatomy.adhesion_mm;
    let is_near = |(p, _): &&Through| (Vec3::from(*p) - Vec3::from(*end)).norm() <= reach_m;
    // Over the gallbladder the cover is a little thinner.
    let thick = |&(p, radius): &Through| (p, radius + 0.8e-3 * anatomy.cover_mm);
    line.iter().filter(is_near).map(thick).collect()
}

/// A box around the fat, m.
pub(super) fn bounds(bodies: &Bodies) -> [Vec3; 2] {
    let cover_m = 1e-3 * bodies.anatomy.cover_mm;
    let around = |tube: &Tube, margin: f64| {
        let [low, high] = tube.bounds();
        [low.add_scalar(-margin), high.add_scalar(margin)]
    };
    let fat = around(&bodies.fat, 0.003);
    let Some(cloak) = &bodies.cloak else {
        return fat;
    };
    let covered = [&bodies.cystic_duct, &bodies.cystic_artery];
    let covered = covered.map(|tube| around(tube, COLLAR_M + cover_m + 0.003));
    let all = covered.into_iter().chain([around(cloak, 0.003)]);
    all.fold(fat, |[low, high], [a, b]| [low.inf(&a), high.sup(&b)])
}

/// Distance to the body of the fat, without lumps and before organs are carved out.
fn body(bodies: &Bodies, p: &Vec3) -> f64 {
    let fat = bodies.fat.distance(p);
    let Some(cloak) = &bodies.cloak else {
        return fat;
    };
    let cover_m = 1e-3 * bodies.anatomy.cover_mm;
    let tubes = [&bodies.cystic_duct, &bodies.cystic_artery];
    let cuffs = tubes.map(|tube| tube.distance(p) - cover_m);
    let cuffs = join(cuffs[0], cuffs[1], BLEND_M);
    let collar = meet(
        bodies.hepatic_artery.distance(p) - cover_m,
        (p - bodies.origin).norm() - COLLAR_M - cover_m,
        BLEND_M,
    );
    let cuffs = join(cuffs, collar, BLEND_M);
    join(join(fat, cuffs, BLEND_M), cloak.distance(p), BLEND_M)
}

pub(super) fn distance(bodies: &Bodies, p: &Vec3) -> f64 {
    let body = body(bodies, p);
    if body > 0.006 {
        return body;
    }
    let turn = p * (std::f64::consts::TAU / LUMP_WIDTH_M);
    let (sin, cos) = (turn.map(libm::sin), turn.map(libm::cos));
    let lumps = sin.x * cos.y + sin.y * cos.z + sin.z * cos.x;
    let mut d = body - LUMP_M / 2.0 * lumps;
    let beside_m = match bodies.cloak {
        Some(_) => COVER_GAP_M,
        None => GAP_M,
    };
    let tubes = [
        (&bodies.bile_duct, beside_m),
        (&bodies.cystic_duct, GAP_M),
        (&bodies.hepatic_artery, beside_m),
        (&bodies.cystic_artery, GAP_M),
    ];
    for (tube, gap_m) in tubes {
        d = carve(d, tube.distance(p) - gap_m, 0.001);
    }
    if bodies.cloak.is_some() {
        d = carve(d, bodies.accessory(p) - GAP_M, 0.001);
        d = carve(d, connective_tissue::distance(bodies, p) - GAP_M, 0.001);
    }
    d = carve(d, gallbladder::distance(bodies, p) - beside_m, 0.001);
    d = carve(d, liver::distance(bodies, p) - GAP_M, 0.001);
    carve(d, stomach::duodenum(bodies, p) - GAP_M, 0.001)
}
