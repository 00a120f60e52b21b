//! Two pedals that act as one. A switch counts as pressed if it is pressed on either pedal.

use rt_core::port::{LineCounters, Pedal, PedalSample, Polled};
use rt_core::time::TimeNs;

/// Two pedals with any drivers. The switches of a silent pedal count as released. If one pedal is
/// lost, both are reported as lost, so that both are opened anew.
pub struct JoinedPedals {
    pedals: [Box<dyn Pedal + Send>; 2],
    pressed: [PedalSample; 2],
}

/// Time without a sample after which a pedal's switches count as released, ns. The core waits for
/// the same time.
const SILENT_NS: u64 = 200_000_000;

impl JoinedPedals {
    /// Joins two pedals.
    #[must_use]
    pub fn new(pedals: [Box<dyn Pedal + Send>; 2]) -> Self {
        Self {
            pedals,
            pressed: [PedalSample::default(); 2],
        }
    }
}

impl Pedal for JoinedPedals {
    fn poll(&mut self, now_ns: TimeNs) -> Polled<PedalSample> {
        let mut is_fresh = false;
        for (pedal, pressed) in self.pedals.iter_mut().zip(&mut self.pressed) {
            match pedal.poll(now_ns) {
                Polled::Fresh(sample) => {
                    *pressed = sample;
                    is_fresh = true;
                }
                Polled::Nothing => {}
                Polled::Lost => return Polled::Lost,
            }
            if now_ns.saturating_sub(pressed.at_ns) > SILENT_NS {
                *pressed = PedalSample {
                    at_ns: pressed.at_ns,
                    ..PedalSample::default()
                };
            }
        }
        if !is_fresh {
            return Polled::Nothing;
        }
        let [one, two] = &self.pressed;
        Polled::Fresh(PedalSample {
            cut: one.cut || two.cut,
            coagulate: one.coagulate || two.coagulate,
            camera_lock: one.camera_lock || two.camera_lock,
            at_ns: one.at_ns.max(two.at_ns),
        })
    }

    fn counters(&self) -> LineCounters {
        let [one, two] = self.pedals.each_ref().map(|pedal| pedal.counters());
        one.plus(two)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::VecDeque;

    const MS: u64 = 1_000_000;

    struct Scripted(VecDeque<Polled<PedalSample>>);

    impl Pedal for Scripted {
        fn poll(&mut self, _now_ns: TimeNs) -> Polled<PedalSample> {
            self.0.pop_front().unwrap_or(Polled::Nothing)
        }

        fn counters(&self) -> LineCounters {
            LineCounters {
                frames: 1,
                ..LineCounters::default()
            }
        }
    }

    fn joined(one: &[Polled<PedalSample>], two: &[Polled<PedalSample>]) -> JoinedPedals {
        JoinedPedals::new([one, two].map(|script| {
            let script = script.iter().copied().collect();
            Box::new(Scripted(script)) as Box<dyn Pedal + Send>
        }))
    }

    fn pressed(cut: bool, camera_lock: bool, at_ns: u64) -> Polled<PedalSample> {
        Polled::Fresh(PedalSample {
            cut,
            coagulate: false,
            camera_lock,
            at_ns,
        })
    }

    #[test]
    fn joined_pedals_press_what_either_presses_and_a_silent_pedal_presses_nothing() {
        let one = [pressed(true, false, MS), Polled::Nothing, Polled::Nothing];
        let two = [
            Polled::Nothing,
            pressed(false, true, 2 * MS),
            pressed(false, false, 300 * MS),
        ];
        let mut pedals = joined(&one, &two);
        assert_eq!(pedals.poll(MS), pressed(true, false, MS));
        assert_eq!(pedals.poll(2 * MS), pressed(true, true, 2 * MS));
        assert_eq!(pedals.poll(300 * MS), pressed(false, false, 300 * MS));
        assert_eq!(pedals.poll(301 * MS), Polled::Nothing);
        assert_eq!(pedals.counters().frames, 2);
    }

    #[test]
    fn one_lost_pedal_loses_both() {
        let mut pedals = joined(&[pressed(true, false, MS)], &[Polled::Lost]);
        assert_eq!(pedals.poll(MS), Polled::Lost);
    }
}
