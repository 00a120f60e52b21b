//! The haptic device's electronics: which protocol its firmware speaks.

use rt_core::math::Vec3;

use super::touch::{Body, Touch};
use crate::rig::device::{Device, Motion};
use crate::rig::wire::Capabilities;
use crate::woody::device::Firmware;
use crate::woody::mechanism::Mechanism;

/// Which haptic device is emulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HapticModel {
    /// A Touch-class device that speaks the rig protocol: open with
    /// [`crate::rig::RigHaptic`].
    #[default]
    TouchRig,
    /// A WoodenHaptics device: open with [`crate::woody::WoodyHaptic`].
    Woody,
}

/// The firmware of one device.
#[derive(Debug)]
pub(super) enum Electronics {
    Rig(Box<Device>),
    Woody(Box<Firmware>),
}

/// A WoodenHaptics device as a body: heavier, little friction (capstans), and its encoders sit
/// on the motors, so positions are rounded there.
const WOODY_BODY: Body = Body {
    mass_kg: 0.12,
    friction_n: 0.1,
    damping_n_s_m: 0.2,
    encoder_step_m: 1e-6,
    workspace_radius_m: 0.12,
    force_max_n: 8.0,
    force_continuous_n: 2.0,
};

const WOODY: Mechanism = Mechanism::WOODY;

impl Electronics {
    pub(super) fn new(model: HapticModel) -> Self {
        match model {
            HapticModel::TouchRig => Self::Rig(Box::new(Device::new(Capabilities::touch_class()))),
            HapticModel::Woody => Self::Woody(Box::default()),
        }
    }

    pub(super) fn body(&self) -> Body {
        match self {
            Self::Rig(_) => Body::TOUCH,
            Self::Woody(_) => WOODY_BODY,
        }
    }

    /// Whether a controller sends commands.
    pub(super) fn is_commanded(&self) -> bool {
        match self {
            Self::Rig(device) => device.is_commanded(),
            Self::Woody(firmware) => firmware.is_commanded(),
        }
    }

    /// Takes what the controller sent and says what the motors render now, N.
    pub(super) fn receive(
        &mut self,
        bytes: &[u8],
        touch: &Touch,
        now_us: u32,
        mut send: impl FnMut(&[u8]),
    ) -> Vec3 {
        match self {
            Self::Rig(device) => {
                device.receive(bytes, now_us);
                if let Some(answer) = device.answer() {
                    send(answer.as_bytes());
                }
                device.force(now_us).force_n.into()
            }
            Self::Woody(firmware) => {
                let [a, b, c] = WOODY.counts(touch.measured_m());
                firmware.receive(bytes, [a, b, c, 0, 0, 0], now_us, send);
                let angles_rad = WOODY.angles_rad([a, b, c]);
                // Where the links are stretched they bear any force.
                WOODY
                    .force_n(angles_rad, firmware.currents_ma(now_us))
                    .unwrap_or_default()
            }
        }
    }

    /// Sends a sample unasked, where the protocol does that.
    pub(super) fn report(
        &mut self,
        motion: &Motion,
        touch: &Touch,
        now_us: u32,
        mut send: impl FnMut(&[u8]),
    ) {
        if let Self::Rig(device) = self {
            device.set_limited(touch.is_limited());
            if let Some(state) = device.state(motion, now_us) {
                send(state.as_bytes());
            }
        }
    }
}
