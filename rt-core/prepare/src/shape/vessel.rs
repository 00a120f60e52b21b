//! Ducts and arteries of Calot's triangle, between the gallbladder's neck, the common bile duct
//! and the liver. Their courses are those that surgeons are warned of.
//!
//! A cystic duct is 2 to 4 cm long and 1 to 5 mm wide; one duct in ten joins low (Turner and
//! Fulcher 2001, RadioGraphics 21:3). One person in ten has a right hepatic artery from the
//! superior mesenteric artery, accessory or in place of the usual one (Hiatt 1994, Ann Surg
//! 220:50). The cystic artery is about 2 mm wide.

use super::anatomy::Course;
use super::bodies::Bodies;
use super::liver;
use super::primitive::{ROUNDING_M, Through, Tube, carve};
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
const CYSTIC_DUCT_SHORT: &[Through] = &[
    ([-0.0389, 0.3038, -0.0689], 0.0021),
    ([-0.0380, 0.3008, -0.0708], 0.0017),
    ([-0.0368, 0.2978, -0.0722], 0.0018),
    ([-0.0346, 0.2945, -0.0732], 0.0016),
    ([-0.0326, 0.2915, -0.0738], 0.0017),
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
const HEPATIC_ARTERY: &[Through] = &[
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

/// Begins at the hump, not at the hepatic artery's usual place.
const CYSTIC_ARTERY_OF_HUMP: &[Through] = &[
    ([-0.0344, 0.3075, -0.0708], 0.0011),
    ([-0.0354, 0.3068, -0.0680], 0.0010),
    ([-0.0368, 0.3056, -0.0656], 0.0010),
    ([-0.0384, 0.3040, -0.0636], 0.0011),
];
/// Crosses behind the bile duct, climbs to the neck and turns back to the liver.
const HEPATIC_ARTERY_HUMPED: &[Through] = &[
    ([0.0060, 0.2800, -0.0840], 0.0024),
    ([-0.0060, 0.2780, -0.0770], 0.0024),
    ([-0.0140, 0.2835, -0.0740], 0.0023),
    ([-0.0190, 0.2920, -0.0785], 0.0022),
    ([-0.0250, 0.2975, -0.0805], 0.0021),
    ([-0.0310, 0.3012, -0.0790], 0.0021),
    ([-0.0340, 0.3060, -0.0745], 0.0021),
    ([-0.0325, 0.3125, -0.0725], 0.0020),
    ([-0.0300, 0.3190, -0.0695], 0.0019),
    ([-0.0290, 0.3290, -0.0640], 0.0017),
];
/// From the stomach, behind which the artery leaves the coeliac trunk.
const HEPATIC_ARTERY_BEGINS: &[Through] = &[
    ([0.0085, 0.2645, -0.0865], 0.0024),
    ([0.0080, 0.2715, -0.0868], 0.0024),
];
/// From behind the duodenum, where it leaves the superior mesenteric artery, to the liver.
pub(super) const ACCESSORY_ARTERY: &[Through] = &[
    ([-0.0300, 0.2620, -0.0965], 0.0017),
    ([-0.0325, 0.2720, -0.0910], 0.0017),
    ([-0.0345, 0.2840, -0.0870], 0.0016),
    ([-0.0355, 0.2960, -0.0845], 0.0016),
    ([-0.0365, 0.3060, -0.0810], 0.0016),
    ([-0.0385, 0.3170, -0.0755], 0.0015),
    ([-0.0400, 0.3280, -0.0700], 0.0015),
];

pub(super) fn cystic_duct(course: Course) -> &'static [Through] {
    match course {
        Course::Variant | Course::LowUnion => CYSTIC_DUCT_LOW,
        Course::ShortDuct => CYSTIC_DUCT_SHORT,
        _ => CYSTIC_DUCT,
    }
}

pub(super) fn cystic_artery(course: Course) -> &'static [Through] {
    match course {
        Course::Variant | Course::ArteryInFront => CYSTIC_ARTERY_IN_FRONT,
        Course::HumpedArtery => CYSTIC_ARTERY_OF_HUMP,
        _ => CYSTIC_ARTERY,
    }
}

/// The hepatic artery in this course. If it `runs_on`, it begins at the stomach.
pub(super) fn hepatic_artery(course: Course, runs_on: bool) -> Vec<Through> {
    let begins = if runs_on { HEPATIC_ARTERY_BEGINS } else { &[] };
    let rest = match course {
        Course::HumpedArtery => HEPATIC_ARTERY_HUMPED,
        _ => HEPATIC_ARTERY,
    };
    [begins, rest].concat()
}

pub(super) fn distance(bodies: &Bodies, vessel: &Tube, p: &Vec3) -> f64 {
    let tube = vessel.distance(p);
    // Far from the vessel the liver cannot matter, so its distance is not computed.
    if tube > 0.003 {
        tube
    } else {
        const BLEND_M: f64 = 0.001;
        // At this distance from the liver or more, `carve` returns `tube`.
        let reach_m = BLEND_M - tube + GAP_M + ROUNDING_M;
        carve(
            tube,
            liver::distance_below(bodies, p, reach_m) - GAP_M,
            BLEND_M,
        )
    }
}
