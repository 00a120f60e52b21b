//! Firmware of the emulated haptic device, in one of several protocols.

use rt_core::math::Vec3;

use super::mistake::{Mistake, RigFirmware};
use super::touch::{Body, Touch};
use crate::hapi::device::Board;
use crate::hapi::pantograph::{Pantograph, swapped};
use crate::rig::device::Motion;
use crate::rig::wire::{Capabilities, Opening};
use crate::woody::device::Firmware;
use crate::woody::mechanism::Mechanism;

/// Emulated haptic device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum HapticModel {
    /// A Touch-class device that speaks the rig protocol: open with
    /// [`crate::rig::RigHaptic`].
    #[default]
    TouchRig,
    /// A Touch-class device whose handle opens and shuts, with a motor along the opening.
    HandleRig,
    /// A WoodenHaptics device: open with [`crate::woody::WoodyHaptic`].
    Woody,
    /// A flat Haply of the third generation: open with [`crate::hapi::HapiHaptic`].
    Hapi,
}

/// Firmware of one device.
#[derive(Debug)]
pub(super) enum Electronics {
    Rig(Box<RigFirmware>),
    Woody(Box<Firmware>),
    Hapi(Box<Hapi>),
}

/// Body of a WoodenHaptics device, heavier than a Touch, with little friction (capstans). The
/// firmware quantises positions, so `encoder_step_m` is tiny.
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

/// Body of a flat Haply: light arms and gears with some friction. No figures are published.
const HAPI_BODY: Body = Body {
    mass_kg: 0.1,
    friction_n: 0.1,
    damping_n_s_m: 0.2,
    encoder_step_m: 1e-6,
    workspace_radius_m: 0.05,
    force_max_n: 5.0,
    force_continuous_n: 1.0,
};

/// A Haply's board and the time of the host's last bytes.
#[derive(Debug, Default)]
pub(super) struct Hapi {
    board: Board,
    last_bytes_us: Option<u32>,
}

impl Hapi {
    const LINKAGE: Pantograph = Pantograph::GEN3;
    /// Silence of the host after which it no longer counts as sending commands, µs. The real board
    /// has no such limit.
    const HOST_TIMEOUT_US: u32 = 100_000;

    fn receive(
        &mut self,
        bytes: &[u8],
        touch: &Touch,
        now_us: u32,
        send: impl FnMut(&[u8]),
    ) -> Vec3 {
        let angles_deg = Self::LINKAGE.angles_deg(touch.measured_m());
        // The handle is held at home until a host has set the board up.
        let [first, second] = swapped(if self.board.was_set_up() {
            angles_deg
        } else {
            Self::LINKAGE.home_deg
        });
        if !bytes.is_empty() {
            self.last_bytes_us = Some(now_us);
        } else if self
            .last_bytes_us
            .is_some_and(|at_us| now_us.wrapping_sub(at_us) > Self::HOST_TIMEOUT_US)
        {
            self.last_bytes_us = None;
        }
        self.board
            .receive(bytes, [first, second, 0.0, 0.0], now_us, send);
        let [first, second, ..] = self.board.torques_nm();
        // Stretched arms transmit any force without torque. The force is then undefined, and this
        // model uses zero.
        Self::LINKAGE
            .force_n(angles_deg, swapped([first, second]))
            .unwrap_or_default()
    }
}

impl Electronics {
    /// Electronics of a model. Only the firmware of a rig can have a mistake.
    pub(super) fn new(model: HapticModel, mistake: Option<Mistake>) -> Self {
        match model {
            HapticModel::TouchRig => {
                let firmware = RigFirmware::new(Capabilities::touch_class(), mistake);
                Self::Rig(Box::new(firmware))
            }
            HapticModel::HandleRig => {
                let can = Capabilities::touch_class_with_opening();
                Self::Rig(Box::new(RigFirmware::new(can, mistake)))
            }
            HapticModel::Woody => Self::Woody(Box::default()),
            HapticModel::Hapi => Self::Hapi(Box::default()),
        }
    }

    pub(super) fn body(&self) -> Body {
        match self {
            Self::Rig(_) => Body::TOUCH,
            Self::Woody(_) => WOODY_BODY,
            Self::Hapi(_) => HAPI_BODY,
        }
    }

    /// Projects a position of the hand onto the space in which the device moves, m: a planar device
    /// keeps y = 0.
    pub(super) fn constrained_m(&self, mut at_m: Vec3) -> Vec3 {
        if matches!(self, Self::Hapi(_)) {
            at_m.y = 0.0;
        }
        at_m
    }

    /// True if a controller sends commands.
    pub(super) fn is_commanded(&self) -> bool {
        match self {
            Self::Rig(firmware) => firmware.is_commanded(),
            Self::Woody(firmware) => firmware.is_commanded(),
            Self::Hapi(hapi) => hapi.last_bytes_us.is_some(),
        }
    }

    /// Takes the controller's bytes and returns the force that the motors render now, N. If
    /// `degenerate`, the Haply answers with NaN, because its protocol sends floats.
    pub(super) fn receive(
        &mut self,
        bytes: &[u8],
        touch: &Touch,
        now_us: u32,
        degenerate: bool,
        mut send: impl FnMut(&[u8]),
    ) -> Vec3 {
        match self {
            Self::Rig(firmware) => {
                if let Some(answer) = firmware.receive(bytes, now_us) {
                    send(&answer);
                }
                firmware.force_n(now_us)
            }
            Self::Woody(firmware) => {
                let [a, b, c] = WOODY.counts(touch.measured_m());
                // The real firmware reads all the time, the emulator only once a millisecond. So
                // the emulator passes on each line of that millisecond separately.
                for line in bytes.split_inclusive(|&byte| byte == b'\n') {
                    firmware.receive(line, [a, b, c, 0, 0, 0], now_us, &mut send);
                }
                let angles_rad = WOODY.angles_rad([a, b, c]);
                // Stretched links transmit any force without current. The force is then undefined,
                // and this model uses zero.
                WOODY
                    .force_n(angles_rad, firmware.currents_ma(now_us))
                    .unwrap_or_default()
            }
            Self::Hapi(hapi) if degenerate => hapi.receive(bytes, touch, now_us, |answer| {
                let mut answer = answer.to_vec();
                answer.iter_mut().skip(1).for_each(|byte| *byte = 0xFF);
                send(&answer);
            }),
            Self::Hapi(hapi) => hapi.receive(bytes, touch, now_us, send),
        }
    }

    /// Force of the motor that opens the handle, N.
    pub(super) fn opening_n(&mut self, now_us: u32) -> f32 {
        match self {
            Self::Rig(firmware) => firmware.opening_n(now_us),
            Self::Woody(_) | Self::Hapi(_) => 0.0,
        }
    }

    /// Opening of the model's handle, if that handle opens.
    pub(super) fn opening(model: HapticModel) -> Option<Opening> {
        match model {
            HapticModel::HandleRig => Capabilities::touch_class_with_opening().opening,
            HapticModel::TouchRig | HapticModel::Woody | HapticModel::Hapi => None,
        }
    }

    /// Present motor command divided by the largest permitted command.
    pub(super) fn motor_load(&mut self, now_us: u32) -> f32 {
        match self {
            Self::Rig(firmware) => {
                firmware.force_n(now_us).norm() / Capabilities::touch_class().force_max_n
            }
            Self::Woody(firmware) => {
                let most_ma = firmware.currents_ma(now_us).map(i32::abs);
                let most_ma = most_ma.into_iter().max().unwrap_or(0);
                most_ma as f32 * 1e-3 / WOODY.current_max_a as f32
            }
            Self::Hapi(hapi) => {
                let torques = hapi.board.torques_nm();
                let most = torques
                    .iter()
                    .fold(0.0, |most: f32, one| most.max(one.abs()));
                most / Hapi::LINKAGE.torque_max_nm as f32
            }
        }
    }

    /// Sends a sample without a request, if the protocol does that.
    pub(super) fn report(
        &mut self,
        motion: &Motion,
        touch: &Touch,
        now_us: u32,
        mut send: impl FnMut(&[u8]),
    ) {
        if let Self::Rig(firmware) = self {
            firmware.set_limited(touch.is_limited());
            if let Some(state) = firmware.state(motion, now_us) {
                send(&state);
            }
        }
    }
}
