//! Ducts and arteries of Calot's triangle: between the gallbladder's neck, the common bile duct
//! and the liver. Two courses of the cystic duct and the cystic artery.

use std::sync::LazyLock;

use serde::Deserialize;

use super::liver;
use super::primitive::{Tube, carve};
use crate::Vec3;

/// Space to the liver.
const GAP_M: f64 = 0.0008;

/// How the cystic duct and the cystic artery run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Course {
    /// As in most people: the duct joins halfway, the artery crosses behind the bile duct.
    #[default]
    Usual,
    /// The duct runs along the bile duct and joins low; the artery crosses in front.
    Variant,
}

/// One vessel: its centre line with radii, as `Tube` takes it.
type Through = &'static [([f64; 3], f64)];

const CYSTIC_DUCT: Through = &[
    ([-0.0402, 0.3046, -0.0672], 0.0020),
    ([-0.0385, 0.3016, -0.0696], 0.0016),
    ([-0.0392, 0.2982, -0.0722], 0.0018),
    ([-0.0372, 0.2948, -0.0716], 0.0015),
    ([-0.0368, 0.2912, -0.0736], 0.0017),
    ([-0.0345, 0.2876, -0.0736], 0.0015),
    ([-0.0338, 0.2842, -0.0746], 0.0017),
];
const CYSTIC_DUCT_LOW: Through = &[
    ([-0.0402, 0.3046, -0.0672], 0.0020),
    ([-0.0380, 0.3000, -0.0705], 0.0016),
    ([-0.0376, 0.2945, -0.0728], 0.0018),
    ([-0.0372, 0.2880, -0.0735], 0.0016),
    ([-0.0380, 0.2815, -0.0742], 0.0018),
    ([-0.0378, 0.2755, -0.0750], 0.0016),
    ([-0.0362, 0.2710, -0.0755], 0.0017),
];
const BILE_DUCT: Through = &[
    ([-0.0255, 0.3085, -0.0700], 0.0026),
    ([-0.0268, 0.2990, -0.0725], 0.0030),
    ([-0.0282, 0.2880, -0.0742], 0.0032),
    ([-0.0300, 0.2760, -0.0752], 0.0033),
    ([-0.0325, 0.2640, -0.0756], 0.0032),
    ([-0.0350, 0.2520, -0.0752], 0.0030),
];
const HEPATIC_ARTERY: Through = &[
    ([0.0060, 0.2760, -0.0840], 0.0024),
    ([-0.0060, 0.2780, -0.0770], 0.0024),
    ([-0.0150, 0.2830, -0.0710], 0.0023),
    ([-0.0185, 0.2940, -0.0695], 0.0022),
    ([-0.0190, 0.3040, -0.0680], 0.0020),
];
const CYSTIC_ARTERY: Through = &[
    ([-0.0215, 0.2990, -0.0712], 0.0011),
    ([-0.0235, 0.2998, -0.0758], 0.0010),
    ([-0.0280, 0.3012, -0.0778], 0.0010),
    ([-0.0320, 0.3026, -0.0742], 0.0010),
    ([-0.0352, 0.3040, -0.0690], 0.0010),
    ([-0.0384, 0.3040, -0.0636], 0.0011),
];
const CYSTIC_ARTERY_IN_FRONT: Through = &[
    ([-0.0212, 0.2960, -0.0672], 0.0011),
    ([-0.0240, 0.2940, -0.0662], 0.0010),
    ([-0.0290, 0.2950, -0.0662], 0.0010),
    ([-0.0335, 0.2985, -0.0655], 0.0010),
    ([-0.0372, 0.3012, -0.0625], 0.0011),
];

/// A vessel ready to be measured against.
#[derive(Debug)]
pub(super) struct Vessel {
    tube: Tube,
    pub(super) bounds: [Vec3; 2],
    /// Length of a triangle's side.
    pub(super) edge_m: f64,
}

impl Vessel {
    fn new(through: Through) -> Self {
        let points = through.iter().map(|(p, _)| Vec3::from(*p));
        let widest = through.iter().map(|(_, r)| *r).fold(0.0, f64::max);
        let low = points.clone().reduce(|a, b| a.inf(&b)).unwrap_or_default();
        let high = points.reduce(|a, b| a.sup(&b)).unwrap_or_default();
        let margin = 2.0 * widest;
        Self {
            tube: Tube::new(through, 6),
            bounds: [low.add_scalar(-margin), high.add_scalar(margin)],
            edge_m: 0.45 * widest,
        }
    }

    pub(super) fn distance(&self, p: &Vec3) -> f64 {
        let tube = self.tube.distance(p);
        // Far off, the liver takes nothing from it.
        if tube > 0.003 {
            tube
        } else {
            carve(tube, liver::distance(p) - GAP_M, 0.001)
        }
    }
}

static VESSELS: LazyLock<[Vessel; 6]> = LazyLock::new(|| {
    [
        CYSTIC_DUCT,
        CYSTIC_DUCT_LOW,
        BILE_DUCT,
        HEPATIC_ARTERY,
        CYSTIC_ARTERY,
        CYSTIC_ARTERY_IN_FRONT,
    ]
    .map(Vessel::new)
});

pub(super) fn cystic_duct(course: Course) -> &'static Vessel {
    &VESSELS[usize::from(course == Course::Variant)]
}

pub(super) fn bile_duct() -> &'static Vessel {
    &VESSELS[2]
}

pub(super) fn hepatic_artery() -> &'static Vessel {
    &VESSELS[3]
}

pub(super) fn cystic_artery(course: Course) -> &'static Vessel {
    &VESSELS[4 + usize::from(course == Course::Variant)]
}
