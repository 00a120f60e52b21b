//! Opening the devices of a station file with their drivers.

use rt_core::math::Vec3;
use rt_core::port::{
    DeviceCapabilities, DeviceSample, Echo, Findings, ForceCommand, Freedom, HapticDevice,
    Identity, LineCounters, Opening, Pedal, Polled, Reading,
};
use rt_core::time::TimeNs;

use super::scaled::Scaled;
use super::{HapticDriver, HapticSpec, Limits, PedalDriver, PedalSpec, TrackerDriver, TrackerSpec};
use crate::HardwareError;
use crate::bird::BirdTracker;
use crate::dhd::DhdHaptic;
use crate::hapi::HapiHaptic;
use crate::inverse3::Inverse3Haptic;
use crate::pedal::{EvdevPedal, JoinedPedals, ModemPedal};
use crate::rig::{RigHaptic, RigPedal};
use crate::touch::TouchHaptic;
use crate::woody::WoodyHaptic;

impl HapticSpec {
    /// Refuses a device that must be tested by hand before it may render a force. This applies to a
    /// WoodenHaptics device, because the maker's present software contradicts this driver: there
    /// the encoder and the motor of the first axis have the same sign, here they have opposite
    /// signs.
    pub fn check_felt(&self) -> Result<(), HardwareError> {
        if self.driver == HapticDriver::Woody && !self.is_felt {
            return Err(HardwareError::Unfelt {
                path: self.path.clone(),
            });
        }
        Ok(())
    }

    /// Opens the device with the station's limits and motion scale. May wait, so the tick must not
    /// call it.
    pub fn open(&self) -> Result<Box<dyn HapticDevice + Send>, HardwareError> {
        self.open_again(false)
    }

    /// Opens the device after a loss, when nobody holds the handle at home. A device whose handle
    /// must be at home during the opening is refused, without force.
    pub fn reopen(&self) -> Result<Box<dyn HapticDevice + Send>, HardwareError> {
        self.open_again(true)
    }

    fn open_again(&self, again: bool) -> Result<Box<dyn HapticDevice + Send>, HardwareError> {
        let path = &self.path;
        let device: Box<dyn HapticDevice + Send> = match &self.driver {
            HapticDriver::Rig => Box::new(RigHaptic::open(path)?),
            HapticDriver::Woody => Box::new(WoodyHaptic::open(path)?),
            HapticDriver::Hapi(generation) if again => {
                Box::new(HapiHaptic::reopen(path, *generation)?)
            }
            HapticDriver::Hapi(generation) => Box::new(HapiHaptic::open(path, *generation)?),
            HapticDriver::Inverse3 { device } => {
                Box::new(Inverse3Haptic::open(path, device.as_deref())?)
            }
            HapticDriver::Touch { device } => Box::new(TouchHaptic::open(path, device.as_deref())?),
            HapticDriver::ForceDimension { serial } => Box::new(DhdHaptic::open(path, *serial)?),
        };
        let device: Box<dyn HapticDevice + Send> = Box::new(Limited {
            device,
            limits: self.limits,
        });
        Ok(match self.motion_scale {
            None => device,
            Some(scale) => Box::new(Scaled { device, scale }),
        })
    }
}

impl TrackerSpec {
    /// Opens the tracker. May wait, so the tick must not call it.
    pub fn open(&self) -> Result<BirdTracker, HardwareError> {
        match self.driver {
            TrackerDriver::Bird => BirdTracker::open(&self.path, self.setup),
            TrackerDriver::Trakstar => BirdTracker::open_usb(&self.path, self.setup),
        }
    }
}

impl PedalSpec {
    /// Opens the pedal, and the second one if there is one. May wait, so the tick must not call it.
    pub fn open(&self) -> Result<Box<dyn Pedal + Send>, HardwareError> {
        let first = self.open_alone()?;
        Ok(match &self.second {
            Some(second) => Box::new(JoinedPedals::new([first, second.open_alone()?])),
            None => first,
        })
    }

    fn open_alone(&self) -> Result<Box<dyn Pedal + Send>, HardwareError> {
        let path = &self.path;
        Ok(match self.driver {
            PedalDriver::Rig => Box::new(RigPedal::open(path)?),
            PedalDriver::Evdev(roles) => Box::new(EvdevPedal::open(path, roles)?),
            PedalDriver::Modem => Box::new(ModemPedal::open(path)?),
        })
    }
}

/// A haptic device with lower limits than its own, and measured values instead of declared ones.
struct Limited {
    device: Box<dyn HapticDevice + Send>,
    limits: Limits,
}

impl HapticDevice for Limited {
    fn capabilities(&self) -> DeviceCapabilities {
        let own = self.device.capabilities();
        let least = |own: f32, limit: Option<f32>| limit.map_or(own, |limit| own.min(limit));
        let force_max_n = least(own.force_max_n, self.limits.force_max_n);
        DeviceCapabilities {
            force_max_n,
            force_continuous_n: least(own.force_continuous_n, self.limits.force_continuous_n)
                .min(force_max_n),
            stiffness_max_n_m: least(own.stiffness_max_n_m, self.limits.stiffness_max_n_m),
            opening: Opening {
                force_max_n: least(own.opening.force_max_n, self.limits.force_max_n),
                ..own.opening
            },
            damping_n_s_m: self.limits.damping_n_s_m.unwrap_or(own.damping_n_s_m),
            delay_s: self.limits.delay_s.unwrap_or(own.delay_s),
            ..own
        }
    }

    fn freedom(&self) -> Freedom {
        self.device.freedom()
    }

    fn poll(&mut self, now_ns: TimeNs) -> Polled<DeviceSample> {
        self.device.poll(now_ns)
    }

    fn poll_each(
        &mut self,
        now_ns: TimeNs,
        each: &mut dyn FnMut(&Reading),
    ) -> Polled<DeviceSample> {
        self.device.poll_each(now_ns, each)
    }

    fn watchdog_ms(&self) -> Option<u16> {
        self.device.watchdog_ms()
    }

    /// Shortens a force above the station's limit, even if the caller should have done so.
    fn send(&mut self, mut command: ForceCommand, now_ns: TimeNs) {
        if let Some(limit) = self.limits.force_max_n {
            let norm = command.force_n.norm();
            if norm > limit {
                command.force_n *= limit / norm;
            }
            command.opening_n = command.opening_n.max(-limit).min(limit);
        }
        self.device.send(command, now_ns);
    }

    fn reported_velocity_m_s(&self) -> Option<Vec3> {
        self.device.reported_velocity_m_s()
    }

    fn identity(&self) -> Identity {
        self.device.identity()
    }

    fn findings(&self) -> Findings {
        self.device.findings()
    }

    fn echo(&self) -> Option<Echo> {
        self.device.echo()
    }

    fn counters(&self) -> LineCounters {
        self.device.counters()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};

    /// A device with a strong handle that remembers its last command.
    struct StrongDevice(Arc<Mutex<ForceCommand>>);

    impl HapticDevice for StrongDevice {
        fn capabilities(&self) -> DeviceCapabilities {
            DeviceCapabilities {
                opening: Opening {
                    travel_m: 0.03,
                    force_max_n: 5.0,
                    stiffness_max_n_m: 1000.0,
                },
                ..DeviceCapabilities::TOUCH
            }
        }
        fn poll(&mut self, _: TimeNs) -> Polled<DeviceSample> {
            Polled::Nothing
        }
        fn send(&mut self, command: ForceCommand, _: TimeNs) {
            *self.0.lock().unwrap() = command;
        }
        fn counters(&self) -> LineCounters {
            LineCounters::default()
        }
    }

    #[test]
    fn the_stations_force_limit_holds_for_the_opening_too() {
        let sent = Arc::new(Mutex::new(ForceCommand::default()));
        let mut device = Limited {
            device: Box::new(StrongDevice(Arc::clone(&sent))),
            limits: Limits {
                force_max_n: Some(1.0),
                ..Limits::default()
            },
        };
        assert!((device.capabilities().opening.force_max_n - 1.0).abs() < 1e-6);
        for (asked, rendered) in [(9.0, 1.0), (-9.0, -1.0), (0.5, 0.5)] {
            let command = ForceCommand {
                opening_n: asked,
                ..ForceCommand::default()
            };
            device.send(command, 1);
            let opening_n = sent.lock().unwrap().opening_n;
            assert!((opening_n - rendered).abs() < 1e-6, "{opening_n}");
        }
    }
}
