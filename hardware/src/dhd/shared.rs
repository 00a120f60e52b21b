//! State that the device's thread and the tick share. Neither waits for the other.

use std::sync::atomic::{AtomicBool, AtomicU32};

use rt_core::math::{Quat, Vec3};
use rt_core::port::Buttons;
use rt_core::time::TimeNs;

use crate::line::now_ns;
use crate::slot::Slot;
use crate::vendor::FORCE_AGE_NS;

/// State shared by the thread and the tick.
#[derive(Debug)]
pub(super) struct Shared {
    pub(super) running: AtomicBool,
    pub(super) is_lost: AtomicBool,
    /// True while the device itself keeps its motors without force.
    pub(super) is_forceless: AtomicBool,
    /// Number of failed reads and impossible poses.
    pub(super) bad_samples: AtomicU32,
    /// Number of samples held back as implausible jumps.
    pub(super) leaps: AtomicU32,
    /// Number of forces that the library refused.
    pub(super) refusals: AtomicU32,
    /// A [`Sample`].
    sample: Slot<16>,
    /// A [`Command`].
    command: Slot<9>,
}

/// One sample, in our axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub(super) position_m: Vec3,
    pub(super) rotation: Quat,
    /// Velocity; not finite when the library reports none.
    pub(super) velocity_m_s: Vec3,
    /// Opening of the gripper; not finite without one.
    pub(super) opening: f32,
    pub(super) buttons: Buttons,
    pub(super) count: u32,
    pub(super) at_ns: TimeNs,
    /// Number of jumps so far that were admitted in the end.
    pub(super) jumps: u32,
}

/// Force, torque and the gripper's opening force that the tick commands, in our axes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Command {
    pub(super) force_n: Vec3,
    pub(super) torque_nm: Vec3,
    pub(super) opening_n: f32,
    pub(super) at_ns: TimeNs,
}

/// No force at all.
pub(super) const ZERO_COMMAND: Command = Command {
    force_n: Vec3::new(0.0, 0.0, 0.0),
    torque_nm: Vec3::new(0.0, 0.0, 0.0),
    opening_n: 0.0,
    at_ns: 0,
};

impl Shared {
    pub(super) fn new() -> Self {
        Self {
            running: AtomicBool::new(true),
            is_lost: AtomicBool::new(false),
            is_forceless: AtomicBool::new(false),
            bad_samples: AtomicU32::new(0),
            leaps: AtomicU32::new(0),
            refusals: AtomicU32::new(0),
            sample: Slot::new(),
            command: Slot::new(),
        }
    }

    /// Newest sample and its sequence count.
    pub(super) fn sample(&self) -> Option<(u32, Sample)> {
        let (version, words) = self.sample.read()?;
        let [x, y, z, i, j, k, w, vx, vy, vz, opening, ..] = words.map(f32::from_bits);
        let [.., buttons, count, low, high, jumps] = words;
        let sample = Sample {
            position_m: Vec3::new(x, y, z),
            rotation: Quat::new_unchecked(nalgebra::Quaternion::new(w, i, j, k)),
            velocity_m_s: Vec3::new(vx, vy, vz),
            opening,
            buttons: Buttons(buttons as u8),
            count,
            at_ns: time(low, high),
            jumps,
        };
        Some((version, sample))
    }

    /// Passes a sample to the tick.
    pub(super) fn publish(&self, sample: &Sample) {
        let [x, y, z] = bits(&sample.position_m);
        let q = sample.rotation;
        let [i, j, k, w] = [q.i, q.j, q.k, q.w].map(f32::to_bits);
        let [vx, vy, vz] = bits(&sample.velocity_m_s);
        let [low, high] = halves(sample.at_ns);
        self.sample.write([
            x,
            y,
            z,
            i,
            j,
            k,
            w,
            vx,
            vy,
            vz,
            sample.opening.to_bits(),
            sample.buttons.0.into(),
            sample.count,
            low,
            high,
            sample.jumps,
        ]);
    }

    /// Passes a command to the thread.
    pub(super) fn send_command(&self, command: &Command) {
        let [x, y, z] = bits(&command.force_n);
        let [tx, ty, tz] = bits(&command.torque_nm);
        let [low, high] = halves(command.at_ns);
        self.command
            .write([x, y, z, tx, ty, tz, command.opening_n.to_bits(), low, high]);
    }

    /// Newest command; no force if that command is older than [`FORCE_AGE_NS`].
    pub(super) fn command(&self) -> Command {
        let Some((_, words)) = self.command.read() else {
            return ZERO_COMMAND;
        };
        let [x, y, z, tx, ty, tz, opening_n, ..] = words.map(f32::from_bits);
        let [.., low, high] = words;
        let at_ns = time(low, high);
        if now_ns().saturating_sub(at_ns) > FORCE_AGE_NS {
            return ZERO_COMMAND;
        }
        Command {
            force_n: Vec3::new(x, y, z),
            torque_nm: Vec3::new(tx, ty, tz),
            opening_n,
            at_ns,
        }
    }
}

fn bits(vector: &Vec3) -> [u32; 3] {
    <[f32; 3]>::from(*vector).map(f32::to_bits)
}

const fn halves(at_ns: TimeNs) -> [u32; 2] {
    [at_ns as u32, (at_ns >> 32) as u32]
}

const fn time(low: u32, high: u32) -> TimeNs {
    low as u64 | (high as u64) << 32
}
