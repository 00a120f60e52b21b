//! Materials of organs.

use shared_mem::scene::{MaterialRecord, OrganKind};

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
}

/// Viscosity of all tissue, Pa s. It damps vibration and not the swing of an organ as a whole.
const VISCOSITY_PA_S: f64 = 5.0;

impl Material {
    /// Typical values of this kind of tissue.
    ///
    /// Young's moduli follow from measured shear moduli (E = 3 G for a nearly incompressible
    /// tissue; collected in PMC6925591, Table 1): liver G 1.8 kPa, stomach 0.64 kPa, bile duct 166
    /// kPa, hepatic artery 210 kPa; fat 0.53 kPa (porcine; Sims 2010). A gallbladder is a stiff
    /// wall (G 85 kPa, 2 mm) around bile. A solid body that bends as much has a Young's modulus of
    /// about 15 kPa. Intestine, connective tissue and abdominal wall have no source: the first two
    /// are taken to lie between stomach and liver, the wall to be stiff. Poisson's ratio is 0.45
    /// for all, because the solver's linear tetrahedra lock above that. The paper gives no
    /// stiffness; the two shares here keep its method stable at 1 kHz.
    ///
    /// Toughness (measured values collected in 10.1186/s10033-022-00767-4, Table 2): liver 164 J/m²
    /// (needles in bovine liver, 10.1016/j.medengphy.2011.09.030), artery 1700 (aorta, trouser
    /// tear). Ducts are taken to be as tough as an artery; gallbladder, stomach and intestine as
    /// tough as other thin walls (amnion, 960 and more). Loose connective tissue has 75, because it
    /// takes 51 to 76 to peel the layers of an aorta apart (10.1115/1.2898733). No source fits fat
    /// and abdominal wall: loose fat parts under a probe, while subcutaneous fat with its septa
    /// bears 4100 and muscle 550 to 8000. A cut by a sharp blade takes less than a tear (aorta:
    /// 290). Here one value serves for both.
    ///
    /// Friction on steel: organs under their serous cover have 0.1. (A caecum that smooth jaws
    /// pinch with 22 N slips out at a pull of 5 N, 10.1007/s00464-003-9153-2; the inside of small
    /// bowel has 0.01 to 0.05, 10.1007/s11249-013-0167-1.) Tissue without a cover is taken to have
    /// 0.2 or 0.3 (bare muscle on bone: 0.3, 10.1115/1.4001893).
    #[must_use]
    pub fn typical(kind: OrganKind) -> Self {
        let (friction, toughness_j_m2) = match kind {
            OrganKind::Liver => (0.1, 164.0),
            OrganKind::Gallbladder | OrganKind::Stomach | OrganKind::Intestine => (0.1, 960.0),
            OrganKind::CysticDuct | OrganKind::BileDuct => (0.2, 1700.0),
            OrganKind::CysticArtery | OrganKind::Vessel => (0.2, 1700.0),
            OrganKind::Fat => (0.1, 150.0),
            OrganKind::ConnectiveTissue => (0.3, 75.0),
            OrganKind::AbdominalWall => (0.1, 2000.0),
        };
        // Tubes lie in fat and fluid, which damp them. Without damping, a tube would swing, because
        // it hardly resists bending.
        let damping_per_s = match kind {
            OrganKind::CysticDuct | OrganKind::BileDuct => 200.0,
            OrganKind::CysticArtery | OrganKind::Vessel => 200.0,
            _ => 4.0,
        };
        let (density_kg_m3, young_pa, contact_stiffness_n_m) = match kind {
            OrganKind::Liver => (1060.0, 5400.0, 120.0),
            OrganKind::Gallbladder => (1020.0, 15_000.0, 200.0),
            OrganKind::CysticDuct | OrganKind::BileDuct => (1040.0, 498_000.0, 350.0),
            OrganKind::CysticArtery | OrganKind::Vessel => (1060.0, 630_000.0, 350.0),
            OrganKind::Stomach => (1040.0, 1920.0, 150.0),
            OrganKind::Intestine => (1040.0, 3000.0, 120.0),
            OrganKind::Fat => (920.0, 1590.0, 80.0),
            OrganKind::ConnectiveTissue => (1000.0, 3000.0, 100.0),
            OrganKind::AbdominalWall => (1090.0, 20_000.0, 500.0),
        };
        Self {
            density_kg_m3,
            young_pa,
            poisson: 0.45,
            stretch_stiffness: 0.6,
            laplacian_stiffness: 0.1,
            damping_per_s,
            retardation_s: VISCOSITY_PA_S / young_pa,
            contact_stiffness_n_m,
            friction,
            toughness_j_m2,
        }
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
