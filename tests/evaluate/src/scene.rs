//! What is done to the organ, the same for the reference and for every method.

use nalgebra::{Rotation3, Unit, Vector3};
use scene_prepare::mesh::Mesh;

type Point = Vector3<f64>;

/// Which experiment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Hangs from one end under gravity. The scene on which dimensionless settings are calibrated.
    Sag,
    /// One end fixed, the other grasped and moved by 30 mm.
    Pull,
    /// One end fixed, the other turned about the long axis, degrees.
    Twist(u16),
}

impl Kind {
    /// Its name in files.
    pub(crate) fn name(self) -> String {
        match self {
            Self::Sag => "sag".to_owned(),
            Self::Pull => "pull 30 mm".to_owned(),
            Self::Twist(degrees) => format!("twist {degrees}°"),
        }
    }

    /// Where the fixed end ends and the moved one begins, shares of the length.
    fn planes(self) -> [f64; 2] {
        match self {
            Self::Sag => [0.58, 1.0],
            Self::Pull => [0.35, 0.88],
            Self::Twist(_) => [0.25, 0.77],
        }
    }
}

/// An experiment on one organ. Both planes lie across the organ's longest axis; tissue beyond
/// them is held.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scene {
    /// Which experiment.
    pub(crate) kind: Kind,
    /// Number of the long axis.
    pub(crate) axis: usize,
    /// Up to here the organ is fixed, m.
    pub(crate) fixed_below_m: f64,
    /// From here on it is moved, or it ends, m.
    pub(crate) free_below_m: f64,
    pivot: Point,
}

/// Two positions this near along the axis are the same, m.
const SAME_M: f64 = 1e-7;

impl Scene {
    /// On an organ.
    pub(crate) fn new(kind: Kind, mesh: &Mesh) -> Self {
        let [min, max] = mesh.bounds();
        let axis = (max - min).imax();
        let at = |share: f64| min[axis] + share * (max[axis] - min[axis]);
        let [fixed_below_m, free_below_m] = kind.planes().map(at);
        let beyond = |p: &&Point| p[axis] > free_below_m;
        let end: Vec<_> = mesh.vertices.iter().filter(beyond).collect();
        Self {
            kind,
            axis,
            fixed_below_m,
            free_below_m,
            pivot: end.iter().copied().sum::<Point>() / end.len().max(1) as f64,
        }
    }

    /// Whether a rest position belongs to the fixed end.
    pub(crate) fn is_fixed(&self, p: &Point) -> bool {
        p[self.axis] < self.fixed_below_m + SAME_M
    }

    /// Whether it belongs to the end that is moved.
    pub(crate) fn is_moved(&self, p: &Point) -> bool {
        self.kind != Kind::Sag && p[self.axis] > self.free_below_m - SAME_M
    }

    /// Where a held position of the fixed end goes, m: nowhere. That of the moved end at a share
    /// of the load.
    pub(crate) fn motion(&self, p: &Point, share: f64) -> Point {
        let mut along = Point::zeros();
        along[self.axis] = 1.0;
        match self.kind {
            Kind::Sag => Point::zeros(),
            Kind::Pull => {
                let mut across = Point::zeros();
                // Upwards, or forwards where the organ stands upright.
                across[if self.axis == 2 { 1 } else { 2 }] = 1.0;
                (along + across * 2.5).normalize() * (0.03 * share)
            }
            Kind::Twist(degrees) => {
                let angle = f64::from(degrees).to_radians() * share;
                let arm = p - self.pivot;
                Rotation3::from_axis_angle(&Unit::new_normalize(along), angle) * arm - arm
            }
        }
    }

    /// Gravity, m/s².
    pub(crate) fn gravity(&self) -> Point {
        let mut down = Point::zeros();
        if self.kind == Kind::Sag {
            down[if self.axis == 2 { 1 } else { 2 }] = -9.81;
        }
        down
    }

    /// The scene's force from the tissue's pull on every held point (rest position, displacement,
    /// force): newtons at the fixed end (sag) or the moved one, newton metres for the twist.
    pub(crate) fn load(&self, pulls: impl Iterator<Item = (bool, Point, Point, Point)>) -> f64 {
        let mut total = Point::zeros();
        for (is_moved, x, u, force) in pulls {
            match self.kind {
                Kind::Sag if !is_moved => total += force,
                Kind::Pull if is_moved => total += force,
                Kind::Twist(_) if is_moved => {
                    total[self.axis] += (x + u - self.pivot).cross(&force)[self.axis];
                }
                _ => {}
            }
        }
        total.norm()
    }
}
