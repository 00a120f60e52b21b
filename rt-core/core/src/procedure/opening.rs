//! The handle's opening: the jaws follow it, and the fingers feel the tissue between the jaws.
//!
//! A spring presses on the fingers. Its stiffness `K` is the largest that the device renders
//! stably, so the fingers never feel anything stiffer. The fingers travel by `L` from shut to wide
//! open, the jaws by `g`.
//!
//! - Grasper: the spring joins the fingers to the jaws (a god-object, as in
//!   [`crate::haptics::proxy`]). With the fingers at `h` and the jaws at `j`, both 0 shut to 1 wide
//!   open, the spring presses on the fingers with `F = K L (j − h)`, at most the device's peak. By
//!   virtual work it presses on the tissue with `F L / g`. The jaws stop where the tissue's
//!   resistance balances this force. So tissue is never squeezed harder than the fingers feel. A
//!   handle without a motor drives its jaws as a button does, with 4 N at most.
//! - Scissors: the blades follow the fingers exactly. A cut takes the fracture energy of the tissue
//!   (toughness times area), spread over the travel of the fingers (Mahvash et al. 2008). The
//!   spring's anchor slips when the spring is as strong as the cut (plastic friction, Hayward and
//!   Armstrong 2000), so fingers that tremble feel no chatter. Greenish et al. 2002 recorded such
//!   forces at scissors.
//! - Hook, clip applier and irrigator: the jaws follow the fingers exactly. No force is rendered,
//!   because no source gives the force that closes a clip.

use crate::port::Opening;
use crate::procedure::grasp::{GRIP_MAX_N, Grasp, Jaws};
use crate::time::TICK_S;
use crate::tool::Instrument;

/// Time in which the jaws close or open fully, s. A surgeon's hand needs 0.5 s (Barrie et al.).
pub(crate) const JAW_TIME_S: f32 = 0.15;
/// Bisections that find the balance of the jaws. Sixteen find it to 1/65536 of the opening, which
/// is 0.4 mN for a spring of 25 N over the whole travel. With ten bisections the fingers feel
/// steps.
const BISECTIONS: u32 = 16;
/// Bisections for jaws that a button closes. The hand does not feel where such jaws stop.
const BUTTON_BISECTIONS: u32 = 10;

/// The drive of the jaws by the handle, and its state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct JawDrive {
    handle: Opening,
    /// Opening of the handle that the jaws follow; `None`: a button closes them.
    handle_opening: Option<f32>,
    /// Opening of the jaws.
    jaw: f32,
    /// Opening at which the spring on the fingers is anchored.
    anchor: f32,
    /// Energy that a full closing of the blades would take if all of it cut as now, J.
    cut_j: f32,
}

impl JawDrive {
    pub(crate) const fn new(handle: Opening) -> Self {
        Self {
            handle,
            handle_opening: None,
            jaw: 1.0,
            anchor: 1.0,
            cut_j: 0.0,
        }
    }

    /// Follows a handle that is open by `handle_opening`, no faster than jaws can move. The first
    /// sample after a gap (`is_first`) is followed at once. A sample without an opening changes
    /// nothing.
    pub(crate) fn follow(&mut self, handle_opening: Option<f32>, is_first: bool) {
        let Some(handle_opening) = handle_opening.filter(|_| self.handle.is_measured()) else {
            return;
        };
        let step = TICK_S / JAW_TIME_S;
        self.handle_opening = Some(match self.handle_opening {
            Some(last) if !is_first => last + (handle_opening - last).max(-step).min(step),
            _ => handle_opening,
        });
    }

    /// Opening of the handle that the jaws follow; `None`: a button closes them.
    pub(crate) const fn handle_opening(&self) -> Option<f32> {
        self.handle_opening
    }

    /// Lets the jaws settle where tissue and fingers balance.
    pub(crate) fn settle(&mut self, jaws: &Jaws<'_>, grasp: &Grasp) {
        let Some(handle_opening) = self.handle_opening else {
            return;
        };
        (self.jaw, self.anchor) = match jaws.instrument {
            Instrument::Grasper => {
                let jaw = self.squeezing_opening(handle_opening, jaws, grasp);
                (jaw, jaw)
            }
            Instrument::Scissors => (handle_opening, self.cutting_anchor(handle_opening)),
            Instrument::Hook | Instrument::ClipApplier | Instrument::Irrigator => {
                (handle_opening, handle_opening)
            }
        };
    }

    /// Opening of the jaws after this tick. A button closes the jaws while it is `pressed`. For a
    /// handle that opens and shuts, [`Self::settle`] has computed the opening.
    pub(crate) fn jaw(&self, pressed: bool, jaws: &Jaws<'_>, grasp: &Grasp) -> f32 {
        if self.handle_opening.is_some() {
            return self.jaw;
        }
        let step = TICK_S / JAW_TIME_S * if pressed { -1.0 } else { 1.0 };
        let to = (jaws.jaw + step).clamp(0.0, 1.0);
        grasp.stop(jaws, (jaws.jaw, to), BUTTON_BISECTIONS, |_| GRIP_MAX_N)
    }

    /// Force of the jaws on the fingers, N: positive opens the handle.
    pub(crate) fn force_n(&self) -> f32 {
        match self.handle_opening {
            Some(handle_opening) if self.handle.is_rendered() => {
                self.spring_n() * (self.anchor - handle_opening).max(0.0)
            }
            _ => 0.0,
        }
    }

    /// Largest force of this instrument's jaws on tissue, N.
    pub(crate) fn grip_max_n(&self, instrument: Instrument) -> f32 {
        if self.handle_opening.is_some() && self.handle.is_rendered() {
            self.handle.force_max_n * self.finger_travel_ratio(instrument)
        } else {
            GRIP_MAX_N
        }
    }

    /// Sets the energy that a full closing of the blades would take if all of it cut as now, J.
    pub(crate) const fn set_cut_energy(&mut self, full_closing_j: f32) {
        self.cut_j = full_closing_j;
    }

    /// Force of the spring when the fingers are a whole travel away from the jaws, N.
    fn spring_n(&self) -> f32 {
        self.handle.stiffness_max_n_m * self.handle.travel_m
    }

    /// Travel of the fingers per travel of a jaw.
    fn finger_travel_ratio(&self, instrument: Instrument) -> f32 {
        self.handle.travel_m / instrument.jaw_opening_m().max(f32::MIN_POSITIVE)
    }

    fn squeezing_opening(&self, handle_opening: f32, jaws: &Jaws<'_>, grasp: &Grasp) -> f32 {
        let force_max_n = self.grip_max_n(jaws.instrument);
        let spring_n = if self.handle.is_rendered() {
            self.spring_n() * self.finger_travel_ratio(jaws.instrument)
        } else {
            f32::MAX // `force_max_n` alone limits the jaws, as with a button
        };
        let push_n = |jaw: f32| (spring_n * (jaw - handle_opening)).min(force_max_n);
        grasp.stop(jaws, (1.0, handle_opening), BISECTIONS, push_n)
    }

    fn cutting_anchor(&self, handle_opening: f32) -> f32 {
        if !self.handle.is_rendered() {
            return handle_opening;
        }
        // A cut that resists with more than the motor's peak is felt with the peak.
        let cut_n = (self.cut_j / self.handle.travel_m).min(self.handle.force_max_n);
        self.anchor
            .max(handle_opening)
            .min(handle_opening + cut_n / self.spring_n())
    }
}
