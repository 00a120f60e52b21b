//! Volumes of the fluids.

/// Volumes of blood, bile and water.
pub type Volumes = [f64; 3];
/// Place of water in [`Volumes`].
pub(super) const WATER: usize = 2;
/// Volume of a parcel of the irrigator's water, m³.
pub(in crate::effects) const WATER_M3: f64 = 24e-9;
