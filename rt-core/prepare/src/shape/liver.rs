//! The liver: a wedge under the diaphragm. It has a thick right lobe, a left lobe that tapers to
//! the left, a smooth dome above and in front, a hollowed visceral surface below and behind, and
//! the sharp inferior edge between them. The gallbladder's fossa, the porta hepatis and the notch
//! of the round ligament are carved out.

use super::anatomy::Build;
use super::bodies::Bodies;
use super::gallbladder::{self, FOSSA_GAP_M};
use super::primitive::{
    ROUNDING_M, Tube, ball, carve, carve_tube, ellipsoid, half_space, join, meet,
};
use crate::Vec3;
use std::sync::LazyLock;

/// Length of a triangle's side, m.
pub(super) const EDGE_M: f64 = 0.0037;

/// Point about which the body of [`drawn`] is scaled, m.
const MIDDLE: [f64; 3] = [-0.062, 0.290, -0.030];
/// Scale that gives the body a healthy adult's volume.
const SIZE: f64 = 0.94;

/// Spine and vena cava, behind the liver.
static SPINE: LazyLock<Tube> = LazyLock::new(|| {
    Tube::new(
        &[([-0.005, 0.2, -0.14], 0.03), ([-0.005, 0.45, -0.14], 0.03)],
        1,
    )
});

/// Fissure of the round ligament, from the inferior edge to the porta.
static LIGAMENT_NOTCH: LazyLock<Tube> = LazyLock::new(|| {
    Tube::new(
        &[
            ([-0.018, 0.258, 0.024], 0.009),
            ([-0.018, 0.275, 0.006], 0.006),
            ([-0.020, 0.295, -0.025], 0.005),
            ([-0.024, 0.314, -0.055], 0.003),
        ],
        6,
    )
});

/// Porta hepatis, across the visceral surface.
static PORTA: LazyLock<Tube> = LazyLock::new(|| {
    Tube::new(
        &[
            ([-0.064, 0.311, -0.072], 0.006),
            ([-0.045, 0.313, -0.068], 0.010),
            ([-0.025, 0.317, -0.062], 0.009),
        ],
        6,
    )
});

/// Bounds of the body before it is scaled, m.
const BOUNDS: [[f64; 3]; 2] = [[-0.165, 0.235, -0.165], [0.135, 0.455, 0.045]];

/// Bounds in this build, m.
pub(super) fn bounds(build: &Build) -> [Vec3; 2] {
    let middle = Vec3::from(MIDDLE);
    BOUNDS.map(|corner| build.place(&Vec3::from(corner), &middle))
}

pub(super) fn distance(bodies: &Bodies, p: &Vec3) -> f64 {
    distance_below(bodies, p, f64::INFINITY)
}

/// The result of [`distance`] if that is below `limit_m`, else any number from `limit_m` upwards.
pub(super) fn distance_below(bodies: &Bodies, p: &Vec3, limit_m: f64) -> f64 {
    const BLEND_M: f64 = 0.006;
    let body = body(p, &bodies.anatomy.liver);
    // Carving only adds to the distance.
    if body >= limit_m {
        return body;
    }
    // At this distance from the gallbladder or more, `carve` returns `body`.
    let reach_m = BLEND_M - body + FOSSA_GAP_M + ROUNDING_M;
    let gallbladder = gallbladder::distance_below(bodies, p, reach_m);
    carve(body, gallbladder - FOSSA_GAP_M, BLEND_M)
}

/// Distance to the liver as it would be without the gallbladder's fossa.
pub(super) fn body(p: &Vec3, build: &Build) -> f64 {
    let middle = Vec3::from(MIDDLE);
    let size = SIZE * build.size;
    size * drawn(&(middle + (p - build.shift_m() - middle) / size))
}

fn drawn(p: &Vec3) -> f64 {
    let right = ellipsoid(p, [-0.070, 0.345, -0.066], [0.068, 0.086, 0.068]);
    let middle = ellipsoid(p, [-0.012, 0.338, -0.040], [0.070, 0.066, 0.048]);
    let left = ellipsoid(p, [0.060, 0.345, -0.028], [0.070, 0.037, 0.030]);
    let mut d = join(join(right, middle, 0.035), left, 0.035);
    // The visceral side is a plane that rises to the left and to the back. The organs below it make
    // hollows: the stomach on the left, colon and kidney on the right.
    let visceral = half_space(p, [-0.060, 0.268, 0.000], [0.22, -0.82, -0.52]);
    d = meet(d, visceral, 0.006);
    d = carve(d, ball(p, [0.080, 0.255, -0.095], 0.090), 0.015);
    d = carve(d, ball(p, [-0.115, 0.225, -0.110], 0.080), 0.015);
    // The heart makes a hollow on top of the left lobe.
    d = carve(d, ball(p, [0.045, 0.480, -0.030], 0.095), 0.03);
    // Vena cava and spine behind.
    d = carve_tube(d, &SPINE, 0.0, 0.03, p);
    d = carve_tube(d, &LIGAMENT_NOTCH, 0.0, 0.008, p);
    carve_tube(d, &PORTA, 0.0, 0.012, p)
}
