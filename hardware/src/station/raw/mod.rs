//! The station file as written, and its checks.

mod centre;
mod haptic;
mod pedal;
mod places;
mod tracker;

use std::ops::RangeInclusive;
use std::path::Path;

use centre::RawCentre;
use haptic::RawHaptic;
use pedal::{RawHandleButtons, RawPedal};
use places::{RawFrames, RawLandmark, RawPorts, RawTrocar};
use serde::Deserialize;
use toml::Spanned;
use tracker::RawTracker;

use super::StationFile;
use crate::HardwareError;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    haptic: Option<RawHaptic>,
    tracker: Option<RawTracker>,
    pedal: Option<RawPedal>,
    second_pedal: Option<Spanned<RawPedal>>,
    handle_buttons: Option<RawHandleButtons>,
    ports: Option<RawPorts>,
    frames: Option<RawFrames>,
    #[serde(default)]
    landmarks: Vec<RawLandmark>,
    centre: Option<RawCentre>,
}

/// Text and path of the file, for errors.
struct File<'a> {
    text: &'a str,
    path: &'a Path,
}

impl File<'_> {
    fn error(&self, at: usize, what: String) -> HardwareError {
        let before = self.text.get(..at).unwrap_or(self.text);
        let line = before.matches('\n').count() + 1;
        HardwareError::Station {
            path: self.path.to_path_buf(),
            line,
            what,
        }
    }

    fn within(
        &self,
        name: &str,
        unit: &str,
        value: Option<Spanned<f32>>,
        allowed: RangeInclusive<f32>,
    ) -> Result<Option<f32>, HardwareError> {
        let Some(value) = value else { return Ok(None) };
        let number = *value.get_ref();
        if allowed.contains(&number) {
            return Ok(Some(number));
        }
        let (low, high) = (allowed.start(), allowed.end());
        let what = format!("{name} is {number} {unit}, allowed is {low} to {high} {unit}");
        Err(self.error(value.span().start, what))
    }
}

pub(super) fn parse(text: &str, path: &Path) -> Result<StationFile, HardwareError> {
    let file = File { text, path };
    let raw: Raw = toml::from_str(text).map_err(|error| {
        let at = error.span().map_or(0, |span| span.start);
        file.error(at, error.message().to_owned())
    })?;
    let (device, tracker) = raw.frames.map_or((None, None), |frames| {
        (frames.world_from_device, frames.world_from_tracker)
    });
    let (instrument, endoscope, trocar) = raw.ports.map_or((None, None, None), |ports| {
        (ports.instrument_m, ports.endoscope_m, ports.trocar)
    });
    let port = |name, raw: Option<Spanned<[f32; 3]>>| {
        raw.map(|place| file.place(name, &place)).transpose()
    };
    Ok(StationFile {
        haptic: raw.haptic.map(|haptic| file.haptic(haptic)).transpose()?,
        tracker: raw
            .tracker
            .map(|tracker| file.tracker(tracker))
            .transpose()?,
        pedal: file.pedals(raw.pedal, raw.second_pedal)?,
        handle_buttons: file.handle_buttons(raw.handle_buttons)?,
        world_from_device: file.pose("world_from_device", device)?,
        world_from_tracker: file.pose("world_from_tracker", tracker)?,
        instrument_port_m: port("ports.instrument_m", instrument)?,
        endoscope_port_m: port("ports.endoscope_m", endoscope)?,
        trocar: RawTrocar::choice(trocar),
        landmarks: file.landmarks(raw.landmarks)?,
        centre: raw.centre.map(|centre| file.centre(centre)).transpose()?,
    })
}

#[cfg(test)]
mod tests;
