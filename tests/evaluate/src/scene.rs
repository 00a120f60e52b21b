//! Load on the organ, shared by the reference and every method.

use nalgebra::{Rotation3, Unit, Vector3};
use scene_prepare::mesh::Mesh;

type Point = Vector3<f64>;

/// Hold on a sphere.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Held {
    /// Nothing.
    Free,
    /// The scene's fixed end.
    Fixed,
    /// The end that the scene moves.
    Moved,
}

/// Kind of experiment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Hangs from one end under gravity. The scene on which dimensionless settings are calibrated.
    Sag,
    /// One end fixed, the other grasped and moved by 30 mm.
    Pull,
    /// One end fixed, the other turned about the long axis, degrees.
    Twist(u16),
    /// The lower part fixed, a rigid frictionless ball of this diameter (mm) pressed by its radius
    /// into the top at one of [`SITES`].
    Press(u8, u8),
}

/// Places at which a ball is pressed in, as shares of the organ's length and width.
const SITES: [[f64; 2]; 3] = [[0.25, 0.50], [0.50, 0.60], [0.75, 0.55]];

impl Kind {
    /// Its name in files.
    pub(crate) fn name(self) -> String {
        match self {
            Self::Sag => "sag".to_owned(),
            Self::Pull => "pull 30 mm".to_owned(),
            Self::Twist(degrees) => format!("twist {degrees}°"),
            Self::Press(diameter_mm, site) => {
                format!("press, {diameter_mm} mm ball, site {}", site + 1)
            }
        }
    }

    /// End of the fixed part and beginning of the moved one, as shares of the length.
    fn planes(self) -> [f64; 2] {
        match self {
            Self::Sag => [0.58, 1.0],
            Self::Pull => [0.35, 0.88],
            // Within less of its length a half turn folds the tissue onto itself.
            Self::Twist(180) => [0.12, 0.90],
            Self::Twist(_) => [0.25, 0.77],
            // From below; there is no upper plane.
            Self::Press(..) => [0.35, 1.0],
        }
    }

    /// True if the organ's far end is moved.
    const fn moves(self) -> bool {
        matches!(self, Self::Pull | Self::Twist(_))
    }
}

/// An experiment on one organ. Both planes lie across the organ's longest axis; tissue beyond
/// them is held.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scene {
    /// Kind of experiment.
    pub(crate) kind: Kind,
    /// Number of the long axis.
    pub(crate) axis: usize,
    /// Up to here the organ is fixed, m.
    pub(crate) fixed_below_m: f64,
    /// From here on it is moved, or it ends, m.
    pub(crate) free_below_m: f64,
    /// The ball that presses.
    pub(crate) press: Option<Press>,
    pivot: Point,
}

/// A ball and where it presses.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Press {
    /// Place on the organ's surface, m.
    pub(crate) site_m: Point,
    /// Its outward normal.
    outward: Point,
    /// Radius of the ball, m.
    pub(crate) radius_m: f64,
}

impl Press {
    /// The highest point of the organ above a place, and the surface's normal there.
    fn new(mesh: &Mesh, diameter_mm: u8, [x, y]: [f64; 2]) -> Self {
        let [min, max] = mesh.bounds();
        let place = min + (max - min).component_mul(&Point::new(x, y, 1.0));
        let mut press = Self {
            site_m: place,
            outward: Point::z(),
            radius_m: f64::from(diameter_mm) * 0.5e-3,
        };
        let mut highest = f64::NEG_INFINITY;
        for triangle in &mesh.triangles {
            let [a, b, c] = mesh.corners(*triangle);
            let normal = (b - a).cross(&(c - a));
            let side = |p: Point, q: Point| (q - p).cross(&(place - p)).z;
            let over = side(a, b) >= 0.0 && side(b, c) >= 0.0 && side(c, a) >= 0.0;
            if normal.z > 0.0 && over {
                let z = a.z - ((place - a).xy().dot(&normal.xy())) / normal.z;
                if z > highest {
                    highest = z;
                    press.site_m.z = z;
                    press.outward = normal.normalize();
                }
            }
        }
        press
    }

    /// Centre of the ball at a share of its way, m: it starts where it touches.
    pub(crate) fn center_m(&self, share: f64) -> Point {
        self.site_m + self.outward * (self.radius_m * (1.0 - share))
    }
}

/// Two positions this near along the axis are the same, m.
const SAME_M: f64 = 1e-7;

impl Scene {
    /// On an organ.
    pub(crate) fn new(kind: Kind, mesh: &Mesh) -> Self {
        let [min, max] = mesh.bounds();
        let press = match kind {
            Kind::Press(diameter_mm, site) => {
                let site = SITES[usize::from(site) % SITES.len()];
                Some(Press::new(mesh, diameter_mm, site))
            }
            _ => None,
        };
        let axis = if press.is_some() {
            2
        } else {
            (max - min).imax()
        };
        let at = |share: f64| min[axis] + share * (max[axis] - min[axis]);
        let [fixed_below_m, free_below_m] = kind.planes().map(at);
        let beyond = |p: &&Point| p[axis] > free_below_m;
        let end: Vec<_> = mesh.vertices.iter().filter(beyond).collect();
        Self {
            kind,
            axis,
            fixed_below_m,
            free_below_m,
            press,
            pivot: end.iter().copied().sum::<Point>() / end.len().max(1) as f64,
        }
    }

    /// True if a rest position belongs to the fixed end.
    pub(crate) fn is_fixed(&self, p: &Point) -> bool {
        p[self.axis] < self.fixed_below_m + SAME_M
    }

    /// True if a rest position belongs to the moved end.
    pub(crate) fn is_moved(&self, p: &Point) -> bool {
        self.kind.moves() && p[self.axis] > self.free_below_m - SAME_M
    }

    /// Hold on a position, if tissue up to this far beyond the planes is held too, m.
    pub(crate) fn held(&self, p: &Point, reach_m: f64) -> Held {
        let along = p[self.axis];
        if along < self.fixed_below_m + reach_m + 1e-6 {
            Held::Fixed
        } else if self.kind.moves() && along > self.free_below_m - reach_m - 1e-6 {
            Held::Moved
        } else {
            Held::Free
        }
    }

    /// Displacement of a held position at a share of the load, m: zero at the fixed end.
    pub(crate) fn motion(&self, p: &Point, share: f64) -> Point {
        let mut along = Point::zeros();
        along[self.axis] = 1.0;
        match self.kind {
            Kind::Sag | Kind::Press(..) => Point::zeros(),
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
