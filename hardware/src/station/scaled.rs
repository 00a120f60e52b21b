//! A haptic device whose movements are scaled in the simulation.

use rt_core::math::Vec3;
use rt_core::port::{
    DeviceCapabilities, DeviceSample, Echo, Findings, ForceCommand, Freedom, HapticDevice,
    Identity, LineCounters, Polled, Reading,
};
use rt_core::time::TimeNs;

/// A device whose movement is multiplied by `scale` for the simulation. By virtual work, the
/// simulation's force is multiplied by `scale` at the hand. So the capabilities that the simulation
/// sees have the force divided by `scale`, and stiffness and damping divided by its square. A
/// passive system stays passive.
pub(super) struct Scaled {
    pub(super) device: Box<dyn HapticDevice + Send>,
    pub(super) scale: f32,
}

impl HapticDevice for Scaled {
    fn capabilities(&self) -> DeviceCapabilities {
        let own = self.device.capabilities();
        let scale2 = self.scale * self.scale;
        DeviceCapabilities {
            force_max_n: own.force_max_n / self.scale,
            force_continuous_n: own.force_continuous_n / self.scale,
            stiffness_max_n_m: own.stiffness_max_n_m / scale2,
            damping_max_n_s_m: own.damping_max_n_s_m / scale2,
            damping_n_s_m: own.damping_n_s_m / scale2,
            workspace_radius_m: own.workspace_radius_m * self.scale,
            ..own
        }
    }

    fn freedom(&self) -> Freedom {
        self.device.freedom()
    }

    fn poll(&mut self, now_ns: TimeNs) -> Polled<DeviceSample> {
        match self.device.poll(now_ns) {
            Polled::Fresh(sample) => Polled::Fresh(scaled(sample, self.scale)),
            other => other,
        }
    }

    fn poll_each(
        &mut self,
        now_ns: TimeNs,
        each: &mut dyn FnMut(&Reading),
    ) -> Polled<DeviceSample> {
        let scale = self.scale;
        let polled = self.device.poll_each(now_ns, &mut |own| {
            each(&Reading {
                sample: scaled(own.sample, scale),
                reported_m_s: own.reported_m_s.map(|velocity| velocity * scale),
                ..*own
            });
        });
        match polled {
            Polled::Fresh(sample) => Polled::Fresh(scaled(sample, scale)),
            other => other,
        }
    }

    fn watchdog_ms(&self) -> Option<u16> {
        self.device.watchdog_ms()
    }

    fn send(&mut self, command: ForceCommand, now_ns: TimeNs) {
        let force_n = command.force_n * self.scale;
        self.device
            .send(ForceCommand { force_n, ..command }, now_ns);
    }

    fn reported_velocity_m_s(&self) -> Option<Vec3> {
        self.device
            .reported_velocity_m_s()
            .map(|velocity| velocity * self.scale)
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

fn scaled(own: DeviceSample, scale: f32) -> DeviceSample {
    let mut sample = own;
    sample.device_from_handle.translation.vector *= scale;
    sample.velocity_m_s = own.velocity_m_s.map(|velocity| velocity * scale);
    sample
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;
    use proptest::prelude::*;
    use rt_core::math::{Pose, Vec3};
    use rt_core::port::Buttons;
    use std::sync::{Arc, Mutex};

    /// A device at one place that remembers its force.
    struct RestingDevice(Arc<Mutex<Vec3>>);

    impl HapticDevice for RestingDevice {
        fn capabilities(&self) -> DeviceCapabilities {
            DeviceCapabilities {
                workspace_radius_m: 0.1,
                ..DeviceCapabilities::TOUCH
            }
        }
        fn poll(&mut self, now_ns: TimeNs) -> Polled<DeviceSample> {
            Polled::Fresh(DeviceSample {
                opening: None,
                device_from_handle: Pose::from_parts(
                    Vec3::new(0.01, 0.02, 0.0).into(),
                    UnitQuaternion::identity(),
                ),
                velocity_m_s: Some(Vec3::new(0.3, 0.0, -0.1)),
                buttons: Buttons(0),
                sequence: 0,
                at_ns: now_ns,
            })
        }
        fn send(&mut self, command: ForceCommand, _: TimeNs) {
            *self.0.lock().unwrap() = command.force_n;
        }
        fn counters(&self) -> LineCounters {
            LineCounters::default()
        }
    }

    proptest! {
        /// Hand and instrument do equal work at any scale, and the force limit that the simulation
        /// sees maps to the device's own.
        #[test]
        fn scaling_keeps_the_work(scale in 0.2f32..5.0, force in [-3.0f32..3.0, -3.0..3.0, -3.0..3.0]) {
            let rendered = Arc::new(Mutex::new(Vec3::zeros()));
            let mut device = Scaled { device: Box::new(RestingDevice(Arc::clone(&rendered))), scale };
            let Polled::Fresh(sample) = device.poll(1) else { panic!("it has one") };
            let force_n = Vec3::from(force);
            device.send(ForceCommand { opening_n: 0.0, force_n, torque_nm: Vec3::zeros() }, 1);
            let inside_w = force_n.dot(&sample.velocity_m_s.unwrap());
            let outside_w = rendered.lock().unwrap().dot(&Vec3::new(0.3, 0.0, -0.1));
            prop_assert!((inside_w - outside_w).abs() < 1e-4 * (1.0 + inside_w.abs()));
            let most_n = device.capabilities().force_max_n;
            device.send(ForceCommand { opening_n: 0.0, force_n: Vec3::x() * most_n, torque_nm: Vec3::zeros() }, 1);
            prop_assert!((rendered.lock().unwrap().norm() - 3.3).abs() < 1e-4);
        }
    }
}
