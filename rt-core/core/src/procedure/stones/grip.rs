//! Jaws that hold a stone, the way out of the body, and suction.

use crate::math::{self, Pose, Quat, Vec3};
use crate::procedure::grasp::Jaws;
use crate::procedure::journal::Journal;
use crate::procedure::stones::{Place, Stone, StoneState};
use crate::scene::Scene;
use crate::tool::{Capsule, Instrument};
use crate::words::{Event, EventKind};

/// Distance across the jaws within which a stone is between them, m: half of a jaw's width.
const ACROSS_M: f32 = 0.002;
/// Length of the jaws, from the joint, that holds no stone, as a share: the gap is too narrow.
const TOO_DEEP: f32 = 0.2;
/// Gap between stone and jaw at which closing jaws have caught the stone, m.
const CAUGHT_M: f32 = 0.001;
/// Opening of the jaws beyond their least opening at which they let go.
const LETS_GO: f32 = 0.04;
/// Distance of a held stone from the port at which it is out of the body, m. Assumed: the end of a
/// trocar's sleeve.
const PORT_M: f32 = 0.02;
/// Bore of the suction tube, m. No source: a tube of 5 mm with a wall of 0.5 mm.
const BORE_M: f32 = 0.004;
/// Gap from the suction's mouth at which a stone is taken, m: as far as the picture's suction
/// takes fluid.
const TAKES_M: f32 = 0.005;

/// A stone's place between the jaws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Held {
    /// Place in the instrument's frame, m.
    in_instrument_m: Vec3,
    instrument_from_stone: Quat,
}

impl StoneState {
    /// The stone between the jaws: its number.
    pub(crate) fn held(&self) -> Option<usize> {
        self.stones.iter().position(Stone::is_held)
    }

    /// Opening of jaws that would close to `jaw`: a held stone stops them.
    pub(crate) fn stopped(&self, jaw: f32) -> f32 {
        match self.held() {
            Some(_) => jaw.max(self.stop),
            None => jaw,
        }
    }

    /// Catches a stone between jaws that have closed in this tick to their present opening. Returns
    /// true if a stone is held.
    pub(crate) fn close(
        &mut self,
        jaws: &Jaws<'_>,
        scene: &Scene<'_>,
        journal: &mut Journal,
    ) -> bool {
        if self.held().is_some() {
            return true;
        }
        let radius_m = scene.stones.radius_m();
        let instrument_from_world = jaws.world_from_instrument.inverse();
        let (length_m, opening_m) = (
            jaws.instrument.jaw_length_m(),
            jaws.instrument.jaw_opening_m(),
        );
        let mut caught: Option<(usize, Vec3, f32)> = None;
        for (number, stone) in self.all(scene).iter().enumerate() {
            let place_m = (instrument_from_world * nalgebra::Point3::from(stone.at_m)).coords;
            let along = -place_m.z / length_m;
            // Jaws that point past the stone's middle would squeeze it out.
            let is_between = (TOO_DEEP..=1.0).contains(&along)
                && place_m.x.abs() < ACROSS_M + 0.5 * radius_m
                && place_m.y.abs() < opening_m * jaws.jaw * along + ACROSS_M;
            let gap_m = opening_m * jaws.jaw * along - radius_m;
            let fits = opening_m * along >= radius_m;
            if stone.is_free() && is_between && fits && gap_m < CAUGHT_M {
                let off_m = place_m.x.abs() + place_m.y.abs();
                if caught.is_none_or(|(_, it, _)| off_m < it.x.abs() + it.y.abs()) {
                    caught = Some((number, place_m, radius_m / (opening_m * along)));
                }
            }
        }
        let Some((number, place_m, stop)) = caught else {
            return false;
        };
        (self.stop, self.least_opening) = (stop, jaws.jaw);
        self.note(number, EventKind::StoneHeld, journal);
        if let Some(stone) = self.stones.get_mut(number) {
            // Both jaws press, so the stone goes to the middle between them.
            stone.place = Place::Held(Held {
                in_instrument_m: Vec3::new(place_m.x, 0.0, place_m.z),
                instrument_from_stone: instrument_from_world.rotation * stone.turn,
            });
        }
        true
    }

    /// Carries the held stone with the jaws. Lets go when they open, and counts it as retrieved at
    /// the port.
    pub(crate) fn carry(&mut self, jaws: &Jaws<'_>, scene: &Scene<'_>, journal: &mut Journal) {
        self.least_opening = self.least_opening.min(jaws.jaw);
        let (least_opening, port_m) = (self.least_opening, scene.room.instrument_port_m);
        let Some(number) = self.held() else { return };
        let Some(stone) = self.stones.get_mut(number) else {
            return;
        };
        if let Place::Held(held) = stone.place {
            stone.at_m = world_m(jaws.world_from_instrument, &held.in_instrument_m);
            stone.turn = jaws.world_from_instrument.rotation * held.instrument_from_stone;
        }
        if math::norm(&(stone.at_m - port_m)) < PORT_M + scene.stones.radius_m() {
            self.take_out(number, journal);
        } else if jaws.jaw > least_opening + LETS_GO {
            stone.set_free();
            self.note(number, EventKind::StoneDropped, journal);
        }
    }

    /// Takes the held stone out of the body, because the instrument leaves it.
    pub(crate) fn leave_with_instrument(&mut self, journal: &mut Journal) {
        if let Some(number) = self.held() {
            self.take_out(number, journal);
        }
    }

    /// Takes free stones that are smaller than the bore of the suction tube, near its mouth.
    pub(crate) fn suck(&mut self, tip: &Capsule, scene: &Scene<'_>, journal: &mut Journal) {
        if scene.stones.diameter_m >= BORE_M {
            return;
        }
        let reach_m = tip.radius_m + TAKES_M + scene.stones.radius_m();
        for number in 0..self.all(scene).len() {
            let near = |it: &&Stone| it.is_free() && math::norm(&(it.at_m - tip.b_m)) < reach_m;
            if self.stones.get(number).filter(near).is_some() && journal.has_room() {
                self.take_out(number, journal);
            }
        }
    }

    fn take_out(&mut self, number: usize, journal: &mut Journal) {
        self.note(number, EventKind::StoneRetrieved, journal);
        if let Some(stone) = self.stones.get_mut(number) {
            stone.place = Place::Retrieved;
        }
    }

    fn note(&self, number: usize, kind: EventKind, journal: &mut Journal) {
        if let Some(stone) = self.stones.get(number) {
            journal.raise(Event {
                kind,
                organ: None,
                at_m: stone.at_m,
                value: number as f32,
            });
        }
    }
}

/// True for an instrument that holds stones.
pub(crate) fn holds_stones(instrument: Instrument) -> bool {
    instrument == Instrument::Grasper
}

fn world_m(world_from_instrument: &Pose, place_m: &Vec3) -> Vec3 {
    world_from_instrument.rotation * place_m + world_from_instrument.translation.vector
}
