//! The handle's opening: the jaws follow it, and the fingers feel what the jaws hold or cut.
//!
//! A spring of the device's own stiffness `K` presses on the fingers, so they never feel anything
//! stiffer. The fingers travel by `L` from shut to wide open, the jaws by `g`.
//!
//! - Grasper: the spring joins the fingers to the jaws (a god-object, as
//!   [`crate::haptics::proxy`]). Fingers at `h` and jaws at `j`, both 0 shut to 1 wide open, press
//!   on the fingers with `F = K L (j − h)`, at most with the device's peak, and by virtual work on
//!   the tissue with `F L / g`. The jaws stand where the tissue's resistance balances this. Tissue
//!   is never squeezed harder than the fingers feel. A handle without a motor drives its jaws like
//!   a button: with 4 N at most.
//! - Scissors: the blades are where the fingers are. A cut takes the energy that parts the tissue
//!   (its toughness times the area) over the fingers' way (Mahvash et al. 2008). The spring's
//!   anchor slips when the spring is as strong as the cut (plastic friction, Hayward and Armstrong
//!   2000), so fingers that tremble feel no chatter. Greenish et al. 2002 recorded such forces at
//!   scissors.
//! - Others: the jaws are where the fingers are. No source gives the force that closes a clip.

use crate::port::Opening;
use crate::procedure::grasp::{GRIP_MAX_N, Grasp, Jaws};
use crate::time::TICK_S;
use crate::tool::Instrument;

/// Time in which the jaws close or open fully, s. A surgeon's hand needs 0.5 s (Barrie et al.).
pub(crate) const JAW_TIME_S: f32 = 0.15;
/// Bisections that find the jaws' balance: to 1/65536 of the opening, 0.4 mN at 25 N a travel. Ten
/// leave steps that fingers feel.
const HALVINGS: u32 = 16;
/// Bisections for jaws that a button closes. Nobody feels where they stop.
const BUTTON_HALVINGS: u32 = 10;

/// The drive of the jaws by the handle, and its state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Drive {
    handle: Opening,
    /// Opening of the handle that the jaws follow; `None`: a button closes them.
    hand: Option<f32>,
    /// Opening at which the jaws stand.
    jaw: f32,
    /// Opening at which the spring on the fingers is anchored.
    anchor: f32,
    /// Energy of the present cut for a full closing of the blades, J.
    cut_j: f32,
}

impl Drive {
    pub(crate) const fn new(handle: Opening) -> Self {
        Self {
            handle,
            hand: None,
            jaw: 1.0,
            anchor: 1.0,
            cut_j: 0.0,
        }
    }

    /// Follows a handle that is open by `hand`, no faster than jaws move. If it `takes_up` after a
    /// gap, it follows at once. A sample without an opening leaves it where it was.
    pub(crate) fn follow(&mut self, hand: Option<f32>, takes_up: bool) {
        let Some(hand) = hand.filter(|_| self.handle.is_measured()) else {
            return;
        };
        let step = TICK_S / JAW_TIME_S;
        self.hand = Some(match self.hand {
            Some(last) if !takes_up => last + (hand - last).max(-step).min(step),
            _ => hand,
        });
    }

    /// Opening of the handle that the jaws follow; `None`: a button closes them.
    pub(crate) const fn hand(&self) -> Option<f32> {
        self.hand
    }

    /// Lets the jaws settle where tissue and fingers balance.
    pub(crate) fn settle(&mut self, jaws: &Jaws<'_>, grasp: &Grasp) {
        let Some(hand) = self.hand else {
            return;
        };
        (self.jaw, self.anchor) = match jaws.instrument {
            Instrument::Grasper => {
                let jaw = self.squeezed(hand, jaws, grasp);
                (jaw, jaw)
            }
            Instrument::Scissors => (hand, self.cutting(hand)),
            Instrument::Hook | Instrument::ClipApplier => (hand, hand),
        };
    }

    /// Opening at which the jaws stand after this tick, for a button that is `pressed`: it closes
    /// them. A handle that opens and shuts settles them instead.
    pub(crate) fn jaw(&self, pressed: bool, jaws: &Jaws<'_>, grasp: &Grasp) -> f32 {
        if self.hand.is_some() {
            return self.jaw;
        }
        let step = TICK_S / JAW_TIME_S * if pressed { -1.0 } else { 1.0 };
        let to = (jaws.jaw + step).clamp(0.0, 1.0);
        grasp.stop(jaws, (jaws.jaw, to), BUTTON_HALVINGS, |_| GRIP_MAX_N)
    }

    /// Force of the jaws on the fingers, N: positive opens the handle.
    pub(crate) fn force_n(&self) -> f32 {
        match self.hand {
            Some(hand) if self.handle.is_rendered() => {
                self.spring_n() * (self.anchor - hand).max(0.0)
            }
            _ => 0.0,
        }
    }

    /// Largest force of this instrument's jaws on tissue, N.
    pub(crate) fn grip_max_n(&self, instrument: Instrument) -> f32 {
        if self.hand.is_some() && self.handle.is_rendered() {
            self.handle.force_max_n * self.lever(instrument)
        } else {
            GRIP_MAX_N
        }
    }

    /// Notes the energy that the present cut takes for a full closing of the blades, J.
    pub(crate) const fn note_cut(&mut self, full_closing_j: f32) {
        self.cut_j = full_closing_j;
    }

    /// Force on the fingers when they are a whole travel from the jaws, N.
    fn spring_n(&self) -> f32 {
        self.handle.stiffness_max_n_m * self.handle.travel_m
    }

    /// Ways of the fingers for one of the jaws.
    fn lever(&self, instrument: Instrument) -> f32 {
        self.handle.travel_m / instrument.jaw_opening_m().max(f32::MIN_POSITIVE)
    }

    fn squeezed(&self, hand: f32, jaws: &Jaws<'_>, grasp: &Grasp) -> f32 {
        let most_n = self.grip_max_n(jaws.instrument);
        let spring_n = if self.handle.is_rendered() {
            self.spring_n() * self.lever(jaws.instrument)
        } else {
            f32::MAX // drives its jaws as a button does
        };
        let push_n = |jaw: f32| (spring_n * (jaw - hand)).min(most_n);
        grasp.stop(jaws, (1.0, hand), HALVINGS, push_n)
    }

    fn cutting(&self, hand: f32) -> f32 {
        if !self.handle.is_rendered() {
            return hand;
        }
        // A cut that resists harder than the motor can is felt as hard as the motor can.
        let cut_n = (self.cut_j / self.handle.travel_m).min(self.handle.force_max_n);
        self.anchor.max(hand).min(hand + cut_n / self.spring_n())
    }
}
