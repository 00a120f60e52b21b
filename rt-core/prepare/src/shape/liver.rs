//! The liver: a wedge under the diaphragm. Thick right lobe, left lobe tapering to the left,
//! smooth dome above and in front, hollowed visceral surface below and behind, and between them
//! the sharp inferior edge; the gallbladder's fossa, the porta hepatis, the notch of the round
//! ligament.

use super::gallbladder;
use super::primitive::{Tube, ball, carve, ellipsoid, half_space, join, meet};
use crate::Vec3;
use std::sync::LazyLock;

pub(super) const BOUNDS: [[f64; 3]; 2] = [[-0.165, 0.235, -0.165], [0.135, 0.455, 0.045]];
/// Length of a triangle's side.
pub(super) const EDGE_M: f64 = 0.0037;

/// The fossa is this much wider than the gallbladder that lies in it.
const FOSSA_GAP_M: f64 = 0.0012;

/// Fissure of the round ligament, from the inferior edge to the porta.
static LIGAMENT_NOTCH: LazyLock<Tube> = LazyLock::new(|| {
    Tube::new(
        &[
            ([-0.020, 0.268, 0.040], 0.006),
            ([-0.020, 0.285, 0.010], 0.005),
            ([-0.022, 0.302, -0.030], 0.004),
            ([-0.028, 0.310, -0.060], 0.003),
        ],
        6,
    )
});

/// Porta hepatis, across the visceral surface.
static PORTA: LazyLock<Tube> = LazyLock::new(|| {
    Tube::new(
        &[
            ([-0.062, 0.296, -0.075], 0.006),
            ([-0.045, 0.300, -0.068], 0.010),
            ([-0.025, 0.310, -0.062], 0.009),
        ],
        6,
    )
});

pub(super) fn distance(p: &Vec3) -> f64 {
    let right = ellipsoid(p, [-0.068, 0.340, -0.070], [0.080, 0.092, 0.085]);
    let middle = ellipsoid(p, [-0.005, 0.350, -0.040], [0.080, 0.070, 0.062]);
    let left = ellipsoid(p, [0.055, 0.362, -0.025], [0.072, 0.040, 0.042]);
    let mut d = join(join(right, middle, 0.05), left, 0.05);
    // The visceral side: a plane that rises to the left and to the back, hollowed by the organs
    // below.
    let visceral = half_space(p, [-0.060, 0.262, 0.010], [0.32, -0.86, -0.40]);
    d = meet(d, visceral, 0.012);
    d = carve(d, ball(p, [0.060, 0.235, -0.060], 0.095), 0.02);
    d = carve(d, ball(p, [-0.110, 0.215, -0.090], 0.075), 0.02);
    // Vena cava and spine behind.
    d = carve(
        d,
        Tube::new(
            &[([-0.02, 0.2, -0.15], 0.03), ([-0.02, 0.45, -0.15], 0.03)],
            1,
        )
        .distance(p),
        0.03,
    );
    d = carve(d, LIGAMENT_NOTCH.distance(p), 0.010);
    d = carve(d, PORTA.distance(p), 0.012);
    carve(d, gallbladder::distance(p) - FOSSA_GAP_M, 0.006)
}
