//! History of leaks in a session. A display shows each leak until an event changes it. So after a
//! jump in time the display must get the state of all leaks.

use shared_mem::inputs::InputRecord;
use shared_mem::message::{CommandMsg, EventMsg};
use shared_mem::words::EventKind;

/// Largest number of changes kept; a session has some dozens.
const KEPT: usize = 4096;

/// A change of leaks at a tick.
enum Change {
    /// A leak event.
    Leak(EventMsg),
    /// The organs were reset, which closes all leaks.
    AllClosed,
}

/// Changes of leaks in the ticks that have run.
#[derive(Default)]
pub(super) struct Leaks(Vec<(u64, Change)>);

/// True if this tick resets the organs, to rest or to the start of a task.
pub(super) fn puts_back(record: &InputRecord) -> bool {
    let command = u32::from(record.command & 15);
    [CommandMsg::RESET, CommandMsg::START].contains(&command)
}

impl Leaks {
    /// Stores the changes of a tick.
    pub(super) fn keep(
        &mut self,
        tick: u64,
        record: &InputRecord,
        events: impl Iterator<Item = EventMsg>,
    ) {
        let room = KEPT.saturating_sub(self.0.len());
        let leaks = events.filter(|event| event.is(EventKind::Leak));
        // In a tick, a command takes effect before the events occur.
        let put_back = puts_back(record).then_some(Change::AllClosed);
        let changes = put_back.into_iter().chain(leaks.map(Change::Leak));
        self.0.extend(changes.take(room).map(|it| (tick, it)));
    }

    /// True if the organs were reset in the ticks after `from` and before `to`.
    pub(super) fn were_put_back(&self, from: u64, to: u64) -> bool {
        let mut changes = self.0.iter();
        changes
            .any(|(at, change)| matches!(change, Change::AllClosed) && (from + 1..to).contains(at))
    }

    /// All places that leak in any tick run so far, each with its state at `tick`. A leak that is
    /// closed at `tick`, or starts later, has the value 0. Open leaks come last, for displays that
    /// keep only the newest.
    pub(super) fn at(&self, tick: u64) -> Vec<EventMsg> {
        let place = |event: &EventMsg| (event.organ, event.at_m.map(f32::to_bits));
        let mut places: Vec<EventMsg> = Vec::new();
        for (at, change) in &self.0 {
            let is_past = *at <= tick;
            match change {
                Change::AllClosed if is_past => places.iter_mut().for_each(|it| it.value = 0.0),
                Change::AllClosed => {}
                Change::Leak(event) => {
                    let value = if is_past { event.value } else { 0.0 };
                    match places.iter_mut().find(|it| place(it) == place(event)) {
                        Some(known) if is_past => known.value = value,
                        Some(_) => {}
                        None => places.push(EventMsg { value, ..*event }),
                    }
                }
            }
        }
        places.sort_by_key(|it| it.value > 0.0);
        places
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable as _;

    use super::*;

    #[test]
    fn leaks_at_a_tick_have_the_state_of_that_tick() {
        let leak = |x: f32, value: f32| EventMsg {
            kind: EventKind::Leak.number(),
            at_m: [x, 0.0, 0.0],
            value,
            ..EventMsg::zeroed()
        };
        let mut leaks = Leaks::default();
        let mut reset = InputRecord::zeroed();
        reset.command = CommandMsg::RESET as u8;
        let none = InputRecord::zeroed();
        leaks.keep(10, &none, [leak(1.0, 0.5)].into_iter());
        leaks.keep(20, &none, [leak(2.0, 1.0), leak(1.0, 0.0)].into_iter());
        leaks.keep(30, &reset, [leak(3.0, 0.25)].into_iter());
        let at = |tick| -> Vec<(f32, f32)> {
            let places = leaks.at(tick).into_iter();
            places.map(|it| (it.at_m[0], it.value)).collect()
        };
        assert_eq!(at(9), [(1.0, 0.0), (2.0, 0.0), (3.0, 0.0)]);
        assert_eq!(at(10), [(2.0, 0.0), (3.0, 0.0), (1.0, 0.5)]);
        assert_eq!(at(29), [(1.0, 0.0), (3.0, 0.0), (2.0, 1.0)]);
        assert_eq!(at(30), [(1.0, 0.0), (2.0, 0.0), (3.0, 0.25)]);
        let put_back = [(0, 30), (0, 31), (29, 40), (30, 40), (40, 10)];
        let put_back = put_back.map(|(from, to)| leaks.were_put_back(from, to));
        assert_eq!(put_back, [false, true, true, false, false]);
        for tick in 0..2 * KEPT as u64 {
            leaks.keep(tick, &none, [leak(1.0, 1.0)].into_iter());
        }
        assert_eq!(leaks.0.len(), KEPT);
    }
}
