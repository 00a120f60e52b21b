//! Ports: the interfaces of the core to devices.
//!
//! `hardware` implements [`HapticDevice`], [`Tracker`] and [`Pedal`]. The realtime process joins
//! them, the clock and the publisher into one [`crate::sim::Ports`].

use heapless::String;

use crate::fault::FaultSet;
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

    /// True if every button of `other` is pressed.
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
    /// Opening of the handle, 0 shut to 1 wide open, when the device measures it. The jaws follow
    /// the opening; without a measured opening, they close by [`Buttons::GRASP`].
    pub opening: Option<f32>,
    /// Counter of the samples that the device has taken; it wraps around.
    pub sequence: u16,
    /// Time at which the sample's last byte was read.
    pub at_ns: TimeNs,
}

/// A sample with the device's own report about it. The simulation needs only the sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// The sample.
    pub sample: DeviceSample,
    /// Velocity that the device reported, m/s; `None` if it measures none.
    pub reported_m_s: Option<Vec3>,
    /// The device's clock, µs; wraps. `None` if it has none.
    pub device_time_us: Option<u32>,
    /// Bits of the device's status; `None` if it sends none.
    pub status: Option<u8>,
}

/// One sample of the endoscope's tracker, in the transmitter's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackerSample {
    /// Pose of the sensor in the transmitter's frame; translation in m.
    pub tracker_from_sensor: Pose,
    /// Time at which the sample's last byte was read.
    pub at_ns: TimeNs,
}

/// State of the foot pedal. A lost pedal reads as released.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PedalSample {
    /// True while the pedal of the cutting current is pressed.
    pub cut: bool,
    /// True while the pedal of the coagulating current is pressed.
    pub coagulate: bool,
    /// True while the pedal that locks the endoscope's camera in place is pressed.
    pub camera_lock: bool,
    /// Time at which the state was read.
    pub at_ns: TimeNs,
}

/// Force, torque and opening force to be rendered, in the device's own base frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ForceCommand {
    /// Force at the handle's tip, N.
    pub force_n: Vec3,
    /// Torque on the handle, N m; zero for a device that renders none.
    pub torque_nm: Vec3,
    /// Force that opens the handle, N, along its opening; zero for a device that renders none.
    pub opening_n: f32,
}

/// Capabilities of a handle that opens and shuts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Opening {
    /// Travel of the fingers from shut to wide open, m; 0 if the device does not measure its
    /// opening.
    pub travel_m: f32,
    /// Peak force along the opening, N; 0 if the device renders none.
    pub force_max_n: f32,
    /// Largest stiffness that the device renders stably along the opening, N/m.
    pub stiffness_max_n_m: f32,
}

impl Opening {
    /// A handle that does not open, or does not measure its opening.
    pub const NONE: Self = Self {
        travel_m: 0.0,
        force_max_n: 0.0,
        stiffness_max_n_m: 0.0,
    };

    /// True if the device measures its opening.
    #[must_use]
    pub fn is_measured(&self) -> bool {
        self.travel_m > 0.0
    }

    /// True if the device renders a force along its opening.
    #[must_use]
    pub fn is_rendered(&self) -> bool {
        self.is_measured() && self.force_max_n > 0.0 && self.stiffness_max_n_m > 0.0
    }
}

/// Capabilities of a haptic device. Constant while it is open.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DeviceCapabilities {
    /// Peak force, N (Touch: 3.3).
    pub force_max_n: f32,
    /// Force that can be rendered continuously, N (Touch: 0.88).
    pub force_continuous_n: f32,
    /// Peak torque, N m; 0 for a device that renders none and ignores torque.
    pub torque_max_nm: f32,
    /// Opening of the handle.
    pub opening: Opening,
    /// Largest stiffness that the device renders stably, N/m.
    pub stiffness_max_n_m: f32,
    /// Largest damping that the device renders, N s/m.
    pub damping_max_n_s_m: f32,
    /// Damping of the device itself, N s/m. It includes the viscous damping that equals the
    /// device's dry friction in a tremor. This damping absorbs the energy that sampling and delay
    /// generate.
    pub damping_n_s_m: f32,
    /// Delay from a movement to its sample plus delay from a command to its force, s. The time for
    /// which a force is held between two commands is not included.
    pub delay_s: f32,
    /// Radius of the workspace around the base frame's origin, m.
    pub workspace_radius_m: f32,
    /// Samples per second that the device sends.
    pub rate_hz: f32,
}

impl DeviceCapabilities {
    /// 3D Systems' Touch. Tests, and runs without a device, assume these figures. The forces are
    /// from the data sheet.
    pub const TOUCH: Self = Self {
        force_max_n: 3.3,
        force_continuous_n: 0.88,
        torque_max_nm: 0.0,
        opening: Opening::NONE,
        stiffness_max_n_m: 1000.0,
        damping_max_n_s_m: 5.0,
        damping_n_s_m: 1.8,
        delay_s: 0.001,
        workspace_radius_m: 0.2,
        rate_hz: 1000.0,
    };

    /// True if the device renders torque.
    #[must_use]
    pub fn renders_torque(&self) -> bool {
        self.torque_max_nm > 0.0
    }
}

/// Numbers of degrees of freedom of a handle that are measured and rendered, out of six (three
/// translations, three rotations). The remaining ones are ignored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Freedom {
    /// Degrees of freedom measured.
    pub measured: u8,
    /// Degrees of freedom rendered.
    pub rendered: u8,
}

/// Result of polling a device.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Polled<T> {
    /// The newest sample since the last poll.
    Fresh(T),
    /// No new sample has come; the caller judges staleness by the age of the last one.
    Nothing,
    /// The connection is lost (unplugged, hung up). The result is `Lost` until the driver
    /// reconnects.
    Lost,
}

/// Counters of a serial line, for reports. They never fall.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LineCounters {
    /// Good frames.
    pub frames: u64,
    /// Frames discarded because their length, checksum or range is wrong.
    pub bad_frames: u64,
    /// Samples missing in the sequence numbers.
    pub lost_frames: u64,
    /// Writes that the line did not accept.
    pub dropped_writes: u64,
    /// Bytes that this computer did not read in time and dropped; the device is not at fault.
    pub unread_bytes: u64,
}

impl LineCounters {
    /// Counters of two lines together.
    #[must_use]
    pub const fn plus(self, other: Self) -> Self {
        Self {
            frames: self.frames.wrapping_add(other.frames),
            bad_frames: self.bad_frames.wrapping_add(other.bad_frames),
            lost_frames: self.lost_frames.wrapping_add(other.lost_frames),
            dropped_writes: self.dropped_writes.wrapping_add(other.dropped_writes),
            unread_bytes: self.unread_bytes.wrapping_add(other.unread_bytes),
        }
    }
}

/// Name and number by which a person recognises a device.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Identity {
    /// Name that the device gives itself, in printable ASCII; empty if it gives none.
    pub name: String<NAME_BYTES>,
    /// Serial number; 0 if it has none.
    pub serial: u32,
}

/// Bytes of the longest name of a device.
const NAME_BYTES: usize = 32;

impl Identity {
    /// An identity with the printable ASCII of `name`, up to a zero. Other bytes become `?`.
    #[must_use]
    pub fn new(name: &[u8], serial: u32) -> Self {
        let mut identity = Self {
            serial,
            ..Self::default()
        };
        for &byte in name.iter().take_while(|&&byte| byte != 0) {
            let is_printable = (b' '..=b'~').contains(&byte);
            let letter = if is_printable { byte.into() } else { '?' };
            let _ = identity.name.push(letter); // a longer name is cut off
        }
        identity
    }
}

/// Faults of a device that only its driver can see, because it sees every sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Findings {
    /// Faults found by the last poll.
    pub faults: FaultSet,
    /// True if samples are missing before the sample of the last poll, so that the handle may have
    /// moved anywhere in between.
    pub leapt: bool,
    /// Time that a bundle of samples spans, ms; 0 if the samples come one by one.
    pub bundle_ms: u32,
    /// Rms length of the noise of the positions, µm; `None`: not measured.
    pub noise_um: Option<u32>,
}

/// A device's report about a force: the time from a motion of the hand to the force, by the
/// device's clock.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Echo {
    /// Arrival of the sample from which the force came, ns.
    pub sample_at_ns: TimeNs,
    /// Time from that sample to the first one with the force in effect, by the device's clock, µs.
    pub took_us: u32,
}

/// A haptic device. No call blocks or allocates.
pub trait HapticDevice {
    /// Capabilities of the device.
    fn capabilities(&self) -> DeviceCapabilities;
    /// Degrees of freedom measured and rendered; by default a pose and a force.
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
    /// Identity that the device gives itself; by default none.
    fn identity(&self) -> Identity {
        Identity::default()
    }
    /// The newest sample since the last poll.
    fn poll(&mut self, now_ns: TimeNs) -> Polled<DeviceSample>;
    /// Polls like [`Self::poll`], and passes every sample since the last poll to `each`, also
    /// samples that are too old for the simulation. The default passes only the newest sample.
    fn poll_each(
        &mut self,
        now_ns: TimeNs,
        each: &mut dyn FnMut(&Reading),
    ) -> Polled<DeviceSample> {
        let polled = self.poll(now_ns);
        if let Polled::Fresh(sample) = &polled {
            each(&Reading {
                sample: *sample,
                reported_m_s: self.reported_velocity_m_s(),
                device_time_us: None,
                status: None,
            });
        }
        polled
    }
    /// Time after which the device itself drops a force, ms, when no command comes. `None` if it
    /// never does, or if the driver does not know.
    fn watchdog_ms(&self) -> Option<u16> {
        None
    }
    /// Velocity that the device itself reported with its newest sample, m/s; `None` if it measures
    /// none. The simulation uses [`DeviceSample::velocity_m_s`] instead, which a driver may have
    /// corrected.
    fn reported_velocity_m_s(&self) -> Option<Vec3> {
        None
    }
    /// Faults that the last poll found; by default none.
    fn findings(&self) -> Findings {
        Findings::default()
    }
    /// Echo of a force that the last poll received; by default none, as for a device without a
    /// clock.
    fn echo(&self) -> Option<Echo> {
        None
    }
    /// Sends a force. If the line cannot take it now, the command is dropped and counted.
    fn send(&mut self, command: ForceCommand, now_ns: TimeNs);
    /// Counters of the line.
    fn counters(&self) -> LineCounters;
}

/// The endoscope's tracker. No call blocks or allocates.
pub trait Tracker {
    /// The newest sample since the last poll.
    fn poll(&mut self, now_ns: TimeNs) -> Polled<TrackerSample>;
    /// Counters of the line.
    fn counters(&self) -> LineCounters;
}

/// The foot pedal. No call blocks or allocates.
pub trait Pedal {
    /// The newest sample since the last poll.
    fn poll(&mut self, now_ns: TimeNs) -> Polled<PedalSample>;
    /// Counters of the line.
    fn counters(&self) -> LineCounters;
}
