//! Handle buttons that act as a pedal. They never reach the simulation as buttons.

use hardware::station::HandleButtons;
use rt_core::port::{DeviceSample, PedalSample, Polled};
use rt_core::time::TimeNs;

/// Time without a sample after which the handle's buttons count as released, ns.
const SILENT_NS: TimeNs = 500_000_000;

/// State of the handle's pedal buttons.
#[derive(Debug, Default)]
pub(crate) struct HandlePedal {
    buttons: HandleButtons,
    pressed: PedalSample,
    /// Last state of the pedal itself.
    pedal: PedalSample,
    /// True if the joined state may have changed since it was last returned.
    has_news: bool,
}

impl HandlePedal {
    pub(crate) fn new(buttons: HandleButtons) -> Self {
        Self {
            buttons,
            ..Self::default()
        }
    }

    /// Stores the buttons that act as a pedal, and removes them from the handle's sample.
    pub(crate) fn take(&mut self, polled: &mut Polled<DeviceSample>) {
        match polled {
            Polled::Fresh(sample) => {
                let held = |bit: u8| sample.buttons.0 & bit != 0;
                let [cut, coagulate, camera_lock] = self.buttons.bits();
                self.pressed = PedalSample {
                    cut: held(cut),
                    coagulate: held(coagulate),
                    camera_lock: held(camera_lock),
                    at_ns: sample.at_ns,
                };
                sample.buttons.0 &= !(cut | coagulate | camera_lock);
                self.has_news = true;
            }
            Polled::Lost => self.release(),
            Polled::Nothing => {}
        }
    }

    /// Joins the states of the pedal and of the handle's buttons. A lost pedal stays lost, even if
    /// a button of the handle is pressed.
    pub(crate) fn join(
        &mut self,
        pedal: Polled<PedalSample>,
        now_ns: TimeNs,
    ) -> Polled<PedalSample> {
        if self.buttons == HandleButtons::default() {
            return pedal;
        }
        if now_ns.saturating_sub(self.pressed.at_ns) > SILENT_NS {
            self.release();
        }
        match pedal {
            Polled::Fresh(sample) => self.pedal = sample,
            Polled::Lost => {
                self.pedal = PedalSample::default();
                return Polled::Lost;
            }
            Polled::Nothing if !self.has_news => return Polled::Nothing,
            Polled::Nothing => {}
        }
        self.has_news = false;
        let (own, other) = (&self.pressed, &self.pedal);
        Polled::Fresh(PedalSample {
            cut: own.cut || other.cut,
            coagulate: own.coagulate || other.coagulate,
            camera_lock: own.camera_lock || other.camera_lock,
            at_ns: now_ns,
        })
    }

    fn release(&mut self) {
        let pressed = &self.pressed;
        self.has_news |= pressed.cut || pressed.coagulate || pressed.camera_lock;
        self.pressed = PedalSample {
            at_ns: pressed.at_ns,
            ..PedalSample::default()
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_core::math::Pose;
    use rt_core::port::Buttons;

    fn handle(buttons: u8, at_ns: TimeNs) -> Polled<DeviceSample> {
        Polled::Fresh(DeviceSample {
            opening: None,
            device_from_handle: Pose::identity(),
            velocity_m_s: None,
            buttons: Buttons(buttons),
            sequence: 0,
            at_ns,
        })
    }

    fn pressed(polled: Polled<PedalSample>) -> Option<[bool; 3]> {
        match polled {
            Polled::Fresh(sample) => Some([sample.cut, sample.coagulate, sample.camera_lock]),
            _ => None,
        }
    }

    fn second_coagulates() -> HandlePedal {
        HandlePedal::new(HandleButtons {
            coagulate: Some(2),
            ..HandleButtons::default()
        })
    }

    #[test]
    fn pedal_button_of_the_handle_acts_as_pedal_and_not_as_button() {
        let mut pedal = second_coagulates();
        let mut polled = handle(0b11, 1000);
        pedal.take(&mut polled);
        assert_eq!(polled, handle(0b01, 1000));
        let joined = pedal.join(Polled::Nothing, 1000);
        assert_eq!(pressed(joined), Some([false, true, false]));
        assert_eq!(
            pedal.join(Polled::Nothing, 1001),
            Polled::Nothing,
            "no news"
        );
        // The pedal itself works too.
        let foot = PedalSample {
            cut: true,
            ..PedalSample::default()
        };
        let joined = pedal.join(Polled::Fresh(foot), 1002);
        assert_eq!(pressed(joined), Some([true, true, false]));
    }

    #[test]
    fn buttons_of_a_lost_or_silent_handle_are_released() {
        let mut pedal = second_coagulates();
        pedal.take(&mut handle(0b10, 1000));
        let _ = pedal.join(Polled::Nothing, 1000);
        pedal.take(&mut Polled::Lost);
        assert_eq!(pressed(pedal.join(Polled::Nothing, 1001)), Some([false; 3]));
        pedal.take(&mut handle(0b10, 2000));
        let _ = pedal.join(Polled::Nothing, 2000);
        let later = pedal.join(Polled::Nothing, 2001 + SILENT_NS);
        assert_eq!(pressed(later), Some([false; 3]));
        assert_eq!(pedal.join(Polled::Lost, 3000 + SILENT_NS), Polled::Lost);
    }

    #[test]
    fn handle_without_pedal_buttons_changes_nothing() {
        let mut pedal = HandlePedal::default();
        let mut polled = handle(0xff, 1);
        pedal.take(&mut polled);
        assert_eq!(polled, handle(0xff, 1));
        assert_eq!(pedal.join(Polled::Nothing, 1), Polled::Nothing);
    }
}
