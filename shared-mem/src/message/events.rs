//! Service `events`.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::words::{Current, EventKind, Fault, Unknown};

/// Service `events`: one event. A gap in `sequence` means that events were lost, and the reader
/// must show the loss.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.EventMsg.v1")]
pub struct EventMsg {
    /// Number of the event, from 0 at the controller's start.
    pub sequence: u64,
    /// Tick that raised the event.
    pub tick: u64,
    /// Time of that tick (`CLOCK_MONOTONIC`).
    pub at_ns: u64,
    /// Number of an [`EventKind`].
    pub kind: u32,
    /// Index of the organ in the scene; `u32::MAX` if the event concerns no organ.
    pub organ: u32,
    /// Place of the event, world frame, m.
    pub at_m: [f32; 3],
    /// Payload. Its meaning and unit depend on the kind: see [`EventMsg::decode`].
    pub value: f32,
}

/// A decoded event: its kind and its payload.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// The instrument began to touch an organ.
    Contact {
        /// Force on the hand, N.
        force_n: f32,
    },
    /// The instrument left the organ.
    Release,
    /// The jaws closed on tissue.
    Grasp {
        /// Number of spheres held.
        spheres: u32,
    },
    /// The jaws let go, or the tissue slipped out of them.
    LetGo {
        /// Number of spheres that were held.
        spheres: u32,
    },
    /// A fault was raised.
    Fault(Fault),
    /// The electrosurgical current changed to this.
    Electro(Current),
    /// Grasped tissue slipped by 2 mm through the jaws.
    Slip {
        /// Pull of the tissue on the jaws, N.
        force_n: f32,
    },
    /// An attachment or a link of a tube tore.
    Tear {
        /// Energy that the tear took, J.
        energy_j: f32,
    },
    /// Scissors or current cut an attachment, a suture or a link of a tube.
    Cut {
        /// Energy that a tear would have taken, J.
        energy_j: f32,
    },
    /// A clip closed.
    Clip {
        /// The clip's number, from 0.
        number: u32,
    },
    /// An electrode burnt an organ.
    Burn {
        /// Energy since the organ's last burn event, J.
        energy_j: f32,
    },
    /// A vessel, a duct or an organ full of bile leaks.
    Leak {
        /// Flow relative to the flow from an open lumen at full pressure; 0: the leak stopped.
        flow: f32,
    },
    /// A cell of layered tissue is gone.
    Removed {
        /// The cell's index in the scene.
        cell: u32,
    },
    /// The jaws crushed the tissue between them.
    Crush {
        /// Force of the jaws, N.
        force_n: f32,
    },
    /// A wall was burnt through, or a tube was severed halfway.
    Perforation {
        /// Energy that burnt through the wall, J; 0 for a tube that is severed halfway.
        energy_j: f32,
    },
    /// A tube was divided, or torn off an organ.
    Divided {
        /// Open share of the lumen, 0 to 1. On each side of the division, it is the share that the
        /// clips up to the tube's next end or division leave open; the larger of the two counts. 0:
        /// clips close both sides.
        open: f32,
    },
    /// All organs were reset to their state at the start of the run, or of a task.
    Reset,
    /// A suture goes through an organ.
    Stitch {
        /// The suture's number in the scene, from 0.
        suture: u32,
    },
    /// A suture hangs an organ on the abdominal wall.
    Hung {
        /// The suture's number in the scene, from 0.
        suture: u32,
    },
    /// An organ that was not cut free left its place and does not return. Sent at most once between
    /// two resets.
    Fall {
        /// Distance of the organ's middle from its place, m.
        distance_m: f32,
    },
    /// An organ does not come to rest, and no tool explains its speed. Sent again only after the
    /// organ came to rest, or after a reset.
    Shake {
        /// Speed of the organ's fastest sphere, m/s.
        speed_m_s: f32,
    },
    /// The instrument was inside an organ at its device's first sample, or at the first after a
    /// gap. The trainee must draw it out.
    Buried {
        /// Depth of the instrument, m.
        depth_m: f32,
    },
    /// The instrument presses on an organ harder than at the previous `Press` of this contact.
    Press {
        /// Force of the instrument on the organ, N.
        force_n: f32,
    },
    /// An instructor's complication opened a vessel.
    Opened {
        /// Area of the hole, m².
        area_m2: f32,
    },
    /// An instructor's complication took a clip off.
    Unclipped {
        /// The clip's number, from 0.
        number: u32,
    },
    /// Heat has destroyed tissue of an organ.
    Seared {
        /// Destroyed volume since the last reset, m³.
        volume_m3: f32,
    },
    /// A stone left the gallbladder through a hole.
    StoneSpilled {
        /// The stone's number, from 0.
        stone: u32,
    },
    /// The jaws closed around a stone.
    StoneHeld {
        /// The stone's number, from 0.
        stone: u32,
    },
    /// The jaws let go of a stone.
    StoneDropped {
        /// The stone's number, from 0.
        stone: u32,
    },
    /// A stone is out of the body: drawn out with the instrument, or sucked off.
    StoneRetrieved {
        /// The stone's number, from 0.
        stone: u32,
    },
    /// The clip of the next [`Event::Clip`] of this organ closes so much of the tube.
    ClipCloses {
        /// Share of the lumen, 0 to 1.
        share: f32,
    },
    /// The clip of the next [`Event::Clip`] of this organ lies here.
    ClipAlong {
        /// Place along the tube at rest, m. Its zero is one end of the tube, always the same.
        along_m: f32,
    },
}

/// An event that cannot be decoded.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum UnknownEvent {
    /// The number of the event's kind, fault or current is unknown.
    #[error(transparent)]
    Word(#[from] Unknown),
    /// The value is not finite, or is not a whole number where the kind needs one.
    #[error("{} cannot carry {value}", .kind.name())]
    Value {
        /// The event's kind.
        kind: EventKind,
        /// The value.
        value: f32,
    },
}

impl EventMsg {
    /// 2²⁴. Above this value, `f32` cannot represent every whole number.
    const WHOLE_END: f32 = 16_777_216.0;

    /// The event with its payload.
    ///
    /// # Errors
    ///
    /// [`UnknownEvent`] if a number is unknown, or if the kind cannot have this value.
    pub fn decode(&self) -> Result<Event, UnknownEvent> {
        let kind = EventKind::try_from(self.kind)?;
        let value = self.value;
        let refused = UnknownEvent::Value { kind, value };
        let number = || {
            let is_whole = (0.0..Self::WHOLE_END).contains(&value) && value.fract() == 0.0;
            is_whole.then_some(value as u32).ok_or(refused)
        };
        if !value.is_finite() {
            return Err(refused);
        }
        Ok(match kind {
            EventKind::Contact => Event::Contact { force_n: value },
            EventKind::Release => Event::Release,
            EventKind::Grasp => Event::Grasp { spheres: number()? },
            EventKind::LetGo => Event::LetGo { spheres: number()? },
            EventKind::Fault => Event::Fault(Fault::try_from(number()?)?),
            EventKind::Electro => Event::Electro(Current::try_from(number()?)?),
            EventKind::Slip => Event::Slip { force_n: value },
            EventKind::Tear => Event::Tear { energy_j: value },
            EventKind::Cut => Event::Cut { energy_j: value },
            EventKind::Clip => Event::Clip { number: number()? },
            EventKind::Burn => Event::Burn { energy_j: value },
            EventKind::Leak => Event::Leak { flow: value },
            EventKind::Removed => Event::Removed { cell: number()? },
            EventKind::Crush => Event::Crush { force_n: value },
            EventKind::Perforation => Event::Perforation { energy_j: value },
            EventKind::Divided => Event::Divided { open: value },
            EventKind::Reset => Event::Reset,
            EventKind::Stitch => Event::Stitch { suture: number()? },
            EventKind::Hung => Event::Hung { suture: number()? },
            EventKind::Fall => Event::Fall { distance_m: value },
            EventKind::Shake => Event::Shake { speed_m_s: value },
            EventKind::Buried => Event::Buried { depth_m: value },
            EventKind::Press => Event::Press { force_n: value },
            EventKind::Opened => Event::Opened { area_m2: value },
            EventKind::Unclipped => Event::Unclipped { number: number()? },
            EventKind::Seared => Event::Seared { volume_m3: value },
            EventKind::StoneSpilled => Event::StoneSpilled { stone: number()? },
            EventKind::StoneHeld => Event::StoneHeld { stone: number()? },
            EventKind::StoneDropped => Event::StoneDropped { stone: number()? },
            EventKind::StoneRetrieved => Event::StoneRetrieved { stone: number()? },
            EventKind::ClipCloses => Event::ClipCloses { share: value },
            EventKind::ClipAlong => Event::ClipAlong { along_m: value },
        })
    }

    /// True if the event is of this kind.
    #[must_use]
    pub const fn is(&self, kind: EventKind) -> bool {
        self.kind == kind.number()
    }

    /// Name of the event's kind, for reports.
    #[must_use]
    pub fn name(&self) -> &'static str {
        EventKind::try_from(self.kind).map_or("unknown", EventKind::name)
    }
}

// Both processes rely on this size. A change of it needs a new version.
const _: () = {
    assert!(size_of::<EventMsg>() == 48);
};

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn event(kind: EventKind, value: f32) -> EventMsg {
        let kind = kind.number();
        EventMsg {
            kind,
            value,
            ..EventMsg::zeroed()
        }
    }

    #[test]
    fn events_of_every_kind_decode_and_keep_their_name() {
        for kind in EventKind::ALL {
            let event = event(kind, 1.0);
            assert!(event.decode().is_ok(), "{kind:?}");
            assert_eq!(event.name(), kind.name());
            assert!(event.is(kind));
        }
    }

    #[test]
    fn payloads_have_the_value() {
        let clip = event(EventKind::Clip, 7.0).decode();
        assert_eq!(clip, Ok(Event::Clip { number: 7 }));
        let fault = event(EventKind::Fault, 17.0).decode();
        assert_eq!(fault, Ok(Event::Fault(Fault::BothElectrodes)));
        let leak = event(EventKind::Leak, 0.25).decode();
        assert_eq!(leak, Ok(Event::Leak { flow: 0.25 }));
    }

    #[test]
    fn events_with_unknown_numbers_are_refused() {
        for (kind, value) in [
            (EventKind::Clip, -1.0),
            (EventKind::Clip, 0.5),
            (EventKind::Removed, 16_777_216.0),
            (EventKind::Fault, Fault::ALL.len() as f32),
            (EventKind::Electro, 3.0),
            (EventKind::Burn, f32::NAN),
        ] {
            let message = event(kind, value)
                .decode()
                .expect_err("a false value")
                .to_string();
            let unnamed = message.starts_with("there is no ");
            assert!(unnamed || message.contains(" cannot carry "), "{message}");
        }
        let message = event(EventKind::Electro, 3.0).decode().unwrap_err();
        assert!(matches!(message, UnknownEvent::Word(_)), "{message:?}");
        assert_eq!(message.to_string(), "there is no current 3");
    }

    proptest! {
        #[test]
        fn any_bits_decode_or_are_refused(kind: u32, bits: u32) {
            let event = EventMsg { kind, value: f32::from_bits(bits), ..EventMsg::zeroed() };
            let known = EventKind::try_from(kind).is_ok();
            prop_assert!(known || event.decode().is_err());
            prop_assert_eq!(event.name() == "unknown", !known);
        }
    }
}
