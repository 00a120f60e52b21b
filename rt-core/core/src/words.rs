//! Types that several modules share: flags of a sphere, health of a device, events.

use crate::math::Vec3;

/// Flags of a sphere, one bit each, as in the shared-memory message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SphereBits(pub u8);

impl SphereBits {
    /// The sphere's organ is simulated in this tick.
    pub const AWAKE: Self = Self(1);
    /// A tool (instrument or endoscope) touches the sphere.
    pub const CONTACT: Self = Self(2);
    /// The jaws of the instrument hold the sphere.
    pub const GRASPED: Self = Self(4);
    /// All cells of layered tissue at the sphere are removed; nothing collides with the sphere.
    pub const REMOVED: Self = Self(8);

    /// True if every flag of `other` is set.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// With the flags of `other` as well.
    #[must_use]
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Without the flags of `other`.
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }
}

/// Status of a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Status {
    /// No sample has arrived since the start.
    #[default]
    Absent = 0,
    /// Samples arrive in time.
    Live = 1,
    /// The newest sample is older than its limit.
    Stale = 2,
    /// The connection to the device is lost.
    Lost = 3,
}

/// Health of one device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Health {
    /// Status.
    pub status: Status,
    /// Age of the device's newest sample, ns; 0 if it has sent none.
    pub age_ns: u64,
}

/// Kind of an [`Event`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// The instrument began to touch an organ; value: force on the hand, N.
    Contact,
    /// The instrument left the organ; value: 0.
    Release,
    /// Jaws closed on tissue; value: spheres held.
    Grasp,
    /// The jaws let go, or their tissue slipped out; value: spheres that were held.
    LetGo,
    /// Held tissue slipped by 2 mm through the jaws; value: pull of the tissue on the jaws, N.
    Slip,
    /// An attachment or a link of a tube has torn; value: energy that the tear took, J.
    Tear,
    /// Scissors or current have cut an attachment, a suture or a link of a tube; value: energy, J,
    /// that tearing it would have taken.
    Cut,
    /// A fault was raised; value: [`crate::fault::Fault::code`].
    Fault,
    /// The electrosurgical current changed; value: 1 cut, 2 coagulate, 0 off.
    Electro,
    /// A clip has closed on the event's organ, or on nothing if the event has no organ; value: the
    /// clip's number, from 0. A clip that closes on two organs raises two events.
    Clip,
    /// An electrode has burnt an organ; value: energy since the organ's last burn event, J.
    Burn,
    /// A vessel, duct or bag leaks; value: flow as a share of the flow from an open lumen at full
    /// pressure; 0: the leak has stopped. All events of one leak carry the place where it began.
    Leak,
    /// A cell of layered tissue is removed; value: its index in the scene.
    Removed,
    /// The jaws have crushed held tissue; value: force of the jaws, N.
    Crush,
    /// A wall is burnt through, or a tube under pressure is half cut or half torn; value: energy
    /// that burnt the wall through, J; 0 for the tube.
    Perforation,
    /// A tube is divided, or torn off an organ. Value: share of the lumen that clips leave open
    /// between the division and the tube's next end; of the two sides, the larger share. 0: clips
    /// or other divisions close both sides.
    Divided,
    /// A suture passes through an organ at this place; value: the suture's number in the scene,
    /// from 0.
    Stitch,
    /// A suture hangs an organ on the abdominal wall at this place; value: the suture's number in
    /// the scene, from 0.
    Hung,
    /// The simulation is back at its start, or at the start of a task; earlier events no longer
    /// hold.
    Reset,
    /// An organ that nobody has freed stays away from its place; value: distance of the organ's
    /// middle from that place, m.
    Fall,
    /// An organ does not come to rest, and no tool explains its speed; value: speed of its fastest
    /// sphere, m/s.
    Shake,
    /// The instrument is inside an organ at its device's first sample, or at the first after a gap;
    /// value: depth of the instrument in the organ, m.
    Buried,
    /// The instrument presses on an organ harder by 0.1 N than at the last `Press` of this contact;
    /// value: smoothed force on the organ, N.
    Press,
    /// An instructor's complication opens a vessel at this place; value: area of the hole, m².
    Opened,
    /// An instructor's complication takes a clip off the event's organ, at this place; value: the
    /// clip's number. A clip on two organs raises two events.
    Unclipped,
    /// Heat has destroyed tissue of an organ, at the hottest place of the organ; value: destroyed
    /// volume since the last reset, m³. The Arrhenius sum of destroyed tissue is at least 1. Raised
    /// again when the volume has grown, at most twice a second.
    Seared,
    /// A stone has left the gallbladder through a hole; value: the stone's number, from 0.
    StoneSpilled,
    /// The jaws have closed around a stone; value: its number.
    StoneHeld,
    /// The jaws have let go of a stone; value: its number.
    StoneDropped,
    /// A stone is out of the body, drawn out by the jaws or sucked off; value: its number.
    StoneRetrieved,
    /// Precedes the `Clip` of the same clip and organ; value: share of the tube's lumen that the
    /// clip closes, 0 to 1.
    ClipCloses,
    /// Precedes the `Clip` of the same clip and organ; value: place of the clip along the tube at
    /// rest, from its end with the lowest sphere, m.
    ClipAlong,
}

/// An event of one tick. [`crate::sim::TickView`] has the tick's number and time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// Kind.
    pub kind: EventKind,
    /// Index in the scene of the organ that the event concerns, if any.
    pub organ: Option<u32>,
    /// Place, world frame, m.
    pub at_m: Vec3,
    /// Value; its meaning depends on the kind.
    pub value: f32,
}
