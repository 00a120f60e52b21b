//! Faults of a tick. Nothing panics: each fault has one defined answer, and a counter.

/// A fault. The number is its index in [`FaultCounters`] and its code in events.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Fault {
    /// A sample of the haptic device or the tracker was not finite, not a rigid pose, more than 10
    /// m from its origin along an axis, or had an opening outside 0..=1. Answer: the sample is
    /// ignored.
    BadSample = 0,
    /// The force was not finite. Answer: zero force.
    BadForce = 1,
    /// A sphere was not finite or more than 10 m from its rest position along an axis. Answer: the
    /// sphere is put back to its last valid place, without velocity.
    BadSphere = 2,
    /// The newest device sample is older than its limit, or no tick ran for more than 20 ms.
    /// Answer: force falls to zero.
    StaleDevice = 3,
    /// The connection to the device is lost. Answer: zero force.
    LostDevice = 4,
    /// The handle was faster than the limit. Answer: zero force until a person enables it again.
    SpeedTrip = 5,
    /// The force was above the device's peak. Answer: the force is cut to the peak.
    Clamped = 6,
    /// The force changed too fast. Answer: it follows at the slew limit.
    Slewed = 7,
    /// Contact was stiffer than the device renders stably. Answer: the force is scaled down.
    StiffnessCapped = 8,
    /// The motors are warm. Answer: the limit of the force falls towards the continuous force.
    ThermalLimited = 9,
    /// More contacts were found than can be kept. Answer: the deepest are kept.
    ContactOverflow = 10,
    /// More near pairs of spheres were found than can be kept. Answer: the pairs that were found
    /// first are kept.
    PairOverflow = 11,
    /// More spheres were between the jaws than can be held. Answer: the first found are held.
    GraspOverflow = 12,
    /// More events or leaks occurred than can be kept. Answer: the later ones are dropped. (The
    /// events of a leak or a division wait for the next tick instead.)
    EventOverflow = 13,
    /// A tick ended after its deadline (reported by the process).
    Overrun = 14,
    /// Time did not go forward between two ticks. Answer: the tick counts as one period.
    BadClock = 15,
    /// Contact returned more energy to the hand than the hand put in (it is too stiff for the
    /// loop's delay, or the tissue moves by itself). Answer: damping, until that energy is
    /// dissipated.
    Damped = 16,
    /// Both electrosurgery pedals are pressed. Answer: no current.
    BothElectrodes = 17,
    /// No person has enabled the force, or a person has cut it. Answer: zero force.
    NotEnabled = 18,
    /// The force rises after it was enabled, or falls while the pose is stale or the simulation
    /// paused. Answer: a share of the force is rendered.
    Ramped = 19,
    /// The haptic device is open but sends no valid sample. Answer: force falls to zero.
    SilentDevice = 20,
    /// The haptic device repeats a position although it reports a velocity, or repeats both a
    /// position and the time of its clock. Answer: the samples are dropped, so the force falls to
    /// zero.
    FrozenDevice = 21,
    /// The haptic device's clock runs backwards, stands still or has another unit. Answer: the
    /// samples are dropped, so the force falls to zero.
    DeviceClock = 22,
    /// The handle's position jumped farther than a hand moves. Answer: the sample is dropped. If
    /// the handle stays at the new place, its samples are used again, and the force starts from
    /// zero.
    DeviceLeap = 23,
    /// Samples arrive in bundles, and a bundle spans more time than a sample may be old. Answer:
    /// force falls to zero.
    DeviceBundles = 24,
    /// The haptic device does not confirm the forces sent to it. Answer: the samples are dropped,
    /// so the force falls to zero.
    DeafDevice = 25,
    /// The connection to the pedal is lost, or the pedal sends nothing any more. Answer: a lost
    /// pedal reads as released; a silent one keeps its last state until its driver reports it as
    /// lost.
    LostPedal = 26,
    /// A pedal has been held down since the start, or since its connection returned. Answer: the
    /// pedal reads as released until the foot has released it once.
    HeldPedal = 27,
    /// The haptic device reports a fault of its own. Answer: zero force; after the fault, the force
    /// rises by the ramp.
    DeviceFault = 28,
    /// The haptic device's watchdog set the force to zero, because no command came in time. Answer:
    /// none; the device renders the next command.
    DeviceWatchdog = 29,
    /// The haptic device limits the force itself (heat, current). Answer: none.
    DeviceLimited = 30,
    /// The haptic device's positions are noisy. Answer: none; the force steps with the positions.
    NoisyDevice = 31,
}

/// Number of kinds of fault.
pub const FAULT_COUNT: usize = 32;

impl Fault {
    /// All kinds, in the order of their numbers.
    pub const ALL: [Self; FAULT_COUNT] = [
        Self::BadSample,
        Self::BadForce,
        Self::BadSphere,
        Self::StaleDevice,
        Self::LostDevice,
        Self::SpeedTrip,
        Self::Clamped,
        Self::Slewed,
        Self::StiffnessCapped,
        Self::ThermalLimited,
        Self::ContactOverflow,
        Self::PairOverflow,
        Self::GraspOverflow,
        Self::EventOverflow,
        Self::Overrun,
        Self::BadClock,
        Self::Damped,
        Self::BothElectrodes,
        Self::NotEnabled,
        Self::Ramped,
        Self::SilentDevice,
        Self::FrozenDevice,
        Self::DeviceClock,
        Self::DeviceLeap,
        Self::DeviceBundles,
        Self::DeafDevice,
        Self::LostPedal,
        Self::HeldPedal,
        Self::DeviceFault,
        Self::DeviceWatchdog,
        Self::DeviceLimited,
        Self::NoisyDevice,
    ];

    /// Number of the fault: index of its counter, and its code in events.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// Name of the fault in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::BadSample => "bad_sample",
            Self::BadForce => "bad_force",
            Self::BadSphere => "bad_sphere",
            Self::StaleDevice => "stale_device",
            Self::LostDevice => "lost_device",
            Self::SpeedTrip => "speed_trip",
            Self::Clamped => "clamped",
            Self::Slewed => "slewed",
            Self::StiffnessCapped => "stiffness_capped",
            Self::ThermalLimited => "thermal_limited",
            Self::ContactOverflow => "contact_overflow",
            Self::PairOverflow => "pair_overflow",
            Self::GraspOverflow => "grasp_overflow",
            Self::EventOverflow => "event_overflow",
            Self::Overrun => "overrun",
            Self::BadClock => "bad_clock",
            Self::Damped => "damped",
            Self::BothElectrodes => "both_electrodes",
            Self::NotEnabled => "not_enabled",
            Self::Ramped => "ramped",
            Self::SilentDevice => "silent_device",
            Self::FrozenDevice => "frozen_device",
            Self::DeviceClock => "device_clock",
            Self::DeviceLeap => "device_leap",
            Self::DeviceBundles => "device_bundles",
            Self::DeafDevice => "deaf_device",
            Self::LostPedal => "lost_pedal",
            Self::HeldPedal => "held_pedal",
            Self::DeviceFault => "device_fault",
            Self::DeviceWatchdog => "device_watchdog",
            Self::DeviceLimited => "device_limited",
            Self::NoisyDevice => "noisy_device",
        }
    }

    /// True if a person has to know of the fault. The other faults are limits that act in ordinary
    /// use.
    #[must_use]
    pub const fn is_alarm(self) -> bool {
        !matches!(
            self,
            Self::Clamped
                | Self::Slewed
                | Self::StiffnessCapped
                | Self::ThermalLimited
                | Self::Damped
                | Self::NotEnabled
                | Self::Ramped
                | Self::DeviceLimited
        )
    }
}

/// Number of ticks in which each fault happened since the start. The numbers never fall.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FaultCounters([u64; FAULT_COUNT]);

impl FaultCounters {
    /// Nothing counted.
    pub const ZERO: Self = Self([0; FAULT_COUNT]);

    /// Number of ticks in which `fault` happened.
    #[must_use]
    pub fn of(&self, fault: Fault) -> u64 {
        self.0.get(usize::from(fault.code())).copied().unwrap_or(0)
    }

    /// All counters, in the order of [`Fault::ALL`].
    #[must_use]
    pub const fn as_array(&self) -> &[u64; FAULT_COUNT] {
        &self.0
    }

    /// Adds one for every fault in `set`.
    pub(crate) fn count(&mut self, set: FaultSet) {
        for (counter, fault) in self.0.iter_mut().zip(Fault::ALL) {
            *counter = counter.wrapping_add(u64::from(set.contains(fault)));
        }
    }
}

/// The faults of one tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FaultSet(u32);

impl FaultSet {
    /// None.
    pub const NONE: Self = Self(0);

    /// Adds `fault`.
    pub const fn raise(&mut self, fault: Fault) {
        self.0 |= 1 << (fault as u32);
    }

    /// Adds `fault` if `happened`.
    pub const fn raise_if(&mut self, happened: bool, fault: Fault) {
        if happened {
            self.raise(fault);
        }
    }

    /// True if the set contains `fault`.
    #[must_use]
    pub const fn contains(self, fault: Fault) -> bool {
        self.0 & (1 << (fault as u32)) != 0
    }

    /// True if a fault of the device explains why its driver passes on no samples.
    #[must_use]
    pub const fn explains_silence(self) -> bool {
        self.contains(Fault::SilentDevice)
            || self.contains(Fault::FrozenDevice)
            || self.contains(Fault::DeviceClock)
            || self.contains(Fault::DeviceBundles)
            || self.contains(Fault::DeafDevice)
    }

    /// Faults in either set.
    #[must_use]
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Faults in `self` that are not in `earlier`.
    #[must_use]
    pub const fn without(self, earlier: Self) -> Self {
        Self(self.0 & !earlier.0)
    }

    /// True if the set is empty.
    #[must_use]
    pub const fn is_empty(self) -> bool {
        self.0 == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fault_codes_are_indices_and_faults_count_separately() {
        for (i, fault) in Fault::ALL.into_iter().enumerate() {
            assert_eq!(usize::from(fault.code()), i);
            let mut set = FaultSet::NONE;
            set.raise(fault);
            let mut counters = FaultCounters::ZERO;
            counters.count(set);
            counters.count(set);
            for other in Fault::ALL {
                assert_eq!(counters.of(other), if other == fault { 2 } else { 0 });
            }
        }
    }
}
