//! Sewing: the trainee hangs an organ on the abdominal wall. A first press of the pedal passes the
//! needle through the tissue at the grasper's tip. A second press hangs the suture on the wall, in
//! the direction in which the tip was carried in between.

use crate::math::{self, Vec3};
use crate::port::PedalSample;
use crate::scene::{Anchor, is_suture};
use crate::sim::Sim;
use crate::tissue::suture::{Placed, Suture};
use crate::tool::{Instrument, Tool};
use crate::words::{Event, EventKind};

/// Length of the needle, m: it pierces tissue that the instrument touches within this distance of
/// the tip.
const NEEDLE_M: f32 = 0.012;
/// Least distance by which the tip must be carried to give a direction, m.
const CARRIED_MIN_M: f32 = 0.01;
/// Least rise of the direction in which the tip was carried: height divided by length.
const RISE_MIN: f32 = 0.5;
/// Longest thread, m.
const THREAD_LENGTH_M: f32 = 0.2;

impl Sim<'_> {
    /// True if a press of the pedal moves the needle: the instrument is the grasper, and a suture
    /// waits to be placed.
    fn is_sewing(&self) -> bool {
        self.tool.instrument == Instrument::Grasper && self.state.bodies.sutures.has_unplaced()
    }

    /// State of the pedal for the electrosurgical generator: released while the pedal moves a
    /// needle.
    pub(super) fn electric_pedal(&self) -> PedalSample {
        let pedal = self.tool.switches.pedal;
        let is_needle = self.is_sewing() || self.state.bodies.sutures.leads_needle();
        // The irrigator's pedals open its valves.
        let is_current = !is_needle && self.tool.instrument != Instrument::Irrigator;
        PedalSample {
            cut: pedal.cut && is_current,
            coagulate: pedal.coagulate && is_current,
            ..pedal
        }
    }

    /// Does the next step of placing a suture (stitch, then hang) when the pedal is pressed. An
    /// impossible step does nothing and raises no event.
    pub(super) fn sew(&mut self) {
        let pedal = self.tool.switches.pedal;
        let is_down = pedal.cut || pedal.coagulate;
        let is_sewing = self.is_sewing();
        let is_pressed = self.state.bodies.sutures.record_pedal(is_down, is_sewing);
        if !is_pressed || self.tool.switches.paused {
            return;
        }
        let Some((number, suture)) = self.state.bodies.sutures.next_unplaced() else {
            return;
        };
        let suture = *suture;
        let placed = match suture.placed {
            Placed::Away => self.stitch(suture),
            Placed::AtHand => self.hang_on_wall(number, suture),
            Placed::Hung => None,
        };
        let (Some((placed, kind, at_m)), Some((_, suture))) =
            (placed, self.state.bodies.sutures.next_unplaced())
        else {
            return;
        };
        *suture = placed;
        let organ = *self.state.bodies.organ.at(placed.sphere);
        self.sleep.wake(organ.into());
        self.journal.raise(Event {
            kind,
            organ: Some(organ.into()),
            at_m,
            value: number as f32,
        });
    }

    /// Passes the suture through its organ at the touched or grasped place nearest to the tip. The
    /// suture then holds the free sphere nearest to this place.
    fn stitch(&self, mut suture: Suture) -> Option<(Suture, EventKind, Vec3)> {
        let bodies = &self.state.bodies;
        let organ_index = *bodies.organ.at(suture.sphere);
        let organ = self.scene.organs.get(usize::from(organ_index))?;
        let from_tip = |at_m: &Vec3| (at_m - self.tool.tip_m).norm_squared();
        let touched = self.contacts.forces.iter();
        let touched =
            touched.filter(|it| it.tool == Tool::Instrument && it.organ == Some(organ_index));
        let grasped = self
            .grasp
            .spheres()
            .filter(|it| *bodies.organ.at(*it) == organ_index);
        let places = touched.map(|it| it.at_m);
        let places = places.chain(grasped.map(|it| bodies.nodes.at(it).center_m()));
        let at_m = places.min_by(|a, b| from_tip(a).total_cmp(&from_tip(b)))?;
        if from_tip(&at_m) > NEEDLE_M * NEEDLE_M {
            return None;
        }
        let spheres = organ.sphere_start..organ.sphere_start + organ.sphere_count;
        let free = spheres.filter(|it| bodies.nodes.at(*it).inverse_mass_per_kg() > 0.0);
        let distance_m2 = |it: &u32| (bodies.nodes.at(*it).center_m() - at_m).norm_squared();
        suture.sphere = free.min_by(|a, b| distance_m2(a).total_cmp(&distance_m2(b)))?;
        suture.placed = Placed::AtHand;
        Some((suture, EventKind::Stitch, at_m))
    }

    /// Hangs the suture where the line from the organ through the tip meets the wall. The wall is
    /// at the height of this suture's anchor in the scene.
    fn hang_on_wall(&self, number: usize, mut suture: Suture) -> Option<(Suture, EventKind, Vec3)> {
        let mut scene_tie = self.scene.attachments.iter().filter(|it| is_suture(it));
        let scene_tie = scene_tie.nth(number)?;
        let Anchor::World(scene_anchor_m) = scene_tie.to else {
            return None;
        };
        let scene_sphere_m = self.scene.spheres.get(scene_tie.sphere as usize)?.center_m;
        let scene_length_m = math::norm(&(scene_anchor_m - scene_sphere_m));
        let gravity = self.scene.room().gravity_m_s2;
        let up = match math::norm(&gravity) {
            size_m_s2 if size_m_s2 > 0.0 => -gravity / size_m_s2,
            _ => (scene_anchor_m - scene_sphere_m) / scene_length_m.max(f32::MIN_POSITIVE),
        };
        let from_m = self.state.bodies.nodes.at(suture.sphere).center_m();
        let travel_m = self.tool.tip_m - from_m;
        let rise_m = travel_m.dot(&up);
        let carried_m = math::norm(&travel_m);
        if carried_m < CARRIED_MIN_M || rise_m < RISE_MIN * carried_m {
            return None;
        }
        let at_m = from_m + travel_m * ((scene_anchor_m - from_m).dot(&up) / rise_m);
        let length_m = math::norm(&(at_m - from_m));
        if !(at_m - from_m).dot(&up).is_sign_positive() || length_m > THREAD_LENGTH_M {
            return None;
        }
        suture.hang(
            at_m,
            length_m,
            (scene_length_m - scene_tie.rest_length_m).max(0.0),
        );
        Some((suture, EventKind::Hung, at_m))
    }
}
