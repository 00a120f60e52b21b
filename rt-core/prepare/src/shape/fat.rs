//! Fat in and over Calot's triangle: lumps around the bile duct and towards the gallbladder's neck.
//! The ducts emerge from the fat.
//!
//! With a cover ([`Anatomy::cover_mm`]) fat and peritoneum also wrap cystic duct and cystic artery
//! from end to end, and the gallbladder's neck. Then nobody sees duct and artery before the
//! dissection.

use super::anatomy::Anatomy;
use super::bodies::Bodies;
use super::primitive::{ROUNDING_M, Through, Tube, carve, carve_tube, join, meet};
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
/// Edges where organs are carved out are rounded over this distance, m.
const EDGE_BLEND_M: f64 = 0.001;
/// Beyond this distance from the fat's body, a lower bound of the distance is enough, m.
pub(super) const FAR_M: f64 = 0.006;
/// Distance from a tube up to which the tube can shape the part of the body that is nearer than
/// [`FAR_M`], m. The body's three joins take off 3 mm at most, so the nearest piece of this part is
/// within 9 mm. Another piece blends with it only within [`BLEND_M`] more, so within 13 mm. A cover
/// of at most 8 mm lies between a tube and its piece.
const BODY_REACH_M: f64 = 0.022;
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

/// Distance to the body of the fat, without lumps and before organs are carved out. Farther than
/// [`FAR_M`] the result is a lower bound.
pub(super) fn body(bodies: &Bodies, p: &Vec3) -> f64 {
    let distance = |tube: &Tube| tube.distance_below(p, BODY_REACH_M);
    let fat = distance(&bodies.fat);
    let Some(cloak) = &bodies.cloak else {
        return fat;
    };
    let cover_m = 1e-3 * bodies.anatomy.cover_mm;
    let tubes = [&bodies.cystic_duct, &bodies.cystic_artery];
    let cuffs = tubes.map(|tube| distance(tube) - cover_m);
    let cuffs = join(cuffs[0], cuffs[1], BLEND_M);
    let collar = meet(
        distance(&bodies.hepatic_artery) - cover_m,
        (p - bodies.origin).norm() - COLLAR_M - cover_m,
        BLEND_M,
    );
    let cuffs = join(cuffs, collar, BLEND_M);
    join(join(fat, cuffs, BLEND_M), distance(cloak), BLEND_M)
}

pub(super) fn distance(bodies: &Bodies, p: &Vec3) -> f64 {
    let body = body(bodies, p);
    if body > FAR_M {
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
    // At this distance or more, `carve` returns `d`.
    let reach_m = |d: f64, gap_m: f64| EDGE_BLEND_M - d + gap_m + ROUNDING_M;
    for (tube, gap_m) in tubes {
        d = carve_tube(d, tube, gap_m, EDGE_BLEND_M, p);
    }
    if bodies.cloak.is_some() {
        d = carve(d, bodies.accessory(p) - GAP_M, EDGE_BLEND_M);
        let tissue = connective_tissue::distance_below(bodies, p, reach_m(d, GAP_M));
        d = carve(d, tissue - GAP_M, EDGE_BLEND_M);
    }
    let gallbladder = gallbladder::distance_below(bodies, p, reach_m(d, beside_m));
    d = carve(d, gallbladder - beside_m, EDGE_BLEND_M);
    let liver = liver::distance_below(bodies, p, reach_m(d, GAP_M));
    d = carve(d, liver - GAP_M, EDGE_BLEND_M);
    let duodenum = stomach::duodenum_below(bodies, p, reach_m(d, GAP_M));
    carve(d, duodenum - GAP_M, EDGE_BLEND_M)
}
