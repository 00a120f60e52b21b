//! Presses on Calot's tissue with Calot's contact law, and with two simpler laws for comparison.
//! The simpler laws are implemented only here.

use nalgebra::Vector3;
use rt_core::study::{Correction, Tissue};
use rt_core::time::TICK_S;
use rt_core::tool::{Capsule, Role};
use scene_prepare::held::Plane;
use scene_prepare::mesh::Mesh;
use scene_prepare::skin::ContactSkin;

use super::case::{Placed, Site};
use super::curve::DEPTHS_MM;
use super::wrench::Wrench;
use crate::body::{self, Body, V3};
use crate::methods::{Parts, Surroundings};
use crate::prepared::prepared;

type Point = Vector3<f64>;

/// Law of contact between tissue and tool.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Law {
    /// Calot's contact law.
    Ours,
    /// Each inner sphere pushes through a spring of 500 N/m, as in earlier versions of Calot.
    Spheres,
    /// Contact at the vertices of the contact skin has no compliance, and the force is the
    /// constraint's multiplier.
    RigidSkin,
}

impl Law {
    /// All laws.
    pub(crate) const ALL: [Self; 3] = [Self::Ours, Self::Spheres, Self::RigidSkin];

    /// Name of the law in files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Ours => "Calot",
            Self::Spheres => "spheres",
            Self::RigidSkin => "rigid skin",
        }
    }
}

/// Speed of a press, m/s.
const SPEED_M_S: f64 = 0.010;
const TICKS_PER_MM: usize = 100;
/// Longest rest at a depth, ticks.
const REST_TICKS: usize = 600;
/// A rest ends when the mean force over 50 ticks differs by less than this from the previous mean,
/// N.
const STILL_N: f64 = 2e-5;
/// Stiffness of [`Law::Spheres`], N/m.
const SPHERE_N_M: f32 = 500.0;

/// An organ of spheres, ready to be pressed.
pub(crate) struct Rig {
    body: Body,
    parts: Parts,
    skin: ContactSkin,
}

impl Rig {
    /// Packs a surface with this many spheres. Spheres below the site's plane are held.
    ///
    /// # Errors
    /// The reason in words.
    pub(crate) fn new(mesh: &Mesh, spheres: usize, site: &Site) -> Result<Self, String> {
        let tissue = body::Tissue::LIVER;
        let (axis, plane_m) = site.held_below;
        let axis = Point::ith(axis, 1.0);
        let plane = Plane {
            point_m: axis * plane_m,
            normal: -axis,
        };
        let (body, skin) = prepared(mesh, spheres, tissue, &[plane])?;
        let around = Surroundings::weightless(&tissue);
        let parts = Parts::new(&body, &around, None).map_err(|e| e.to_string())?;
        Ok(Self {
            body,
            parts: parts.with_skin(skin.clone()),
            skin,
        })
    }

    /// Number of spheres.
    pub(crate) fn spheres(&self) -> usize {
        self.body.rest_m.len()
    }

    /// The organ at rest.
    fn at_rest(&mut self) -> Result<Run<'_>, String> {
        Ok(Run {
            tissue: self.parts.bare().map_err(|e| e.to_string())?,
            body: &self.body,
            skin: &self.skin,
        })
    }

    /// Presses the tool, and returns force and torque at the first depths of [`DEPTHS_MM`].
    ///
    /// # Errors
    /// The reason in words.
    pub(crate) fn press(
        &mut self,
        placed: &Placed,
        law: Law,
        depths: usize,
    ) -> Result<Vec<Wrench>, String> {
        let mut run = self.at_rest()?;
        let mut at_m = 0.0;
        let mut wrenches = Vec::new();
        for depth in DEPTHS_MM.iter().take(depths) {
            let from_m = at_m;
            at_m = depth * 1e-3;
            let ticks = ((at_m - from_m) * 1e3 * TICKS_PER_MM as f64).round() as usize;
            for i in 1..=ticks {
                let now_m = from_m + (at_m - from_m) * i as f64 / ticks as f64;
                run.tick(&placed.bars_at(&(-placed.outward * now_m)), law);
            }
            let shift_m = -placed.outward * at_m;
            let parts = placed.bars_at(&shift_m);
            let (mut before, mut mean) = (f64::NAN, Felt::default());
            for _ in 0..REST_TICKS / 50 {
                mean = Felt::default();
                for _ in 0..50 {
                    mean.add(&run.tick(&parts, law), 1.0 / 50.0);
                }
                let out_n = mean.force_n.dot(&placed.outward);
                if (out_n - before).abs() < STILL_N {
                    break;
                }
                before = out_n;
            }
            // The port moves with the tool.
            let torque_nm = mean.torque_nm(&(placed.port_m + shift_m));
            wrenches.push(Wrench::new(placed, &mean.force_n, &torque_nm));
        }
        Ok(wrenches)
    }

    /// The largest step of the force from one tick to the next, N. Without `slide_m_s`, the motion
    /// is a press to 5 mm at 10 mm/s. With it, the motion is a slide of 40 mm across the site, 4 mm
    /// deep.
    ///
    /// # Errors
    /// The reason in words.
    pub(crate) fn largest_step_n(
        &mut self,
        placed: &Placed,
        slide_m_s: Option<f64>,
    ) -> Result<f64, String> {
        let mut run = self.at_rest()?;
        let along = placed.along * if slide_m_s.is_some() { 0.020 } else { 0.0 };
        let tick_s = f64::from(TICK_S);
        let mut last: Option<Point> = None;
        let mut largest: f64 = 0.0;
        let deepest_m = if slide_m_s.is_some() { 0.004 } else { 0.005 };
        let ticks = (deepest_m / SPEED_M_S / tick_s) as usize;
        for i in 0..=ticks {
            let depth_m = deepest_m * i as f64 / ticks as f64;
            let parts = placed.bars_at(&(-placed.outward * depth_m - along));
            let force = run.tick(&parts, Law::Ours).force_n;
            if slide_m_s.is_none() {
                largest = largest.max(last.map_or(0.0, |l| (force - l).norm()));
            }
            last = Some(force);
        }
        let Some(speed) = slide_m_s else {
            return Ok(largest);
        };
        // The slide starts and stops smoothly: the tool's position follows half a period of a
        // cosine.
        let ticks = (0.040 / speed / tick_s * std::f64::consts::FRAC_PI_2) as usize;
        for i in 0..=ticks {
            let side = -(std::f64::consts::PI * i as f64 / ticks as f64).cos();
            let parts = placed.bars_at(&(along * side - placed.outward * deepest_m));
            let force = run.tick(&parts, Law::Ours).force_n;
            largest = largest.max(last.map_or(0.0, |l| (force - l).norm()));
            last = Some(force);
        }
        Ok(largest)
    }
}

impl Placed {
    fn bars_at(&self, shift: &Point) -> Vec<Capsule> {
        let capsule = |bar: &fem_reference::Bar| {
            let [a, b] = bar.ends_m.map(|p| (p + shift).cast());
            Capsule {
                // In a tip's capsule, the end that touches is the second one.
                a_m: b,
                b_m: a,
                radius_m: bar.radius_m as f32,
                role: Role::Tip,
            }
        };
        self.bars.iter().map(capsule).collect()
    }
}

struct Run<'a> {
    tissue: Tissue<'a>,
    body: &'a Body,
    skin: &'a ContactSkin,
}

/// Force of the tissue on a tool in one tick.
#[derive(Debug, Clone, Copy, Default)]
struct Felt {
    /// Force, N.
    force_n: Point,
    /// Torque about the world's origin, N m.
    moment_nm: Point,
}

impl Felt {
    fn add(&mut self, other: &Self, share: f64) {
        self.force_n += other.force_n * share;
        self.moment_nm += other.moment_nm * share;
    }

    /// Adds a force at a place.
    fn push(&mut self, at_m: &V3, force_n: &V3) {
        let (at_m, force_n): (Point, Point) = (at_m.cast(), force_n.cast());
        self.force_n += force_n;
        self.moment_nm += at_m.cross(&force_n);
    }

    /// Torque about a point, N m.
    fn torque_nm(&self, about_m: &Point) -> Point {
        self.moment_nm - about_m.cross(&self.force_n)
    }
}

impl Run<'_> {
    /// Runs one tick.
    fn tick(&mut self, parts: &[Capsule], law: Law) -> Felt {
        let (body, skin) = (self.body, self.skin);
        let mut felt = Felt::default();
        match law {
            Law::Ours => {
                let pressed = self.tissue.press(parts);
                felt.force_n = pressed.force_n.cast();
                felt.moment_nm = pressed.torque_nm(&V3::zeros()).cast();
            }
            Law::Spheres => {
                self.tissue.step_with(|tissue, step_s| {
                    push_spheres(tissue, body, parts, step_s, &mut felt);
                });
            }
            Law::RigidSkin => {
                self.tissue.step_with(|tissue, step_s| {
                    push_skin(tissue, skin, parts, step_s, &mut felt);
                });
            }
        }
        felt
    }
}

/// Depth of a ball in the part that contains it most deeply, m, and the unit vector out of that
/// part. `None` if the ball is outside all parts.
fn depth(parts: &[Capsule], center_m: &V3, radius_m: f32) -> Option<(f32, V3)> {
    let one = |part: &Capsule| {
        let axis = part.b_m - part.a_m;
        let along = (center_m - part.a_m).dot(&axis) / axis.norm_squared().max(1e-12);
        let arm = center_m - part.a_m - axis * along.clamp(0.0, 1.0);
        (part.radius_m + radius_m - arm.norm(), arm)
    };
    let deepest = parts.iter().map(one).max_by(|a, b| a.0.total_cmp(&b.0))?;
    (deepest.0 > 0.0).then(|| (deepest.0, deepest.1.normalize()))
}

fn push_spheres(
    tissue: &mut Correction<'_>,
    body: &Body,
    parts: &[Capsule],
    step_s: f32,
    felt: &mut Felt,
) {
    for (i, &radius_m) in (0_u32..).zip(&body.radius_m) {
        if let Some((depth_m, out)) = depth(parts, &tissue.center_m(i), radius_m) {
            let yielding = tissue.inverse_mass_per_kg(i) * step_s * step_s;
            let force_n = SPHERE_N_M * depth_m / (1.0 + SPHERE_N_M * yielding);
            tissue.move_by(i, &(out * (force_n * yielding)));
            felt.push(&tissue.center_m(i), &(out * -(force_n * step_s / TICK_S)));
        }
    }
}

fn push_skin(
    tissue: &mut Correction<'_>,
    skin: &ContactSkin,
    parts: &[Capsule],
    step_s: f32,
    felt: &mut Felt,
) {
    for vertex in &skin.vertices {
        let carriers = || {
            vertex
                .spheres
                .map(u32::from)
                .into_iter()
                .zip(vertex.weights)
        };
        let at_m: V3 = carriers().map(|(i, w)| tissue.center_m(i) * w).sum();
        let Some((depth_m, out)) = depth(parts, &at_m, 0.0) else {
            continue;
        };
        let yields = carriers().map(|(i, w)| tissue.inverse_mass_per_kg(i) * w * w);
        let yields: f32 = yields.sum();
        if yields > 0.0 {
            let pushed = depth_m / yields;
            for (i, w) in carriers() {
                let by = tissue.inverse_mass_per_kg(i) * w * pushed;
                tissue.move_by(i, &(out * by));
            }
            felt.push(&at_m, &(out * -(pushed / (step_s * TICK_S))));
        }
    }
}
