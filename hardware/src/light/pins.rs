//! A photodiode that switches an input pin of a serial port, as a switch would.

use std::path::Path;
use std::time::Duration;

use rt_core::time::TimeNs;
use serialport::{SerialPort, TTYPort};

use super::sensor::{LightInput, Seen};
use crate::HardwareError;

/// Time after which the pins have settled, once RTS and DTR are high.
const SETTLE: Duration = Duration::from_millis(10);

/// Input pins of a serial port.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pin {
    /// Clear to send.
    Cts,
    /// Data set ready.
    Dsr,
    /// Data carrier detect.
    Dcd,
    /// Ring indicator.
    Ri,
}

impl Pin {
    /// Name on the plug.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cts => "CTS",
            Self::Dsr => "DSR",
            Self::Dcd => "DCD",
            Self::Ri => "RI",
        }
    }
}

/// Reads a pin. It is a trait because a pty has no such pins: tests implement it.
pub trait PinReader: Send {
    /// True if the pin is high.
    ///
    /// # Errors
    ///
    /// The kernel's words.
    fn is_high(&mut self, pin: Pin) -> Result<bool, String>;
}

impl PinReader for TTYPort {
    fn is_high(&mut self, pin: Pin) -> Result<bool, String> {
        let read = match pin {
            Pin::Cts => self.read_clear_to_send(),
            Pin::Dsr => self.read_data_set_ready(),
            Pin::Dcd => self.read_carrier_detect(),
            Pin::Ri => self.read_ring_indicator(),
        };
        read.map_err(|error| error.description)
    }
}

/// The sensor on a pin.
#[derive(Debug)]
pub struct PinLight<P> {
    port: P,
    pin: Pin,
}

impl PinLight<TTYPort> {
    /// Opens the port, and powers the sensor from RTS and DTR.
    ///
    /// # Errors
    ///
    /// A port that does not open, or that has no such pins (a pty).
    pub fn open(path: &Path, pin: Pin) -> Result<Self, HardwareError> {
        let mut port = crate::line::open_port(path, 9600)?;
        // A port without these wires is allowed: the sensor may have a power supply of its own.
        let _ = port.write_request_to_send(true);
        let _ = port.write_data_terminal_ready(true);
        std::thread::sleep(SETTLE);
        Self::on(port, pin).map_err(|what| HardwareError::NotSerial {
            path: path.to_path_buf(),
            what: format!("the port has no {}: {what}", pin.name()),
        })
    }
}

impl<P: PinReader> PinLight<P> {
    /// Sensor on a pin of any port.
    ///
    /// # Errors
    ///
    /// The kernel's words, if the pin cannot be read.
    pub fn on(mut port: P, pin: Pin) -> Result<Self, String> {
        port.is_high(pin)?;
        Ok(Self { port, pin })
    }
}

impl<P: PinReader> LightInput for PinLight<P> {
    fn look(&mut self, at_ns: TimeNs) -> Seen {
        match self.port.is_high(self.pin) {
            Ok(bright) => Seen::Level { bright, at_ns },
            Err(_) => Seen::Lost,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A port with one pin whose states come from a list.
    struct ScriptedPin(Pin, std::vec::IntoIter<bool>);

    impl PinReader for ScriptedPin {
        fn is_high(&mut self, pin: Pin) -> Result<bool, String> {
            match pin == self.0 {
                true => self.1.next().ok_or("unplugged".to_owned()),
                false => Err("no such pin".to_owned()),
            }
        }
    }

    #[test]
    fn the_chosen_pin_is_read_until_the_adapter_is_unplugged() {
        for pin in [Pin::Cts, Pin::Dsr, Pin::Dcd, Pin::Ri] {
            let states = vec![false, true, false].into_iter();
            let mut light = PinLight::on(ScriptedPin(pin, states), pin).unwrap();
            let level = |bright, at_ns| Seen::Level { bright, at_ns };
            assert_eq!(light.look(5), level(true, 5), "{}", pin.name());
            assert_eq!(light.look(6), level(false, 6));
            assert_eq!(light.look(7), Seen::Lost);
        }
        let other = PinLight::on(ScriptedPin(Pin::Ri, vec![true].into_iter()), Pin::Cts);
        assert!(other.is_err_and(|what| what == "no such pin"));
    }

    #[test]
    fn a_pty_has_no_pins_and_is_refused() {
        use serialport::SerialPort as _;
        let (_far, near) = TTYPort::pair().unwrap();
        let path = std::path::PathBuf::from(near.name().unwrap());
        drop(near);
        let error = PinLight::open(&path, Pin::Dcd).unwrap_err().to_string();
        assert!(error.contains("the port has no DCD"), "{error}");
    }
}
