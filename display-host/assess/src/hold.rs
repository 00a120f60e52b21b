//! A hold: the trainee shows something and holds the picture still. A [`Hold`] gives the share of
//! the required time that is over, and the picture's fault.
//!
//! A hand that holds an endoscope corrects its place now and then. A correction that sways the
//! picture pauses the hold, and only a longer sway ends it. The whole hold, with its pauses, must
//! be as steady as the rules ask, or it begins anew.

use crate::rules::Steadiness;
use crate::steady::Held;

/// Longest sway that pauses a hold, s. Voluntary movements of a hand have 99 % of their power below
/// 2 Hz (Riviere, Rader and Khosla 1997, kilthub.cmu.edu 6621335), so one of them, to and fro,
/// takes about this time. Tremor of a hand, 0.05 to 0.2 mm at 8 to 12 Hz (PMC3989364), is no sway:
/// smoothing and leash of the paths take it out.
const CORRECTION_S: f64 = 0.5;

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
    /// Nobody has moved the endoscope yet, so the picture is nobody's work.
    Unled,
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
    /// Time of the sway that pauses the hold, s.
    swayed_s: f64,
    /// Path of the hold, m, and its time, s, with its pauses.
    whole: [f64; 2],
    lack: Option<Lack>,
}

impl Timer {
    /// Takes a picture with this fault, if any, and its movement since the last one. Returns path
    /// (m) and time (s) of the hold, with its pauses, once it has lasted `hold_s` without them, and
    /// begins anew.
    pub(crate) fn look(
        &mut self,
        lack: Option<Lack>,
        held: &Held,
        steadiness: &Steadiness,
        hold_s: f64,
    ) -> Option<[f64; 2]> {
        self.lack = lack.or_else(|| steadiness.lack(held));
        let was_good = core::mem::replace(&mut self.is_good, self.lack.is_none());
        match self.lack {
            None if was_good => {
                self.held_s += held.seconds;
                self.goes_on(held);
            }
            // The hold goes on after a pause. The time before the first picture that counts is left
            // out.
            None if self.held_s > 0.0 => self.goes_on(held),
            None => {}
            Some(Lack::Sway)
                if self.held_s > 0.0 && self.swayed_s + held.seconds <= CORRECTION_S =>
            {
                let swayed_s = self.swayed_s + held.seconds;
                self.goes_on(held);
                self.swayed_s = swayed_s;
            }
            Some(_) => self.begin(),
        }
        if self.held_s < hold_s {
            return None;
        }
        let whole @ [path_m, seconds] = self.whole;
        let mean = Held {
            seconds,
            path_m,
            ..*held
        };
        self.begin();
        self.lack = steadiness.lack(&mean);
        self.is_good = false;
        self.lack.is_none().then_some(whole)
    }

    /// Counts a movement of the picture to the whole hold, and ends a pause.
    fn goes_on(&mut self, held: &Held) {
        let [path_m, seconds] = &mut self.whole;
        *path_m += held.path_m;
        *seconds += held.seconds;
        self.swayed_s = 0.0;
    }

    fn begin(&mut self) {
        (self.held_s, self.swayed_s, self.whole) = (0.0, 0.0, [0.0; 2]);
    }

    pub(crate) fn hold(&self, hold_s: f64) -> Hold {
        Hold {
            share: (self.held_s / hold_s.max(1e-6)).clamp(0.0, 1.0),
            lack: self.lack,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEADY: Steadiness = Steadiness {
        sway_mm_s: 30.0,
        tilt_deg: 20.0,
    };

    /// Number of pictures, five a second, until a hold of 1.5 s is over, and its mean sway, mm/s.
    /// `sway` gives the sway before each picture, mm/s, or none for a hidden organ.
    fn held(sway: impl Fn(usize) -> Option<f64>) -> Option<(usize, f64)> {
        let mut timer = Timer::default();
        (0..100).find_map(|number| {
            let (lack, mm_s) = match sway(number) {
                Some(mm_s) => (None, mm_s),
                None => (Some(Lack::Hidden), 0.0),
            };
            let held = Held {
                seconds: 0.2,
                path_m: mm_s * 0.2e-3,
                tilt_deg: 0.0,
            };
            let [path_m, seconds] = timer.look(lack, &held, &STEADY, 1.5)?;
            Some((number, path_m / seconds * 1e3))
        })
    }

    #[test]
    fn a_correction_pauses_a_hold_and_a_long_sway_ends_it() {
        let (still, _) = held(|_| Some(4.0)).unwrap();
        let jerks = |from: usize, to: usize| {
            held(move |number| {
                Some(if (from..to).contains(&number) {
                    60.0
                } else {
                    4.0
                })
            })
        };
        let (paused, mean) = jerks(5, 7).unwrap();
        // Two pictures sway, and the first steady one after them ends the pause.
        assert_eq!(paused, still + 3);
        assert!((10.0..20.0).contains(&mean), "{mean}");
        let (anew, mean) = jerks(5, 8).unwrap();
        assert_eq!(anew, still + 8);
        assert!((mean - 4.0).abs() < 1e-9, "{mean}");
    }

    #[test]
    fn a_hidden_organ_ends_a_hold_at_once() {
        let (still, _) = held(|_| Some(4.0)).unwrap();
        let hidden = held(|number| (number != 5).then_some(4.0)).unwrap();
        assert_eq!(hidden.0, still + 6);
    }

    /// Every third picture sways. Nothing is held if the mean is beyond the limit.
    #[test]
    fn a_hold_that_sways_beyond_the_limit_on_the_mean_begins_anew() {
        let sways = |mm_s: f64| held(move |number| Some(if number % 3 == 0 { mm_s } else { 4.0 }));
        let (_, mean) = sways(60.0).unwrap();
        assert!((20.0..30.0).contains(&mean), "{mean}");
        assert_eq!(sways(120.0), None);
    }
}
