//! Names for the numbers that messages carry between processes.
//!
//! A message stores raw integers, because a broken peer may write any bit pattern. A reader
//! converts them to these types. The conversion refuses a number without a name.

use core::ops::BitOr;

/// A number that has no name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("there is no {what} {number}")]
pub struct Unknown {
    /// The type of the number, in words.
    pub what: &'static str,
    /// The number.
    pub number: u32,
}

/// Declares an enum, the numbers of its variants in messages, and their names in reports.
macro_rules! words {
    (
        $(#[$doc:meta])*
        $word:ident, $what:literal {
            $($(#[$of:meta])* $variant:ident = $number:literal, $name:literal;)+
        }
    ) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr(u32)]
        pub enum $word {
            $($(#[$of])* $variant = $number,)+
        }

        impl $word {
            /// All variants, in the order of their numbers.
            pub const ALL: [Self; [$($number),+].len()] = [$(Self::$variant),+];

            /// Number of the variant in messages.
            #[must_use]
            pub const fn number(self) -> u32 {
                self as u32
            }

            /// Name of the variant in reports.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }
        }

        impl TryFrom<u32> for $word {
            type Error = Unknown;

            fn try_from(number: u32) -> Result<Self, Unknown> {
                match number {
                    $($number => Ok(Self::$variant),)+
                    _ => Err(Unknown { what: $what, number }),
                }
            }
        }
    };
}

words! {
    /// An instrument in the hand.
    Instrument, "instrument" {
        /// Two jaws that hold tissue.
        Grasper = 0, "grasper";
        /// An electrode with a bent end.
        Hook = 1, "cautery hook";
        /// Two blades.
        Scissors = 2, "scissors";
        /// Jaws that place clips.
        ClipApplier = 3, "clip applier";
        /// A tube that sucks and rinses.
        Irrigator = 4, "irrigator";
    }
}

words! {
    /// Part of a tool that a capsule represents.
    CapsuleRole, "role of a capsule" {
        /// The shaft.
        Shaft = 0, "shaft";
        /// The upper jaw.
        UpperJaw = 1, "upper jaw";
        /// The lower jaw.
        LowerJaw = 2, "lower jaw";
        /// The uninsulated end of the hook, or the end of the irrigator's tube.
        Tip = 3, "tip";
    }
}

words! {
    /// Electrosurgical current.
    Current, "current" {
        /// No current.
        Off = 0, "off";
        /// Cutting current.
        Cut = 1, "cut";
        /// Coagulating current.
        Coagulate = 2, "coagulate";
    }
}

words! {
    /// A complication that an instructor can trigger in the simulation.
    Complication, "complication" {
        /// The artery of the gallbladder bleeds from a hole in its wall.
        Bleeding = 0, "bleeding";
        /// The newest clip slips off.
        SlippedClip = 1, "slipped_clip";
    }
}

words! {
    /// Act of an instructor at a running station.
    ActKind, "act of an instructor" {
        /// Points at a place in the body.
        Point = 0, "point";
        /// Pauses the simulation.
        Pause = 1, "pause";
        /// Lets the simulation go on.
        Resume = 2, "resume";
        /// Writes a remark for the debrief.
        Remark = 3, "remark";
        /// Fogs the endoscope's lens.
        Fog = 4, "fog";
        /// Makes the artery of the gallbladder bleed.
        Bleeding = 5, "bleeding";
        /// Makes the newest clip slip off.
        SlippedClip = 6, "slipped_clip";
    }
}

impl ActKind {
    /// The complication that the controller has to bring about, if the act is one.
    #[must_use]
    pub const fn complication(self) -> Option<Complication> {
        match self {
            Self::Bleeding => Some(Complication::Bleeding),
            Self::SlippedClip => Some(Complication::SlippedClip),
            _ => None,
        }
    }

    /// True if the act changes the trainee's work or tells the trainee something.
    #[must_use]
    pub const fn helps_or_hinders(self) -> bool {
        !matches!(self, Self::Remark)
    }
}

words! {
    /// Kind of an event. [`crate::message::Event`] has the payload of each kind.
    EventKind, "kind of event" {
        /// The instrument began to touch an organ.
        Contact = 1, "contact";
        /// The instrument left the organ.
        Release = 2, "release";
        /// The jaws closed on tissue.
        Grasp = 3, "grasp";
        /// The jaws let go, or the tissue slipped out of them.
        LetGo = 4, "let_go";
        /// A fault was raised.
        Fault = 5, "fault";
        /// The electrosurgical current changed.
        Electro = 6, "electro";
        /// Grasped tissue slipped by 2 mm through the jaws.
        Slip = 7, "slip";
        /// An attachment or a link of a tube tore.
        Tear = 8, "tear";
        /// Scissors or current cut an attachment, a suture or a link of a tube.
        Cut = 9, "cut";
        /// A clip closed on the organ. If the event names no organ, there was nothing in the clip.
        /// A clip on two organs raises two events.
        Clip = 10, "clip";
        /// An electrode burnt an organ.
        Burn = 11, "burn";
        /// A vessel, a duct or an organ full of bile leaks. All events of one leak have the
        /// position at which the leak began.
        Leak = 12, "leak";
        /// A cell of layered tissue is gone.
        Removed = 13, "removed";
        /// The jaws crushed the tissue between them.
        Crush = 14, "crush";
        /// A wall was burnt through, or a tube was severed halfway.
        Perforation = 15, "perforation";
        /// A tube was divided, or torn off an organ.
        Divided = 16, "divided";
        /// All organs were reset to their state at the start of the run, or of a task. Earlier
        /// events no longer count.
        Reset = 17, "reset";
        /// A suture goes through an organ.
        Stitch = 18, "stitch";
        /// A suture hangs an organ on the abdominal wall.
        Hung = 19, "hung";
        /// An organ that was not cut free left its place and does not return.
        Fall = 20, "fall";
        /// An organ does not come to rest, and no tool explains its speed.
        Shake = 21, "shake";
        /// The instrument was inside an organ at its device's first sample, or at the first after a
        /// gap.
        Buried = 22, "buried";
        /// The instrument presses on an organ harder than before in this contact.
        Press = 23, "press";
        /// An instructor's complication opened a vessel.
        Opened = 24, "opened";
        /// An instructor's complication took a clip off the organ. A clip on two organs raises two
        /// events.
        Unclipped = 25, "unclipped";
        /// Heat has destroyed tissue of an organ.
        Seared = 26, "seared";
        /// A stone left the gallbladder through a hole.
        StoneSpilled = 27, "stone_spilled";
        /// The jaws closed around a stone.
        StoneHeld = 28, "stone_held";
        /// The jaws let go of a stone.
        StoneDropped = 29, "stone_dropped";
        /// A stone is out of the body.
        StoneRetrieved = 30, "stone_retrieved";
        /// Share of the tube that the clip of the next event `clip` of this organ closes.
        ClipCloses = 31, "clip_closes";
        /// Place of that clip along the tube.
        ClipAlong = 32, "clip_along";
    }
}

words! {
    /// A fault of the controller. `rt_core::fault::Fault` describes the controller's reaction to
    /// each.
    Fault, "fault" {
        /// A device's sample was not finite, was no rigid pose, or lay more than 10 m from the
        /// device's origin.
        BadSample = 0, "bad_sample";
        /// The force was not finite.
        BadForce = 1, "bad_force";
        /// A sphere was not finite, or more than 10 m from its rest position.
        BadSphere = 2, "bad_sphere";
        /// The newest sample of the haptic device is too old, or no tick ran for more than 20 ms.
        StaleDevice = 3, "stale_device";
        /// The connection to the haptic device is gone.
        LostDevice = 4, "lost_device";
        /// The handle was too fast.
        SpeedTrip = 5, "speed_trip";
        /// The force was greater than the device's peak.
        Clamped = 6, "clamped";
        /// The force changed too fast.
        Slewed = 7, "slewed";
        /// Contact was stiffer than the device can render without oscillation.
        StiffnessCapped = 8, "stiffness_capped";
        /// The motors are warm, and the force is limited.
        ThermalLimited = 9, "thermal_limited";
        /// A tick found more contacts than it can keep.
        ContactOverflow = 10, "contact_overflow";
        /// A tick found more pairs of near spheres than it can keep.
        PairOverflow = 11, "pair_overflow";
        /// More spheres were between the jaws than the jaws can hold.
        GraspOverflow = 12, "grasp_overflow";
        /// A tick had more events or leaks than it can keep.
        EventOverflow = 13, "event_overflow";
        /// A tick ended after its deadline.
        Overrun = 14, "overrun";
        /// Time did not go forward between two ticks.
        BadClock = 15, "bad_clock";
        /// Contact returned more energy to the hand than it took, and the controller damped the
        /// force.
        Damped = 16, "damped";
        /// Both pedals of the electrosurgical unit are pressed.
        BothElectrodes = 17, "both_electrodes";
        /// The force is off: a person has not enabled it, or has cut it.
        NotEnabled = 18, "not_enabled";
        /// The force rises after it was enabled, or falls while the pose is stale or the simulation
        /// is paused.
        Ramped = 19, "ramped";
        /// The haptic device is open but sends no valid sample.
        SilentDevice = 20, "silent_device";
        /// The haptic device repeats a position although it reports a velocity, or repeats both a
        /// position and the time of its clock.
        FrozenDevice = 21, "frozen_device";
        /// The haptic device's clock runs backwards, stands still or counts in another unit.
        DeviceClock = 22, "device_clock";
        /// The handle leapt farther than a hand moves.
        DeviceLeap = 23, "device_leap";
        /// The haptic device's samples arrive in bundles.
        DeviceBundles = 24, "device_bundles";
        /// The haptic device confirms none of the forces sent to it.
        DeafDevice = 25, "deaf_device";
        /// The connection to the pedal is gone, or the pedal is silent.
        LostPedal = 26, "lost_pedal";
        /// A pedal has been held down since the start, or since its connection returned.
        HeldPedal = 27, "held_pedal";
        /// The haptic device reports a fault of its own.
        DeviceFault = 28, "device_fault";
        /// The haptic device's watchdog set the force to zero.
        DeviceWatchdog = 29, "device_watchdog";
        /// The haptic device itself limits the force.
        DeviceLimited = 30, "device_limited";
        /// The haptic device's positions are noisy.
        NoisyDevice = 31, "noisy_device";
    }
}

impl Fault {
    /// Names by number, in the order of [`crate::message::TimingBatch::faults`].
    pub const NAMES: [&str; Self::ALL.len()] = {
        let mut names = [""; Self::ALL.len()];
        let mut i = 0;
        while i < names.len() {
            names[i] = Self::ALL[i].name();
            i += 1;
        }
        names
    };
}

/// Declares a set of named bits.
macro_rules! bits {
    (
        $(#[$doc:meta])*
        $set:ident, $what:literal {
            $($(#[$of:meta])* $name:ident = $bit:literal;)+
        }
    ) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
        pub struct $set(u32);

        impl $set {
            $($(#[$of])* pub const $name: Self = Self($bit);)+
            /// No bit.
            pub const NONE: Self = Self(0);
            /// All named bits.
            pub const ALL: Self = Self($($bit)|+);

            /// The set with the named bits of a message. Other bits are dropped.
            #[must_use]
            pub const fn named(bits: u32) -> Self {
                Self(bits & Self::ALL.0)
            }

            /// The bits, as a message contains them.
            #[must_use]
            pub const fn bits(self) -> u32 {
                self.0
            }

            /// True if the set contains all of `these`.
            #[must_use]
            pub const fn contains(self, these: Self) -> bool {
                self.0 & these.0 == these.0
            }

            /// This set if `on`, else the empty set.
            #[must_use]
            pub const fn when(self, on: bool) -> Self {
                if on { self } else { Self::NONE }
            }
        }

        impl TryFrom<u32> for $set {
            type Error = Unknown;

            fn try_from(number: u32) -> Result<Self, Unknown> {
                let what = $what;
                let known = number & !Self::ALL.0 == 0;
                if known { Ok(Self(number)) } else { Err(Unknown { what, number }) }
            }
        }

        impl BitOr for $set {
            type Output = Self;

            fn bitor(self, other: Self) -> Self {
                Self(self.0 | other.0)
            }
        }
    };
}

bits! {
    /// Switches of the foot pedal and of the controller.
    Switches, "set of switches" {
        /// Pedal: cut.
        CUT = 1;
        /// Pedal: coagulate.
        COAGULATE = 2;
        /// Pedal: the endoscope's camera stays where it is.
        CAMERA_LOCK = 4;
        /// The simulation is paused.
        PAUSED = 8;
        /// The controller may send force to the device.
        FORCE_ENABLED = 16;
    }
}

impl Switches {
    /// The three pedals: cut, coagulate and camera lock.
    pub const PEDALS: Self = Self(7);

    /// Current that the pedals request. Both pedals at once give no current.
    #[must_use]
    pub const fn current(self) -> Current {
        match (self.contains(Self::CUT), self.contains(Self::COAGULATE)) {
            (true, false) => Current::Cut,
            (false, true) => Current::Coagulate,
            _ => Current::Off,
        }
    }
}

bits! {
    /// Buttons of the handle. A device has up to eight; one has a name in messages.
    Buttons, "set of buttons" {
        /// Closes the jaws.
        GRASP = 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Checks that each variant is found by its number, and that no other number finds one.
    macro_rules! is_checked {
        ($($word:ident),+) => {$(
            for word in $word::ALL {
                assert_eq!($word::try_from(word.number()), Ok(word));
                assert!(!word.name().is_empty());
            }
            let numbers = $word::ALL.map($word::number);
            for number in (0..64).chain([u32::MAX]).filter(|it| !numbers.contains(it)) {
                let unknown = $word::try_from(number).expect_err("a number without a name");
                assert_eq!(unknown.number, number);
            }
        )+};
    }

    #[test]
    fn words_are_found_by_their_numbers_and_unknown_numbers_are_refused() {
        is_checked!(
            Instrument,
            CapsuleRole,
            Current,
            Complication,
            ActKind,
            EventKind,
            Fault
        );
    }

    #[test]
    fn faults_are_numbered_without_gaps() {
        for (index, fault) in Fault::ALL.into_iter().enumerate() {
            assert_eq!(fault.number() as usize, index);
            assert_eq!(Fault::NAMES[index], fault.name());
        }
    }

    #[test]
    fn both_pedals_together_give_no_current() {
        let both = Switches::CUT | Switches::COAGULATE;
        assert_eq!(both.current(), Current::Off);
        assert_eq!(Switches::CUT.current(), Current::Cut);
        let held = Switches::COAGULATE | Switches::CAMERA_LOCK;
        assert_eq!(held.current(), Current::Coagulate);
    }

    proptest! {
        #[test]
        fn sets_refuse_bits_without_a_name(bits: u32) {
            let known = bits & !31 == 0;
            prop_assert_eq!(Switches::try_from(bits).is_ok(), known);
            prop_assert_eq!(Switches::named(bits).bits(), bits & 31);
            prop_assert_eq!(Switches::try_from(bits & 31).map(Switches::bits), Ok(bits & 31));
        }
    }
}
