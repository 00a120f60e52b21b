//! Words that the rooms above share.

use crate::math::Vec3;

/// What a sphere is doing: bits as in the shared-memory message.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SphereBits(pub u8);

impl SphereBits {
    /// Its organ is simulated this tick.
    pub const AWAKE: Self = Self(1);
    /// The instrument touches it.
    pub const CONTACT: Self = Self(2);
    /// Between closed jaws.
    pub const GRASPED: Self = Self(4);
    /// Layered tissue of which nothing is left: nobody meets it.
    pub const GONE: Self = Self(8);

    /// Whether every bit of `other` is set.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// With the bits of `other` as well.
    #[must_use]
    pub const fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Without the bits of `other`.
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }
}

/// Whether a device can be relied on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum Status {
    /// Nothing came from it since the start.
    #[default]
    Absent = 0,
    /// Samples arrive in time.
    Live = 1,
    /// The newest sample is older than its limit.
    Stale = 2,
    /// The line is gone.
    Lost = 3,
}

/// Health of one device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Health {
    /// Status.
    pub status: Status,
    /// Age of its newest sample, ns. 0 if there is none.
    pub age_ns: u64,
}

/// Kind of an [`Event`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EventKind {
    /// The instrument began to touch an organ; value: force on the hand, N.
    Contact,
    /// It left it; value: 0.
    Release,
    /// Jaws closed on tissue; value: spheres held.
    Grasp,
    /// Jaws let go, or what they held has slipped out; value: spheres that were held.
    LetGo,
    /// What the jaws hold has slipped by 2 mm; value: what it pulls with, N.
    Slip,
    /// A band between organs, or a link of a tube, has torn; value: the energy it took, J.
    Tear,
    /// Scissors or current have cut a band, a suture, or a link of a tube; value: the energy of a tear of it, J.
    Cut,
    /// A fault was raised; value: [`crate::fault::Fault::code`].
    Fault,
    /// Electrosurgery: value 1 cut, 2 coagulate, 0 off.
    Electro,
    /// A clip has closed, on this organ or, if none is named, on nothing; value: the clip's number,
    /// from 0. One that closes on two organs raises two.
    Clip,
    /// An electrode has burnt an organ; value: the energy since that was last told, J.
    Burn,
    /// A vessel, duct or bag leaks; value: its flow as a share of what runs in it whole, 0: stopped. Every
    /// event of one leak has the place where it began.
    Leak,
    /// A cell of layered tissue is gone; value: its index in the scene.
    Removed,
    /// Jaws have crushed what they hold; value: their force, N.
    Crush,
    /// A wall is burnt through or torn open; value: the energy it took, J.
    Perforation,
    /// A tube is divided, or off what it was grown to; value: share of its inside that clips leave open on
    /// the worse of both sides, up to where it ends or is divided already. 0: between clips that close it.
    Divided,
    /// A suture goes through an organ, there; value: the suture's number in the scene, from 0.
    Stitch,
    /// A suture hangs an organ on the abdominal wall, there; value: the suture's number in the scene, from 0.
    Hung,
    /// Everything is as it was at the start, or as a task begins; what was told before is void.
    Reset,
}

/// An event of one tick. The tick's number and time stand in [`crate::sim::TickView`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Event {
    /// What.
    pub kind: EventKind,
    /// Organ's index in the scene, if it concerns one.
    pub organ: Option<u32>,
    /// Where, world frame, m.
    pub at_m: Vec3,
    /// Depends on the kind.
    pub value: f32,
}
