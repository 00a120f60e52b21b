//! Grasp: spheres between closed jaws move with the instrument until the jaws open or the spheres
//! slip out.
//!
//! The jaws squeeze the tissue between them ([`bite`]). The friction then holds the tissue against
//! a pull, and the tissue keeps the jaws open. A handle that opens and shuts renders the squeeze
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
use bite::{Bite, GRIP_N_M, crushed_by_pa};

/// Distance from the line between joint and tip of the jaws within which spheres are grasped, m.
/// Spheres lie up to a few mm under the skin that the trainee sees.
const REACH_M: f32 = 0.005;
/// Distance beyond `REACH_M` at which a held sphere counts as slid out, m.
const OUT_M: f32 = 0.001;
/// Share of the grip that a sphere loses per tick after it has slid out: the sphere is free after
/// 0.2 s. A larger share ends the pull more abruptly.
const OUT_STEP: f32 = 0.005;
/// Distance that tissue slides through the jaws until a slip is reported, m.
const SLIP_M: f32 = 0.002;

/// A held sphere.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Held {
    sphere: u32,
    /// Place of the sphere in the jaws, in the instrument's frame, m.
    in_instrument_m: Vec3,
    /// The place at the end of the last tick, world frame, m.
    was_at_m: Vec3,
    /// Remaining share of the grip on it.
    share: f32,
}

/// Tissue between closed jaws.
#[derive(Debug, Clone, Default)]
pub(crate) struct Grasp {
    held: Vec<Held, MAX_GRASPED>,
    bite: Bite,
    /// True for scissors and clip applier: held tissue does not slip, and does not stop the jaws.
    is_sharp: bool,
    /// Reciprocal of the number of spheres that were grasped.
    part: f32,
    /// Force of the jaws on the tissue, N.
    grip_n: f32,
    /// Pull of the tissue in the last tick, world frame, N.
    pull_n: Vec3,
    /// Pull summed so far in the present tick, world frame, N.
    so_far_n: Vec3,
    /// Organs that this grip has crushed.
    crushed: [bool; MAX_ORGANS],
    /// Distance slid since the last report, mean over the spheres, m.
    slid_m: f32,
}

/// State of the jaws.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jaws<'a> {
    pub(crate) instrument: Instrument,
    pub(crate) world_from_instrument: &'a Pose,
    /// Opening, 0 shut to 1 wide open.
    pub(crate) jaw: f32,
}

/// Thickness of the jaws between their axes, m. Jaws meet tissue when their axes are less than the
/// tissue's thickness plus this value apart.
const MEET_M: f32 = 0.001;

/// Crossing of a link between the jaws.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crossing {
    /// Position along the jaws: 0 at the joint, 1 at the tips.
    pub(crate) along: f32,
    /// Position along the link, from its first end to its second.
    pub(crate) share: f32,
}

impl Jaws<'_> {
    /// Distance between the axes of the jaws at the middle of their length, m: half of that at the
    /// tips.
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
        2.0 * self.gap_m() * crossing.along < 2.0 * radius_m + MEET_M
    }

    fn tip_in_instrument_m(&self) -> Vec3 {
        Vec3::new(0.0, 0.0, -self.instrument.jaw_length_m())
    }
}

impl Grasp {
    pub(crate) fn count(&self) -> u32 {
        self.held.len() as u32
    }

    /// Spheres that are held.
    pub(crate) fn spheres(&self) -> impl Iterator<Item = u32> {
        self.held.iter().map(|held| held.sphere)
    }

    /// First sphere that is held.
    pub(crate) fn first(&self) -> Option<u32> {
        self.held.first().map(|held| held.sphere)
    }

    /// Grasps every movable sphere near the line from the jaw joint to the tip, of the organs for
    /// which `takes` returns true.
    pub(crate) fn close(
        &mut self,
        jaws: &Jaws<'_>,
        takes: impl Fn(u8) -> bool,
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
            let is_between = meets(&center, radius_m, &joint_m, &tip_m, REACH_M);
            let is_removed = bodies.bits.at(i).contains(SphereBits::REMOVED);
            if !is_between
                || is_removed
                || !takes(*bodies.organ.at(i))
                || node.inverse_mass_per_kg() <= 0.0
            {
                continue;
            }
            let held = Held {
                sphere: i,
                in_instrument_m: instrument.rotation.inverse() * (center - joint_m),
                was_at_m: center,
                share: 1.0,
            };
            if self.held.push(held).is_err() {
                faults.raise(Fault::GraspOverflow);
                break;
            }
            let bits = bodies.bits.at_mut(i);
            *bits = bits.with(SphereBits::GRASPED);
        }
        self.is_sharp = jaws.instrument != Instrument::Grasper;
        self.part = (self.held.len().max(1) as f32).recip();
        let spheres = self.held.iter().map(|held| held.sphere);
        let across = instrument.rotation * Vec3::y();
        let along = instrument.rotation * Vec3::z();
        let room = (jaws.gap_m(), jaws.instrument.jaw_length_m());
        self.bite = Bite::new(spheres, room, (&across, &along), scene, bodies);
    }

    /// Releases everything.
    pub(crate) fn open(&mut self, bodies: &mut Bodies) {
        for held in &self.held {
            let bits = bodies.bits.at_mut(held.sphere);
            *bits = bits.without(SphereBits::GRASPED);
        }
        *self = Self::default();
    }

    /// Opening at which the tissue stops jaws that close from `open` to `to`, found by `halvings`
    /// bisections. `push_n` gives the force of the jaws at an opening, N.
    pub(crate) fn stop(
        &self,
        jaws: &Jaws<'_>,
        (mut open, to): (f32, f32),
        halvings: u32,
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
        for _ in 0..halvings {
            let middle = 0.5 * (stopped + open);
            if is_stopped(middle) {
                stopped = middle;
            } else {
                open = middle;
            }
        }
        open
    }

    /// Updates the force of the jaws after they have moved, N, at most `most_n`, and releases
    /// spheres that have slid out. Returns true if tissue has slipped by `SLIP_M`.
    pub(crate) fn hold(&mut self, jaws: &Jaws<'_>, most_n: f32, bodies: &mut Bodies) -> bool {
        self.grip_n = self.bite.squeeze_n(jaws.gap_m()).min(most_n);
        let (joint_m, tip_m) = (Vec3::zeros(), jaws.tip_in_instrument_m());
        for held in &mut self.held {
            let radius_m = *bodies.radius_m.at(held.sphere);
            let at_m = &held.in_instrument_m;
            if held.share < 1.0 || !meets(at_m, radius_m, &joint_m, &tip_m, REACH_M + OUT_M) {
                held.share -= OUT_STEP;
            }
        }
        self.held.retain(|held| {
            let stays = held.share > 0.0;
            if !stays {
                let bits = bodies.bits.at_mut(held.sphere);
                *bits = bits.without(SphereBits::GRASPED);
            }
            stays
        });
        let slipped = self.slid_m > SLIP_M;
        if slipped {
            self.slid_m = 0.0;
        }
        slipped
    }

    /// A sphere of an organ that the jaws crush now and had not crushed before in this grip, and
    /// the jaws' force, N. Scissors and clip applier do not crush.
    pub(crate) fn crush(&mut self, scene: &Scene<'_>, bodies: &Bodies) -> Option<(u32, f32)> {
        let pressure_pa = self.bite.pressure_pa(self.grip_n);
        for held in self.held.iter().filter(|_| !self.is_sharp) {
            let organ = usize::from(*bodies.organ.at(held.sphere));
            let (Some(it), Some(crushed)) = (scene.organs.get(organ), self.crushed.get_mut(organ))
            else {
                continue;
            };
            if !*crushed && pressure_pa > crushed_by_pa(it.inside) {
                *crushed = true;
                return Some((held.sphere, self.grip_n));
            }
        }
        None
    }

    /// Pull of the tissue in the last tick, world frame, N.
    pub(crate) fn pull_n(&self) -> Vec3 {
        self.pull_n
    }

    /// True if the jaws are so far open that they do not press on the tissue any more.
    pub(crate) fn is_loose(&self) -> bool {
        self.grip_n <= 0.0
    }

    /// Draws the held spheres of `organ` to where the instrument has carried them by `share` of the
    /// tick; all of them if `organ` is `None`. The grip is a spring (XPBD, Macklin 2016) whose
    /// multiplier is the tissue's pull. A sphere that would bear more than its part of the friction
    /// slides instead.
    pub(crate) fn carry(
        &mut self,
        organ: Option<u8>,
        share: f32,
        world_from_instrument: &Pose,
        scene: &Scene<'_>,
        bodies: &mut Bodies,
    ) {
        let bears_n = if self.is_sharp {
            f32::MAX
        } else {
            self.bite.slip_n(self.grip_n) * self.part
        };
        let instrument_from_world = world_from_instrument.inverse();
        let mut pull_n = Vec3::zeros(); // of this substep, as a share of the tick's
        for held in &mut self.held {
            let own = *bodies.organ.at(held.sphere);
            if organ.is_some_and(|organ| organ != own) {
                continue;
            }
            let end_m = world_from_instrument.rotation * held.in_instrument_m
                + world_from_instrument.translation.vector;
            let target_m = held.was_at_m + (end_m - held.was_at_m) * share;
            let yielding_m_n = yield_m_n(held.sphere, scene, bodies);
            let node = bodies.nodes.at_mut(held.sphere);
            let stiffness_n_m = GRIP_N_M * self.part * held.share;
            let away_m = target_m - node.center_m();
            let stuck_n = away_m * (stiffness_n_m / (1.0 + stiffness_n_m * yielding_m_n));
            let most_n = bears_n * held.share;
            let kept = most_n / math::norm(&stuck_n).max(most_n).max(f32::MIN_POSITIVE);
            let force_n = stuck_n * kept;
            if organ.is_none() {
                held.was_at_m = end_m;
                if kept < 1.0 {
                    // The jaws move on; the tissue stays behind.
                    held.was_at_m = node.center_m() + away_m * kept;
                    held.in_instrument_m =
                        (instrument_from_world * nalgebra::Point3::from(held.was_at_m)).coords;
                    self.slid_m += math::norm(&away_m) * (1.0 - kept) * self.part;
                }
            }
            node.move_by(&(force_n * yielding_m_n));
            pull_n -= force_n * (scene.step_s_of(own) / TICK_S);
        }
        self.so_far_n += pull_n;
        if organ.is_none() {
            self.pull_n = core::mem::take(&mut self.so_far_n);
        }
    }

    /// Pull of the tissue on the jaws; `None` if nothing is held.
    pub(crate) fn pull(&self, bodies: &Bodies) -> Option<Pull> {
        let share: f32 = self.held.iter().map(|held| held.share).sum();
        let weighted = |held: &Held| bodies.nodes.at(held.sphere).center_m() * held.share;
        let sum_m: Vec3 = self.held.iter().map(weighted).sum();
        (share > 0.0).then(|| Pull {
            at_m: sum_m / share,
            force_n: self.pull_n,
            stiffness_n_m: self.bite.pull_stiffness_n_m(share * self.part),
            grip_n_m: GRIP_N_M * share * self.part,
        })
    }
}

/// Compliance of a sphere in the last substep of its organ, m/N.
fn yield_m_n(sphere: u32, scene: &Scene<'_>, bodies: &Bodies) -> f32 {
    let step_s = scene.step_s_of(*bodies.organ.at(sphere));
    bodies.nodes.at(sphere).inverse_mass_per_kg() * step_s * step_s
}
