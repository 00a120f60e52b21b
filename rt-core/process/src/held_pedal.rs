//! A pedal that is held down at the start, or when its line returns, counts only after a release.

use rt_core::port::{PedalSample, Polled};

/// Switches of the electrosurgical unit that have been released once. The camera lock is not held
/// back: it gives no current and may be a latching switch.
#[derive(Debug, Default)]
pub(crate) struct HeldPedal {
    cut: bool,
    coagulate: bool,
    /// True while a switch is down that was never released.
    is_held: bool,
}

impl HeldPedal {
    /// Returns `polled` without the switches that were never released.
    pub(crate) fn released_once(&mut self, polled: Polled<PedalSample>) -> Polled<PedalSample> {
        match polled {
            Polled::Fresh(mut sample) => {
                self.cut |= !sample.cut;
                self.coagulate |= !sample.coagulate;
                self.is_held = !(self.cut && self.coagulate);
                sample.cut &= self.cut;
                sample.coagulate &= self.coagulate;
                Polled::Fresh(sample)
            }
            Polled::Lost => {
                *self = Self::default();
                Polled::Lost
            }
            Polled::Nothing => Polled::Nothing,
        }
    }

    /// True while a switch is down that was never released.
    pub(crate) const fn is_held(&self) -> bool {
        self.is_held
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn coagulates(pedal: &mut HeldPedal, coagulate: bool) -> bool {
        let sample = PedalSample {
            coagulate,
            ..PedalSample::default()
        };
        match pedal.released_once(Polled::Fresh(sample)) {
            Polled::Fresh(sample) => sample.coagulate,
            _ => panic!("a sample must stay a sample"),
        }
    }

    #[test]
    fn a_pedal_held_at_the_start_or_on_return_gives_no_current_until_released() {
        let mut pedal = HeldPedal::default();
        assert!(!coagulates(&mut pedal, true));
        assert!(pedal.is_held());
        assert!(!coagulates(&mut pedal, false));
        assert!(coagulates(&mut pedal, true) && !pedal.is_held());
        assert_eq!(pedal.released_once(Polled::Lost), Polled::Lost);
        assert!(!coagulates(&mut pedal, true), "held when it returns");
        assert!(!coagulates(&mut pedal, false));
        assert!(coagulates(&mut pedal, true));
    }
}
