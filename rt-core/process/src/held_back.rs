//! Counts the ticks in which contact asks for a force while a fault holds the force back, or while
//! the force rises again after that fault. Each fault has its own count.

use core::sync::atomic::AtomicU64;

use rt_core::fault::{Fault, FaultSet};
use rt_core::sim::TickView;

use crate::shared::Shared;

/// Faults that hold the force back. If a tick has several, the first in this list is the reason.
const REASONS: [Fault; 12] = [
    Fault::DeviceFault,
    Fault::LostDevice,
    Fault::FrozenDevice,
    Fault::DeviceClock,
    Fault::DeafDevice,
    Fault::DeviceBundles,
    Fault::SilentDevice,
    Fault::DeviceLeap,
    Fault::BadForce,
    Fault::SpeedTrip,
    Fault::NotEnabled,
    Fault::StaleDevice,
];

/// The reason for which force is held back now, if any.
#[derive(Debug, Default)]
pub(crate) struct HeldBack {
    reason: Option<Fault>,
    /// Faults of the last tick.
    last: FaultSet,
}

impl HeldBack {
    /// Counts a tick in `shared`.
    pub(crate) fn note(&mut self, view: &TickView<'_>, shared: &Shared) {
        let begins = self.step(view.faults, view.force_share);
        if !view.asks_force {
            return;
        }
        Shared::count(&shared.contact_ticks);
        let Some(reason) = self.reason else { return };
        let add = |counts: &[AtomicU64]| {
            if let Some(count) = counts.get(usize::from(reason.code())) {
                Shared::count(count);
            }
        };
        add(&shared.held_ticks);
        if begins {
            add(&shared.held_times);
        }
    }

    /// Updates the reason. `share` is the share of the force that is rendered, 0 to 1. Returns true
    /// if the reason's fault is present and the last tick did not have it.
    fn step(&mut self, faults: FaultSet, share: f32) -> bool {
        let found = REASONS.into_iter().find(|&it| faults.contains(it));
        // A trip holds the force until a person enables it, whatever else happens meanwhile.
        let is_tripped = self.reason == Some(Fault::SpeedTrip) && share <= 0.0;
        let now = match found {
            Some(Fault::NotEnabled) => found,
            _ if is_tripped && !faults.contains(Fault::NotEnabled) => faults
                .contains(Fault::SpeedTrip)
                .then_some(Fault::SpeedTrip),
            _ => found,
        };
        // A person has enabled the force. It rises now, but nothing holds it back.
        let was_enabled = self.reason == Some(Fault::NotEnabled);
        let is_full = share >= 1.0;
        self.reason = now.or(self.reason.filter(|_| !is_full && !was_enabled));
        let begins = now.is_some_and(|it| !self.last.contains(it));
        self.last = faults;
        begins
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn only(fault: Fault) -> FaultSet {
        let mut set = FaultSet::NONE;
        set.raise(fault);
        set
    }

    #[test]
    fn a_reason_lasts_until_the_force_is_whole_again() {
        let mut held = HeldBack::default();
        assert!(!held.step(FaultSet::NONE, 0.3), "the first ramp");
        assert_eq!(held.reason, None);
        assert!(held.step(only(Fault::StaleDevice), 0.9));
        assert!(!held.step(only(Fault::StaleDevice), 0.8));
        assert!(!held.step(FaultSet::NONE, 0.8), "the force rises");
        assert_eq!(held.reason, Some(Fault::StaleDevice));
        assert!(held.step(only(Fault::StaleDevice), 0.8), "late once more");
        assert!(!held.step(FaultSet::NONE, 1.0));
        assert_eq!(held.reason, None);
    }

    #[test]
    fn a_trip_holds_until_a_person_enables_the_force() {
        let mut held = HeldBack::default();
        assert!(held.step(only(Fault::SpeedTrip), 0.0));
        assert!(!held.step(FaultSet::NONE, 0.0));
        assert_eq!(held.reason, Some(Fault::SpeedTrip));
        assert!(held.step(only(Fault::NotEnabled), 0.0));
        assert!(!held.step(FaultSet::NONE, 0.1));
        assert_eq!(held.reason, None, "a person enabled it");
    }

    #[test]
    fn samples_that_come_late_during_a_trip_do_not_replace_it() {
        let mut held = HeldBack::default();
        assert!(held.step(only(Fault::SpeedTrip), 0.0));
        for _ in 0..5 {
            assert!(!held.step(only(Fault::StaleDevice), 0.0), "no new reason");
            assert_eq!(held.reason, Some(Fault::SpeedTrip));
            assert!(!held.step(FaultSet::NONE, 0.0));
            assert_eq!(held.reason, Some(Fault::SpeedTrip));
        }
        let mut both = only(Fault::StaleDevice);
        both.raise(Fault::NotEnabled);
        assert!(held.step(both, 0.0));
        assert_eq!(held.reason, Some(Fault::NotEnabled), "a person acted");
        held.step(only(Fault::StaleDevice), 0.4);
        assert_eq!(held.reason, Some(Fault::StaleDevice));
    }

    /// Run it with `cargo test -p rt-process --lib cost_of_noting -- --ignored --nocapture`.
    #[test]
    #[ignore = "measures, for the report"]
    fn cost_of_noting_a_tick() {
        const TICKS: u32 = 10_000_000;
        let mut best_ns = f64::INFINITY;
        for _ in 0..10 {
            let mut held = HeldBack::default();
            let start = std::time::Instant::now();
            let mut begun = 0;
            for at in 0..TICKS {
                let is_late = at.is_multiple_of(1000);
                let mut faults = FaultSet::NONE;
                faults.raise_if(is_late, Fault::StaleDevice);
                begun += u32::from(held.step(std::hint::black_box(faults), 1.0));
            }
            best_ns = best_ns.min(start.elapsed().as_secs_f64() * 1.0e9 / f64::from(TICKS));
            assert_eq!(begun, TICKS / 1000);
        }
        println!("finding the reason of force that is held back: {best_ns:.1} ns a tick");
    }
}
