//! A photodiode on a switch of a board that speaks the rig protocol as a pedal.

use std::path::Path;

use rt_core::port::{Pedal, PedalSample, Polled};
use rt_core::time::TimeNs;

use super::sensor::{LightInput, Seen};
use crate::HardwareError;
use crate::rig::RigPedal;

/// A sensor on a pedal's switches: any pressed switch means light.
#[derive(Debug)]
pub struct PedalLight<P>(P);

/// A sensor on a board that speaks the rig protocol.
pub type BoardLight = PedalLight<RigPedal>;

impl BoardLight {
    /// Opens the line and greets the board. Waits up to 5 s for its answer.
    ///
    /// # Errors
    ///
    /// A line that does not open, or no pedal on it.
    pub fn open(path: &Path) -> Result<Self, HardwareError> {
        RigPedal::open(path).map(Self)
    }
}

impl<P> PedalLight<P> {
    /// The sensor on any pedal.
    pub const fn on(pedal: P) -> Self {
        Self(pedal)
    }
}

impl<P: Pedal + Send> LightInput for PedalLight<P> {
    fn look(&mut self, now_ns: TimeNs) -> Seen {
        match self.0.poll(now_ns) {
            Polled::Nothing => Seen::Nothing,
            Polled::Lost => Seen::Lost,
            Polled::Fresh(PedalSample {
                cut,
                coagulate,
                camera_lock,
                at_ns,
            }) => Seen::Level {
                bright: cut || coagulate || camera_lock,
                at_ns,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rt_core::port::LineCounters;

    struct ScriptedPedal(std::vec::IntoIter<Polled<PedalSample>>);

    impl Pedal for ScriptedPedal {
        fn poll(&mut self, _: TimeNs) -> Polled<PedalSample> {
            self.0.next().unwrap_or(Polled::Lost)
        }

        fn counters(&self) -> LineCounters {
            LineCounters::default()
        }
    }

    #[test]
    fn every_change_of_a_switch_counts_as_light_at_the_time_of_its_report() {
        let pressed = |at_ns, [cut, coagulate, camera_lock]: [bool; 3]| {
            Polled::Fresh(PedalSample {
                cut,
                coagulate,
                camera_lock,
                at_ns,
            })
        };
        let reports = vec![
            pressed(10, [false; 3]),
            Polled::Nothing,
            pressed(20, [true, false, false]),
            pressed(30, [false, true, false]),
            pressed(40, [false, false, true]),
        ];
        let mut light = PedalLight::on(ScriptedPedal(reports.into_iter()));
        let level = |bright, at_ns| Seen::Level { bright, at_ns };
        let mut look = || light.look(1000);
        assert_eq!(look(), level(false, 10));
        assert_eq!(look(), Seen::Nothing);
        assert_eq!(
            [look(), look(), look()],
            [20, 30, 40].map(|at| level(true, at))
        );
        assert_eq!(look(), Seen::Lost);
    }
}
