//! The course of an operation: poses of both hands, a hundred times a second, and the events. An
//! assessment uses nothing else, so that a repeated assessment yields the same numbers.
//!
//! ```text
//! u8 kind, u64 tick, u64 host time ns, then
//! 1 movement: 3 × (3 f32 m, 4 f32 x y z w) handle, instrument, camera; 3 f32 tip m; 3 f32 force N;
//!             f32 jaw; u8 instrument; u8 switches; u8 live; u16 contacts
//! 2 event:    u64 sequence; u32 kind; u32 organ; 3 f32 place m; f32 value
//! 3 device:   f32 greatest force N
//! 4 reset
//! 5 start:    u8 number of the task, as in `CommandMsg::START`
//! 6 sight:    f32 angle between view and shaft, f32 turn about the shaft, rad
//! 7 seen:     f32 side rad; f32 triangle; f32 lower bed; 16 × (u8 in view, u8 clear, u8 √size,
//!             u8 off), shares × 255, organs in the scene's order
//! 8 act:      u8 kind of the act, 3 f32 place m, then the remark in UTF-8
//! ```
//!
//! All little-endian.

use std::f32::consts::{FRAC_PI_2, TAU};

use shared_mem::message::{
    ActMsg, CapsuleMsg, DeviceHealth, EventMsg, PoseMsg, REMARK_BYTES, ToolFrame,
};
use shared_mem::words::{ActKind, CapsuleRole, Instrument, Switches};

use crate::identity::{ORGANS_MAX, OrganSeen, Seen};
use crate::pack::Rest;

const MOVEMENT: u8 = 1;
const EVENT: u8 = 2;
const DEVICE: u8 = 3;
const RESET: u8 = 4;
const START: u8 = 5;
const SIGHT: u8 = 6;
const SEEN: u8 = 7;
const ACT: u8 = 8;
/// Size of the longest entry, bytes.
#[cfg(test)]
const LONGEST_BYTES: usize = 17 + 3 * 28 + 2 * 12 + 4 + 5;

/// Poses and state of both hands at one moment: one holds the instrument, one the endoscope.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Movement {
    /// Handle of the haptic device, world frame.
    pub world_from_handle: PoseMsg,
    /// Instrument: origin at the jaw joint, −z along the shaft towards the tip.
    pub world_from_instrument: PoseMsg,
    /// Endoscope's shaft: −z along it, y up.
    pub world_from_camera: PoseMsg,
    /// Middle of the instrument's tips, world frame, m.
    pub tip_m: [f32; 3],
    /// Force on the hand, world frame, N.
    pub force_n: [f32; 3],
    /// Opening of the jaws: 0 closed, 1 open.
    pub jaw: f32,
    /// Instrument: 0 grasper, 1 cautery hook, 2 scissors, 3 clip applier, 4 irrigator.
    pub instrument: u8,
    /// Bits: 1 cut, 2 coagulate, 4 camera lock, 8 paused, 16 force enabled.
    pub switches: u8,
    /// Devices whose samples arrive in time: 1 haptic device, 2 tracker, 4 pedal.
    pub live: u8,
    /// Number of the instrument's contacts.
    pub contacts: u16,
}

impl Movement {
    /// Makes a movement from a frame of the tools; `None` if the frame is malformed.
    #[must_use]
    pub fn of(tools: &ToolFrame) -> Option<Self> {
        let capsules = tools.capsules()?;
        // The tips are the hook's bent end or both jaws. Shaft and endoscope do not count.
        let bent = capsules.iter().any(|it| it.is(CapsuleRole::Tip));
        let is_tip = |it: &&CapsuleMsg| {
            if bent {
                it.is(CapsuleRole::Tip)
            } else {
                it.is(CapsuleRole::UpperJaw) || it.is(CapsuleRole::LowerJaw)
            }
        };
        let tips = capsules.iter().filter(is_tip);
        let (sum, count) = tips.fold(([0.0f32; 3], 0.0f32), |(sum, count), capsule| {
            let add = |i: usize| sum[i] + capsule.b_m[i];
            ([add(0), add(1), add(2)], count + 1.0)
        });
        let tip_m = match count > 0.0 {
            true => sum.map(|x| x / count),
            false => tools.world_from_instrument.position_m,
        };
        let live = tools.health.iter().zip([1u8, 2, 4]);
        Some(Self {
            world_from_handle: tools.world_from_handle,
            world_from_instrument: tools.world_from_instrument,
            world_from_camera: tools.world_from_camera,
            tip_m,
            force_n: tools.force_n,
            jaw: tools.jaw,
            instrument: u8::try_from(tools.instrument).unwrap_or(u8::MAX),
            switches: tools.switches as u8,
            live: live
                .filter(|(health, _)| health.status == DeviceHealth::LIVE)
                .map(|(_, bit)| bit)
                .sum(),
            contacts: u16::try_from(tools.contact_count).unwrap_or(u16::MAX),
        })
    }

    /// The instrument in the hand; `None` if its number has no name.
    #[must_use]
    pub fn instrument(&self) -> Option<Instrument> {
        u32::from(self.instrument).try_into().ok()
    }

    /// The switches that have a name.
    #[must_use]
    pub fn switches(&self) -> Switches {
        Switches::named(self.switches.into())
    }

    fn is_sane(&self) -> bool {
        let poses = [
            self.world_from_handle,
            self.world_from_instrument,
            self.world_from_camera,
        ];
        let numbers = self.tip_m.iter().chain(&self.force_n).chain([&self.jaw]);
        poses.iter().all(PoseMsg::is_sane) && numbers.into_iter().all(|x| x.abs() < 1e3)
    }
}

/// Content of an entry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EntryContent {
    /// A movement of the hands.
    Moved(Movement),
    /// An event.
    Event(EventMsg),
    /// The haptic device's limits.
    Device {
        /// Greatest force, N.
        force_max_n: f32,
    },
    /// The organs were reset to rest.
    Reset,
    /// The endoscope's view changed its angle to the shaft. Before the first such entry, the view
    /// is along the shaft.
    Sight {
        /// Angle between view and shaft, rad: 0 to a quarter turn.
        off_rad: f32,
        /// Turn of the light cable about the shaft, rad. At 0 an inclined view looks downwards.
        turned_rad: f32,
    },
    /// The endoscope's picture was measured in an identity image.
    Seen(Seen),
    /// An instructor acted.
    Act(ActMsg),
    /// The organs were prepared for a task: 0 hang, 1 identify, 2 clamp, 3 cut, 4 disconnect.
    Start {
        /// The task's number.
        task: u8,
    },
}

/// An entry of the course.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// Tick of the entry.
    pub tick: u64,
    /// Host time: `CLOCK_MONOTONIC` of the recording computer, ns.
    pub at_ns: u64,
    /// Its content.
    pub what: EntryContent,
}

impl Entry {
    pub(crate) fn pack(&self, into: &mut Vec<u8>) {
        let kind = match self.what {
            EntryContent::Moved(_) => MOVEMENT,
            EntryContent::Event(_) => EVENT,
            EntryContent::Device { .. } => DEVICE,
            EntryContent::Reset => RESET,
            EntryContent::Start { .. } => START,
            EntryContent::Sight { .. } => SIGHT,
            EntryContent::Seen(_) => SEEN,
            EntryContent::Act(_) => ACT,
        };
        into.push(kind);
        into.extend(self.tick.to_le_bytes());
        into.extend(self.at_ns.to_le_bytes());
        match &self.what {
            EntryContent::Moved(moved) => {
                for pose in [
                    &moved.world_from_handle,
                    &moved.world_from_instrument,
                    &moved.world_from_camera,
                ] {
                    into.extend(bytemuck::bytes_of(pose));
                }
                into.extend(bytemuck::bytes_of(&moved.tip_m));
                into.extend(bytemuck::bytes_of(&moved.force_n));
                into.extend(moved.jaw.to_le_bytes());
                into.extend([moved.instrument, moved.switches, moved.live]);
                into.extend(moved.contacts.to_le_bytes());
            }
            EntryContent::Event(event) => {
                into.extend(event.sequence.to_le_bytes());
                into.extend(event.kind.to_le_bytes());
                into.extend(event.organ.to_le_bytes());
                into.extend(bytemuck::bytes_of(&event.at_m));
                into.extend(event.value.to_le_bytes());
            }
            EntryContent::Device { force_max_n } => into.extend(force_max_n.to_le_bytes()),
            EntryContent::Reset => {}
            EntryContent::Start { task } => into.push(*task),
            EntryContent::Sight {
                off_rad,
                turned_rad,
            } => {
                into.extend(off_rad.to_le_bytes());
                into.extend(turned_rad.to_le_bytes());
            }
            EntryContent::Seen(seen) => {
                for number in [seen.side_rad, seen.triangle, seen.lower_bed] {
                    into.extend(number.to_le_bytes());
                }
                for organ in &seen.organs {
                    into.extend(organ.0);
                }
            }
            EntryContent::Act(act) => {
                into.push(act.kind as u8);
                into.extend(bytemuck::bytes_of(&act.at_m));
                into.extend(act.text().unwrap_or_default().as_bytes());
            }
        }
    }

    /// Parses a message; `None` if its form or its values are invalid.
    pub(crate) fn unpack(message: &[u8]) -> Option<Self> {
        let mut rest = Rest(message);
        let [kind] = rest.take()?;
        let tick = u64::from_le_bytes(rest.take()?);
        let at_ns = u64::from_le_bytes(rest.take()?);
        let what = match kind {
            MOVEMENT => {
                let moved = Movement {
                    world_from_handle: rest.pose()?,
                    world_from_instrument: rest.pose()?,
                    world_from_camera: rest.pose()?,
                    tip_m: bytemuck::cast(rest.take::<12>()?),
                    force_n: bytemuck::cast(rest.take::<12>()?),
                    jaw: f32::from_le_bytes(rest.take()?),
                    instrument: u8::from_le_bytes(rest.take()?),
                    switches: u8::from_le_bytes(rest.take()?),
                    live: u8::from_le_bytes(rest.take()?),
                    contacts: u16::from_le_bytes(rest.take()?),
                };
                EntryContent::Moved(Some(moved).filter(Movement::is_sane)?)
            }
            EVENT => {
                let event = EventMsg {
                    sequence: u64::from_le_bytes(rest.take()?),
                    tick,
                    at_ns,
                    kind: u32::from_le_bytes(rest.take()?),
                    organ: u32::from_le_bytes(rest.take()?),
                    at_m: bytemuck::cast(rest.take::<12>()?),
                    value: f32::from_le_bytes(rest.take()?),
                };
                EntryContent::Event(Some(event).filter(is_sane)?)
            }
            DEVICE => {
                let force_max_n = f32::from_le_bytes(rest.take()?);
                let sane = (0.0..1e3).contains(&force_max_n);
                EntryContent::Device {
                    force_max_n: sane.then_some(force_max_n)?,
                }
            }
            RESET => EntryContent::Reset,
            START => {
                let [task] = rest.take()?;
                EntryContent::Start { task }
            }
            SIGHT => {
                let off_rad = f32::from_le_bytes(rest.take()?);
                let turned_rad = f32::from_le_bytes(rest.take()?);
                sight(off_rad, turned_rad)?
            }
            SEEN => {
                let mut number = || rest.take().map(f32::from_le_bytes);
                let [side_rad, triangle, lower_bed] = [number()?, number()?, number()?];
                let mut organs = [OrganSeen::default(); ORGANS_MAX];
                for organ in &mut organs {
                    organ.0 = rest.take()?;
                }
                let seen = Seen {
                    side_rad,
                    triangle,
                    lower_bed,
                    organs,
                };
                EntryContent::Seen(Some(seen).filter(Seen::is_sane)?)
            }
            ACT => {
                let [kind] = rest.take()?;
                let at_m = bytemuck::cast(rest.take::<12>()?);
                let text = core::mem::take(&mut rest.0);
                let mut remark = [0; REMARK_BYTES];
                remark.get_mut(..text.len())?.copy_from_slice(text);
                let act = ActMsg {
                    length: u32::try_from(text.len()).ok()?,
                    at_m,
                    remark,
                    ..ActMsg::of(ActKind::try_from(u32::from(kind)).ok()?)
                };
                EntryContent::Act(Some(act).filter(ActMsg::is_sane)?)
            }
            _ => return None,
        };
        rest.0.is_empty().then_some(Self { tick, at_ns, what })
    }

    /// Makes an entry from an event; `None` if the numbers of the event are out of range.
    pub(crate) fn of_event(event: &EventMsg) -> Option<Self> {
        is_sane(event).then_some(Self {
            tick: event.tick,
            at_ns: event.at_ns,
            what: EntryContent::Event(*event),
        })
    }
}

/// The endoscope's view; `None` if the angles are invalid.
pub(crate) fn sight(off_rad: f32, turned_rad: f32) -> Option<EntryContent> {
    let is_sane = (0.0..=FRAC_PI_2).contains(&off_rad) && turned_rad.abs() <= TAU;
    is_sane.then_some(EntryContent::Sight {
        off_rad,
        turned_rad,
    })
}

fn is_sane(event: &EventMsg) -> bool {
    event.value.is_finite() && event.at_m.iter().all(|x| x.abs() < 1e3)
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable as _;

    use super::*;
    use proptest::prelude::*;

    fn poses() -> impl Strategy<Value = PoseMsg> {
        prop::array::uniform3(-1.0f32..1.0).prop_map(|position_m| PoseMsg {
            position_m,
            ..PoseMsg::IDENTITY
        })
    }

    fn whats() -> impl Strategy<Value = EntryContent> {
        let vector = || prop::array::uniform3(-5.0f32..5.0);
        let moved = (
            prop::array::uniform3(poses()),
            vector(),
            vector(),
            0.0f32..1.0,
            any::<[u8; 3]>(),
            any::<u16>(),
        )
            .prop_map(|(poses, tip_m, force_n, jaw, bytes, contacts)| {
                EntryContent::Moved(Movement {
                    world_from_handle: poses[0],
                    world_from_instrument: poses[1],
                    world_from_camera: poses[2],
                    tip_m,
                    force_n,
                    jaw,
                    instrument: bytes[0],
                    switches: bytes[1],
                    live: bytes[2],
                    contacts,
                })
            });
        let event = (any::<[u32; 2]>(), any::<u64>(), vector(), -9.0f32..9.0).prop_map(
            |([kind, organ], sequence, at_m, value)| {
                EntryContent::Event(EventMsg {
                    sequence,
                    kind,
                    organ,
                    at_m,
                    value,
                    ..EventMsg::zeroed()
                })
            },
        );
        let device = (0.0f32..100.0).prop_map(|force_max_n| EntryContent::Device { force_max_n });
        let start = any::<u8>().prop_map(|task| EntryContent::Start { task });
        let sight =
            (0.0f32..1.5, -3.2f32..3.2).prop_map(|(off_rad, turned_rad)| EntryContent::Sight {
                off_rad,
                turned_rad,
            });
        let seen = (
            prop::array::uniform3(0.0f32..1.0),
            prop::array::uniform16(any::<[u8; 4]>()),
        )
            .prop_map(|([side_rad, triangle, lower_bed], organs)| {
                EntryContent::Seen(Seen {
                    side_rad,
                    triangle,
                    lower_bed,
                    organs: organs.map(OrganSeen),
                })
            });
        let acts = ("[a-zéध ]{0,40}", vector()).prop_map(|(text, at_m)| {
            EntryContent::Act(ActMsg::remark(&text).unwrap_or_else(|| ActMsg::point(at_m)))
        });
        prop_oneof![
            moved,
            event,
            device,
            start,
            sight,
            seen,
            acts,
            Just(EntryContent::Reset)
        ]
    }

    proptest! {
        #[test]
        fn packed_course_comes_back(tick in any::<u64>(), at_ns in any::<u64>(), mut what in whats()) {
            if let EntryContent::Event(event) = &mut what {
                (event.tick, event.at_ns) = (tick, at_ns);
            }
            let entry = Entry { tick, at_ns, what };
            let mut bytes = Vec::new();
            entry.pack(&mut bytes);
            prop_assert!(bytes.len() <= LONGEST_BYTES);
            prop_assert_eq!(Entry::unpack(&bytes), Some(entry));
            bytes.push(0);
            prop_assert_eq!(Entry::unpack(&bytes), None);
        }

        #[test]
        fn any_bytes_are_sane_or_refused(
            kind in 0u8..9,
            bytes in prop::collection::vec(any::<u8>(), 0..160),
        ) {
            let message: Vec<u8> = [kind].into_iter().chain(bytes).collect();
            match Entry::unpack(&message).map(|entry| entry.what) {
                Some(EntryContent::Moved(moved)) => prop_assert!(moved.is_sane()),
                Some(EntryContent::Event(event)) => prop_assert!(is_sane(&event)),
                Some(EntryContent::Sight { off_rad, turned_rad }) => {
                    prop_assert!((0.0..1.6).contains(&off_rad) && turned_rad.abs() < 6.3);
                }
                Some(EntryContent::Seen(seen)) => prop_assert!(seen.is_sane()),
                _ => {}
            }
        }
    }

    #[test]
    fn the_schema_in_a_session_describes_every_kind_of_entry() {
        let topic = crate::describe::COURSE;
        let schema = String::from_utf8_lossy(&topic.schema);
        for kind in [MOVEMENT, EVENT, DEVICE, RESET, START, SIGHT, SEEN] {
            assert!(schema.contains(&format!("Kind {kind}")), "{kind}");
        }
    }

    #[test]
    fn an_hour_of_the_course_leaves_room_for_the_inputs() {
        // An entry, the head of its record (9), the head of its message (22), its index (16).
        let bytes = LONGEST_BYTES + 9 + 22 + 16;
        assert!(bytes * 100 * 3600 < 80_000_000, "{bytes}");
    }

    #[test]
    fn the_tip_lies_between_the_jaws() {
        let mut tools = ToolFrame::zeroed();
        for pose in [
            &mut tools.world_from_handle,
            &mut tools.world_from_instrument,
            &mut tools.world_from_camera,
        ] {
            *pose = PoseMsg::IDENTITY;
        }
        assert_eq!(Movement::of(&tools).map(|it| it.tip_m), Some([0.0; 3]));
        tools.capsule_count = 4;
        for (capsule, (role, x)) in
            tools
                .capsules
                .iter_mut()
                .zip([(0, 9.0), (1, 1.0), (2, 2.0), (4, 9.0)])
        {
            (capsule.role, capsule.b_m) = (role, [x, 0.0, 0.5]);
        }
        tools.health[1].status = DeviceHealth::LIVE;
        let moved = Movement::of(&tools).unwrap();
        assert_eq!((moved.tip_m, moved.live), ([1.5, 0.0, 0.5], 2));
        tools.capsules[2].role = 3;
        assert_eq!(
            Movement::of(&tools).map(|it| it.tip_m),
            Some([2.0, 0.0, 0.5])
        );
        tools.force_n[1] = f32::NAN;
        assert_eq!(Movement::of(&tools), None);
    }
}
