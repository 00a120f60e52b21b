//! Materials of organs.

use shared_mem::scene::{MaterialRecord, OrganKind, RelaxationRecord};

use super::sourced::sourced;

/// A material: the tissue's SI values, and the two stiffnesses of the inner-sphere paper's method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Density, kg/m³.
    pub density_kg_m3: f64,
    /// Young's modulus, Pa.
    pub young_pa: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Share of a link's stretch that one iteration corrects (paper Eq. 4–5).
    pub stretch_stiffness: f64,
    /// Share of the way to a sphere's Laplacian target (paper Eq. 8) by which one iteration moves
    /// the sphere.
    pub laplacian_stiffness: f64,
    /// Rate at which the velocity decays, 1/s.
    pub damping_per_s: f64,
    /// Retardation time of the viscous damping: viscosity over Young's modulus, s.
    pub retardation_s: f64,
    /// Stiffness of a sphere's wall under a tool, N/m, in organs without a contact skin.
    pub contact_stiffness_n_m: f64,
    /// Coefficient of Coulomb friction on a moist steel tool.
    pub friction: f64,
    /// Energy of a tear or cut per area, J/m²; 0: the tissue does not tear.
    pub toughness_j_m2: f64,
    /// Share of its stress that held tissue loses, and the time constant, s, of two terms. By
    /// default tissue keeps its stress.
    pub relaxation: [[f64; 2]; 2],
}

/// The relaxation of tissue that keeps its stress.
pub(super) const KEEPS_STRESS: [[f64; 2]; 2] = [[0.0, 1.0]; 2];

impl Material {
    /// Typical values of this kind of tissue. [`sourced`] has the source of each.
    #[must_use]
    pub fn typical(kind: OrganKind) -> Self {
        let [
            density_kg_m3,
            young_pa,
            poisson,
            stretch_stiffness,
            laplacian_stiffness,
            damping_per_s,
            viscosity_pa_s,
            contact_stiffness_n_m,
            friction,
            toughness_j_m2,
        ] = sourced(kind).map(|it| it.value);
        Self {
            density_kg_m3,
            young_pa,
            poisson,
            stretch_stiffness,
            laplacian_stiffness,
            damping_per_s,
            retardation_s: viscosity_pa_s / young_pa,
            contact_stiffness_n_m,
            friction,
            toughness_j_m2,
            relaxation: KEEPS_STRESS,
        }
    }

    /// The compiled scene's record of the relaxation of organ number `organ`; `None` for tissue
    /// that keeps its stress.
    #[must_use]
    pub fn relaxation_record(&self, organ: u32) -> Option<RelaxationRecord> {
        let [[fast, fast_s], [slow, slow_s]] = self.relaxation;
        (fast > 0.0 || slow > 0.0).then(|| RelaxationRecord {
            organ,
            shares: [fast as f32, slow as f32],
            times_s: [fast_s as f32, slow_s as f32],
        })
    }

    /// Converts the material to the compiled scene's record.
    #[must_use]
    pub fn to_record(self) -> MaterialRecord {
        MaterialRecord {
            density_kg_m3: self.density_kg_m3 as f32,
            young_pa: self.young_pa as f32,
            poisson: self.poisson as f32,
            stretch_stiffness: self.stretch_stiffness as f32,
            laplacian_stiffness: self.laplacian_stiffness as f32,
            damping_per_s: self.damping_per_s as f32,
            contact_stiffness_n_m: self.contact_stiffness_n_m as f32,
            retardation_s: self.retardation_s as f32,
            friction: self.friction as f32,
            toughness_j_m2: self.toughness_j_m2 as f32,
        }
    }
}
