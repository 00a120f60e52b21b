//! State of the sutures that hang organs on the abdominal wall.
//!
//! The scene places the sutures. A task can take them down; then the trainee places each of them
//! (`sim/sew.rs`). The scene then gives only the height of the wall and the shortening of the
//! suture.

use heapless::Vec;

use crate::capacity::MAX_SUTURES;
use crate::hash::Hash;
use crate::math::{self, Vec3};
use crate::scene::{Anchor, Attachment, Scene, is_suture};
use crate::tissue::damage::Damage;

/// Progress of drawing in a hung suture per tick: it has its final length after two seconds.
const DRAW_IN_STEP: f32 = 0.000_5;

/// Stage of placing a suture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Placed {
    /// Not placed.
    Away = 0,
    /// Passes through the organ; its other end is at the instrument.
    AtHand = 1,
    /// Hangs the organ on the wall.
    Hung = 2,
}

/// A suture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Suture {
    /// Stage of placing.
    pub placed: Placed,
    /// Sphere that the suture holds; a sphere of its organ while the suture is not placed.
    pub sphere: u32,
    /// Place at which it passes the wall, world frame, m.
    pub at_m: Vec3,
    /// Length when drawn in, m.
    pub length_m: f32,
    /// Length before it is drawn in, m.
    initial_length_m: f32,
    /// Progress of drawing in, 0 to 1.
    draw_in_progress: f32,
    /// True if the trainee has placed the suture or has yet to place it.
    is_by_trainee: bool,
    is_cut: bool,
}

/// Sutures of a scene, in the order of its attachments.
#[derive(Debug, Clone)]
pub(crate) struct Sutures {
    all: Vec<Suture, MAX_SUTURES>,
    is_pedal_down: bool,
    /// True from a press of the pedal that leads a needle until the pedal is released.
    leads_needle: bool,
}

impl Sutures {
    /// No sutures.
    pub(crate) const NONE: Self = Self {
        all: Vec::new(),
        is_pedal_down: false,
        leads_needle: false,
    };

    /// Hangs all sutures as in the scene, not yet drawn in.
    pub(crate) fn reset(&mut self, scene: &Scene<'_>) {
        self.all.clear();
        for tie in scene.attachments {
            let (Anchor::World(at_m), true, Some(rest)) = (
                tie.to,
                tie.is_thread,
                scene.spheres.get(tie.sphere as usize),
            ) else {
                continue;
            };
            // A scene with more is refused.
            let _ = self.all.push(Suture {
                placed: Placed::Hung,
                sphere: tie.sphere,
                at_m,
                length_m: tie.rest_length_m,
                initial_length_m: math::norm(&(rest.center_m - at_m)),
                draw_in_progress: 0.0,
                is_by_trainee: false,
                is_cut: false,
            });
        }
    }

    /// Takes all sutures down.
    pub(crate) fn take_down(&mut self) {
        for suture in &mut self.all {
            suture.placed = Placed::Away;
            suture.is_by_trainee = true;
        }
    }

    /// Draws hung sutures in by one tick.
    pub(crate) fn draw_in(&mut self) {
        for suture in &mut self.all {
            if suture.placed == Placed::Hung {
                suture.draw_in_progress = (suture.draw_in_progress + DRAW_IN_STEP).min(1.0);
            }
        }
    }

    /// The attachment in its present state; `None` if it is a suture that is not hung. `suture` is
    /// the number of the suture, if the attachment is a suture.
    #[inline]
    pub(crate) fn current(&self, tie: &Attachment, suture: Option<u8>) -> Option<Attachment> {
        if let Some(number) = suture {
            let suture = self.all.get(usize::from(number))?;
            (suture.placed == Placed::Hung).then(|| Attachment {
                sphere: suture.sphere,
                to: Anchor::World(suture.at_m),
                rest_length_m: suture.length_now_m(),
                ..*tie
            })
        } else {
            Some(*tie)
        }
    }

    /// All sutures.
    pub(crate) fn all(&self) -> &[Suture] {
        &self.all
    }

    /// Records the pedal, and whether the instrument holds a needle (`is_sewing`). Returns true if
    /// the pedal was just pressed to lead the needle.
    pub(crate) fn record_pedal(&mut self, is_pedal_down: bool, is_sewing: bool) -> bool {
        let was_down = core::mem::replace(&mut self.is_pedal_down, is_pedal_down);
        let is_needle_pressed = is_pedal_down && !was_down && is_sewing;
        self.leads_needle = is_pedal_down && (self.leads_needle || is_needle_pressed);
        is_needle_pressed
    }

    /// True while the pedal is held down that was pressed to lead a needle.
    pub(crate) const fn leads_needle(&self) -> bool {
        self.leads_needle
    }

    /// The suture to be placed next, and its number.
    pub(crate) fn next_unplaced(&mut self) -> Option<(usize, &mut Suture)> {
        let mut all = self.all.iter_mut().enumerate();
        all.find(|(_, suture)| suture.placed != Placed::Hung)
    }

    /// True if a suture waits to be placed.
    pub(crate) fn has_unplaced(&self) -> bool {
        self.all.iter().any(|it| it.placed != Placed::Hung)
    }

    /// Spheres that wake their organ: the spheres of the trainee's sutures that are being drawn in,
    /// and of sutures just cut.
    pub(crate) fn waking_spheres(
        &mut self,
        scene: &Scene<'_>,
        damage: &Damage,
    ) -> Vec<u32, MAX_SUTURES> {
        let ties = scene.attachments.iter().enumerate();
        let sutures = ties.filter(|(_, tie)| is_suture(tie));
        let mut waking_spheres = Vec::new();
        for (suture, (tie, _)) in self.all.iter_mut().zip(sutures) {
            let is_cut = damage.intact_of_tie(tie) <= 0.0;
            let was_cut = core::mem::replace(&mut suture.is_cut, is_cut);
            let draws = suture.is_by_trainee
                && suture.placed == Placed::Hung
                && suture.draw_in_progress < 1.0;
            if draws || is_cut != was_cut {
                let _ = waking_spheres.push(suture.sphere); // there are no more sutures
            }
        }
        waking_spheres
    }

    /// Adds the sutures that the trainee places to `hash`.
    pub(crate) fn hash_into(&self, hash: &mut Hash) {
        for suture in self.all.iter().filter(|it| it.is_by_trainee) {
            hash.word(u32::from(suture.placed as u8));
            hash.word(suture.sphere);
            hash.vector(&suture.at_m);
            hash.float(suture.draw_in_progress);
        }
    }
}

impl Suture {
    /// Hangs the suture at `at_m`. When drawn in, the suture is `drawn_in_m` shorter than the
    /// distance `initial_length_m` of its ends.
    pub(crate) fn hang(&mut self, at_m: Vec3, initial_length_m: f32, drawn_in_m: f32) {
        self.placed = Placed::Hung;
        self.at_m = at_m;
        self.initial_length_m = initial_length_m;
        self.length_m = (initial_length_m - drawn_in_m).max(0.0);
        self.draw_in_progress = 0.0;
    }

    fn length_now_m(&self) -> f32 {
        if self.draw_in_progress < 1.0 {
            self.length_m
                + (self.initial_length_m - self.length_m).max(0.0) * (1.0 - self.draw_in_progress)
        } else {
            self.length_m
        }
    }
}
