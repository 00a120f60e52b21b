//! Sutures that hang organs on the abdominal wall: where each goes.
//!
//! The scene has placed them; or they are taken down, and the trainee places each, with its place in the scene
//! for nothing but how high the wall is and how much it is drawn in (`sim/sew.rs`).

use heapless::Vec;

use crate::capacity::MAX_SUTURES;
use crate::hash::Hash;
use crate::math::{self, Vec3};
use crate::scene::{Anchor, Attachment, Scene, is_suture};
use crate::tissue::part::Parted;

/// What a tick draws of a suture that is shorter than its ends are apart: it is as short as it will be
/// after two seconds.
const DRAWN_STEP: f32 = 0.000_5;

/// How far a suture is placed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Placed {
    /// Not at all.
    Away = 0,
    /// It goes through the organ, and its other end to the instrument.
    AtHand = 1,
    /// It hangs the organ on the wall.
    Hung = 2,
}

/// A suture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Suture {
    /// How far it is placed.
    pub placed: Placed,
    /// The sphere that it holds; one of the organ that it is for while it is away.
    pub sphere: u32,
    /// Where it goes through the wall, world frame, m.
    pub at_m: Vec3,
    /// How long it is once it is drawn in, m.
    pub length_m: f32,
    /// How long before, m.
    apart_m: f32,
    /// How far it is drawn in, 0 to 1.
    drawn: f32,
    /// The trainee's, not the scene's.
    is_own: bool,
    is_cut: bool,
}

/// A scene's sutures to the world, in the order of its attachments.
#[derive(Debug, Clone)]
pub(crate) struct Sutures {
    all: Vec<Suture, MAX_SUTURES>,
    is_pedal_down: bool,
    /// It was pressed for a needle, and is until it is let go.
    leads_needle: bool,
}

impl Sutures {
    /// None.
    pub(crate) const NONE: Self = Self {
        all: Vec::new(),
        is_pedal_down: false,
        leads_needle: false,
    };

    /// All as the scene has them, not yet drawn in.
    pub(crate) fn rest(&mut self, scene: &Scene<'_>) {
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
                apart_m: math::norm(&(rest.center_m - at_m)),
                drawn: 0.0,
                is_own: false,
                is_cut: false,
            });
        }
    }

    /// Takes all down, for the trainee to place.
    pub(crate) fn take_down(&mut self) {
        for suture in &mut self.all {
            suture.placed = Placed::Away;
            suture.is_own = true;
        }
    }

    /// Draws what hangs in by a tick.
    pub(crate) fn draw_in(&mut self) {
        for suture in &mut self.all {
            if suture.placed == Placed::Hung {
                suture.drawn = (suture.drawn + DRAWN_STEP).min(1.0);
            }
        }
    }

    /// How an attachment is now, which is a suture with this number or none at all; none where that holds nothing.
    #[inline]
    pub(crate) fn now(&self, tie: &Attachment, suture: Option<u8>) -> Option<Attachment> {
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

    /// All of them.
    pub(crate) fn all(&self) -> &[Suture] {
        &self.all
    }

    /// Takes whether a pedal is down, and whether there is a needle in the instrument; says whether it was just
    /// pressed for that.
    pub(crate) fn is_pressed(&mut self, is_pedal_down: bool, is_sewing: bool) -> bool {
        let was_down = core::mem::replace(&mut self.is_pedal_down, is_pedal_down);
        let is_pressed = is_pedal_down && !was_down && is_sewing;
        self.leads_needle = is_pedal_down && (self.leads_needle || is_pressed);
        is_pressed
    }

    /// Whether the pedal that is down was pressed for a needle.
    pub(crate) const fn leads_needle(&self) -> bool {
        self.leads_needle
    }

    /// The one that is to be placed next, and its number.
    pub(crate) fn next(&mut self) -> Option<(usize, &mut Suture)> {
        let mut all = self.all.iter_mut().enumerate();
        all.find(|(_, suture)| suture.placed != Placed::Hung)
    }

    /// Whether there is one to be placed.
    pub(crate) fn are_awaited(&self) -> bool {
        self.all.iter().any(|it| it.placed != Placed::Hung)
    }

    /// The spheres of those that stir what they hold: the trainee's that are being drawn in, and what was just cut.
    pub(crate) fn stirring(&mut self, scene: &Scene<'_>, parted: &Parted) -> Vec<u32, MAX_SUTURES> {
        let ties = scene.attachments.iter().enumerate();
        let own = ties.filter(|(_, tie)| is_suture(tie));
        let mut stirring = Vec::new();
        for (suture, (tie, _)) in self.all.iter_mut().zip(own) {
            let is_cut = parted.left_of_tie(tie) <= 0.0;
            let was_cut = core::mem::replace(&mut suture.is_cut, is_cut);
            let draws = suture.is_own && suture.placed == Placed::Hung && suture.drawn < 1.0;
            if draws || is_cut != was_cut {
                let _ = stirring.push(suture.sphere); // there are no more sutures
            }
        }
        stirring
    }

    /// Adds what the trainee has placed.
    pub(crate) fn add_to(&self, hash: &mut Hash) {
        for suture in self.all.iter().filter(|it| it.is_own) {
            hash.word(u32::from(suture.placed as u8));
            hash.word(suture.sphere);
            hash.vector(&suture.at_m);
            hash.float(suture.drawn);
        }
    }
}

impl Suture {
    /// Hangs it there, `drawn_in_m` shorter than its ends are `apart_m`.
    pub(crate) fn hang(&mut self, at_m: Vec3, apart_m: f32, drawn_in_m: f32) {
        self.placed = Placed::Hung;
        self.at_m = at_m;
        self.apart_m = apart_m;
        self.length_m = (apart_m - drawn_in_m).max(0.0);
        self.drawn = 0.0;
    }

    fn length_now_m(&self) -> f32 {
        if self.drawn < 1.0 {
            self.length_m + (self.apart_m - self.length_m).max(0.0) * (1.0 - self.drawn)
        } else {
            self.length_m
        }
    }
}
