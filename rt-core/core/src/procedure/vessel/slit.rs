//! Slits: tubes that are torn, cut or burnt half through, and stay so.

use crate::procedure::vessel::hole::{Hole, Opening};
use crate::procedure::vessel::{Progress, Vessels};
use crate::scene::{Inside, Scene};
use crate::tissue::Bodies;

/// Remaining share of the stiffness of a link with a damage of one half: `(1 − d) / (1 + d)` with
/// `d = 1/2` (`tissue::damage`).
const HALF_CUT_INTACT: f32 = 1.0 / 3.0;
/// Time for which a link is half severed before it leaks, ticks. A division that continues is
/// complete by then: fibres tear within 50 ms, and jaws that a button closes shut within 150 ms.
const SLIT_DELAY_TICKS: u32 = 100;

impl Vessels {
    /// Finds links of tubes that have become half severed. O(links of vessels and ducts).
    pub(super) fn find_slits(&mut self, scene: &Scene<'_>, bodies: &Bodies) {
        for hole in self.holes.iter_mut().filter(|it| it.delay_ticks > 0) {
            hole.delay_ticks -= 1;
            if hole.delay_ticks == 0 {
                self.progress = Progress::Changed;
            }
        }
        let mut without_room = 0;
        for (organ, it) in (0u8..).zip(scene.organs) {
            if !matches!(it.inside, Inside::Blood | Inside::Bile) {
                continue;
            }
            for segment in bodies.beads.segments_of(organ) {
                let intact = bodies.damage.intact_of_link(segment.link);
                if intact > HALF_CUT_INTACT || intact <= 0.0 {
                    continue;
                }
                let (link, sphere) = (segment.link, u32::from(segment.a));
                let slit = Opening::Slit { link, sphere };
                if !self.is_open(slit) {
                    let delay_ticks = SLIT_DELAY_TICKS;
                    let hole = Hole {
                        delay_ticks,
                        ..Hole::new(slit)
                    };
                    without_room += usize::from(self.holes.push(hole).is_err());
                }
            }
        }
        // A slit without room is found again in each tick. It is reported as lost only once.
        self.has_lost_leak |= without_room > self.slits_without_room;
        self.slits_without_room = without_room;
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::math::Vec3;
    use crate::procedure::clip::Clips;
    use crate::procedure::journal::Journal;
    use crate::scene::Link;
    use crate::scene::tests::{organ, room, sphere};
    use crate::words::EventKind;
    use std::boxed::Box;
    use std::vec::Vec;

    /// Runs `work` on an artery of eleven spheres that is held at its left end. `intact` is the
    /// intact share of the stiffness of link 5.
    fn on_artery(intact: f32, work: impl FnOnce(&Scene<'_>, &mut crate::state::State)) {
        let spheres: Vec<_> = (0..11)
            .map(|i| crate::scene::RestSphere {
                held: i == 0,
                ..sphere(Vec3::new(0.002 * i as f32, 0.0, 0.0), 0.001)
            })
            .collect();
        let links: Vec<_> = (0..10)
            .map(|a| Link {
                a,
                b: a + 1,
                rest_length_m: 0.002,
                compliance_m_n: 0.2,
            })
            .collect();
        let organs = [crate::scene::Organ {
            inside: Inside::Blood,
            ..organ(0, 11, 0, 10)
        }];
        let scene = Scene::new(&organs, &spheres, &links, room()).expect("sound");
        let mut state = Box::new(crate::state::State::new());
        state.bodies.load(&scene);
        state.bodies.begin(&scene, true);
        state.bodies.damage.weaken_link(5, intact);
        work(&scene, &mut state);
    }

    /// Events (kind and value) of the artery, which is divided at link 5 after half of the ticks if
    /// `is_divided`.
    fn reported(intact: f32, ticks: u32, is_divided: bool) -> Vec<(EventKind, f32)> {
        let mut events = Vec::new();
        on_artery(intact, |scene, state| {
            let (clips, mut journal) = (Clips::default(), Journal::default());
            for tick in 0..ticks {
                journal.begin();
                if is_divided && tick == ticks / 2 {
                    state.bodies.damage.sever_link(5);
                    state.vessels.mark_changed();
                }
                let (bodies, vessels) = (&mut state.bodies, &mut state.vessels);
                vessels.flow(scene, &clips, bodies, &mut journal);
                events.extend(journal.events().iter().map(|it| (it.kind, it.value)));
            }
        });
        events
    }

    #[test]
    fn a_slit_without_room_is_reported_once() {
        on_artery(0.3, |scene, state| {
            let sphere = 0;
            let hole = Hole::new(Opening::TornOff { sphere });
            while state.vessels.holes.push(hole).is_ok() {}
            let lost_leaks = |state: &mut crate::state::State, ticks| {
                let found = (0..ticks).map(|_| {
                    state.vessels.find_slits(scene, &state.bodies);
                    state.vessels.take_lost_leak()
                });
                found.collect::<Vec<_>>()
            };
            assert_eq!(lost_leaks(state, 3), [true, false, false]);
            state.bodies.damage.weaken_link(7, 0.3);
            assert_eq!(lost_leaks(state, 2), [true, false], "another slit");
        });
    }

    #[test]
    fn a_vessel_that_stays_half_parted_leaks_half() {
        assert_eq!(
            reported(0.4, 300, false),
            [],
            "a little more than half is left"
        );
        assert_eq!(
            reported(0.3, SLIT_DELAY_TICKS, false),
            [],
            "the division may still continue"
        );
        let both = [(EventKind::Perforation, 0.0), (EventKind::Leak, 0.5)];
        assert_eq!(reported(0.3, 300, false), both);
    }

    #[test]
    fn quick_division_is_no_slit_and_late_division_leaks_at_its_end() {
        let kinds = |ticks| {
            let events = reported(0.3, ticks, true);
            events.iter().map(|it| it.0).collect::<Vec<_>>()
        };
        assert_eq!(kinds(150), [EventKind::Divided, EventKind::Leak]);
        let all = reported(0.3, 600, true);
        let leaks = all.iter().filter(|it| it.0 == EventKind::Leak);
        assert_eq!(leaks.map(|it| it.1).collect::<Vec<_>>(), [0.5, 0.0, 1.0]);
    }
}
