//! Debouncing: a press counts at once, a release only after the contact has stayed open for a
//! while.

use rt_core::time::TimeNs;

/// Shortest time for which a press counts, ns.
const HOLD_NS: u64 = 10_000_000;
/// Time for which the contact must be open before a release counts, ns.
const RELEASE_NS: u64 = 20_000_000;

/// One debounced switch.
#[derive(Debug, Clone, Copy, Default)]
pub struct Debounced {
    pressed_at_ns: Option<TimeNs>,
    open_since_ns: Option<TimeNs>,
}

impl Debounced {
    /// Takes the state of the contact and returns the debounced state of the switch.
    pub fn update(&mut self, closed: bool, now_ns: TimeNs) -> bool {
        let Some(pressed_at_ns) = self.pressed_at_ns else {
            if closed {
                self.pressed_at_ns = Some(now_ns);
                self.open_since_ns = None;
            }
            return closed;
        };
        if closed {
            self.open_since_ns = None;
            return true;
        }
        let since_ns = *self.open_since_ns.get_or_insert(now_ns);
        let held = now_ns.saturating_sub(pressed_at_ns) >= HOLD_NS;
        let open = now_ns.saturating_sub(since_ns) >= RELEASE_NS;
        if held && open {
            *self = Self::default();
        }
        !(held && open)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn a_press_counts_at_once_and_its_bounces_are_one_press() {
        let mut switch = Debounced::default();
        assert!(!switch.update(false, 0));
        assert!(switch.update(true, MS));
        for ms in 2..20 {
            assert!(switch.update(ms % 2 == 0, ms * MS), "bounce at {ms} ms");
        }
        assert!(switch.update(false, 20 * MS));
        assert!(switch.update(false, 38 * MS));
        assert!(!switch.update(false, 40 * MS));
    }

    proptest! {
        /// For any chatter of the contact, the switch finally agrees with the contact.
        #[test]
        fn debounced_contact_ends_where_the_contact_ends(chatter in prop::collection::vec(any::<bool>(), 0..200),
                                          end in any::<bool>()) {
            let mut switch = Debounced::default();
            let mut now_ns = 0;
            for closed in chatter {
                let pressed = switch.update(closed, now_ns);
                prop_assert!(pressed || !closed, "a closed contact is a pressed switch");
                now_ns += MS;
            }
            for _ in 0..50 {
                switch.update(end, now_ns);
                now_ns += MS;
            }
            prop_assert_eq!(switch.update(end, now_ns), end);
        }
    }
}
