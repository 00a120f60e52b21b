//! What is done to the organ, the same for the reference and for every method.

use nalgebra::{Rotation3, Vector3};
use scene_prepare::mesh::Mesh;

type Point = Vector3<f64>;

/// Which experiment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Hangs from one end under gravity. The scene on which dimensionless settings are calibrated.
    Sag,
    /// One end fixed, the other grasped and moved by 30 mm.
    Pull,
    /// One end fixed, the other turned by 90° about the long axis.
    Twist,
}

impl Kind {
    /// All of them.
    pub(crate) const ALL: [Self; 3] = [Self::Sag, Self::Pull, Self::Twist];

    /// Its name in files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Sag => "sag",
            Self::Pull => "pull 30 mm",
            Self::Twist => "twist 90°",
        }
    }
}

/// An experiment on one organ.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scene {
    /// Which experiment.
    pub(crate) kind: Kind,
    fixed_below_x: f64,
    moved_above_x: f64,
    axis: Point,
}

/// Shares of the organ's length that are held at each end.
const FIXED: f64 = 0.2;
const MOVED: f64 = 0.2;

impl Scene {
    /// On an organ that is long in x.
    pub(crate) fn new(kind: Kind, mesh: &Mesh) -> Self {
        let [min, max] = mesh.bounds();
        let length = max.x - min.x;
        let moved_above_x = max.x - MOVED * length;
        let end: Vec<_> = mesh
            .vertices
            .iter()
            .filter(|p| p.x > moved_above_x)
            .collect();
        Self {
            kind,
            fixed_below_x: min.x + FIXED * length,
            moved_above_x,
            axis: end.iter().copied().sum::<Point>() / end.len().max(1) as f64,
        }
    }

    /// Whether a rest position belongs to the fixed end.
    pub(crate) fn is_fixed(&self, p: &Point) -> bool {
        p.x < self.fixed_below_x
    }

    /// Whether it belongs to the end that is moved.
    pub(crate) fn is_moved(&self, p: &Point) -> bool {
        self.kind != Kind::Sag && p.x > self.moved_above_x
    }

    /// Whether a rest position's displacement is prescribed.
    pub(crate) fn is_held(&self, p: &Point) -> bool {
        self.is_fixed(p) || self.is_moved(p)
    }

    /// Its displacement at a share of the load, m.
    pub(crate) fn motion(&self, p: &Point, share: f64) -> Point {
        if !self.is_moved(p) {
            return Point::zeros();
        }
        match self.kind {
            Kind::Sag => Point::zeros(),
            Kind::Pull => Point::new(1.0, 0.0, 2.5).normalize() * (0.03 * share),
            Kind::Twist => {
                let angle = std::f64::consts::FRAC_PI_2 * share;
                let arm = p - self.axis;
                Rotation3::from_axis_angle(&Vector3::x_axis(), angle) * arm - arm
            }
        }
    }

    /// Gravity, m/s².
    pub(crate) fn gravity(&self) -> Point {
        match self.kind {
            Kind::Sag => Point::new(0.0, 0.0, -9.81),
            _ => Point::zeros(),
        }
    }

    /// The scene's force from the tissue's pull on every held point (rest position, displacement,
    /// force): newtons at the fixed end (sag) or the moved one, newton metres for the twist.
    pub(crate) fn load(&self, pulls: impl Iterator<Item = (Point, Point, Point)>) -> f64 {
        let mut total = Point::zeros();
        for (x, u, force) in pulls {
            match self.kind {
                Kind::Sag if self.is_fixed(&x) => total += force,
                Kind::Pull if self.is_moved(&x) => total += force,
                Kind::Twist if self.is_moved(&x) => {
                    total.x += (x + u - self.axis).cross(&force).x;
                }
                _ => {}
            }
        }
        total.norm()
    }
}
