//! The sections with positions and frames: `[frames]`, `[ports]` and `[[landmarks]]`.

use nalgebra::{Quaternion, UnitQuaternion};
use rt_core::math::{Pose, Vec3};
use rt_core::scene::TrocarChoice;
use serde::Deserialize;
use toml::Spanned;

use super::File;
use crate::HardwareError;
use crate::station::Landmark;

/// Largest coordinate of a position in a station, m.
const ROOM_M: f32 = 5.0;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawFrames {
    pub(super) world_from_device: Option<RawPose>,
    pub(super) world_from_tracker: Option<RawPose>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPose {
    position_m: Spanned<[f32; 3]>,
    rotation_xyzw: Spanned<[f32; 4]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawPorts {
    pub(super) instrument_m: Option<Spanned<[f32; 3]>>,
    pub(super) endoscope_m: Option<Spanned<[f32; 3]>>,
    pub(super) trocar: Option<RawTrocar>,
}

/// The instrument's trocar.
#[derive(Deserialize, Clone, Copy)]
#[serde(rename_all = "lowercase")]
pub(super) enum RawTrocar {
    Real,
    Dry,
    Wet,
}

impl RawTrocar {
    pub(super) const fn choice(raw: Option<Self>) -> TrocarChoice {
        match raw {
            None => TrocarChoice::Scene,
            Some(Self::Real) => TrocarChoice::Real,
            Some(Self::Dry) => TrocarChoice::Dry,
            Some(Self::Wet) => TrocarChoice::Wet,
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawLandmark {
    name: String,
    position_m: Spanned<[f32; 3]>,
}

impl File<'_> {
    /// Position of the entry `name`, if no coordinate exceeds `ROOM_M`.
    pub(super) fn place(&self, name: &str, raw: &Spanned<[f32; 3]>) -> Result<Vec3, HardwareError> {
        let position = Vec3::from(*raw.get_ref());
        if position
            .iter()
            .all(|part| (-ROOM_M..=ROOM_M).contains(part))
        {
            return Ok(position);
        }
        let [x, y, z] = *raw.get_ref();
        let what = format!(
            "{name} is {x}, {y}, {z}, allowed is -{ROOM_M} to {ROOM_M} m along each axis. Is it in metres?"
        );
        Err(self.error(raw.span().start, what))
    }

    pub(super) fn landmarks(&self, raw: Vec<RawLandmark>) -> Result<Vec<Landmark>, HardwareError> {
        let landmark = |raw: RawLandmark| {
            let position_m = self.place("landmarks.position_m", &raw.position_m)?;
            let name = raw.name;
            Ok(Landmark { name, position_m })
        };
        raw.into_iter().map(landmark).collect()
    }

    pub(super) fn pose(
        &self,
        name: &str,
        raw: Option<RawPose>,
    ) -> Result<Option<Pose>, HardwareError> {
        let Some(raw) = raw else { return Ok(None) };
        let position = self.place(&format!("{name}.position_m"), &raw.position_m)?;
        let [x, y, z, w] = *raw.rotation_xyzw.get_ref();
        let quaternion = Quaternion::new(w, x, y, z);
        let norm = quaternion.norm();
        if !(0.99..=1.01).contains(&norm) {
            let what = format!(
                "{name}.rotation_xyzw has length {norm}, allowed is 0.99 to 1.01: a unit quaternion"
            );
            return Err(self.error(raw.rotation_xyzw.span().start, what));
        }
        let rotation = UnitQuaternion::new_normalize(quaternion);
        Ok(Some(Pose::from_parts(position.into(), rotation)))
    }
}
