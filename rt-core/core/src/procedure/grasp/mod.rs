//! Grasp: spheres between closed jaws move with the instrument, until the jaws open or the spheres
//! slip out.
//!
//! The jaws squeeze the tissue between them ([`bite`]). Friction holds the tissue against a pull,
//! and the tissue keeps the jaws open. A handle that opens and shuts renders the squeeze
//! ([`crate::procedure::opening`]); a handle with a button does not.

mod bite;

use heapless::Vec;

use crate::capacity::{MAX_GRASPED, MAX_ORGANS};
use crate::contact::contact_force::Pull;
use crate::fault::{Fault, FaultSet};
use crate::math::{self, Pose, Vec3};
use crate::scene::Scene;
use crate::time::TICK_S;
use crate::tissue::Bodies;
use crate::tool::Instrument;
use crate::tool::cylinder::meets;
use crate::words::SphereBits;
pub(crate) use bite::GRIP_MAX_N;
use bite::{Bite, GRIP_N_M, crush_pressure_pa};

/// Distance from the line between joint and tip of the jaws within which spheres are grasped, m. It
/// allows for spheres that lie up to a few mm under the visible skin.
const GRASP_RADIUS_M: f32 = 0.005;
/// Distance beyond `GRASP_RADIUS_M` at which a grasped sphere counts as slid out, m.
const RELEASE_MARGIN_M: f32 = 0.001;
/// Share of the grip that a sphere loses in a tick after it has slid out: it is free after 0.2 s. A
/// larger share ends the pull more abruptly.
const RELEASE_STEP: f32 = 0.005;
/// Distance that tissue slides through the jaws until a slip is reported, m.
const SLIP_M: f32 = 0.002;

/// A grasped sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
struct GraspedSphere {
    sphere: u32,
    /// Place of the sphere in the jaws, in the instrument's frame, m.
    in_instrument_m: Vec3,
    /// This place at the end of the last tick, world frame, m.
    last_target_m: Vec3,
    /// Remaining share of the grip on the sphere.
    share: f32,
}

/// Tissue between closed jaws.
#[derive(Debug, Clone, Default)]
pub(crate) struct Grasp {
    grasped: Vec<GraspedSphere, MAX_GRASPED>,
    bite: Bite,
    /// True for scissors and clip applier: grasped tissue does not slip, and does not stop the
    /// jaws.
    is_sharp: bool,
    /// Reciprocal of the number of spheres that were grasped.
    sphere_share: f32,
    /// Force of the jaws on the tissue, N.
    grip_n: f32,
    /// Pull of the tissue in the last tick, world frame, N.
    pull_n: Vec3,
    /// Pull summed so far in the present tick, world frame, N.
    pull_sum_n: Vec3,
    /// Organs that this grip has crushed.
    crushed: [bool; MAX_ORGANS],
    /// Distance slid since the last report, mean over the spheres, m.
    slip_m: f32,
}

/// State of the jaws.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jaws<'a> {
    pub(crate) instrument: Instrument,
    pub(crate) world_from_instrument: &'a Pose,
    /// Opening, 0 shut to 1 wide open.
    pub(crate) jaw: f32,
}

/// Thickness of the jaws between their axes, m. Jaws touch tissue when the distance of their axes
/// is less than the tissue's thickness plus this value.
const JAW_THICKNESS_M: f32 = 0.001;

/// Crossing of a link between the jaws.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crossing {
    /// Position along the jaws: 0 at the joint, 1 at the tips.
    pub(crate) along: f32,
    /// Position along the link, from its first end to its second.
    pub(crate) share: f32,
}

impl Jaws<'_> {
    /// Distance between the axes of the jaws at the middle of their length, m: half of the distance
    /// at the tips.
    fn gap_m(&self) -> f32 {
        self.instrument.jaw_opening_m() * self.jaw
    }

    /// Crossing of a link with these ends (world frame, m) between the jaws. A thick link counts
    /// while part of it is between the jaws.
    pub(crate) fn crossing(&self, ends_m: &[Vec3; 2], radius_m: f32) -> Option<Crossing> {
        let instrument_from_world = self.world_from_instrument.inverse();
        let local = |end: &Vec3| (instrument_from_world * nalgebra::Point3::from(*end)).coords;
        let (a, b) = (local(&ends_m[0]), local(&ends_m[1]));
        if (a.x < 0.0) == (b.x < 0.0) {
            return None;
        }
        let share = a.x / (a.x - b.x);
        let at_m = a + (b - a) * share;
        let along = -at_m.z / self.instrument.jaw_length_m();
        let half_gap_m = self.gap_m() * along;
        let is_between = (0.0..=1.0).contains(&along) && at_m.y.abs() <= half_gap_m + radius_m;
        is_between.then_some(Crossing { along, share })
    }

    /// True if the jaws have closed onto a link of this thickness at the crossing.
    pub(crate) fn meets(&self, crossing: &Crossing, radius_m: f32) -> bool {
        2.0 * self.gap_m() * crossing.along < 2.0 * radius_m + JAW_THICKNESS_M
    }

    fn tip_in_instrument_m(&self) -> Vec3 {
        Vec3::new(0.0, 0.0, -self.instrument.jaw_length_m())
    }
}

impl Grasp {
    pub(crate) fn count(&self) -> u32 {
        self.grasped.len() as u32
    }

    /// Grasped spheres.
    pub(crate) fn spheres(&self) -> impl Iterator<Item = u32> {
        self.grasped.iter().map(|grasped| grasped.sphere)
    }

    /// First grasped sphere.
    pub(crate) fn first(&self) -> Option<u32> {
        self.grasped.first().map(|grasped| grasped.sphere)
    }

    /// Grasps every movable sphere near the line from the jaw joint to the tip, of the organs for
    /// which `may_grasp` returns true.
    pub(crate) fn close(
        &mut self,
        jaws: &Jaws<'_>,
        may_grasp: impl Fn(u8) -> bool,
        scene: &Scene<'_>,
        bodies: &mut Bodies,
        faults: &mut FaultSet,
    ) {
        let instrument = jaws.world_from_instrument;
        let joint_m = instrument.translation.vector;
        let tip_m = instrument.rotation * jaws.tip_in_instrument_m() + joint_m;
        for i in 0..scene.spheres.len() as u32 {
            let radius_m = *bodies.radius_m.at(i);
            let node = bodies.nodes.at(i);
            let center = node.center_m();
            let is_between = meets(&center, radius_m, &joint_m, &tip_m, GRASP_RADIUS_M);
            let is_removed = bodies.bits.at(i).contains(SphereBits::REMOVED);
            if !is_between
                || is_removed
                || !may_grasp(*bodies.organ.at(i))
                || node.inverse_mass_per_kg() <= 0.0
            {
                continue;
            }
            let grasped = GraspedSphere {
                sphere: i,
                in_instrument_m: instrument.rotation.inverse() * (center - joint_m),
                last_target_m: center,
                share: 1.0,
            };
            if self.grasped.push(grasped).is_err() {
                faults.raise(Fault::GraspOverflow);
                break;
            }
            let bits = bodies.bits.at_mut(i);
            *bits = bits.with(SphereBits::GRASPED);
        }
        self.is_sharp = jaws.instrument != Instrument::Grasper;
        self.sphere_share = (self.grasped.len().max(1) as f32).recip();
        let spheres = self.grasped.iter().map(|grasped| grasped.sphere);
        let across = instrument.rotation * Vec3::y();
        let along = instrument.rotation * Vec3::z();
        let jaw_size_m = (jaws.gap_m(), jaws.instrument.jaw_length_m());
        self.bite = Bite::new(spheres, jaw_size_m, (&across, &along), scene, bodies);
    }

    /// Releases everything.
    pub(crate) fn open(&mut self, bodies: &mut Bodies) {
        for grasped in &self.grasped {
            let bits = bodies.bits.at_mut(grasped.sphere);
            *bits = bits.without(SphereBits::GRASPED);
        }
        *self = Self::default();
    }

    /// Opening at which the tissue stops jaws that close from `open` to `to`, found by `bisections`
    /// bisections. `push_n` gives the force of the jaws at an opening, N.
    pub(crate) fn stop(
        &self,
        jaws: &Jaws<'_>,
        (mut open, to): (f32, f32),
        bisections: u32,
        push_n: impl Fn(f32) -> f32,
    ) -> f32 {
        let is_stopped = |jaw: f32| {
            let closed = Jaws { jaw, ..*jaws };
            self.bite.squeeze_n(closed.gap_m()) > push_n(jaw)
        };
        if self.count() == 0 || self.is_sharp || to >= open || !is_stopped(to) {
            return to;
        }
        let mut stopped = to;
        for _ in 0..bisections {
            let middle = 0.5 * (stopped + open);
            if is_stopped(middle) {
                stopped = middle;
            } else {
                open = middle;
            }
        }
        open
    }

    /// Updates the force of the jaws after they have moved, N, at most `force_max_n`, and releases
    /// spheres that have slid out. Returns true if tissue has slipped by `SLIP_M`.
    pub(crate) fn hold(&mut self, jaws: &Jaws<'_>, force_max_n: f32, bodies: &mut Bodies) -> bool {
        self.grip_n = self.bite.squeeze_n(jaws.gap_m()).min(force_max_n);
        let (joint_m, tip_m) = (Vec3::zeros(), jaws.tip_in_instrument_m());
        for grasped in &mut self.grasped {
            let radius_m = *bodies.radius_m.at(grasped.sphere);
            let at_m = &grasped.in_instrument_m;
            if grasped.share < 1.0
                || !meets(
                    at_m,
                    radius_m,
                    &joint_m,
                    &tip_m,
                    GRASP_RADIUS_M + RELEASE_MARGIN_M,
                )
            {
                grasped.share -= RELEASE_STEP;
            }
        }
        self.grasped.retain(|grasped| {
            let stays = grasped.share > 0.0;
            if !stays {
                let bits = bodies.bits.at_mut(grasped.sphere);
                *bits = bits.without(SphereBits::GRASPED);
            }
            stays
        });
        let slipped = self.slip_m > SLIP_M;
        if slipped {
            self.slip_m = 0.0;
        }
        slipped
    }

    /// A sphere of an organ that this grip crushes for the first time, and the jaws' force, N.
    /// Scissors and clip applier do not crush.
    pub(crate) fn crush(&mut self, scene: &Scene<'_>, bodies: &Bodies) -> Option<(u32, f32)> {
        let pressure_pa = self.bite.pressure_pa(self.grip_n);
        for grasped in self.grasped.iter().filter(|_| !self.is_sharp) {
            let organ = usize::from(*bodies.organ.at(grasped.sphere));
            let (Some(it), Some(crushed)) = (scene.organs.get(organ), self.crushed.get_mut(organ))
            else {
                continue;
            };
            if !*crushed && pressure_pa > crush_pressure_pa(it.inside) {
                *crushed = true;
                return Some((grasped.sphere, self.grip_n));
            }
        }
        None
    }

    /// Pull of the tissue in the last tick, world frame, N.
    pub(crate) fn pull_n(&self) -> Vec3 {
        self.pull_n
    }

    /// True if the jaws are so far open that they no longer press on the tissue.
    pub(crate) fn is_loose(&self) -> bool {
        self.grip_n <= 0.0
    }

    /// Pulls the grasped spheres of `organ` towards their places in the jaws, when `share` of the
    /// tick has passed. If `organ` is `None`, pulls all grasped spheres. The grip is a spring
    /// (XPBD, Macklin 2016) whose multiplier gives the tissue's pull. A sphere whose pull would
    /// exceed its share of the friction slides instead.
    pub(crate) fn carry(
        &mut self,
        organ: Option<u8>,
        share: f32,
        world_from_instrument: &Pose,
        scene: &Scene<'_>,
        bodies: &mut Bodies,
    ) {
        let friction_max_n = if self.is_sharp {
            f32::MAX
        } else {
            self.bite.slip_n(self.grip_n) * self.sphere_share
        };
        let instrument_from_world = world_from_instrument.inverse();
        let mut pull_n = Vec3::zeros(); // of this substep, weighted by its share of the tick
        for grasped in &mut self.grasped {
            let organ_index = *bodies.organ.at(grasped.sphere);
            if organ.is_some_and(|organ| organ != organ_index) {
                continue;
            }
            let end_m = world_from_instrument.rotation * grasped.in_instrument_m
                + world_from_instrument.translation.vector;
            let target_m = grasped.last_target_m + (end_m - grasped.last_target_m) * share;
            let compliance_m_n = sphere_compliance_m_n(grasped.sphere, scene, bodies);
            let node = bodies.nodes.at_mut(grasped.sphere);
            let stiffness_n_m = GRIP_N_M * self.sphere_share * grasped.share;
            let extension_m = target_m - node.center_m();
            let stuck_n = extension_m * (stiffness_n_m / (1.0 + stiffness_n_m * compliance_m_n));
            let slip_max_n = friction_max_n * grasped.share;
            let force_share =
                slip_max_n / math::norm(&stuck_n).max(slip_max_n).max(f32::MIN_POSITIVE);
            let force_n = stuck_n * force_share;
            if organ.is_none() {
                grasped.last_target_m = end_m;
                if force_share < 1.0 {
                    // The tissue slides: its place in the jaws moves back.
                    grasped.last_target_m = node.center_m() + extension_m * force_share;
                    grasped.in_instrument_m = (instrument_from_world
                        * nalgebra::Point3::from(grasped.last_target_m))
                    .coords;
                    self.slip_m +=
                        math::norm(&extension_m) * (1.0 - force_share) * self.sphere_share;
                }
            }
            node.move_by(&(force_n * compliance_m_n));
            pull_n -= force_n * (scene.step_s_of(organ_index) / TICK_S);
        }
        self.pull_sum_n += pull_n;
        if organ.is_none() {
            self.pull_n = core::mem::take(&mut self.pull_sum_n);
        }
    }

    /// Pull of the tissue on the jaws; `None` if nothing is held.
    pub(crate) fn pull(&self, bodies: &Bodies) -> Option<Pull> {
        let share: f32 = self.grasped.iter().map(|grasped| grasped.share).sum();
        let weighted =
            |grasped: &GraspedSphere| bodies.nodes.at(grasped.sphere).center_m() * grasped.share;
        let sum_m: Vec3 = self.grasped.iter().map(weighted).sum();
        (share > 0.0).then(|| Pull {
            at_m: sum_m / share,
            force_n: self.pull_n,
            stiffness_n_m: self.bite.pull_stiffness_n_m(share * self.sphere_share),
            grip_n_m: GRIP_N_M * share * self.sphere_share,
        })
    }
}

/// Compliance of a sphere in the last substep of its organ, m/N.
fn sphere_compliance_m_n(sphere: u32, scene: &Scene<'_>, bodies: &Bodies) -> f32 {
    let step_s = scene.step_s_of(*bodies.organ.at(sphere));
    bodies.nodes.at(sphere).inverse_mass_per_kg() * step_s * step_s
}
