//! The sections `[pedal]` and `[second_pedal]`, and the buttons of the handle that act as pedal
//! switches.

use std::path::PathBuf;

use serde::Deserialize;
use toml::Spanned;

use super::File;
use crate::HardwareError;
use crate::pedal::Roles;
use crate::station::{HandleButtons, PedalDriver, PedalSpec};

/// The kernel's highest key code.
const KEY_MAX: u16 = 0x2FF;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPedal {
    driver: RawPedalDriver,
    path: PathBuf,
    cut_key: Option<Spanned<u16>>,
    coagulate_key: Option<Spanned<u16>>,
    camera_lock_key: Option<Spanned<u16>>,
}

#[derive(Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum RawPedalDriver {
    Rig,
    Evdev,
    Modem,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawHandleButtons {
    cut: Option<Spanned<u8>>,
    coagulate: Option<Spanned<u8>>,
    camera_lock: Option<Spanned<u8>>,
}

impl File<'_> {
    pub(super) fn handle_buttons(
        &self,
        raw: Option<RawHandleButtons>,
    ) -> Result<HandleButtons, HardwareError> {
        let Some(raw) = raw else {
            return Ok(HandleButtons::default());
        };
        let mut taken = 0u8;
        let mut number = |name: &str, raw: Option<Spanned<u8>>| {
            let Some(raw) = raw else { return Ok(None) };
            let number = *raw.get_ref();
            let what = if !(1..=8).contains(&number) {
                format!("handle_buttons.{name} is {number}, allowed is 1 to 8")
            } else if taken & (1 << (number - 1)) != 0 {
                format!("handle_buttons.{name} is {number}, a button that has another role already")
            } else {
                taken |= 1 << (number - 1);
                return Ok(Some(number));
            };
            Err(self.error(raw.span().start, what))
        };
        Ok(HandleButtons {
            cut: number("cut", raw.cut)?,
            coagulate: number("coagulate", raw.coagulate)?,
            camera_lock: number("camera_lock", raw.camera_lock)?,
        })
    }

    pub(super) fn pedals(
        &self,
        first: Option<RawPedal>,
        second: Option<Spanned<RawPedal>>,
    ) -> Result<Option<PedalSpec>, HardwareError> {
        let Some(first) = first else {
            return match second {
                Some(second) => {
                    let what = "there is a [second_pedal] but no [pedal]: name it [pedal]";
                    Err(self.error(second.span().start, what.into()))
                }
                None => Ok(None),
            };
        };
        let mut spec = self.pedal(first)?;
        if let Some(second) = second {
            let at = second.span().start;
            let second = self.pedal(second.into_inner())?;
            if second.path == spec.path {
                let what = "[second_pedal] has the path of [pedal]: one device is one pedal";
                return Err(self.error(at, what.into()));
            }
            spec.second = Some(Box::new(second));
        }
        Ok(Some(spec))
    }

    fn pedal(&self, raw: RawPedal) -> Result<PedalSpec, HardwareError> {
        let keys = [&raw.cut_key, &raw.coagulate_key, &raw.camera_lock_key];
        for key in keys.into_iter().flatten() {
            let what = if raw.driver != RawPedalDriver::Evdev {
                "only a USB pedal (driver \"evdev\") has keys: remove the key, or correct the driver".to_owned()
            } else if *key.get_ref() > KEY_MAX {
                format!("the key is {}, allowed is 0 to {KEY_MAX}", key.get_ref())
            } else {
                continue;
            };
            return Err(self.error(key.span().start, what));
        }
        let driver = match raw.driver {
            RawPedalDriver::Rig => PedalDriver::Rig,
            RawPedalDriver::Modem => PedalDriver::Modem,
            RawPedalDriver::Evdev if keys.iter().all(|key| key.is_none()) => {
                PedalDriver::Evdev(Roles::default())
            }
            RawPedalDriver::Evdev => PedalDriver::Evdev(Roles {
                cut: raw.cut_key.map(Spanned::into_inner),
                coagulate: raw.coagulate_key.map(Spanned::into_inner),
                camera_lock: raw.camera_lock_key.map(Spanned::into_inner),
            }),
        };
        Ok(PedalSpec {
            driver,
            path: raw.path,
            second: None,
        })
    }
}
