//! The section `[tracker]`.

use std::path::PathBuf;

use serde::Deserialize;
use toml::Spanned;

use super::File;
use crate::HardwareError;
use crate::bird::BirdSetup;
use crate::bird::wire::{Hemisphere, Scale};
use crate::station::{TrackerDriver, TrackerSpec};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawTracker {
    driver: RawTrackerDriver,
    path: PathBuf,
    hemisphere: Option<RawHemisphere>,
    full_scale_in: Option<Spanned<u8>>,
    birds: Option<Spanned<u8>>,
    bird: Option<Spanned<u8>>,
    filter_rest_hz: Option<Spanned<f32>>,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum RawTrackerDriver {
    Bird,
    Trakstar,
}

#[derive(Deserialize)]
#[serde(rename_all = "lowercase")]
enum RawHemisphere {
    Forward,
    Aft,
    Right,
    Left,
    Lower,
    Upper,
}

impl File<'_> {
    pub(super) fn tracker(&self, raw: RawTracker) -> Result<TrackerSpec, HardwareError> {
        let scale = match raw.full_scale_in.as_ref().map(|scale| *scale.get_ref()) {
            None | Some(36) => Scale::Inches36,
            Some(72) => Scale::Inches72,
            Some(other) => {
                let at = raw.full_scale_in.map_or(0, |scale| scale.span().start);
                let what = format!("full_scale_in is {other}, allowed is 36 or 72");
                return Err(self.error(at, what));
            }
        };
        let number = |name: &str, value: &Option<Spanned<u8>>, most: u8| match value {
            None => Ok(1),
            Some(value) if (1..=most).contains(value.get_ref()) => Ok(*value.get_ref()),
            Some(value) => {
                let what = format!("{name} is {}, allowed is 1 to {most}", value.get_ref());
                Err(self.error(value.span().start, what))
            }
        };
        let birds = number("birds", &raw.birds, 14)?;
        Ok(TrackerSpec {
            driver: match raw.driver {
                RawTrackerDriver::Bird => TrackerDriver::Bird,
                RawTrackerDriver::Trakstar => TrackerDriver::Trakstar,
            },
            path: raw.path,
            setup: BirdSetup {
                hemisphere: match raw.hemisphere {
                    Some(RawHemisphere::Forward) => Hemisphere::Forward,
                    Some(RawHemisphere::Aft) => Hemisphere::Aft,
                    Some(RawHemisphere::Right) => Hemisphere::Right,
                    Some(RawHemisphere::Left) => Hemisphere::Left,
                    Some(RawHemisphere::Lower) => Hemisphere::Lower,
                    Some(RawHemisphere::Upper) | None => Hemisphere::Upper,
                },
                scale,
                birds,
                bird: number("bird", &raw.bird, birds)?,
                filter_rest_hz: self
                    .within("filter_rest_hz", "Hz", raw.filter_rest_hz, 0.0..=50.0)?
                    .unwrap_or(BirdSetup::default().filter_rest_hz),
            },
        })
    }
}
