//! Service `tools`.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use super::PoseMsg;
use crate::limits::{MAX_CAPSULES, MAX_DENTS};
use crate::words::{CapsuleRole, Instrument, Switches, Unknown};

/// Health of one device as the controller sees it.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, ZeroCopySend)]
pub struct DeviceHealth {
    /// One of [`DeviceHealth::ABSENT`], `LIVE`, `STALE`, `LOST`.
    pub status: u32,
    /// Age of the newest sample, µs, saturating; 0 if there is none yet.
    pub age_us: u32,
    /// Frames received without an error.
    pub frames: u64,
    /// Frames rejected because of an error.
    pub bad_frames: u64,
    /// Lost frames, counted from gaps in the sequence numbers.
    pub lost_frames: u64,
    /// Commands that the device's line did not accept.
    pub dropped_writes: u64,
    /// Bytes lost because this computer did not read them in time.
    pub unread_bytes: u64,
}

impl DeviceHealth {
    /// No such device is configured.
    pub const ABSENT: u32 = 0;
    /// Samples arrive in time.
    pub const LIVE: u32 = 1;
    /// The newest sample is older than its limit, or none has come yet.
    pub const STALE: u32 = 2;
    /// The connection to the device is gone.
    pub const LOST: u32 = 3;
}

/// A capsule of an instrument, world frame.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
pub struct CapsuleMsg {
    /// One end of the axis, m.
    pub a_m: [f32; 3],
    /// Radius, m.
    pub radius_m: f32,
    /// Other end of the axis, m.
    pub b_m: [f32; 3],
    /// Number of a [`CapsuleRole`].
    pub role: u32,
}

/// The part of a tool's dent in an organ that the spheres are too coarse to show. The skin that
/// follows the spheres still reaches into a piece of the tool by `depth_m`. A piece is a section of
/// a capsule, or the capsule's round end.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
pub struct DentMsg {
    /// Middle of the piece's axis, world frame, m.
    pub center_m: [f32; 3],
    /// Radius of the piece, m.
    pub radius_m: f32,
    /// Half of the piece's axis, m; zero for a round end.
    pub half_m: [f32; 3],
    /// Depth of the tool below the skin that follows the spheres, along the normal, m.
    pub depth_m: f32,
    /// Unit vector from tissue to tool.
    pub normal: [f32; 3],
    /// Index of the organ.
    pub organ: u32,
}

/// Service `tools`: the state of the tools. A reader gets only the newest frame.
#[repr(C)]
#[derive(Debug, Clone, Copy, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.ToolFrame.v4")]
pub struct ToolFrame {
    /// Tick that wrote the frame.
    pub tick: u64,
    /// Time at which the newest sample of the haptic device was read (`CLOCK_MONOTONIC`); 0 before
    /// the first.
    pub sample_ns: u64,
    /// Time at which the frame was filled (`CLOCK_MONOTONIC`).
    pub at_ns: u64,
    /// First 16 bytes of the compiled scene's identity.
    pub scene_id: [u8; 16],
    /// Device pose: the handle as the hand holds it, world frame.
    pub world_from_handle: PoseMsg,
    /// Proxy pose of the instrument, world frame: origin at the jaw joint, −z along the shaft
    /// towards the tip. If the device is too weak to stop the hand at the tissue, the instrument
    /// stays behind the hand.
    pub world_from_instrument: PoseMsg,
    /// Pose of the endoscope's camera, world frame. The camera looks along −z, and y is up in the
    /// picture.
    pub world_from_camera: PoseMsg,
    /// Opening of the jaws: 0 closed, 1 open.
    pub jaw: f32,
    /// Number of an [`Instrument`].
    pub instrument: u32,
    /// Force on the hand, world frame, N, as sent to the device.
    pub force_n: [f32; 3],
    /// Number of the instrument's contacts with tissue or with the endoscope.
    pub contact_count: u32,
    /// Bits of [`Switches`].
    pub switches: u32,
    /// Pressed buttons of the device, one bit each.
    pub buttons: u32,
    /// Number of `capsules` in use.
    pub capsule_count: u32,
    /// Clips left in the applier.
    pub clips_left: u32,
    /// Number of `dents` in use.
    pub dent_count: u32,
    /// Capsules of the instrument, world frame.
    pub capsules: [CapsuleMsg; MAX_CAPSULES],
    /// Dents of instrument and endoscope in tissue.
    pub dents: [DentMsg; MAX_DENTS],
    /// Health of the haptic device, the tracker and the pedal, in this order.
    pub health: [DeviceHealth; 3],
}

impl CapsuleMsg {
    /// Part of a tool that the capsule represents.
    ///
    /// # Errors
    ///
    /// [`Unknown`] if the number has no name.
    pub fn role(&self) -> Result<CapsuleRole, Unknown> {
        self.role.try_into()
    }

    /// True if the capsule represents this part of a tool.
    #[must_use]
    pub const fn is(&self, role: CapsuleRole) -> bool {
        self.role == role.number()
    }
}

impl ToolFrame {
    /// The instrument in the hand.
    ///
    /// # Errors
    ///
    /// [`Unknown`] if the number has no name.
    pub fn instrument(&self) -> Result<Instrument, Unknown> {
        self.instrument.try_into()
    }

    /// True if this instrument is in the hand.
    #[must_use]
    pub const fn has(&self, instrument: Instrument) -> bool {
        self.instrument == instrument.number()
    }

    /// The switches that are on. Bits without a name are dropped.
    #[must_use]
    pub const fn switches(&self) -> Switches {
        Switches::named(self.switches)
    }

    /// The capsules in use. `None` if the frame is malformed: `capsule_count` is too large, or a
    /// number of its poses, capsules, force or jaw is out of range.
    #[must_use]
    pub fn capsules(&self) -> Option<&[CapsuleMsg]> {
        let poses = [
            self.world_from_handle,
            self.world_from_instrument,
            self.world_from_camera,
        ];
        let sane = |x: &f32| x.abs() < 1e3;
        let poses_ok = poses.iter().all(PoseMsg::is_sane);
        let capsules = self.capsules.get(..self.capsule_count as usize)?;
        let capsules_ok = capsules
            .iter()
            .all(|c| c.a_m.iter().chain(&c.b_m).chain([&c.radius_m]).all(sane));
        let force_ok = self.force_n.iter().all(sane) && self.jaw.is_finite();
        (poses_ok && capsules_ok && force_ok).then_some(capsules)
    }

    /// The dents in use. `None` if the frame is malformed: `dent_count` is too large, or a number
    /// of a dent is out of range.
    #[must_use]
    pub fn dents(&self) -> Option<&[DentMsg]> {
        let dents = self.dents.get(..self.dent_count as usize)?;
        let sane = |x: &f32| x.abs() < 1e3;
        let is_sane = |dent: &DentMsg| {
            let vectors = [dent.center_m, dent.half_m, dent.normal];
            let sizes = [dent.radius_m, dent.depth_m];
            vectors.as_flattened().iter().chain(&sizes).all(sane)
        };
        dents.iter().all(is_sane).then_some(dents)
    }
}

// Both processes rely on these sizes. A change of one needs a new version.
const _: () = {
    assert!(size_of::<CapsuleMsg>() == 32);
    assert!(size_of::<DentMsg>() == 48);
    assert!(size_of::<DeviceHealth>() == 48);
    assert!(size_of::<ToolFrame>() == 168 + 32 * MAX_CAPSULES + 48 * MAX_DENTS + 3 * 48);
};
