//! Cases: the tool, the organ and the site.

use fem_reference::Bar;
use nalgebra::{Rotation3, Vector3};
use scene_prepare::mesh::Mesh;
use scene_prepare::shape::{Form, Shape};

use crate::organ::Organ;

type Point = Vector3<f64>;

/// A body that is pressed, of the same tissue all.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Subject {
    /// The smooth liver of `evaluate accuracy`.
    Liver,
    /// The product's gallbladder, laid down: fundus at −x, neck at +x.
    Gallbladder,
    /// The product's stomach.
    Stomach,
}

impl Subject {
    /// Its name in files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Liver => "liver",
            Self::Gallbladder => "gallbladder",
            Self::Stomach => "stomach",
        }
    }

    /// Its surface, m.
    ///
    /// # Errors
    /// In words.
    pub(crate) fn mesh(self) -> Result<Mesh, String> {
        match self {
            Self::Liver => Organ::Liver.mesh(),
            Self::Gallbladder => {
                // From fundus to neck.
                let lies = Point::new(0.030, 0.044, -0.057);
                let turn = Rotation3::rotation_between(&lies, &Point::x());
                Ok(placed(Form::Gallbladder, &turn.unwrap_or_default()))
            }
            Self::Stomach => Ok(placed(Form::Stomach, &Rotation3::identity())),
        }
    }
}

/// Turned, its middle at the origin.
fn placed(form: Form, turn: &Rotation3<f64>) -> Mesh {
    let mut mesh = Shape::from(form).mesh();
    for p in &mut mesh.vertices {
        *p = turn * *p;
    }
    let [min, max] = mesh.bounds();
    for p in &mut mesh.vertices {
        *p -= (min + max) / 2.0;
    }
    mesh
}

/// A place on a body, and what holds the body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Site {
    /// The body.
    pub(crate) subject: Subject,
    /// Its name in files.
    pub(crate) name: &'static str,
    /// The tool looks from here …
    from: [f64; 3],
    /// … at this point, and meets the surface on the way, m.
    at_m: [f64; 3],
    /// Tissue is held below this place along this axis, m.
    pub(crate) held_below: (usize, f64),
    /// A constant of the contact law was once chosen here.
    pub(crate) seen: bool,
}

impl Site {
    /// True if both are the same.
    pub(crate) fn is(&self, other: &Self) -> bool {
        (self.subject, self.name) == (other.subject, other.name)
    }
}

const fn site(
    subject: Subject,
    name: &'static str,
    from: [f64; 3],
    at_m: [f64; 3],
    held_below: (usize, f64),
) -> Site {
    Site {
        subject,
        name,
        from,
        at_m,
        held_below,
        seen: false,
    }
}

const TOP: [f64; 3] = [0.0, 0.0, 1.0];
const RIGHT_LOBE: Site = Site {
    seen: true,
    ..site(
        Subject::Liver,
        "right lobe",
        TOP,
        [-0.030, 0.0, 0.0],
        (2, -0.020),
    )
};
const LEFT_LOBE: Site = site(
    Subject::Liver,
    "left lobe",
    TOP,
    [0.055, 0.004, 0.0],
    (2, -0.010),
);
/// A rim of 16 mm radius.
const RIM: Site = site(
    Subject::Liver,
    "upper rim",
    [0.0, 1.0, 0.0],
    [0.055, 0.0, 0.004],
    (1, 0.0),
);
/// The left lobe's end, nothing below it.
const LOBE_END: Site = site(
    Subject::Liver,
    "free lobe",
    TOP,
    [0.090, 0.008, 0.0],
    (0, 0.055),
);
const BODY: Site = site(
    Subject::Gallbladder,
    "body",
    TOP,
    [-0.012, 0.0, 0.0],
    (2, -0.008),
);
const NECK: Site = Site {
    seen: true,
    ..site(
        Subject::Gallbladder,
        "neck",
        TOP,
        [0.018, 0.0, 0.0],
        (2, -0.006),
    )
};
/// Held by its middle: a plane 10 mm lower takes a few millimetres off the fundus, and there finite
/// elements are held while spheres, whose centres lie half a spacing under the skin, are not.
const WALL: Site = site(Subject::Stomach, "front", TOP, [0.0, 0.0, 0.0], (2, 0.0));

/// A rigid tool. Sizes are radii.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shaped {
    /// A round bar of this radius, mm, its round end first.
    Tip(f64),
    /// The instruments' shaft, on its side.
    Shaft,
    /// Closed jaws, flat.
    Jaws,
    /// Open jaws, their two ends first.
    OpenJaws,
    /// Two round ends of 5 mm radius, 25 mm apart.
    TwoTips,
}

/// A bar is looked at in so many places and one more.
const PLACES: u32 = 160;
/// Length of a bar outside the body, m.
const LENGTH_M: f64 = 0.08;
const SHAFT_RADIUS_M: f64 = 0.0025;
const JAW_RADIUS_M: f64 = 0.0015;
const JAW_M: f64 = 0.020;
/// Half the distance of the ends of open jaws, m.
const OPEN_M: f64 = 0.006;
const APART_M: f64 = 0.0125;

impl Shaped {
    /// Its name in files.
    pub(crate) fn name(self) -> String {
        match self {
            Self::Tip(mm) => format!("tip {mm:.0} mm"),
            Self::Shaft => "shaft, sideways".to_owned(),
            Self::Jaws => "closed jaws, flat".to_owned(),
            Self::OpenJaws => "open jaws, ends".to_owned(),
            Self::TwoTips => "two tips 5 mm".to_owned(),
        }
    }

    /// Radius of its parts, m.
    pub(crate) fn radius_m(self) -> f64 {
        match self {
            Self::Tip(mm) => mm * 1e-3,
            Self::Shaft => SHAFT_RADIUS_M,
            Self::Jaws | Self::OpenJaws => JAW_RADIUS_M,
            Self::TwoTips => 0.005,
        }
    }

    /// True if it touches at two places.
    pub(crate) fn has_two_ends(self) -> bool {
        matches!(self, Self::OpenJaws | Self::TwoTips)
    }

    /// Length that scales the region of small elements, m: the mean of a tip's radius and another
    /// length. Around the line of jaws or a shaft it is the radius.
    pub(crate) fn mean_m(self, other_m: f64) -> f64 {
        match self {
            Self::Shaft | Self::Jaws | Self::OpenJaws => self.radius_m(),
            Self::Tip(_) | Self::TwoTips => (self.radius_m() * other_m).sqrt(),
        }
    }
}

/// A tool at a site.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Case {
    /// Site of the press.
    pub(crate) site: Site,
    /// With what.
    pub(crate) tool: Shaped,
}

/// First contact of a tool, and its orientation there.
#[derive(Debug, Clone)]
pub(crate) struct Placed {
    /// The site on the surface, m.
    pub(crate) at_m: Point,
    /// Out of the body.
    pub(crate) outward: Point,
    /// Along the surface.
    pub(crate) along: Point,
    /// Its parts where they touch, m; the free end of each first.
    pub(crate) bars: Vec<Bar>,
    /// Along the line on which it touches, of length 1.
    pub(crate) line: Point,
}

impl Placed {
    /// Half the length of the line on which it touches at a depth, m; 0 of one round end.
    /// `distance_m` is the signed distance to the body's surface.
    pub(crate) fn half_m(&self, depth_m: f64, distance_m: impl Fn(&Point) -> f64) -> f64 {
        let touches = |bar: &Bar| {
            let [a, b] = bar.ends_m;
            let places =
                (0..=PLACES).map(move |i| a + (b - a) * (f64::from(i) / f64::from(PLACES)));
            let radius_m = bar.radius_m;
            let sunk = places.filter(|p| distance_m(&(p - self.outward * depth_m)) < radius_m);
            sunk.map(|p| (p - self.at_m).dot(&self.line).abs())
                .fold(0.0, f64::max)
        };
        self.bars.iter().map(touches).fold(0.0, f64::max)
    }
}

impl Case {
    /// All, those whose reference is dear last.
    pub(crate) fn all() -> Vec<Self> {
        let sites = [RIGHT_LOBE, LEFT_LOBE, RIM, LOBE_END, BODY, WALL];
        let with = |mm: f64| sites.map(|site| (site, Shaped::Tip(mm)));
        let others = [
            (NECK, Shaped::Tip(5.0)),
            (LEFT_LOBE, Shaped::Shaft),
            (WALL, Shaped::Shaft),
            (LEFT_LOBE, Shaped::TwoTips),
            (LEFT_LOBE, Shaped::Jaws),
            (LEFT_LOBE, Shaped::OpenJaws),
            (BODY, Shaped::Jaws),
            (BODY, Shaped::OpenJaws),
            (NECK, Shaped::Tip(3.0)),
        ];
        let all = [with(5.0), with(10.0)].concat().into_iter();
        let all = all.chain(others).chain(with(3.0));
        all.map(|(site, tool)| Self { site, tool }).collect()
    }

    /// Its name in files.
    pub(crate) fn name(&self) -> String {
        let site = &self.site;
        format!(
            "{} {}: {}",
            site.subject.name(),
            site.name,
            self.tool.name()
        )
    }

    /// The tool where it touches the body.
    ///
    /// # Errors
    /// Where it meets nothing, in words.
    pub(crate) fn placed(&self, mesh: &Mesh) -> Result<Placed, String> {
        let from = Point::from(self.site.from);
        let (at_m, outward) = meet(mesh, &self.site.at_m.into(), &from)
            .ok_or_else(|| format!("{}: nothing there", self.name()))?;
        // The axis of the world that lies flattest: along it bars lie.
        let along = [Point::x(), Point::y(), Point::z()]
            .map(|axis| axis - outward * axis.dot(&outward))
            .into_iter()
            .enumerate()
            .filter(|(i, _)| from[*i] == 0.0)
            .max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()));
        let along = along.map_or_else(Point::x, |(_, axis)| axis.normalize());
        let across = outward.cross(&along);
        let radius_m = self.tool.radius_m();
        let low = at_m + outward * radius_m;
        let bar = |a: Point, b: Point| Bar {
            ends_m: [a, b],
            radius_m,
        };
        let up = |end: Point| bar(end, end + outward * LENGTH_M);
        let bars = match self.tool {
            Shaped::Tip(_) => vec![up(low)],
            Shaped::TwoTips => [1.0, -1.0].map(|s| up(low + along * (s * APART_M))).into(),
            Shaped::Shaft => vec![bar(low - along * LENGTH_M, low + along * LENGTH_M)],
            Shaped::Jaws => {
                let joint = low - along * (JAW_M / 2.0);
                let end = |side: f64| joint + along * JAW_M + across * (side * 0.001);
                [1.0, -1.0].map(|s| bar(end(s), joint)).into()
            }
            Shaped::OpenJaws => {
                let joint = low + outward * JAW_M;
                let end = |side: f64| low + across * (side * OPEN_M);
                [1.0, -1.0].map(|s| bar(end(s), joint)).into()
            }
        };
        Ok(Placed {
            at_m,
            outward,
            along,
            bars,
            line: match self.tool {
                Shaped::OpenJaws => across,
                _ => along,
            },
        })
    }
}

/// Point at which a line along `from` through `at` leaves the body, and the smoothed normal there.
fn meet(mesh: &Mesh, at: &Point, from: &Point) -> Option<(Point, Point)> {
    let normals = mesh.vertex_normals();
    let mut found: Option<(f64, Point)> = None;
    for t in &mesh.triangles {
        let [a, b, c] = mesh.corners(*t);
        let area = (b - a).cross(&(c - a)).dot(from);
        if area <= 0.0 {
            continue;
        }
        let share = |p: &Point, q: &Point| (q - p).cross(&(at - p)).dot(from) / area;
        let shares = [share(&b, &c), share(&c, &a), share(&a, &b)];
        if shares.iter().any(|s| *s < 0.0) {
            continue;
        }
        let blend = |v: [Point; 3]| v[0] * shares[0] + v[1] * shares[1] + v[2] * shares[2];
        let height = (blend([a, b, c]) - at).dot(from);
        if found.is_none_or(|(h, _)| height > h) {
            found = Some((height, blend(t.map(|i| normals[i as usize])).normalize()));
        }
    }
    found.map(|(height, normal)| (at + from * height, normal))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_as_long_as_what_it_touches() {
        for case in Case::all() {
            let placed = case.placed(&case.site.subject.mesh().expect("built in"));
            let placed = placed.expect("a place");
            // On a cylinder that lies across the line.
            let round_m = 0.030;
            let axis = placed.outward.cross(&placed.line);
            let distance_m = |p: &Point| {
                let arm = p - placed.at_m + placed.outward * round_m;
                (arm - axis * axis.dot(&arm)).norm() - round_m
            };
            let half_m = placed.half_m(0.008, distance_m);
            let expected_m = match case.tool {
                Shaped::Tip(_) => 0.0,
                Shaped::Jaws => 0.010,
                Shaped::OpenJaws => 0.006,
                Shaped::TwoTips => 0.0125,
                // Its axis stands 2.5 mm over the top and goes down 8 mm.
                Shaped::Shaft => (0.0325_f64.powi(2) - 0.0245_f64.powi(2)).sqrt(),
            };
            assert!(
                (half_m - expected_m).abs() < 1.1e-3,
                "{}: {half_m} {expected_m}",
                case.name()
            );
        }
    }

    #[test]
    fn every_tool_touches_where_it_is_put() {
        for case in Case::all() {
            let mesh = case.site.subject.mesh().expect("built in");
            let placed = case.placed(&mesh).expect("a place");
            let nearest = scene_prepare::field::Nearest::new(&mesh).expect("triangles");
            assert!(nearest.distance(&placed.at_m) < 1e-6, "{}", case.name());
            let inside = |bar: &Bar| {
                let ends = bar.ends_m.iter();
                let gap = ends.map(|p| nearest.distance(p) - bar.radius_m);
                gap.fold(f64::MAX, f64::min)
            };
            let least = placed.bars.iter().map(inside).fold(f64::MAX, f64::min);
            assert!(least > -2e-3, "{}: {least}", case.name());
            let (axis, plane) = case.site.held_below;
            assert!(placed.at_m[axis] > plane + 0.006, "{}", case.name());
        }
    }
}
