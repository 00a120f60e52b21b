//! Service `events`.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

/// Service `events`: sequence-numbered; a gap in `sequence` is a loss that the reader must show.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[type_name("calot.EventMsg.v1")]
pub struct EventMsg {
    /// Counts up by one an event, from 0 at the controller's start.
    pub sequence: u64,
    /// Tick that raised it.
    pub tick: u64,
    /// When.
    pub at_ns: u64,
    /// One of the `EventMsg` constants.
    pub kind: u32,
    /// Organ's index in the scene, or `u32::MAX`.
    pub organ: u32,
    /// Where, world frame, m.
    pub at_m: [f32; 3],
    /// Depends on the kind: force in N, fault code, button.
    pub value: f32,
}

impl EventMsg {
    /// An instrument began to touch an organ; value: force, N.
    pub const CONTACT: u32 = 1;
    /// It left it.
    pub const RELEASE: u32 = 2;
    /// Jaws closed on tissue; value: spheres held.
    pub const GRASP: u32 = 3;
    /// Jaws let go.
    pub const LET_GO: u32 = 4;
    /// A fault was raised; value: its code (`rt_core::fault::Fault`).
    pub const FAULT: u32 = 5;
    /// Electrosurgery on (value 1 cut, 2 coagulate) or off (0).
    pub const ELECTRO: u32 = 6;
    /// What the jaws hold has slipped; value: what it pulls with, N.
    pub const SLIP: u32 = 7;
    /// A band between organs, or a link of a tube, has torn; value: the energy it took, J.
    pub const TEAR: u32 = 8;
    /// Scissors or current have cut a band, a suture, or a link of a tube; value: the energy of a tear of it, J.
    pub const CUT: u32 = 9;

    /// A clip has closed, on this organ or, if none is named, on nothing; value: the clip's number,
    /// from 0. One that closes on two organs raises two.
    pub const CLIP: u32 = 10;
    /// An electrode has burnt an organ; value: the energy since that was last told, J.
    pub const BURN: u32 = 11;
    /// A vessel, duct or bag leaks; value: its flow as a share of what runs in it whole, 0: stopped. Every
    /// event of one leak has the place where it began.
    pub const LEAK: u32 = 12;
    /// A cell of layered tissue is gone; value: its index in the scene.
    pub const REMOVED: u32 = 13;
    /// Jaws have crushed what they hold; value: their force, N.
    pub const CRUSH: u32 = 14;
    /// A wall is burnt through or torn open; value: the energy it took, J.
    pub const PERFORATION: u32 = 15;
    /// A tube is divided, or off what it was grown to; value: share of its inside that clips leave open on
    /// the worse of both sides, up to where it ends or is divided already. 0: between clips that close it.
    pub const DIVIDED: u32 = 16;
    /// Everything is as it was at the start, or as a task begins; what was told before is void.
    pub const RESET: u32 = 17;
    /// A suture goes through an organ, there; value: the suture's number in the scene, from 0.
    pub const STITCH: u32 = 18;
    /// A suture hangs an organ on the abdominal wall, there; value: the suture's number in the scene, from 0.
    pub const HUNG: u32 = 19;

    /// Its kind's name, for reports.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self.kind {
            Self::CONTACT => "contact",
            Self::RELEASE => "release",
            Self::GRASP => "grasp",
            Self::LET_GO => "let_go",
            Self::FAULT => "fault",
            Self::ELECTRO => "electro",
            Self::SLIP => "slip",
            Self::TEAR => "tear",
            Self::CUT => "cut",
            Self::CLIP => "clip",
            Self::BURN => "burn",
            Self::LEAK => "leak",
            Self::REMOVED => "removed",
            Self::CRUSH => "crush",
            Self::PERFORATION => "perforation",
            Self::DIVIDED => "divided",
            Self::RESET => "reset",
            Self::STITCH => "stitch",
            Self::HUNG => "hung",
            _ => "unknown",
        }
    }
}

// The layout is the contract: a change of size is a change of version.
const _: () = {
    assert!(size_of::<EventMsg>() == 48);
};
