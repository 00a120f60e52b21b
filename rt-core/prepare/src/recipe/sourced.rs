//! Values of materials, each with its source. A value that nobody has measured says "assumed".
//!
//! Young's moduli follow from measured shear moduli: `E = 3 G` for a nearly incompressible tissue.
//! A cut by a sharp blade takes less energy than a tear (aorta: 290 J/m²). Here one value serves
//! for both.

use shared_mem::scene::OrganKind::{
    self, AbdominalWall, BileDuct, ConnectiveTissue, CysticArtery, CysticDuct, Fat, Gallbladder,
    Intestine, Liver, Stomach, Vessel,
};

/// A value and its source: a publication, or "assumed" with the reason.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sourced {
    /// Name of the value in a recipe. Viscosity, in Pa s, has no name there.
    pub name: &'static str,
    /// The value, SI.
    pub value: f64,
    /// Publication, or "assumed: " and the reason.
    pub source: &'static str,
}

/// Number of sourced values of a material.
const COUNT: usize = 10;

/// Every value of the material of this kind of tissue.
#[must_use]
pub fn sourced(kind: OrganKind) -> [Sourced; COUNT] {
    [
        density(kind),
        young(kind),
        of(
            "poisson",
            (0.45, "assumed: the solver's linear tetrahedra lock above"),
        ),
        of(
            "stretch_stiffness",
            (0.6, "assumed: the paper gives none; stable at 1 kHz"),
        ),
        of(
            "laplacian_stiffness",
            (0.1, "assumed: the paper gives none; stable at 1 kHz"),
        ),
        damping(kind),
        of(
            "viscosity",
            (5.0, "assumed: damps vibration, not the swing of an organ"),
        ),
        contact_stiffness(kind),
        friction(kind),
        toughness(kind),
    ]
}

const fn of(name: &'static str, (value, source): (f64, &'static str)) -> Sourced {
    Sourced {
        name,
        value,
        source,
    }
}

fn density(kind: OrganKind) -> Sourced {
    let value = match kind {
        Gallbladder => 1020.0,
        CysticDuct | BileDuct | Stomach | Intestine => 1040.0,
        Liver | CysticArtery | Vessel => 1060.0,
        Fat => 920.0,
        ConnectiveTissue => 1000.0,
        AbdominalWall => 1090.0,
    };
    of("density_kg_m3", (value, "assumed: near that of water"))
}

fn young(kind: OrganKind) -> Sourced {
    let found = match kind {
        Liver => (5400.0, "G 1.8 kPa: PMC6925591, Table 1"),
        Gallbladder => (
            15_000.0,
            "assumed: bends as a wall of 2 mm around bile; wall G 85 kPa: PMC6925591, Table 1",
        ),
        CysticDuct | BileDuct => (498_000.0, "bile duct G 166 kPa: PMC6925591, Table 1"),
        CysticArtery | Vessel => (630_000.0, "hepatic artery G 210 kPa: PMC6925591, Table 1"),
        Stomach => (1920.0, "G 0.64 kPa: PMC6925591, Table 1"),
        Intestine => (3000.0, "assumed: between stomach and liver"),
        Fat => (1590.0, "porcine G 0.53 kPa: Sims 2010"),
        ConnectiveTissue => (3000.0, "assumed: between stomach and liver"),
        AbdominalWall => (20_000.0, "assumed: stiff"),
    };
    of("young_pa", found)
}

fn damping(kind: OrganKind) -> Sourced {
    let found = match kind {
        CysticDuct | BileDuct | CysticArtery | Vessel => (
            200.0,
            "assumed: a tube hardly resists bending and would swing; fat and fluid damp it",
        ),
        _ => (4.0, "assumed: an organ that is let go comes to rest"),
    };
    of("damping_per_s", found)
}

fn contact_stiffness(kind: OrganKind) -> Sourced {
    let value = match kind {
        Liver | Intestine => 120.0,
        Gallbladder => 200.0,
        CysticDuct | BileDuct | CysticArtery | Vessel => 350.0,
        Stomach => 150.0,
        Fat => 80.0,
        ConnectiveTissue => 100.0,
        AbdominalWall => 500.0,
    };
    of(
        "contact_stiffness_n_m",
        (value, "assumed: stiffer where the tissue is stiffer"),
    )
}

fn friction(kind: OrganKind) -> Sourced {
    let found = match kind {
        // A caecum that smooth jaws pinch with 22 N slips out at a pull of 5 N. The inside of small
        // bowel has 0.01 to 0.05 (10.1007/s11249-013-0167-1).
        Liver | Gallbladder | Stomach | Intestine => {
            (0.1, "serous cover of caecum: 10.1007/s00464-003-9153-2")
        }
        Fat | AbdominalWall => (0.1, "assumed: as an organ under its serous cover"),
        CysticDuct | BileDuct | CysticArtery | Vessel => (0.2, "assumed: between cover and muscle"),
        ConnectiveTissue => (0.3, "assumed: as bare muscle on bone, 10.1115/1.4001893"),
    };
    of("friction", found)
}

fn toughness(kind: OrganKind) -> Sourced {
    let found = match kind {
        Liver => (
            164.0,
            "needles in bovine liver: 10.1016/j.medengphy.2011.09.030",
        ),
        Gallbladder | Stomach | Intestine => (
            960.0,
            "assumed: as amnion, another thin wall, 10.1186/s10033-022-00767-4",
        ),
        CysticDuct | BileDuct => (1700.0, "assumed: as tough as an artery"),
        CysticArtery | Vessel => (1700.0, "trouser tear of aorta: 10.1186/s10033-022-00767-4"),
        // Subcutaneous fat with its septa bears 4100 J/m².
        Fat => (150.0, "assumed: loose fat parts under a probe"),
        ConnectiveTissue => (75.0, "layers of an aorta, 51 to 76: 10.1115/1.2898733"),
        // Muscle bears 550 to 8000 J/m².
        AbdominalWall => (2000.0, "assumed: within the range of muscle"),
    };
    of("toughness_j_m2", found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recipe::{BUILT_IN, Material, TRIANGLE};

    /// True if a text names a publication: a DOI, a number of PubMed, or an author and a year.
    fn names_a_publication(text: &str) -> bool {
        let is_year = |word: &str| {
            let digits = word.trim_end_matches([',', ':', '.']);
            digits
                .parse()
                .is_ok_and(|year| (1900..2100).contains(&year))
        };
        text.contains("PMC") || text.contains("10.1") || text.split(' ').any(is_year)
    }

    fn has_source(text: &str) -> bool {
        text.starts_with("assumed: ") || names_a_publication(text)
    }

    #[test]
    fn every_value_has_a_source_or_says_assumed() {
        for kind in OrganKind::ALL {
            for it in sourced(kind) {
                assert!(has_source(it.source), "{kind:?}: {it:?}");
                assert!(it.value.is_finite() && it.value > 0.0, "{kind:?}: {it:?}");
            }
        }
        assert!(!has_source("measured somewhere") && !has_source("assumed"));
        assert!(has_source("Sims 2010") && has_source("PMC1: 3 kPa"));
    }

    #[test]
    fn a_material_consists_of_sourced_values() {
        for kind in OrganKind::ALL {
            let material = Material::typical(kind);
            let own = [
                material.density_kg_m3,
                material.young_pa,
                material.poisson,
                material.stretch_stiffness,
                material.laplacian_stiffness,
                material.damping_per_s,
                material.retardation_s * material.young_pa,
                material.contact_stiffness_n_m,
                material.friction,
                material.toughness_j_m2,
            ];
            for (own, it) in own.iter().zip(sourced(kind)) {
                assert!((own / it.value - 1.0).abs() < 1e-12, "{kind:?}: {it:?}");
            }
        }
    }

    /// Lines of a recipe that set a value of a material without its source in a comment.
    fn unsourced(recipe: &str) -> Vec<&str> {
        let names = sourced(Liver).map(|it| it.name);
        let sets = |code: &str| {
            let mut words = code.split(|c: char| !c.is_alphanumeric() && c != '_');
            words.any(|word| names.contains(&word) || word == "retardation_s")
        };
        let is_bare = |line: &&str| {
            let (code, comment) = line.split_once('#').unwrap_or((line, ""));
            sets(code) && !has_source(comment.trim())
        };
        recipe.lines().filter(is_bare).collect()
    }

    #[test]
    fn built_in_recipes_set_no_value_without_a_source() {
        for recipe in [BUILT_IN, TRIANGLE] {
            assert_eq!(unsourced(recipe), [""; 0]);
        }
        let bare = "material = { young_pa = 4000.0 }";
        assert_eq!(unsourced(bare), [bare]);
        assert!(unsourced("material = { young_pa = 4e3 } # assumed: soft").is_empty());
        assert!(unsourced("young_pa = 4e3 # Sims 2010").is_empty());
    }
}
