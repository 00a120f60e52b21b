//! The station's devices behind the core's ports; one that is not configured is simply absent.

use std::path::Path;

use hardware::HardwareError;
use hardware::station::StationFile;
use rt_core::port::{
    DeviceCapabilities, ForceCommand, HapticDevice, LineCounters, Pedal, TimeNs, Tracker,
};
use shared_mem::message::DeviceHealth;

use crate::config::RtConfig;
use crate::error::RtError;

/// What the core is told when there is no haptic device: nothing is rendered anyway.
pub(crate) const NO_DEVICE: DeviceCapabilities = DeviceCapabilities {
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

/// Open devices.
#[derive(Default)]
pub(crate) struct Devices {
    pub(crate) haptic: Option<Box<dyn HapticDevice + Send>>,
    pub(crate) tracker: Option<Box<dyn Tracker + Send>>,
    pub(crate) pedal: Option<Box<dyn Pedal + Send>>,
}

impl Devices {
    /// Opens what is configured, by path or by the station file. Waits for each device's answer.
    pub(crate) fn open(config: &RtConfig, file: &StationFile) -> Result<Self, RtError> {
        let mut devices = Self::default();
        if let Some(path) = &config.haptic {
            let haptic = named("haptic device", path, hardware::rig::RigHaptic::open)?;
            devices.haptic = Some(Box::new(haptic));
        } else if let Some(spec) = &file.haptic {
            devices.haptic = Some(named("haptic device", &spec.path, |_| spec.open())?);
        }
        if let Some(path) = &config.tracker {
            let tracker = named("tracker", path, hardware::bird::BirdTracker::open)?;
            devices.tracker = Some(Box::new(tracker));
        } else if let Some(spec) = &file.tracker {
            let tracker = named("tracker", &spec.path, |_| spec.open())?;
            devices.tracker = Some(Box::new(tracker));
        }
        if let Some(path) = &config.pedal {
            let pedal = named("pedal", path, hardware::rig::RigPedal::open)?;
            devices.pedal = Some(Box::new(pedal));
        } else if let Some(spec) = &file.pedal {
            devices.pedal = Some(named("pedal", &spec.path, |_| spec.open())?);
        }
        Ok(devices)
    }

    /// What the haptic device can do.
    pub(crate) fn capabilities(&self) -> DeviceCapabilities {
        self.haptic
            .as_ref()
            .map_or(NO_DEVICE, |haptic| haptic.capabilities())
    }

    /// Zero force: the safe state. Repeated, for a line may drop one.
    pub(crate) fn make_safe(&mut self, now_ns: TimeNs) {
        if let Some(haptic) = &mut self.haptic {
            for _ in 0..3 {
                haptic.send(ForceCommand::default(), now_ns);
            }
        }
    }

    /// Counters of haptic device, tracker and pedal; none for an absent one.
    pub(crate) fn counters(&self) -> [Option<LineCounters>; 3] {
        [
            self.haptic.as_ref().map(|device| device.counters()),
            self.tracker.as_ref().map(|device| device.counters()),
            self.pedal.as_ref().map(|device| device.counters()),
        ]
    }
}

fn named<T>(
    device: &'static str,
    path: &Path,
    open: impl FnOnce(&Path) -> Result<T, HardwareError>,
) -> Result<T, RtError> {
    open(path).map_err(|source| RtError::Device { device, source })
}

/// A device's health as frames carry it.
pub(crate) fn health(health: rt_core::sim::Health, line: Option<LineCounters>) -> DeviceHealth {
    let line_or_zero = line.unwrap_or_default();
    DeviceHealth {
        status: match (line, health.status) {
            (None, _) => DeviceHealth::ABSENT,
            // Open, but nothing came from it yet.
            (Some(_), rt_core::sim::Status::Absent | rt_core::sim::Status::Stale) => {
                DeviceHealth::STALE
            }
            (Some(_), rt_core::sim::Status::Live) => DeviceHealth::LIVE,
            (Some(_), rt_core::sim::Status::Lost) => DeviceHealth::LOST,
        },
        age_us: u32::try_from(health.age_ns / 1000).unwrap_or(u32::MAX),
        frames: line_or_zero.frames,
        bad_frames: line_or_zero.bad_frames,
        lost_frames: line_or_zero.lost_frames,
    }
}
