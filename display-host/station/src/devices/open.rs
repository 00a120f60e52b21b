//! Opens a haptic device by its path and driver.

use std::path::Path;

use hardware::HardwareError;
use hardware::hapi::pantograph::Pantograph;
use hardware::station::{HapticDriver, HapticSpec, Limits};
use rt_core::port::HapticDevice;

use super::args::LineDriver;

/// Describes the haptic device at `path`, with the limits that it declares itself and without a
/// motion scale.
///
/// # Errors
///
/// If the driver belongs to another kind of device.
pub(super) fn haptic_spec(path: &Path, driver: LineDriver) -> Result<HapticSpec, HardwareError> {
    let driver = match driver {
        LineDriver::Rig => HapticDriver::Rig,
        LineDriver::Woody => HapticDriver::Woody,
        LineDriver::HapiGen2 => HapticDriver::Hapi(Pantograph::GEN2),
        LineDriver::HapiGen3 => HapticDriver::Hapi(Pantograph::GEN3),
        LineDriver::HapiGen31 => HapticDriver::Hapi(Pantograph::GEN3_1),
        LineDriver::ForceDimension => HapticDriver::ForceDimension { serial: None },
        LineDriver::Touch => HapticDriver::Touch { device: None },
        LineDriver::Inverse3 => HapticDriver::Inverse3 { device: None },
        LineDriver::Evdev | LineDriver::Modem | LineDriver::Bird | LineDriver::Trakstar => {
            return Err(HardwareError::WrongDevice {
                path: path.to_path_buf(),
                expected: "haptic device",
                found: "the driver of a pedal or a tracker".to_owned(),
            });
        }
    };
    Ok(HapticSpec {
        driver,
        path: path.to_path_buf(),
        limits: Limits::default(),
        motion_scale: None,
        is_felt: false,
        failed_felt: None,
    })
}

/// Opens the haptic device at `path`.
///
/// # Errors
///
/// If the driver belongs to another kind of device, or cannot open this one.
pub(super) fn open_haptic(
    path: &Path,
    driver: LineDriver,
) -> Result<Box<dyn HapticDevice + Send>, HardwareError> {
    haptic_spec(path, driver)?.open()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_driver_of_another_kind_of_device_is_refused() {
        for driver in [
            LineDriver::Evdev,
            LineDriver::Modem,
            LineDriver::Bird,
            LineDriver::Trakstar,
        ] {
            let error = haptic_spec("/dev/null".as_ref(), driver).unwrap_err();
            let error = error.to_string();
            assert!(
                error.contains("the driver of a pedal or a tracker"),
                "{error}"
            );
        }
        let spec = haptic_spec("/dev/ttyACM0".as_ref(), LineDriver::HapiGen2).unwrap();
        assert_eq!(spec.driver, HapticDriver::Hapi(Pantograph::GEN2));
        assert_eq!(spec.limits, Limits::default());
    }
}
