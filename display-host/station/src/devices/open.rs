//! Opens a haptic device by its path and driver.

use std::path::Path;

use hardware::HardwareError;
use hardware::dhd::DhdHaptic;
use hardware::hapi::{HapiHaptic, pantograph::Pantograph};
use hardware::inverse3::Inverse3Haptic;
use hardware::rig::RigHaptic;
use hardware::touch::TouchHaptic;
use hardware::woody::WoodyHaptic;
use rt_core::port::HapticDevice;

use super::args::LineDriver;

/// Opens the haptic device at `path`.
///
/// # Errors
///
/// If the driver is one of another kind of device, or of the driver.
pub(super) fn open_haptic(
    path: &Path,
    driver: LineDriver,
) -> Result<Box<dyn HapticDevice + Send>, HardwareError> {
    Ok(match driver {
        LineDriver::Rig => Box::new(RigHaptic::open(path)?),
        LineDriver::Woody => Box::new(WoodyHaptic::open(path)?),
        LineDriver::HapiGen2 => Box::new(HapiHaptic::open(path, Pantograph::GEN2)?),
        LineDriver::HapiGen3 => Box::new(HapiHaptic::open(path, Pantograph::GEN3)?),
        LineDriver::HapiGen31 => Box::new(HapiHaptic::open(path, Pantograph::GEN3_1)?),
        LineDriver::ForceDimension => Box::new(DhdHaptic::open(path, None)?),
        LineDriver::Touch => Box::new(TouchHaptic::open(path, None)?),
        LineDriver::Inverse3 => Box::new(Inverse3Haptic::open(path, None)?),
        LineDriver::Evdev | LineDriver::Modem | LineDriver::Bird | LineDriver::Trakstar => {
            return Err(HardwareError::WrongDevice {
                path: path.to_path_buf(),
                expected: "haptic device",
                found: "the driver of a pedal or a tracker".to_owned(),
            });
        }
    })
}
