//! Jaws that hold: spheres within their reach go with the instrument until it lets go, or they slip
//! out.
//!
//! What is between the jaws is squeezed as they close ([`bite`]); the grip that this gives bears a
//! pull up to its friction. The handle's closing is a button: nothing of the squeeze is rendered,
//! but the jaws stay as far open as what they hold keeps them.

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
use bite::{Bite, GRIP_MAX_N, GRIP_N_M, crushed_by_pa};

/// Spheres that come this near to the middle of the jaws are between them, m. Inner spheres lie
/// up to some mm under the skin that the trainee sees.
const REACH_M: f32 = 0.005;
/// One that is held has to slide out by this more before it is lost, m.
const OUT_M: f32 = 0.001;
/// What a tick takes of the grip on a sphere that has slid out of the jaws: none is left after 0.2 s.
const OUT_STEP: f32 = 0.005;
/// Tissue that slides through the jaws by this has slipped, m.
const SLIP_M: f32 = 0.002;
/// Halvings of the jaws' last step, after which they stand where they are stopped.
const STOP_HALVINGS: u32 = 10;

/// A sphere in the jaws.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Held {
    sphere: u32,
    /// Where the jaws have it, in the instrument's frame, m.
    in_instrument_m: Vec3,
    /// Where that was at the end of the last tick, world frame, m.
    was_at_m: Vec3,
    /// Share of the grip that is left on it.
    share: f32,
}

/// What the jaws hold.
#[derive(Debug, Clone, Default)]
pub(crate) struct Grasp {
    held: Vec<Held, MAX_GRASPED>,
    bite: Bite,
    /// Edges dig in, a clip holds: nothing slips, nothing stops them.
    is_sharp: bool,
    /// One over the spheres that were bitten.
    part: f32,
    /// Force of the jaws on what they hold, N.
    grip_n: f32,
    /// What the tissue pulled with in the last tick, world frame, N.
    pull_n: Vec3,
    /// The same of the tick that is being solved.
    so_far_n: Vec3,
    /// Which organs this grip has crushed.
    crushed: [bool; MAX_ORGANS],
    /// How far it has slid since that was last told, mean over the spheres, m.
    slid_m: f32,
}

/// The instrument as its jaws close.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Jaws<'a> {
    pub(crate) instrument: Instrument,
    pub(crate) world_from_instrument: &'a Pose,
    /// Opening, 0 to 1.
    pub(crate) jaw: f32,
}

/// Jaws meet what is between them while their middles are farther apart than it is thick by this, m:
/// they are thick themselves.
const MEET_M: f32 = 0.001;

/// Where a bar crosses between jaws.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crossing {
    /// From the joint, 0, to their tips, 1.
    pub(crate) along: f32,
    /// From the bar's first end to its second.
    pub(crate) share: f32,
}

impl Jaws<'_> {
    /// Between the middles of the jaws, m.
    fn gap_m(&self) -> f32 {
        self.instrument.jaw_opening_m() * self.jaw
    }

    /// Where a bar with these ends (world frame, m) crosses between the jaws. A bar this thick counts as
    /// between them as long as some of it is.
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

    /// Whether the jaws have closed so far that they meet a bar this thick that crosses here.
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

    /// The spheres held.
    pub(crate) fn spheres(&self) -> impl Iterator<Item = u32> {
        self.held.iter().map(|held| held.sphere)
    }

    /// The first of them.
    pub(crate) fn first(&self) -> Option<u32> {
        self.held.first().map(|held| held.sphere)
    }

    /// Closes on every movable sphere near the line from the jaw joint to the tip, of organs that it
    /// `takes`.
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
            let is_gone = bodies.bits.at(i).contains(SphereBits::GONE);
            if !is_between
                || is_gone
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

    /// Lets go of everything.
    pub(crate) fn open(&mut self, bodies: &mut Bodies) {
        for held in &self.held {
            let bits = bodies.bits.at_mut(held.sphere);
            *bits = bits.without(SphereBits::GRASPED);
        }
        *self = Self::default();
    }

    /// Where jaws that close to `to` are stopped by what is between them.
    pub(crate) fn stop(&self, jaws: &Jaws<'_>, to: f32) -> f32 {
        let is_stopped = |jaw: f32| {
            let closed = Jaws { jaw, ..*jaws };
            self.bite.squeeze_n(closed.gap_m()) > GRIP_MAX_N
        };
        if self.count() == 0 || self.is_sharp || to >= jaws.jaw || !is_stopped(to) {
            return to;
        }
        let (mut stopped, mut open) = (to, jaws.jaw);
        for _ in 0..STOP_HALVINGS {
            let middle = 0.5 * (stopped + open);
            if is_stopped(middle) {
                stopped = middle;
            } else {
                open = middle;
            }
        }
        open
    }

    /// After the jaws have moved: how hard they hold, and what has slid out of them. Returns
    /// whether something has slipped.
    pub(crate) fn hold(&mut self, jaws: &Jaws<'_>, bodies: &mut Bodies) -> bool {
        self.grip_n = self.bite.squeeze_n(jaws.gap_m()).min(GRIP_MAX_N);
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

    /// A sphere of an organ that the jaws crush and had not crushed yet in this grip, and their force, N. An
    /// edge cuts and a clip closes: neither counts.
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

    /// What the tissue pulled with in the last tick, world frame, N.
    pub(crate) fn pull_n(&self) -> Vec3 {
        self.pull_n
    }

    /// Whether jaws that open have nothing between them any more.
    pub(crate) fn is_loose(&self) -> bool {
        self.grip_n <= 0.0
    }

    /// Draws the held spheres of organ `organ` to where the instrument has carried them by `share`
    /// of the tick; every one of them if no organ is given. The grip is a spring (XPBD, Macklin
    /// 2016): the multiplier is what the tissue pulls with. One that would bear more than its part
    /// of the friction slides instead.
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
                    // The jaws go on, the tissue stays behind.
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

    /// How the tissue pulls on the jaws. `None` when nothing is held.
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

/// How far a sphere goes in the last substep of its organ for a force on it, m/N.
fn yield_m_n(sphere: u32, scene: &Scene<'_>, bodies: &Bodies) -> f32 {
    let step_s = scene.step_s_of(*bodies.organ.at(sphere));
    bodies.nodes.at(sphere).inverse_mass_per_kg() * step_s * step_s
}
