//! A hold: the trainee shows something and holds the picture still. A [`Hold`] gives the share of
//! the required time that is over, and the picture's fault.

use crate::rules::Steadiness;
use crate::steady::Held;

/// Fault of a picture that is to be held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Lack {
    /// The lens is on the other side of the triangle, or looks along its plane.
    Side,
    /// The triangle or the lower third of the bed is not cleared yet.
    Uncleared,
    /// Too little of the cleared triangle is seen.
    Triangle,
    /// Too little of the freed bed is seen.
    LowerBed,
    /// Too little of cystic duct or artery is seen.
    Two,
    /// Too little of the organ is in the picture.
    OutOfView,
    /// Something hides the organ.
    Hidden,
    /// The organ is not in the middle of the picture.
    Aside,
    /// The organ is too small in the picture.
    Small,
    /// The picture sways.
    Sway,
    /// The horizon is tilted.
    Tilt,
}

/// State of a running hold.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Hold {
    /// Share of the required time that is over, 0 to 1.
    pub share: f64,
    /// Fault of the picture; `None` while it counts.
    pub lack: Option<Lack>,
}

/// The running time of a hold.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Timer {
    /// True if the last picture counted.
    is_good: bool,
    held_s: f64,
    path_m: f64,
    lack: Option<Lack>,
}

impl Timer {
    /// Takes a picture with this fault, if any, and its movement since the last one. Returns path
    /// (m) and time (s) of the hold once it has lasted `hold_s`, and begins anew.
    pub(crate) fn look(
        &mut self,
        lack: Option<Lack>,
        held: &Held,
        steadiness: &Steadiness,
        hold_s: f64,
    ) -> Option<[f64; 2]> {
        self.lack = lack.or_else(|| steadiness.lack(held));
        let was_good = core::mem::replace(&mut self.is_good, self.lack.is_none());
        if !self.is_good {
            (self.held_s, self.path_m) = (0.0, 0.0);
        } else if was_good {
            // The time before the first picture that counts is left out.
            self.held_s += held.seconds;
            self.path_m += held.path_m;
        }
        let done = [self.path_m, self.held_s];
        (self.held_s >= hold_s).then(|| {
            *self = Self::default();
            done
        })
    }

    pub(crate) fn hold(&self, hold_s: f64) -> Hold {
        Hold {
            share: (self.held_s / hold_s.max(1e-6)).clamp(0.0, 1.0),
            lack: self.lack,
        }
    }
}
