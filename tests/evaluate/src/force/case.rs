//! Cases: a tool at a site of an organ.

use fem_reference::Bar;
use nalgebra::{Rotation3, Vector3};
use scene_prepare::mesh::Mesh;
use scene_prepare::shape::{Form, Shape};

use crate::organ::Organ;

type Point = Vector3<f64>;

/// A body that is pressed. All bodies are of the same tissue.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Subject {
    /// The smooth liver of `evaluate accuracy`.
    Liver,
    /// Calot's built-in gallbladder, rotated so that it lies along x: fundus at −x, neck at +x.
    Gallbladder,
    /// Calot's built-in stomach.
    Stomach,
}

impl Subject {
    /// Name of the body in files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Liver => "liver",
            Self::Gallbladder => "gallbladder",
            Self::Stomach => "stomach",
        }
    }

    /// Surface of the body, m.
    ///
    /// # Errors
    /// The reason in words.
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

/// Mesh of a form, rotated and with its middle at the origin.
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

/// A place on a body, and the part of the body that is held.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Site {
    /// The body.
    pub(crate) subject: Subject,
    /// Name of the site in files.
    pub(crate) name: &'static str,
    /// Direction from which the tool comes.
    from: [f64; 3],
    /// Point inside the body, m. The tool meets the surface on its way to this point.
    at_m: [f64; 3],
    /// An axis and a coordinate on it, m. Tissue below this coordinate is held.
    pub(crate) held_below: (usize, f64),
    /// True if a constant of the contact law was once chosen at this site.
    pub(crate) seen: bool,
}

impl Site {
    /// True if both are the same site.
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
/// The left lobe's end, which is not supported from below.
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
/// The stomach is held up to its middle. With a plane 10 mm lower, a few millimetres of the fundus
/// would lie below it. Finite elements would be held there, but no spheres, because their centres
/// lie half a spacing under the skin.
const WALL: Site = site(Subject::Stomach, "front", TOP, [0.0, 0.0, 0.0], (2, 0.0));

/// A rigid tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Shaped {
    /// The round end of a bar of this radius, mm.
    Tip(f64),
    /// The instruments' shaft, pressed sideways.
    Shaft,
    /// Closed jaws that lie flat.
    Jaws,
    /// The two ends of open jaws.
    OpenJaws,
    /// Two round ends of 5 mm radius, 25 mm apart.
    TwoTips,
}

/// Number of intervals into which a bar's axis is divided for tests.
const PLACES: u32 = 160;
/// Length of a bar outside the body, m.
const LENGTH_M: f64 = 0.08;
const SHAFT_RADIUS_M: f64 = 0.0025;
const JAW_RADIUS_M: f64 = 0.0015;
const JAW_M: f64 = 0.020;
/// Half the distance between the ends of open jaws, m.
const OPEN_M: f64 = 0.006;
const APART_M: f64 = 0.0125;

impl Shaped {
    /// Name of the tool in files.
    pub(crate) fn name(self) -> String {
        match self {
            Self::Tip(mm) => format!("tip {mm:.0} mm"),
            Self::Shaft => "shaft, sideways".to_owned(),
            Self::Jaws => "closed jaws, flat".to_owned(),
            Self::OpenJaws => "open jaws, ends".to_owned(),
            Self::TwoTips => "two tips 5 mm".to_owned(),
        }
    }

    /// Radius of the tool's parts, m.
    pub(crate) fn radius_m(self) -> f64 {
        match self {
            Self::Tip(mm) => mm * 1e-3,
            Self::Shaft => SHAFT_RADIUS_M,
            Self::Jaws | Self::OpenJaws => JAW_RADIUS_M,
            Self::TwoTips => 0.005,
        }
    }
}

/// Distance of the port from the first point of contact, along the tool's axis, m. It is a usual
/// length of the shaft inside the body.
pub(crate) const PORT_M: f64 = 0.150;

/// A tool at a site.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Case {
    /// Site that is pressed.
    pub(crate) site: Site,
    /// Tool that presses.
    pub(crate) tool: Shaped,
}

/// A tool at its first contact.
#[derive(Debug, Clone)]
pub(crate) struct Placed {
    /// The site, a point of the surface, m.
    pub(crate) at_m: Point,
    /// Unit vector out of the body.
    pub(crate) outward: Point,
    /// Unit vector along the surface.
    pub(crate) along: Point,
    /// The tool's parts at first contact, m. In each part the end that touches comes first.
    pub(crate) bars: Vec<Bar>,
    /// Unit vector along the line on which the tool touches.
    pub(crate) line: Point,
    /// The tool's port at first contact: a point of its axis, [`PORT_M`] behind the site, m.
    pub(crate) port_m: Point,
}

impl Placed {
    /// Unit vectors out of the body, along the surface, and across both.
    pub(crate) fn axes(&self) -> [Point; 3] {
        let across = self.outward.cross(&self.along);
        [self.outward, self.along, across]
    }

    /// The port as seen from the site, in [`Self::axes`], m.
    pub(crate) fn port_from_site_m(&self) -> Point {
        let arm_m = self.port_m - self.at_m;
        Point::from(self.axes().map(|axis| axis.dot(&arm_m)))
    }

    /// Lines near the surface on which the tool touches; their total length is `2 half_m`. A
    /// contact at a point is a line with equal ends.
    pub(crate) fn lines(&self, tool: Shaped, half_m: f64) -> Vec<[Point; 2]> {
        let at = |share: f64| self.at_m + self.line * (share * half_m);
        match tool {
            Shaped::Tip(_) => vec![[self.at_m; 2]],
            Shaped::TwoTips | Shaped::OpenJaws => vec![[at(1.0); 2], [at(-1.0); 2]],
            // The surface is curved, so the line is divided into pieces.
            Shaped::Shaft | Shaped::Jaws => (-3..3)
                .map(|i| [f64::from(i) / 3.0, f64::from(i + 1) / 3.0].map(at))
                .collect(),
        }
    }

    /// Half the length of the line on which the tool touches at a depth, m; 0 for one round end.
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
    /// All cases. Those whose references take longest come last.
    pub(crate) fn all() -> Vec<Self> {
        let sites = [RIGHT_LOBE, LEFT_LOBE, RIM, LOBE_END, BODY, WALL];
        let with = |mm: f64| sites.map(|site| (site, Shaped::Tip(mm)));
        let others = [
            (NECK, Shaped::Tip(5.0)),
            (LEFT_LOBE, Shaped::Shaft),
            (WALL, Shaped::Shaft),
            // The lobe ends under the shaft, so the shaft touches beside its middle.
            (LOBE_END, Shaped::Shaft),
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

    /// Name of the case in files.
    pub(crate) fn name(&self) -> String {
        let site = &self.site;
        format!(
            "{} {}: {}",
            site.subject.name(),
            site.name,
            self.tool.name()
        )
    }

    /// Places the tool where it touches the body.
    ///
    /// # Errors
    /// When the tool meets nothing, in words.
    pub(crate) fn placed(&self, mesh: &Mesh) -> Result<Placed, String> {
        let from = Point::from(self.site.from);
        let (at_m, outward) = meet(mesh, &self.site.at_m.into(), &from)
            .ok_or_else(|| format!("{}: the tool meets no surface there", self.name()))?;
        // Bars lie along the world axis that is nearest to the surface's tangent plane.
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
            port_m: match self.tool {
                Shaped::Tip(_) | Shaped::TwoTips | Shaped::OpenJaws => low + outward * PORT_M,
                Shaped::Shaft | Shaped::Jaws => low - along * PORT_M,
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
            // The surface is a cylinder that lies across the line.
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
                // The shaft's axis is 2.5 mm above the top and goes down by 8 mm.
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
