//! The section `[haptic]`.

use std::path::PathBuf;

use serde::Deserialize;
use toml::Spanned;

use super::File;
use crate::HardwareError;
use crate::hapi::pantograph::Pantograph;
use crate::station::{HapticDriver, HapticSpec, Limits};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawHaptic {
    driver: Spanned<RawHapticDriver>,
    path: Option<PathBuf>,
    device: Option<Spanned<String>>,
    force_max_n: Option<Spanned<f32>>,
    force_continuous_n: Option<Spanned<f32>>,
    stiffness_max_n_m: Option<Spanned<f32>>,
    damping_n_s_m: Option<Spanned<f32>>,
    delay_s: Option<Spanned<f32>>,
    motion_scale: Option<Spanned<f32>>,
    felt: Option<RawFelt>,
}

/// Result of `calot devices feel`. Calot uses `passed` and `failed`. The other fields are for
/// people.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFelt {
    passed: bool,
    #[serde(rename = "on")]
    _on: Option<String>,
    #[serde(rename = "device")]
    _device: Option<String>,
    failed: Option<Vec<String>>,
}

#[derive(Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum RawHapticDriver {
    Rig,
    Woody,
    Hapi,
    Inverse3,
    Touch,
    #[serde(rename = "force-dimension")]
    ForceDimension,
}

impl File<'_> {
    pub(super) fn haptic(&self, raw: RawHaptic) -> Result<HapticSpec, HardwareError> {
        let named = matches!(
            *raw.driver.get_ref(),
            RawHapticDriver::Touch
                | RawHapticDriver::Hapi
                | RawHapticDriver::Inverse3
                | RawHapticDriver::ForceDimension
        );
        if let Some(device) = raw.device.as_ref().filter(|_| !named) {
            let what = "device names a Touch in the vendor's set-up, a Haply's generation, an Inverse3's \
                        number or a Force Dimension device's serial number: only drivers \"touch\", \
                        \"hapi\", \"inverse3\" and \"force-dimension\" have one";
            return Err(self.error(device.span().start, what.into()));
        }
        let force_at = raw
            .force_continuous_n
            .as_ref()
            .map_or(0, |force| force.span().start);
        let limits = Limits {
            force_max_n: self.within("force_max_n", "N", raw.force_max_n, 0.1..=40.0)?,
            force_continuous_n: self.within(
                "force_continuous_n",
                "N",
                raw.force_continuous_n,
                0.1..=40.0,
            )?,
            stiffness_max_n_m: self.within(
                "stiffness_max_n_m",
                "N/m",
                raw.stiffness_max_n_m,
                10.0..=20_000.0,
            )?,
            damping_n_s_m: self.within("damping_n_s_m", "N s/m", raw.damping_n_s_m, 0.0..=50.0)?,
            delay_s: self.within("delay_s", "s", raw.delay_s, 0.0..=0.05)?,
        };
        if let (Some(peak), Some(continuous)) = (limits.force_max_n, limits.force_continuous_n)
            && continuous > peak
        {
            let what = format!(
                "force_continuous_n is {continuous} N, allowed is at most force_max_n, {peak} N"
            );
            return Err(self.error(force_at, what));
        }
        Ok(HapticSpec {
            driver: self.haptic_driver(&raw.driver, raw.device)?,
            path: self.haptic_path(&raw.driver, raw.path)?,
            limits,
            motion_scale: self.within("motion_scale", "", raw.motion_scale, 0.5..=2.0)?,
            is_felt: raw.felt.as_ref().is_some_and(|felt| felt.passed),
            failed_felt: raw.felt.filter(|it| !it.passed).and_then(|it| it.failed),
        })
    }

    fn haptic_path(
        &self,
        driver: &Spanned<RawHapticDriver>,
        path: Option<PathBuf>,
    ) -> Result<PathBuf, HardwareError> {
        match (path, driver.get_ref()) {
            (Some(path), _) => Ok(path),
            // An installed library has a name that the loader finds.
            (None, RawHapticDriver::ForceDimension) => Ok(PathBuf::from(crate::dhd::LIBRARY)),
            (None, _) => {
                let what =
                    "the haptic device has no path: name its line, its library or its service";
                Err(self.error(driver.span().start, what.into()))
            }
        }
    }

    fn haptic_driver(
        &self,
        driver: &Spanned<RawHapticDriver>,
        device: Option<Spanned<String>>,
    ) -> Result<HapticDriver, HardwareError> {
        Ok(match *driver.get_ref() {
            RawHapticDriver::Rig => HapticDriver::Rig,
            RawHapticDriver::Woody => HapticDriver::Woody,
            RawHapticDriver::Hapi => HapticDriver::Hapi(self.generation(driver, device.as_ref())?),
            RawHapticDriver::Inverse3 => HapticDriver::Inverse3 {
                device: device.map(Spanned::into_inner),
            },
            RawHapticDriver::Touch => HapticDriver::Touch {
                device: device.map(Spanned::into_inner),
            },
            RawHapticDriver::ForceDimension => HapticDriver::ForceDimension {
                serial: self.serial(device.as_ref())?,
            },
        })
    }

    fn serial(&self, device: Option<&Spanned<String>>) -> Result<Option<u16>, HardwareError> {
        let Some(device) = device else {
            return Ok(None);
        };
        device.get_ref().parse().map(Some).map_err(|_| {
            let what = format!(
                "device is \"{}\", allowed is a serial number, \"0\" to \"{}\", or no device: the first",
                device.get_ref(),
                u16::MAX
            );
            self.error(device.span().start, what)
        })
    }

    /// Generation of a Haply. There is no default, because with a wrong generation the motors turn
    /// the wrong way.
    fn generation(
        &self,
        driver: &Spanned<RawHapticDriver>,
        device: Option<&Spanned<String>>,
    ) -> Result<Pantograph, HardwareError> {
        let at = device.map_or(driver.span().start, |device| device.span().start);
        device
            .and_then(|device| Pantograph::named(device.get_ref()))
            .ok_or_else(|| {
                let what = "driver \"hapi\" needs device = \"gen2\", \"gen3\" or \"gen3.1\": \
                            the Haply's generation";
                self.error(at, what.into())
            })
    }
}
