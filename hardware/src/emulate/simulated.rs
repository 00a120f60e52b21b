//! A haptic device and its line in memory, with a clock that the caller advances. Tests use it to
//! test a driver, with any bytes, without terminals, threads or waiting.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rt_core::math::Vec3;
use rt_core::port::HapticDevice;

use super::electronics::{Electronics, HapticModel};
use super::fingers::{Fingers, RING};
use super::mistake::Mistake;
use super::touch::{Body, Grip, Touch};
use crate::HardwareError;
use crate::hapi::HapiHaptic;
use crate::hapi::pantograph::Pantograph;
use crate::line::{InputRing, Line, MemoryDevice, now_ns};
use crate::rig::RigHaptic;
use crate::rig::device::Motion;
use crate::woody::WoodyHaptic;
use crate::woody::mechanism::Mechanism;

/// The device's end of a line in memory.
#[derive(Debug)]
pub struct SimulatedDevice {
    end: Arc<End>,
}

#[derive(Debug)]
struct End {
    input: Arc<InputRing>,
    device: Mutex<Device>,
}

#[derive(Debug)]
struct Device {
    electronics: Electronics,
    touch: Touch,
    /// Fingers in a handle that opens.
    fingers: Option<Fingers>,
    squeeze: Squeeze,
    motion: Motion,
    now_ns: u64,
}

/// Intention of the fingers in a handle that opens.
#[derive(Debug, Clone, Copy)]
enum Squeeze {
    Shut,
    Open,
    /// Pull to a position, m from half open.
    To(f32),
}

/// Body of a device in memory, and the hand at its handle.
#[derive(Debug, Clone, Copy)]
pub struct SimulatedBody {
    /// Mechanics.
    pub body: Body,
    /// Hand at the handle.
    pub grip: Grip,
    /// Initial position of the handle, m.
    pub start_m: Vec3,
    /// Constant force on the handle, N.
    pub load_n: Vec3,
    /// Moving half of a handle that opens, in the same hand.
    pub ring: Body,
}

impl SimulatedBody {
    /// The model's body with nobody at the handle.
    #[must_use]
    pub fn free(model: HapticModel) -> Self {
        Self {
            body: Electronics::new(model, None).body(),
            grip: Grip::NONE,
            start_m: Vec3::zeros(),
            load_n: Vec3::zeros(),
            ring: RING,
        }
    }
}

impl Device {
    const fn now_us(&self) -> u32 {
        (self.now_ns / 1000) as u32
    }
}

impl End {
    fn device(&self) -> MutexGuard<'_, Device> {
        self.device.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl MemoryDevice for End {
    fn receive(&self, bytes: &[u8]) {
        let mut device = self.device();
        let (now_us, now_ns) = (device.now_us(), device.now_ns);
        let Device {
            electronics, touch, ..
        } = &mut *device;
        electronics.receive(bytes, touch, now_us, false, |answer| {
            self.input.put(answer, now_ns);
        });
    }
}

impl SimulatedDevice {
    /// Makes a device at rest in a hand and opens its driver.
    pub fn open(model: HapticModel) -> Result<(Box<dyn HapticDevice + Send>, Self), HardwareError> {
        let held = SimulatedBody {
            grip: Grip::STYLUS,
            ..SimulatedBody::free(model)
        };
        Self::open_with_body(model, held)
    }

    /// Makes a rig whose firmware may have a mistake, in a hand, and opens its driver.
    pub fn open_rig(
        mistake: Option<Mistake>,
        grip: Grip,
    ) -> Result<(Box<dyn HapticDevice + Send>, Self), HardwareError> {
        Self::open_rig_as(HapticModel::TouchRig, mistake, grip)
    }

    /// Makes a rig of this model as [`open_rig`](Self::open_rig) does.
    pub fn open_rig_as(
        model: HapticModel,
        mistake: Option<Mistake>,
        grip: Grip,
    ) -> Result<(Box<dyn HapticDevice + Send>, Self), HardwareError> {
        let held = SimulatedBody {
            grip,
            ..SimulatedBody::free(model)
        };
        Self::made(model, mistake, held)
    }

    /// Makes a device with this body and opens its driver.
    pub fn open_with_body(
        model: HapticModel,
        of: SimulatedBody,
    ) -> Result<(Box<dyn HapticDevice + Send>, Self), HardwareError> {
        Self::made(model, None, of)
    }

    fn made(
        model: HapticModel,
        mistake: Option<Mistake>,
        of: SimulatedBody,
    ) -> Result<(Box<dyn HapticDevice + Send>, Self), HardwareError> {
        let input = Arc::new(InputRing::new());
        let electronics = Electronics::new(model, mistake);
        let touch = Touch::new(of.body, of.grip, of.start_m).loaded(of.load_n);
        let motion = Motion {
            rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
            ..Motion::default()
        };
        let end = Arc::new(End {
            input: Arc::clone(&input),
            device: Mutex::new(Device {
                electronics,
                touch,
                fingers: Electronics::opening(model)
                    .map(|opening| Fingers::new(opening, of.ring, of.grip)),
                squeeze: Squeeze::Open,
                motion,
                now_ns: now_ns(),
            }),
        });
        let line = Line::in_memory(input, Arc::clone(&end) as Arc<dyn MemoryDevice>);
        let driver: Box<dyn HapticDevice + Send> = match model {
            HapticModel::TouchRig | HapticModel::HandleRig => Box::new(RigHaptic::on(line)?),
            HapticModel::Woody => Box::new(WoodyHaptic::on(line, Mechanism::WOODY)?),
            HapticModel::Hapi => Box::new(HapiHaptic::on(
                line,
                Pantograph::GEN3,
                Pantograph::GEN3.home_deg,
            )?),
        };
        Ok((driver, Self { end }))
    }

    /// Sends any bytes to the driver.
    pub fn send_to_driver(&self, bytes: &[u8]) {
        let now_ns = self.now_ns();
        self.end.input.put(bytes, now_ns);
    }

    /// Advances one millisecond without movement. If `speaks`, the device sends a sample, if its
    /// protocol does so without a request.
    pub fn millisecond(&self, speaks: bool) {
        let mut device = self.end.device();
        device.now_ns += 1_000_000;
        let (now_us, now_ns) = (device.now_us(), device.now_ns);
        let Device {
            electronics,
            touch,
            motion,
            ..
        } = &mut *device;
        electronics.receive(&[], touch, now_us, false, |_| {});
        if speaks {
            electronics.report(motion, touch, now_us, |state| {
                self.end.input.put(state, now_ns);
            });
        }
    }

    /// Advances one millisecond in which the handle moves. The hand pulls towards `target_m`.
    /// Returns the force of the motors, N.
    pub fn advance(&self, target_m: Vec3) -> Vec3 {
        let mut device = self.end.device();
        device.now_ns += 1_000_000;
        let (now_us, now_ns) = (device.now_us(), device.now_ns);
        let Device {
            electronics,
            touch,
            fingers,
            squeeze,
            motion,
            ..
        } = &mut *device;
        let force_n = electronics.receive(&[], touch, now_us, false, |_| {});
        if let Some(fingers) = fingers {
            let opening_n = electronics.opening_n(now_us);
            match *squeeze {
                Squeeze::Shut => fingers.step(true, opening_n),
                Squeeze::Open => fingers.step(false, opening_n),
                Squeeze::To(wanted_m) => fingers.pull(wanted_m, opening_n),
            }
            motion.opening = fingers.opening();
        }
        touch.step(target_m, Vec3::zeros(), force_n);
        motion.position_m = touch.measured_m().into();
        motion.velocity_m_s = touch.measured_velocity_m_s().into();
        if !self.end.input.is_lost() {
            electronics.report(motion, touch, now_us, |state| {
                self.end.input.put(state, now_ns);
            });
        }
        force_n
    }

    /// Lets the fingers shut a handle that opens, or open it.
    pub fn squeeze(&self, shut: bool) {
        self.end.device().squeeze = if shut { Squeeze::Shut } else { Squeeze::Open };
    }

    /// Lets the fingers pull a handle that opens towards a position, m from half open.
    pub fn squeeze_to(&self, wanted_m: f32) {
        self.end.device().squeeze = Squeeze::To(wanted_m);
    }

    /// Force of the motor that opens the handle now, N.
    #[must_use]
    pub fn opening_n(&self) -> f32 {
        let mut device = self.end.device();
        let now_us = device.now_us();
        device.electronics.opening_n(now_us)
    }

    /// Pulls the plug.
    pub fn unplug(&self) {
        self.end.input.mark_lost();
    }

    /// Position from the encoders now, m.
    #[must_use]
    pub fn measured_m(&self) -> Vec3 {
        self.end.device().touch.measured_m()
    }

    /// The device's time, ns, for calls of the driver.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        self.end.device().now_ns
    }

    /// Motor command now, as a share of the largest permitted command.
    #[must_use]
    pub fn motor_load(&self) -> f32 {
        let mut device = self.end.device();
        let now_us = device.now_us();
        device.electronics.motor_load(now_us)
    }
}
