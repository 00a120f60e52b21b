//! The ports: what the core asks of the world, and what it gives back.
//!
//! `hardware` adapts devices to [`HapticDevice`], [`Tracker`] and [`Pedal`]; the realtime process
//! joins them, the clock and the publisher into one [`crate::sim::Ports`].

use crate::math::{Pose, Vec3};
use crate::time::TimeNs;

/// Buttons of a haptic handle, one bit each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Buttons(pub u8);

impl Buttons {
    /// First stylus button: closes the grasper's jaws.
    pub const GRASP: Self = Self(1);
    /// Second stylus button: changes the instrument.
    pub const CHANGE: Self = Self(2);

    /// Whether every bit of `other` is pressed.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

/// One sample of a haptic device, in the device's own base frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviceSample {
    /// Pose of the handle in the device's base frame; translation in m.
    pub device_from_handle: Pose,
    /// Velocity of the handle's tip in the base frame, m/s, when the device measures it.
    pub velocity_m_s: Option<Vec3>,
    /// Buttons pressed.
    pub buttons: Buttons,
    /// Counts up by one per sample that the device took; wraps.
    pub sequence: u16,
    /// When the sample's last byte was read.
    pub at_ns: TimeNs,
}

/// One sample of the endoscope's tracker, in the transmitter's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackerSample {
    /// Pose of the sensor in the transmitter's frame; translation in m.
    pub tracker_from_sensor: Pose,
    /// When the sample's last byte was read.
    pub at_ns: TimeNs,
}

/// State of the foot pedal. A lost pedal reads as released.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PedalSample {
    /// Electrosurgery: cut.
    pub cut: bool,
    /// Electrosurgery: coagulate.
    pub coagulate: bool,
    /// Holds the endoscope's camera where it is.
    pub camera_lock: bool,
    /// When it was read.
    pub at_ns: TimeNs,
}

/// What the device is asked to render, in the device's own base frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ForceCommand {
    /// Force at the handle's tip, N.
    pub force_n: Vec3,
    /// Torque on the handle, N m; zero for a device that renders none.
    pub torque_n_m: Vec3,
}

/// What a haptic device can do. Constant once it is open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviceCapabilities {
    /// Peak force, N (Touch: 3.3).
    pub force_max_n: f32,
    /// Force that can be held for ever, N (Touch: 0.88).
    pub force_continuous_n: f32,
    /// Peak torque, N m; 0 for a device that renders none and drops what it is sent.
    pub torque_max_n_m: f32,
    /// Largest stiffness that the device renders stably, N/m.
    pub stiffness_max_n_m: f32,
    /// Largest damping that it renders, N s/m.
    pub damping_max_n_s_m: f32,
    /// Damping of the device itself, with what its dry friction takes from a tremor, N s/m: what
    /// bears the energy that sampling and delay make.
    pub damping_n_s_m: f32,
    /// From a movement to its sample and from a command to its force, together, s; without the
    /// time that the force is held.
    pub delay_s: f32,
    /// Radius of the workspace around the base frame's origin, m.
    pub workspace_radius_m: f32,
    /// Samples per second that the device sends.
    pub rate_hz: f32,
}

impl DeviceCapabilities {
    /// 3D Systems' Touch, as tests and runs without a device assume it. The forces are its
    /// data sheet's.
    pub const TOUCH: Self = Self {
        force_max_n: 3.3,
        force_continuous_n: 0.88,
        torque_max_n_m: 0.0,
        stiffness_max_n_m: 1000.0,
        damping_max_n_s_m: 5.0,
        damping_n_s_m: 1.8,
        delay_s: 0.001,
        workspace_radius_m: 0.2,
        rate_hz: 1000.0,
    };

    /// Whether torque reaches the hand.
    #[must_use]
    pub fn renders_torque(&self) -> bool {
        self.torque_max_n_m > 0.0
    }
}

/// In how many of its six directions (three to move along, three to turn about) a handle is
/// measured, and in how many force or torque is rendered. What is not rendered is dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Freedom {
    /// Directions measured.
    pub measured: u8,
    /// Directions rendered.
    pub rendered: u8,
}

/// What a poll of a device brought.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Polled<T> {
    /// The newest sample since the last poll.
    Fresh(T),
    /// Nothing new; the caller judges staleness by the last sample's age.
    Nothing,
    /// The line is gone (unplugged, hung up). Stays so until the driver reconnects.
    Lost,
}

/// Counters of a serial line, for the reports. All only grow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LineCounters {
    /// Good frames.
    pub frames: u64,
    /// Frames thrown away: length, checksum, range.
    pub bad_frames: u64,
    /// Samples that the sequence number says were lost.
    pub lost_frames: u64,
    /// Writes that the line did not take.
    pub dropped_writes: u64,
}

/// A haptic device. Neither call blocks or allocates.
pub trait HapticDevice {
    /// What it can do.
    fn capabilities(&self) -> DeviceCapabilities;
    /// In how many directions it measures and renders; a pose and a force, unless it says otherwise.
    fn freedom(&self) -> Freedom {
        Freedom {
            measured: 6,
            rendered: if self.capabilities().renders_torque() {
                6
            } else {
                3
            },
        }
    }
    /// The newest sample since the last poll.
    fn poll(&mut self, now_ns: TimeNs) -> Polled<DeviceSample>;
    /// Sends a force. A line that cannot take it now drops it and counts.
    fn send(&mut self, command: ForceCommand, now_ns: TimeNs);
    /// What the line has seen.
    fn counters(&self) -> LineCounters;
}

/// The endoscope's tracker. Does not block or allocate.
pub trait Tracker {
    /// The newest sample since the last poll.
    fn poll(&mut self, now_ns: TimeNs) -> Polled<TrackerSample>;
    /// What the line has seen.
    fn counters(&self) -> LineCounters;
}

/// The foot pedal. Does not block or allocate.
pub trait Pedal {
    /// The newest sample since the last poll.
    fn poll(&mut self, now_ns: TimeNs) -> Polled<PedalSample>;
    /// What the line has seen.
    fn counters(&self) -> LineCounters;
}
