//! Experiments on an organ. Holds and loads are equal for the reference and for every method.

use nalgebra::{Rotation3, Unit, Vector3};
use scene_prepare::held::Plane;
use scene_prepare::mesh::Mesh;

type Point = Vector3<f64>;

/// Hold on a sphere.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Held {
    /// No hold.
    Free,
    /// Held in place, at the scene's fixed end.
    Fixed,
    /// Moved with the scene's moved end.
    Moved,
}

/// Kind of experiment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// One end is fixed, and the rest sags under gravity perpendicular to the axis. Dimensionless
    /// settings are calibrated on this scene.
    Sag,
    /// One end is fixed, and the other is moved by 30 mm, mostly perpendicular to the axis.
    Pull,
    /// One end is fixed, and the other is rotated about the long axis by this angle, degrees.
    Twist(u16),
    /// The lower part is fixed. A rigid frictionless ball of this diameter (mm) is pressed by its
    /// radius into the top, at one of [`SITES`].
    Press(u8, u8),
}

/// Sites of a press, as shares of the organ's length and width.
const SITES: [[f64; 2]; 3] = [[0.25, 0.50], [0.50, 0.60], [0.75, 0.55]];

impl Kind {
    /// Name of the experiment in files.
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

    /// End of the fixed part and beginning of the moved part, as shares of the extent along the
    /// axis.
    fn planes(self) -> [f64; 2] {
        match self {
            Self::Sag => [0.58, 1.0],
            Self::Pull => [0.35, 0.88],
            // With a shorter free part, half a turn would fold the tissue onto itself.
            Self::Twist(180) => [0.12, 0.90],
            Self::Twist(_) => [0.25, 0.77],
            // The fixed part is the lower one. There is no upper plane.
            Self::Press(..) => [0.35, 1.0],
        }
    }

    /// True if the organ's far end is moved.
    const fn moves(self) -> bool {
        matches!(self, Self::Pull | Self::Twist(_))
    }
}

/// An experiment on one organ. One or two planes are perpendicular to the axis; tissue beyond them
/// is held.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scene {
    /// Kind of experiment.
    pub(crate) kind: Kind,
    /// Index of the axis: the longest one or, for a press, the vertical.
    pub(crate) axis: usize,
    /// Coordinate along the axis up to which the organ is fixed, m.
    pub(crate) fixed_below_m: f64,
    /// Coordinate along the axis beyond which the organ is moved, m. Without a moved end, the
    /// coordinate of the organ's end.
    pub(crate) free_below_m: f64,
    /// The pressing ball, if any.
    pub(crate) press: Option<Press>,
    pivot: Point,
}

/// A ball, with the site and direction of its press.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Press {
    /// Point on the organ's surface, m.
    pub(crate) site_m: Point,
    /// Outward normal of the surface at the site.
    outward: Point,
    /// Radius of the ball, m.
    pub(crate) radius_m: f64,
}

impl Press {
    /// Places the ball on top of the surface, at these shares of the organ's length and width.
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

    /// Centre of the ball at a share of its path, m. At the start, the ball just touches the
    /// surface.
    pub(crate) fn center_m(&self, share: f64) -> Point {
        self.site_m + self.outward * (self.radius_m * (1.0 - share))
    }
}

/// Positions that differ by less than this along the axis count as equal, m.
const SAME_M: f64 = 1e-7;
/// [`SAME_M`] for positions that were rounded to single precision, m.
const NEAR_M: f64 = 1e-6;

impl Scene {
    /// Makes the experiment for an organ with this surface.
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

    /// Hold at a rest position that was rounded to single precision.
    pub(crate) fn held(&self, p: &Point) -> Held {
        if p[self.axis] < self.fixed_below_m + NEAR_M {
            Held::Fixed
        } else if self.kind.moves() && p[self.axis] > self.free_below_m - NEAR_M {
            Held::Moved
        } else {
            Held::Free
        }
    }

    /// Hold of the plane that is nearest to a position.
    pub(crate) fn nearest_hold(&self, p: &Point) -> Held {
        let middle_m = (self.fixed_below_m + self.free_below_m) / 2.0;
        if self.kind.moves() && p[self.axis] > middle_m {
            Held::Moved
        } else {
            Held::Fixed
        }
    }

    /// The planes beyond which tissue is held.
    pub(crate) fn planes(&self) -> Vec<Plane> {
        let axis = Point::ith(self.axis, 1.0);
        let plane = |height_m: f64, normal: Point| Plane {
            point_m: axis * height_m,
            normal,
        };
        let mut planes = vec![plane(self.fixed_below_m, -axis)];
        if self.kind.moves() {
            planes.push(plane(self.free_below_m, axis));
        }
        planes
    }

    /// Displacement of a rest position of the moved end at a share of the load, m.
    pub(crate) fn motion(&self, p: &Point, share: f64) -> Point {
        let mut along = Point::zeros();
        along[self.axis] = 1.0;
        match self.kind {
            Kind::Sag | Kind::Press(..) => Point::zeros(),
            Kind::Pull => {
                let mut across = Point::zeros();
                // Upwards; forwards if the organ's axis is vertical.
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

    /// Course of the moved end: its shift at full load, m, its turn (axis times angle, rad) and the
    /// point about which it turns, m.
    pub(crate) fn course(&self) -> [Point; 3] {
        let shift = match self.kind {
            Kind::Pull => self.motion(&self.pivot, 1.0),
            _ => Point::zeros(),
        };
        let turn = match self.kind {
            Kind::Twist(degrees) => Point::ith(self.axis, f64::from(degrees).to_radians()),
            _ => Point::zeros(),
        };
        [shift, turn, self.pivot]
    }

    /// Gravity, m/s²; zero except for a sag.
    pub(crate) fn gravity(&self) -> Point {
        let mut down = Point::zeros();
        if self.kind == Kind::Sag {
            down[if self.axis == 2 { 1 } else { 2 }] = -9.81;
        }
        down
    }

    /// The scene's load, computed from the tissue's force on every held point. An item is: true for
    /// the moved end, rest position, displacement, force. The load is the force at the fixed end
    /// (sag) or at the moved end (pull), N, or the torque about the axis (twist), N m.
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
