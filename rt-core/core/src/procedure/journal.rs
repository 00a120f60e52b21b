//! Journal: the events of a tick that the host records.

use heapless::Vec;

use crate::capacity::{MAX_EVENTS_PER_TICK, MAX_ORGANS};
use crate::contact::contact_force::ContactForce;
use crate::fault::{FAULT_COUNT, Fault, FaultSet};
use crate::math::Vec3;
use crate::port::PedalSample;
use crate::scene::Organ;
use crate::tool::Tool;
use crate::words::{Event, EventKind};

/// Ticks without contact after which the instrument has left an organ. A tip that trembles at the
/// surface thus makes one contact. A larger value merges more touches into one.
const RELEASE_TICKS: u32 = 50;
/// Rise of the force on an organ that raises another event of the same press, N. It is half of the
/// lowest limit that the rules of assessment set (0.2 N). A press of 10 N raises about a hundred
/// events.
const PRESS_STEP_N: f32 = 0.1;
/// Gain of the low-pass filter of a press's force, per tick: a time constant of 50 ms. The filter
/// removes impacts: a tip that strikes tissue fast has, for some milliseconds, five times the force
/// of the tip at rest.
const PRESS_SHARE: f32 = 1.0 / RELEASE_TICKS as f32;
/// A kind of fault raises an event only after this many ticks without this fault.
const FAULT_QUIET_TICKS: u32 = 1000;

/// Force of the instrument on an organ during a contact.
#[derive(Debug, Clone, Copy, Default)]
struct Press {
    /// Smoothed force, N.
    force_n: f32,
    /// Force in the last event, N.
    reported_n: f32,
}

/// Events of a tick, and the state that prevents repeated events.
#[derive(Debug, Clone, Default)]
pub(crate) struct Journal {
    events: Vec<Event, MAX_EVENTS_PER_TICK>,
    is_full: bool,
    /// Ticks until each organ counts as left; 0 for an organ that is not touched.
    release_ticks: [u32; MAX_ORGANS],
    presses: [Press; MAX_ORGANS],
    /// Current in the last event: 0 none, 1 cutting, 2 coagulating.
    electro: u8,
    /// Ticks until each fault may raise an event again, if it does not recur.
    fault_quiet: [u32; FAULT_COUNT],
}

impl Journal {
    /// Begins a tick.
    pub(crate) fn begin(&mut self) {
        self.events.clear();
        self.is_full = false;
    }

    pub(crate) fn events(&self) -> &[Event] {
        &self.events
    }

    /// Adds an event. If there is no room, the event is lost, and the tick raises a fault.
    pub(crate) fn raise(&mut self, event: Event) {
        self.is_full |= self.events.push(event).is_err();
    }

    /// True if this tick has room for another event.
    pub(crate) fn has_room(&self) -> bool {
        !self.events.is_full()
    }

    /// True if an event of this tick was lost.
    pub(crate) const fn is_full(&self) -> bool {
        self.is_full
    }

    /// Raises contact, press and release events, organ by organ. `force_n` is the force on the
    /// hand.
    pub(crate) fn note_contacts(&mut self, list: &[ContactForce], organs: &[Organ], force_n: f32) {
        for (organ, _) in (0u8..).zip(organs) {
            let contact = list
                .iter()
                .find(|contact| contact.tool == Tool::Instrument && contact.organ == Some(organ));
            let Some(ticks_left) = self.release_ticks.get_mut(usize::from(organ)) else {
                continue;
            };
            let before = *ticks_left;
            *ticks_left = if contact.is_some() {
                RELEASE_TICKS
            } else {
                before.saturating_sub(1)
            };
            let (kind, value) = match (before, *ticks_left) {
                (0, 1..) => (EventKind::Contact, force_n),
                (1.., 0) => (EventKind::Release, 0.0),
                _ => {
                    self.note_press(list, organ);
                    continue;
                }
            };
            if let Some(press) = self.presses.get_mut(usize::from(organ)) {
                *press = Press::default();
            }
            let at_m = contact.map_or_else(Vec3::zeros, |contact| contact.at_m);
            self.raise(Event {
                kind,
                organ: Some(u32::from(organ)),
                at_m,
                value,
            });
        }
    }

    /// Raises an event if the smoothed force on an organ has risen by [`PRESS_STEP_N`] since the
    /// last event of this contact.
    fn note_press(&mut self, list: &[ContactForce], organ: u8) {
        let of_organ = |it: &&ContactForce| it.tool == Tool::Instrument && it.organ == Some(organ);
        let now_n: f32 = list.iter().filter(of_organ).map(|it| it.force_n).sum();
        let Some(press) = self.presses.get_mut(usize::from(organ)) else {
            return;
        };
        press.force_n += (now_n - press.force_n) * PRESS_SHARE;
        let Some(contact) = list.iter().find(of_organ) else {
            return;
        };
        if press.force_n >= press.reported_n + PRESS_STEP_N {
            press.reported_n = press.force_n;
            let (at_m, value) = (contact.at_m, press.force_n);
            self.raise(Event {
                kind: EventKind::Press,
                organ: Some(u32::from(organ)),
                at_m,
                value,
            });
        }
    }

    /// Raises an event when the electrosurgical current changes. Both pedals at once give no
    /// current.
    pub(crate) fn note_electro(&mut self, pedal: &PedalSample, at_m: Vec3) {
        let electro = match (pedal.cut, pedal.coagulate) {
            (true, false) => 1,
            (false, true) => 2,
            _ => 0,
        };
        if electro != self.electro {
            self.electro = electro;
            let value = f32::from(electro);
            self.raise(Event {
                kind: EventKind::Electro,
                organ: None,
                at_m,
                value,
            });
        }
    }

    /// Raises events for faults that a person has to know. A fault that recurs within a second
    /// raises no further event.
    pub(crate) fn note_faults(&mut self, faults: &FaultSet, at_m: Vec3) {
        for fault in Fault::ALL {
            let Some(quiet) = self.fault_quiet.get_mut(usize::from(fault.code())) else {
                continue;
            };
            let may_report = *quiet == 0;
            *quiet = quiet.saturating_sub(1);
            if faults.contains(fault) && fault.is_alarm() {
                *quiet = FAULT_QUIET_TICKS;
                if may_report {
                    let value = f32::from(fault.code());
                    self.raise(Event {
                        kind: EventKind::Fault,
                        organ: None,
                        at_m,
                        value,
                    });
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Inside, Material};

    const ORGAN: Organ = Organ {
        sphere_start: 0,
        sphere_count: 0,
        link_start: 0,
        link_count: 0,
        elastic_links: 0,
        batch_start: 0,
        batch_count: 0,
        substeps: 1,
        gravity_share: 1.0,
        breath_m: Vec3::new(0.0, 0.0, 0.0),
        inside: Inside::Solid,
        material: Material {
            young_pa: 0.0,
            poisson: 0.0,
            retardation_s: 0.0,
            stretch_stiffness: 0.0,
            laplacian_stiffness: 0.0,
            damping_per_s: 0.0,
            contact_stiffness_n_m: 0.0,
            friction: 0.0,
            toughness_j_m2: 0.0,
        },
    };

    fn contact(organ: u8) -> ContactForce {
        let zero = Vec3::new(0.0, 0.0, 0.0);
        ContactForce {
            tool: Tool::Instrument,
            organ: Some(organ),
            at_m: zero,
            normal: zero,
            force_n: 0.0,
            stiffness_n_m: 0.0,
            friction_n: zero,
            friction_stiffness_n_m: 0.0,
        }
    }

    fn kinds(journal: &Journal) -> Vec<(EventKind, Option<u32>), 8> {
        journal
            .events()
            .iter()
            .map(|event| (event.kind, event.organ))
            .collect()
    }

    #[test]
    fn a_trembling_tip_raises_one_contact_and_one_release() {
        let mut journal = Journal::default();
        let organs = [ORGAN; 2];
        journal.note_contacts(&[contact(1)], &organs, 0.5);
        assert_eq!(kinds(&journal), [(EventKind::Contact, Some(1))]);
        for tick in 0..2 * RELEASE_TICKS {
            journal.begin();
            let list = [contact(1)];
            journal.note_contacts(if tick % 10 == 0 { &list } else { &[] }, &organs, 0.5);
            assert!(journal.events().is_empty());
        }
        let mut released = 0;
        for _ in 0..2 * RELEASE_TICKS {
            journal.begin();
            journal.note_contacts(&[], &organs, 0.0);
            released += journal.events().len();
        }
        assert_eq!(released, 1);
    }

    #[test]
    fn a_press_is_reported_when_its_force_rises_and_again_at_the_next_contact() {
        let mut journal = Journal::default();
        let organs = [ORGAN; 2];
        // Presses with this force for these ticks. Returns the force of the last event.
        let mut press = |force_n: f32, ticks: u32| {
            let half = ContactForce {
                force_n: 0.5 * force_n,
                ..contact(1)
            };
            let endoscope = ContactForce {
                tool: Tool::Endoscope,
                force_n: 9.0,
                ..contact(1)
            };
            let mut reported_n = 0.0;
            for _ in 0..ticks {
                journal.begin();
                journal.note_contacts(&[half, half, endoscope], &organs, 9.0);
                let mut events = journal.events().iter();
                let last = events.rfind(|it| it.kind == EventKind::Press);
                reported_n = last.map_or(reported_n, |it| it.value);
            }
            reported_n
        };
        assert!(press(1.5, 2) <= 0.0, "a blow of 2 ms");
        let reported = [press(0.35, 500), press(0.35, 500), press(0.6, 500)];
        assert!((0.2..0.35).contains(&reported[0]), "{reported:?}");
        assert!(
            reported[1] <= 0.0 && (0.5..0.6).contains(&reported[2]),
            "{reported:?}"
        );
        for _ in 0..2 * RELEASE_TICKS {
            journal.begin();
            journal.note_contacts(&[], &organs, 0.0);
        }
        let mut reported = 0;
        for _ in 0..500 {
            let again = ContactForce {
                force_n: 0.15,
                ..contact(1)
            };
            journal.begin();
            journal.note_contacts(&[again], &organs, 0.0);
            let is_press = |it: &&Event| it.kind == EventKind::Press;
            reported += journal.events().iter().filter(is_press).count();
        }
        assert_eq!(reported, 1);
    }

    #[test]
    fn a_changed_current_raises_an_event_and_both_pedals_give_no_current() {
        let mut journal = Journal::default();
        let pedal = |cut, coagulate| PedalSample {
            cut,
            coagulate,
            ..PedalSample::default()
        };
        let presses = [
            (pedal(true, false), Some(1.0)),
            (pedal(true, false), None),
            (pedal(true, true), Some(0.0)),
            (pedal(false, true), Some(2.0)),
            (pedal(false, false), Some(0.0)),
        ];
        for (pedal, value) in presses {
            journal.begin();
            journal.note_electro(&pedal, Vec3::zeros());
            assert_eq!(journal.events().first().map(|event| event.value), value);
        }
    }

    #[test]
    fn a_recurring_fault_is_reported_once_and_a_limited_force_not_at_all() {
        let mut journal = Journal::default();
        let (mut reported, mut faults) = (0, FaultSet::NONE);
        faults.raise(Fault::StaleDevice);
        faults.raise(Fault::Slewed);
        for tick in 0..4 * FAULT_QUIET_TICKS {
            journal.begin();
            let now = if tick % 2 == 0 {
                faults
            } else {
                FaultSet::NONE
            };
            journal.note_faults(&now, Vec3::zeros());
            reported += journal.events().len();
        }
        assert_eq!(reported, 1, "the fault never paused for a second");
    }

    #[test]
    fn a_lost_event_is_noticed() {
        let mut journal = Journal::default();
        let event = Event {
            kind: EventKind::Grasp,
            organ: None,
            at_m: Vec3::zeros(),
            value: 0.0,
        };
        for i in 0..=MAX_EVENTS_PER_TICK {
            assert_eq!(journal.has_room(), i < MAX_EVENTS_PER_TICK);
            journal.raise(event);
        }
        assert!(journal.is_full());
        assert_eq!(journal.events().len(), MAX_EVENTS_PER_TICK);
    }
}
