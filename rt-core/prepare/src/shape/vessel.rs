//! Ducts and arteries of Calot's triangle, between the gallbladder's neck, the common bile duct and
//! the liver. Cystic duct and cystic artery each have two courses.

use super::bodies::Bodies;
use super::liver;
use super::primitive::{Through, Tube, carve};
use crate::Vec3;

/// Gap between a vessel and the liver, m.
const GAP_M: f64 = 0.0008;

const CYSTIC_DUCT: &[Through] = &[
    ([-0.0389, 0.3038, -0.0689], 0.0021),
    ([-0.0379, 0.3008, -0.0708], 0.0016),
    ([-0.0392, 0.2982, -0.0722], 0.0018),
    ([-0.0372, 0.2948, -0.0716], 0.0015),
    ([-0.0368, 0.2912, -0.0736], 0.0017),
    ([-0.0345, 0.2876, -0.0736], 0.0015),
    ([-0.0338, 0.2842, -0.0746], 0.0017),
];
const CYSTIC_DUCT_LOW: &[Through] = &[
    ([-0.0389, 0.3038, -0.0689], 0.0021),
    ([-0.0380, 0.3000, -0.0705], 0.0016),
    ([-0.0376, 0.2945, -0.0728], 0.0018),
    ([-0.0372, 0.2880, -0.0735], 0.0016),
    ([-0.0380, 0.2815, -0.0742], 0.0018),
    ([-0.0378, 0.2755, -0.0750], 0.0016),
    ([-0.0362, 0.2710, -0.0755], 0.0017),
];
pub(super) const BILE_DUCT: &[Through] = &[
    ([-0.0225, 0.3225, -0.0630], 0.0022),
    ([-0.0238, 0.3150, -0.0670], 0.0024),
    ([-0.0255, 0.3085, -0.0700], 0.0026),
    ([-0.0268, 0.2990, -0.0725], 0.0030),
    ([-0.0282, 0.2880, -0.0742], 0.0032),
    ([-0.0300, 0.2760, -0.0752], 0.0033),
    ([-0.0318, 0.2662, -0.0785], 0.0031),
];
pub(super) const HEPATIC_ARTERY: &[Through] = &[
    ([0.0060, 0.2800, -0.0840], 0.0024),
    ([-0.0060, 0.2780, -0.0770], 0.0024),
    ([-0.0150, 0.2830, -0.0710], 0.0023),
    ([-0.0185, 0.2940, -0.0695], 0.0022),
    ([-0.0190, 0.3040, -0.0680], 0.0020),
    ([-0.0175, 0.3140, -0.0640], 0.0019),
    ([-0.0150, 0.3250, -0.0590], 0.0017),
];
const CYSTIC_ARTERY: &[Through] = &[
    ([-0.0215, 0.2990, -0.0712], 0.0011),
    ([-0.0235, 0.2998, -0.0758], 0.0010),
    ([-0.0280, 0.3012, -0.0778], 0.0010),
    ([-0.0320, 0.3026, -0.0742], 0.0010),
    ([-0.0352, 0.3040, -0.0690], 0.0010),
    ([-0.0384, 0.3040, -0.0636], 0.0011),
];
const CYSTIC_ARTERY_IN_FRONT: &[Through] = &[
    ([-0.0212, 0.2960, -0.0672], 0.0011),
    ([-0.0240, 0.2940, -0.0662], 0.0010),
    ([-0.0290, 0.2950, -0.0662], 0.0010),
    ([-0.0335, 0.2985, -0.0655], 0.0010),
    ([-0.0388, 0.3014, -0.0606], 0.0011),
];

pub(super) fn cystic_duct(variant: bool) -> &'static [Through] {
    if variant {
        CYSTIC_DUCT_LOW
    } else {
        CYSTIC_DUCT
    }
}

pub(super) fn cystic_artery(variant: bool) -> &'static [Through] {
    if variant {
        CYSTIC_ARTERY_IN_FRONT
    } else {
        CYSTIC_ARTERY
    }
}

pub(super) fn distance(bodies: &Bodies, vessel: &Tube, p: &Vec3) -> f64 {
    let tube = vessel.distance(p);
    // Far from the vessel the liver cannot matter, so its distance is not computed.
    if tube > 0.003 {
        tube
    } else {
        carve(tube, liver::distance(bodies, p) - GAP_M, 0.001)
    }
}
