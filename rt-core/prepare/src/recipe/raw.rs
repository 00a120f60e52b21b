//! The recipe as it is written, before it is checked.

use serde::Deserialize;

use super::{Attached, Axes, Closing, Layers, Packing, Pieces, Place, Region, Unit};
use crate::shape::Anatomy;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RecipeRaw {
    pub(super) name: String,
    pub(super) tick_us: Option<f64>,
    #[serde(default)]
    pub(super) room: RoomRaw,
    #[serde(default)]
    pub(super) anatomy: Anatomy,
    #[serde(default)]
    pub(super) organ: Vec<OrganRaw>,
    #[serde(default)]
    pub(super) suture: Vec<TieRaw>,
    #[serde(default)]
    pub(super) band: Vec<TieRaw>,
    pub(super) stones: Option<StonesRaw>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StonesRaw {
    pub(super) count: u32,
    pub(super) diameter_mm: f64,
    pub(super) room_ml: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TieRaw {
    pub(super) from: Place,
    pub(super) to: Place,
    pub(super) length_mm: Option<f64>,
    pub(super) drawn_mm: Option<f64>,
    pub(super) stiffness_n_m: Option<f64>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct RoomRaw {
    pub(super) gravity_m_s2: Option<[f64; 3]>,
    pub(super) instrument_port_m: Option<[f64; 3]>,
    pub(super) instrument_length_m: Option<f64>,
    pub(super) endoscope_port_m: Option<[f64; 3]>,
    pub(super) look_at_m: Option<[f64; 3]>,
    pub(super) camera_distance_m: Option<f64>,
    pub(super) breath_s: Option<f64>,
    pub(super) trocar: Option<TrocarRaw>,
    pub(super) up: Option<[f64; 3]>,
    pub(super) device: Option<FrameRaw>,
    pub(super) tracker: Option<FrameRaw>,
    pub(super) target: Option<TargetRaw>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct TrocarRaw {
    pub(super) sliding_n: f64,
    pub(super) breakaway_n: Option<f64>,
    pub(super) wall_nm_rad: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FrameRaw {
    pub(super) position_m: [f64; 3],
    pub(super) orientation: [f64; 4],
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TargetRaw {
    pub(super) organ: String,
    pub(super) near_m: Option<[f64; 3]>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OrganRaw {
    pub(super) name: String,
    pub(super) kind: String,
    pub(super) mesh: Option<String>,
    #[serde(default)]
    pub(super) parts: Vec<String>,
    pub(super) unit: Option<Unit>,
    pub(super) scale: Option<f64>,
    #[serde(default)]
    pub(super) axes: Axes,
    pub(super) shape: Option<toml::Table>,
    pub(super) closing: Option<Closing>,
    pub(super) pieces: Option<Pieces>,
    pub(super) spheres: Option<usize>,
    pub(super) gap_95_mm: Option<f64>,
    #[serde(default)]
    pub(super) coarser: Vec<usize>,
    pub(super) packing: Option<Packing>,
    pub(super) gravity_share: Option<f64>,
    pub(super) breath_mm: Option<[f64; 3]>,
    #[serde(default)]
    pub(super) material: MaterialRaw,
    #[serde(default)]
    pub(super) held: Vec<Region>,
    #[serde(default)]
    pub(super) attached: Vec<Attached>,
    pub(super) layers: Option<Layers>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(super) struct MaterialRaw {
    pub(super) density_kg_m3: Option<f64>,
    pub(super) young_pa: Option<f64>,
    pub(super) poisson: Option<f64>,
    pub(super) stretch_stiffness: Option<f64>,
    pub(super) laplacian_stiffness: Option<f64>,
    pub(super) damping_per_s: Option<f64>,
    pub(super) retardation_s: Option<f64>,
    pub(super) contact_stiffness_n_m: Option<f64>,
    pub(super) friction: Option<f64>,
    pub(super) toughness_j_m2: Option<f64>,
}
