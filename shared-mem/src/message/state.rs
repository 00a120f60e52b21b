//! Service `state`.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use super::PoseMsg;
use crate::limits::{MAX_CELLS, MAX_CLIPPED, MAX_SPHERES, MAX_STONES, MAX_SUTURES, MAX_TUBE_LINKS};

/// One sphere's state.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
pub struct SphereState {
    /// Centre, world frame, m.
    pub center_m: [f32; 3],
    /// Bits of the `SphereState` constants in the lowest byte. The other bytes hold the heat:
    /// [`Self::rise_k`], [`Self::denatured`], [`Self::dried`].
    pub bits: u32,
}

impl SphereState {
    /// The sphere's organ is simulated in this tick.
    pub const AWAKE: u32 = 1;
    /// A tool touches the sphere.
    pub const CONTACT: u32 = 2;
    /// The closed jaws hold the sphere.
    pub const GRASPED: u32 = 4;
    /// All cells of layered tissue that belong to the sphere are removed.
    pub const GONE: u32 = 8;

    /// Temperature above the body's, K; 255 also stands for higher values.
    #[must_use]
    pub const fn rise_k(&self) -> u8 {
        self.bits.to_le_bytes()[1]
    }

    /// Share of proteins that heat has denatured, 0 to 255.
    #[must_use]
    pub const fn denatured(&self) -> u8 {
        self.bits.to_le_bytes()[2]
    }

    /// Share of its water that the tissue has lost, 0 to 255.
    #[must_use]
    pub const fn dried(&self) -> u8 {
        self.bits.to_le_bytes()[3]
    }

    /// With this heat: temperature above the body's, K, and shares of denatured proteins and of
    /// lost water, 0 to 255.
    #[must_use]
    pub const fn with_heat(self, [rise_k, denatured, dried]: [u8; 3]) -> Self {
        let flags = self.bits.to_le_bytes()[0];
        Self {
            bits: u32::from_le_bytes([flags, rise_k, denatured, dried]),
            ..self
        }
    }
}

/// A clip on a vessel or duct, between two of its spheres.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
pub struct ClipMsg {
    /// The two spheres, in the scene's order.
    pub spheres: [u32; 2],
    /// Position of the clip between the two spheres: 0 at the first, 1 at the second.
    pub share: f32,
    /// Share of the lumen that the clip closes, 0 to 1.
    pub closed: f32,
    /// Direction of the clip's legs, from the bend to the open ends: a unit vector, world frame.
    pub legs: [f32; 3],
    /// The clip's number, from 0. A clip on two tubes has two records.
    pub number: u32,
}

impl ClipMsg {
    /// True if the clip lies between existing spheres and its numbers are in range.
    fn is_sane(&self, sphere_count: u32) -> bool {
        let share = |x: f32| (0.0..=1.0).contains(&x);
        self.spheres.iter().all(|it| *it < sphere_count)
            && share(self.share)
            && share(self.closed)
            && self.legs.iter().all(|x| x.abs() < 2.0)
    }
}

/// A suture that hangs an organ on the abdominal wall.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
pub struct SutureMsg {
    /// Index of the sphere that the suture goes through, in the scene's order.
    pub sphere: u32,
    /// One of the `SutureMsg` constants.
    pub placed: u32,
    /// Other end of the suture, in the wall or at the instrument's tip, world frame, m.
    pub at_m: [f32; 3],
    /// Length of the suture when it is pulled tight, m.
    pub length_m: f32,
}

impl SutureMsg {
    /// The suture is not placed yet.
    pub const AWAY: u32 = 0;
    /// The suture leads through the organ to the instrument's tip.
    pub const AT_HAND: u32 = 1;
    /// The suture hangs the organ on the wall.
    pub const HUNG: u32 = 2;
    /// The suture hung the organ and was then cut through.
    pub const CUT: u32 = 3;

    /// True if the suture goes through an existing sphere and its numbers are in range.
    fn is_sane(&self, sphere_count: u32) -> bool {
        self.sphere < sphere_count
            && self.placed <= Self::CUT
            && self.at_m.iter().all(|x| x.abs() < 1e3)
            && (0.0..=10.0).contains(&self.length_m)
    }
}

/// A stone outside of the gallbladder.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
pub struct StoneMsg {
    /// Centre, world frame, m.
    pub at_m: [f32; 3],
    /// Radius, m.
    pub radius_m: f32,
    /// Rotation from the stone's frame to the world, x y z w.
    pub orientation: [f32; 4],
    /// The stone's number, from 0.
    pub number: u32,
    /// 1: the jaws hold the stone.
    pub is_held: u32,
}

impl StoneMsg {
    fn is_sane(&self) -> bool {
        let pose = PoseMsg {
            position_m: self.at_m,
            orientation: self.orientation,
        };
        let has_size = (1.0e-4..=0.1).contains(&self.radius_m);
        pose.is_sane() && has_size && self.number < MAX_STONES as u32
    }
}

/// Service `state`: the state of all tissue. A reader gets only the newest frame.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.StateFrame.v7")]
pub struct StateFrame {
    /// Tick that wrote the frame.
    pub tick: u64,
    /// Time at which the newest sample of the haptic device was read (`CLOCK_MONOTONIC`); 0 before
    /// the first.
    pub sample_ns: u64,
    /// Time at which the frame was filled (`CLOCK_MONOTONIC`).
    pub at_ns: u64,
    /// First 16 bytes of the compiled scene's identity.
    pub scene_id: [u8; 16],
    /// Number of `spheres` in use.
    pub sphere_count: u32,
    /// Number of `clips` in use.
    pub clip_count: u32,
    /// Number of `cells` in use.
    pub cell_count: u32,
    /// Number of `sutures` in use.
    pub suture_count: u32,
    /// Number of bits of `parted` in use.
    pub link_count: u32,
    /// Number of `stones` in use.
    pub stone_count: u32,
    /// The sutures between an organ and the world (attachments with `AttachmentRecord::is_thread`),
    /// in the scene's order.
    pub sutures: [SutureMsg; MAX_SUTURES],
    /// The spheres, in the scene's order.
    pub spheres: [SphereState; MAX_SPHERES],
    /// The clips, in the order in which they were closed.
    pub clips: [ClipMsg; MAX_CLIPPED],
    /// The elastic links of tubes (organs without tetrahedra), in the scene's order: one bit for
    /// each link, lowest bit first. The bit is set if the link is severed.
    pub parted: [u8; MAX_TUBE_LINKS / 8],
    /// Cells of layered tissue, in the scene's order. A value is the heat that the cell has
    /// absorbed so far, in 1/254 of the heat that removes it, or [`StateFrame::GONE`].
    pub cells: [u8; MAX_CELLS],
    /// The stones outside of the gallbladder that are still in the body, in the order of their
    /// numbers.
    pub stones: [StoneMsg; MAX_STONES],
}

impl StateFrame {
    /// A cell that is gone.
    pub const GONE: u8 = u8::MAX;

    /// The cells in use. `None` if `cell_count` is too large.
    #[must_use]
    pub fn cells(&self) -> Option<&[u8]> {
        self.cells.get(..self.cell_count as usize)
    }

    /// One value for each link of `parted` in use: true if the link is severed. `None` if
    /// `link_count` is too large.
    #[must_use]
    pub fn parted(&self) -> Option<impl Iterator<Item = bool>> {
        let count = self.link_count as usize;
        let bit = |link: usize| self.parted[link / 8] >> (link % 8) & 1 != 0;
        (count <= MAX_TUBE_LINKS).then(|| (0..count).map(bit))
    }

    /// The spheres in use. `None` if the frame is malformed: `sphere_count` is too large, or a
    /// coordinate is not finite or beyond 1000 m.
    #[must_use]
    pub fn spheres(&self) -> Option<&[SphereState]> {
        let spheres = self.spheres.get(..self.sphere_count as usize)?;
        let sane = |s: &SphereState| s.center_m.iter().all(|x| x.abs() < 1e3);
        spheres.iter().all(sane).then_some(spheres)
    }

    /// The sutures in use. `None` if the frame is malformed: `suture_count` is too large, or a
    /// suture names a sphere that does not exist or has a number out of range.
    #[must_use]
    pub fn sutures(&self) -> Option<&[SutureMsg]> {
        let sutures = self.sutures.get(..self.suture_count as usize)?;
        let sane = |it: &SutureMsg| it.is_sane(self.sphere_count.min(MAX_SPHERES as u32));
        sutures.iter().all(sane).then_some(sutures)
    }

    /// The stones in use. `None` if the frame is malformed: `stone_count` is too large, or a number
    /// of a stone is out of range.
    #[must_use]
    pub fn stones(&self) -> Option<&[StoneMsg]> {
        let stones = self.stones.get(..self.stone_count as usize)?;
        stones.iter().all(StoneMsg::is_sane).then_some(stones)
    }

    /// The clips in use. `None` if the frame is malformed: `clip_count` is too large, or a clip
    /// names a sphere that does not exist or has a number out of range.
    #[must_use]
    pub fn clips(&self) -> Option<&[ClipMsg]> {
        let clips = self.clips.get(..self.clip_count as usize)?;
        let sane = |clip: &ClipMsg| clip.is_sane(self.sphere_count.min(MAX_SPHERES as u32));
        clips.iter().all(sane).then_some(clips)
    }
}

// Both processes rely on these sizes. A change of one needs a new version.
const _: () = {
    assert!(size_of::<SphereState>() == 16);
    assert!(size_of::<ClipMsg>() == 32);
    assert!(size_of::<SutureMsg>() == 24);
    assert!(size_of::<StoneMsg>() == 40);
    let links_and_stones = MAX_TUBE_LINKS / 8 + 40 * MAX_STONES;
    let (spheres, clips, sutures) = (16 * MAX_SPHERES, 32 * MAX_CLIPPED, 24 * MAX_SUTURES);
    assert!(
        size_of::<StateFrame>() == 64 + spheres + clips + sutures + links_and_stones + MAX_CELLS
    );
};
