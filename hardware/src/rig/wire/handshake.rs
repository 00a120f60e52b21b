//! `HELLO` and its answer, `CAPABILITIES`.

use super::{Field, Frame, Kind, Message, WireError, Writer};

/// Offsets of the fields of `HELLO` in the payload.
mod hello {
    pub(super) const MAGIC: usize = 3;
    pub(super) const VERSION: usize = 8;
    pub(super) const END: usize = 9;
}

/// Offsets of the fields of `CAPABILITIES` in the payload.
mod capabilities {
    pub(super) const VERSION: usize = 3;
    pub(super) const KIND: usize = 4;
    pub(super) const FLAGS: usize = 5;
    pub(super) const WATCHDOG: usize = 6;
    pub(super) const RATE: usize = 7;
    pub(super) const FORCE_MAX: usize = 9;
    pub(super) const FORCE_CONTINUOUS: usize = 11;
    pub(super) const STIFFNESS_MAX: usize = 13;
    pub(super) const DAMPING_MAX: usize = 15;
    pub(super) const WORKSPACE: usize = 17;
    pub(super) const TORQUE_MAX: usize = 19;
    pub(super) const DAMPING: usize = 21;
    pub(super) const DELAY: usize = 23;
    pub(super) const SERIAL: usize = 25;
    pub(super) const NAME: usize = 29;
    pub(super) const END: usize = 45;
    // Version 2.
    pub(super) const OPENING_TRAVEL: usize = 45;
    pub(super) const OPENING_FORCE: usize = 47;
    pub(super) const OPENING_STIFFNESS: usize = 49;
    pub(super) const OPENING_END: usize = 51;
}

pub(super) const HELLO_BYTES: usize = hello::END - super::field::BODY;
pub(super) const CAPABILITIES_BYTES: usize = capabilities::END - super::field::BODY;
pub(super) const OPENING_BYTES: usize = capabilities::OPENING_END - capabilities::END;

const MAGIC: [u8; 5] = *b"CALOT";
const MEASURES_VELOCITY: u8 = 2;
const FORCE_UNIT_N: f32 = 1e-3;
const STIFFNESS_UNIT_N_M: f32 = 1.0;
const DAMPING_UNIT_N_S_M: f32 = 1e-3;
const WORKSPACE_UNIT_M: f32 = 1e-4;
const TORQUE_UNIT_NM: f32 = 1e-4;
const DELAY_UNIT_S: f32 = 1e-5;
const TRAVEL_UNIT_M: f32 = 1e-5;

/// The host's greeting.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hello {
    /// Newest version that the host speaks.
    pub version: u8,
}

impl Hello {
    /// Parses a message of kind `HELLO`.
    pub fn parse(message: &Message<'_>) -> Result<Self, WireError> {
        if message.kind() != Kind::Hello {
            return Err(WireError::Kind(message.kind() as u8));
        }
        if message.bytes(hello::MAGIC) != MAGIC {
            return Err(WireError::Range(Field::Other));
        }
        Ok(Self {
            version: message.u8(hello::VERSION),
        })
    }

    /// The framed message.
    #[must_use]
    pub fn frame(&self, sequence: u16) -> Frame {
        let mut writer = Writer::new(Kind::Hello, sequence);
        writer.put(&MAGIC);
        writer.put(&[self.version]);
        writer.frame()
    }
}

/// Kind of the device that answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum DeviceKind {
    /// Sends `STATE`, takes `FORCE`.
    Haptic = 1,
    /// Sends `SWITCHES`.
    Pedal = 2,
}

/// A handle that opens and shuts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Opening {
    /// Travel of the fingers from shut to wide open, m; in steps of 10 µm.
    pub travel_m: f32,
    /// Peak force along the opening, N; in steps of 1 mN. 0: none is rendered.
    pub force_max_n: f32,
    /// Largest stable stiffness along the opening, N/m; in steps of 1 N/m.
    pub stiffness_max_n_m: f32,
}

/// Capabilities that a device reports. A pedal leaves the haptic fields zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Capabilities {
    /// Version that the device will use.
    pub version: u8,
    /// Kind of the device.
    pub kind: DeviceKind,
    /// True if the velocity in `STATE` is measured.
    pub measures_velocity: bool,
    /// Time without a new `FORCE` after which the device drops the force, ms.
    pub watchdog_ms: u8,
    /// Samples per second.
    pub rate_hz: u16,
    /// Peak force, N; in steps of 1 mN.
    pub force_max_n: f32,
    /// Continuous force, N; in steps of 1 mN.
    pub force_continuous_n: f32,
    /// Largest stable stiffness, N/m; in steps of 1 N/m.
    pub stiffness_max_n_m: f32,
    /// Largest damping, N s/m; in steps of 1 mN s/m.
    pub damping_max_n_s_m: f32,
    /// Radius of the workspace, m; in steps of 0.1 mm.
    pub workspace_radius_m: f32,
    /// Peak torque, N m; in steps of 0.1 mN m. 0: none is rendered.
    pub torque_max_nm: f32,
    /// Damping of the device itself, N s/m; in steps of 1 mN s/m.
    pub damping_n_s_m: f32,
    /// Delay from a movement to its sample plus delay from a command to its force, s; in steps of
    /// 10 µs.
    pub delay_s: f32,
    /// Serial number.
    pub serial: u32,
    /// Name, ASCII, padded with zeros.
    pub name: [u8; 16],
    /// Opening of the handle. A message with this field has version 2.
    pub opening: Option<Opening>,
}

impl Capabilities {
    /// Parses a message of kind `CAPABILITIES`. An unknown kind of device is out of range, and so
    /// is a version 1 or 2 that does not fit the length.
    pub fn parse(message: &Message<'_>) -> Result<Self, WireError> {
        use capabilities as at;
        if message.kind() != Kind::Capabilities {
            return Err(WireError::Kind(message.kind() as u8));
        }
        let kind = match message.u8(at::KIND) {
            1 => DeviceKind::Haptic,
            2 => DeviceKind::Pedal,
            _ => return Err(WireError::Range(Field::Other)),
        };
        let flags = message.u8(at::FLAGS);
        let version = message.u8(at::VERSION);
        let of_opening = if message.has_opening() { 2 } else { 1 };
        if matches!(version, 1 | 2) && version != of_opening {
            return Err(WireError::Range(Field::Other));
        }
        Ok(Self {
            version,
            kind,
            measures_velocity: flags & MEASURES_VELOCITY != 0,
            watchdog_ms: message.u8(at::WATCHDOG),
            rate_hz: message.u16(at::RATE),
            force_max_n: f32::from(message.u16(at::FORCE_MAX)) * FORCE_UNIT_N,
            force_continuous_n: f32::from(message.u16(at::FORCE_CONTINUOUS)) * FORCE_UNIT_N,
            stiffness_max_n_m: f32::from(message.u16(at::STIFFNESS_MAX)) * STIFFNESS_UNIT_N_M,
            damping_max_n_s_m: f32::from(message.u16(at::DAMPING_MAX)) * DAMPING_UNIT_N_S_M,
            workspace_radius_m: f32::from(message.u16(at::WORKSPACE)) * WORKSPACE_UNIT_M,
            torque_max_nm: f32::from(message.u16(at::TORQUE_MAX)) * TORQUE_UNIT_NM,
            damping_n_s_m: f32::from(message.u16(at::DAMPING)) * DAMPING_UNIT_N_S_M,
            delay_s: f32::from(message.u16(at::DELAY)) * DELAY_UNIT_S,
            serial: message.u32(at::SERIAL),
            name: message.bytes(at::NAME),
            opening: message.has_opening().then(|| Opening {
                travel_m: f32::from(message.u16(at::OPENING_TRAVEL)) * TRAVEL_UNIT_M,
                force_max_n: f32::from(message.u16(at::OPENING_FORCE)) * FORCE_UNIT_N,
                stiffness_max_n_m: f32::from(message.u16(at::OPENING_STIFFNESS))
                    * STIFFNESS_UNIT_N_M,
            }),
        })
    }

    /// The framed message.
    #[must_use]
    pub fn frame(&self, sequence: u16) -> Frame {
        let mut writer = Writer::new(Kind::Capabilities, sequence);
        let flags = if self.measures_velocity {
            MEASURES_VELOCITY
        } else {
            0
        };
        writer.put(&[self.version, self.kind as u8, flags, self.watchdog_ms]);
        writer.put(&self.rate_hz.to_le_bytes());
        writer.put_u16(self.force_max_n, FORCE_UNIT_N);
        writer.put_u16(self.force_continuous_n, FORCE_UNIT_N);
        writer.put_u16(self.stiffness_max_n_m, STIFFNESS_UNIT_N_M);
        writer.put_u16(self.damping_max_n_s_m, DAMPING_UNIT_N_S_M);
        writer.put_u16(self.workspace_radius_m, WORKSPACE_UNIT_M);
        writer.put_u16(self.torque_max_nm, TORQUE_UNIT_NM);
        writer.put_u16(self.damping_n_s_m, DAMPING_UNIT_N_S_M);
        writer.put_u16(self.delay_s, DELAY_UNIT_S);
        writer.put(&self.serial.to_le_bytes());
        writer.put(&self.name);
        if let Some(opening) = &self.opening {
            writer.put_u16(opening.travel_m, TRAVEL_UNIT_M);
            writer.put_u16(opening.force_max_n, FORCE_UNIT_N);
            writer.put_u16(opening.stiffness_max_n_m, STIFFNESS_UNIT_N_M);
        }
        writer.frame()
    }

    /// The emulated haptic device, of the class of a Touch.
    #[must_use]
    pub const fn touch_class() -> Self {
        Self {
            version: 1,
            kind: DeviceKind::Haptic,
            measures_velocity: true,
            watchdog_ms: 50,
            rate_hz: 1000,
            force_max_n: 3.3,
            force_continuous_n: 0.88,
            stiffness_max_n_m: 700.0,
            damping_max_n_s_m: 5.0,
            workspace_radius_m: 0.1,
            torque_max_nm: 0.0,
            damping_n_s_m: crate::touch::DAMPING_N_S_M,
            delay_s: crate::touch::DELAY_S,
            serial: 1,
            name: *b"emulated touch\0\0",
            opening: None,
        }
    }

    /// A Touch-class device whose handle opens by 30 mm, as scissors' rings do, and renders 5 N
    /// there.
    #[must_use]
    pub const fn touch_class_with_opening() -> Self {
        Self {
            version: 2,
            name: *b"emulated handle\0",
            opening: Some(Opening {
                travel_m: 0.03,
                force_max_n: 5.0,
                stiffness_max_n_m: 1000.0,
            }),
            ..Self::touch_class()
        }
    }

    /// A foot pedal that reports `rate_hz` times a second.
    #[must_use]
    pub const fn pedal(rate_hz: u16) -> Self {
        Self {
            version: 1,
            kind: DeviceKind::Pedal,
            measures_velocity: false,
            watchdog_ms: 0,
            rate_hz,
            force_max_n: 0.0,
            force_continuous_n: 0.0,
            stiffness_max_n_m: 0.0,
            damping_max_n_s_m: 0.0,
            workspace_radius_m: 0.0,
            torque_max_nm: 0.0,
            damping_n_s_m: 0.0,
            delay_s: 0.0,
            serial: 2,
            name: *b"emulated pedal\0\0",
            opening: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::payload;
    use super::*;

    #[test]
    fn hello_has_its_documented_bytes_and_is_read_as_sent() {
        let bytes = payload(&Hello { version: 1 }.frame(7));
        assert_eq!(bytes, *b"\x01\x07\x00CALOT\x01");
        let message = Message::new(&bytes).unwrap();
        assert_eq!(message.sequence(), 7);
        assert_eq!(Hello::parse(&message), Ok(Hello { version: 1 }));
    }

    #[test]
    fn a_hello_without_the_magic_is_refused() {
        let bytes = *b"\x01\x07\x00calot\x01";
        assert_eq!(
            Hello::parse(&Message::new(&bytes).unwrap()),
            Err(WireError::Range(Field::Other))
        );
    }

    #[test]
    fn a_version_that_contradicts_the_length_is_refused() {
        for (sent, version) in [
            (Capabilities::touch_class(), 2),
            (Capabilities::touch_class_with_opening(), 1),
        ] {
            let bytes = payload(&Capabilities { version, ..sent }.frame(0));
            let read = Capabilities::parse(&Message::new(&bytes).unwrap());
            assert_eq!(read, Err(WireError::Range(Field::Other)));
        }
    }

    #[test]
    fn capabilities_are_read_as_sent() {
        for sent in [
            Capabilities::touch_class(),
            Capabilities::touch_class_with_opening(),
            Capabilities::pedal(100),
        ] {
            let bytes = payload(&sent.frame(0));
            let read = Capabilities::parse(&Message::new(&bytes).unwrap()).unwrap();
            assert!((read.force_max_n - sent.force_max_n).abs() < 1e-6);
            assert!((read.workspace_radius_m - sent.workspace_radius_m).abs() < 1e-6);
            assert!((read.damping_n_s_m - sent.damping_n_s_m).abs() < 1e-6);
            assert!((read.delay_s - sent.delay_s).abs() < 1e-8);
            assert_eq!(
                Capabilities {
                    force_max_n: sent.force_max_n,
                    ..read
                }
                .frame(0),
                sent.frame(0)
            );
        }
    }
}
