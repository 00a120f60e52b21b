//! The quality report: figures of the organs that were built and of their fit.

use std::fmt;

use serde::Serialize;

use crate::cells::Filling;
use crate::elastic;

/// Figures of the scene that [`crate::prepare()`] built. The figures outside of `organs` are the
/// sum, the mean or the worst value of all organs.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Report {
    /// The scene's name.
    pub scene: String,
    /// Time of the whole preparation, s.
    pub build_s: f64,
    /// Spheres of all organs.
    pub spheres: usize,
    /// Links of all organs.
    pub springs: usize,
    /// Tetrahedra between sphere centres, of all organs.
    pub tetrahedra: usize,
    /// Share of the organs' volume inside at least one sphere, 0..1.
    pub coverage: f64,
    /// Mean distance from skin to the nearest sphere, over the skin of all organs, mm.
    pub gap_mean_mm: f64,
    /// Distance from the nearest sphere within which 95 % of the worst organ's skin lies, mm.
    pub gap_95_mm: f64,
    /// Largest distance from the skin to the nearest sphere, mm.
    pub gap_max_mm: f64,
    /// Length by which the worst sphere sticks out of the skin, mm.
    pub protrusion_max_mm: f64,
    /// Number of connected pieces of the worst organ.
    pub components: usize,
    /// Fewest links of any sphere.
    pub min_degree: usize,
    /// Isotropy of the links' directions ([`OrganReport::isotropy`]), mean over all spheres, 0..1.
    pub isotropy: f64,
    /// Worst shape of a tetrahedron of any organ ([`OrganReport::tetra_shape_min`]).
    pub tetra_shape_min: Option<f64>,
    /// Volume inside the skins, mL.
    pub volume_ml: f64,
    /// Mass of all organs, g.
    pub mass_g: f64,
    /// Predicted time of a tick on one core while every organ is awake ([`crate::cost`]), µs.
    pub tick_us: f64,
    /// Figures of each organ.
    pub organs: Vec<OrganReport>,
    /// Pairs of organs that overlap at rest.
    pub overlaps: Vec<Overlap>,
    /// Faults of the scene that do not keep it from running, each with its remedy.
    pub warnings: Vec<String>,
}

/// Two organs that overlap at rest.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Overlap {
    /// Names of the two organs.
    pub organs: [String; 2],
    /// Place where the overlap is deepest, world frame, m.
    pub at_m: [f64; 3],
    /// Depth of the overlap at that place, mm.
    pub depth_mm: f64,
    /// Volume of the overlap, mL.
    pub volume_ml: f64,
    /// True if the recipe attaches one to the other: organs that are attached to each other may
    /// overlap.
    pub attached: bool,
}

impl fmt::Display for Overlap {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [one, other] = &self.organs;
        let [x, y, z] = self.at_m;
        write!(
            f,
            "'{one}' and '{other}' overlap by up to {:.1} mm, at [{x:.3}, {y:.3}, {z:.3}] m ({:.2} mL)",
            self.depth_mm, self.volume_ml
        )?;
        match self.attached {
            true => write!(f, "; they are attached to each other"),
            false => write!(f, "; part their meshes there, or attach one to the other"),
        }
    }
}

/// One organ's figures.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct OrganReport {
    /// The organ's name.
    pub name: String,
    /// Origin of its mesh and the repairs made to it.
    pub mesh: String,
    /// Vertices of the skin.
    pub vertices: usize,
    /// Triangles of the skin.
    pub triangles: usize,
    /// Time for the organ's surface, packing and skins, s.
    pub build_s: f64,
    /// Spheres.
    pub spheres: usize,
    /// Reason for this number of spheres.
    pub spheres_because: String,
    /// Number of held spheres: the constraints do not move them.
    pub held: usize,
    /// Number of the organ's spheres that its `attached` entries attach to other organs.
    pub attached: usize,
    /// Fit of the organ's cells, if it is layered tissue.
    pub cells: Option<Filling>,
    /// True for a tube: spheres in a row, and links along it.
    pub is_tube: bool,
    /// Links.
    pub springs: usize,
    /// Tetrahedra between sphere centres. Tissue outside all of them is counted with the nearest
    /// one.
    pub tetrahedra: usize,
    /// Worst shape of a tetrahedron: volume over the cube of the longest edge. A regular
    /// tetrahedron has 0.118, a sliver less than 0.015, an inverted one less than 0. `None` if
    /// there are no tetrahedra.
    pub tetra_shape_min: Option<f64>,
    /// Substeps of the organ in a tick, at most 16.
    pub substeps: u32,
    /// Stiffness number `E dt² / (ρ h²)`, with the substep `dt` and the spacing `h` of the spheres.
    /// A tube has its material's stiffness up to 2.4. Other links are softer by 3 % at 0.2, by 15 %
    /// at 0.7 and by a third at 2. Tetrahedra keep their material's stiffness. Beyond 0.6, a
    /// tetrahedron may invert when it is squeezed to less than half its height.
    pub stiffness_number: f64,
    /// Share of the volume inside at least one sphere, 0..1.
    pub coverage: f64,
    /// Mean distance from skin to the nearest sphere, mm.
    pub gap_mean_mm: f64,
    /// Distance from the nearest sphere within which 95 % of the skin lies, mm.
    pub gap_95_mm: f64,
    /// Largest distance from the skin to the nearest sphere, mm.
    pub gap_max_mm: f64,
    /// Length by which the worst sphere sticks out of the skin, mm.
    pub protrusion_max_mm: f64,
    /// Number of pieces that the links leave separate.
    pub components: usize,
    /// Fewest links of any sphere.
    pub min_degree: usize,
    /// Isotropy of the links' directions: λmin/λmax of Σddᵀ over the unit directions `d` of a
    /// sphere's links, mean over the spheres, 0..1.
    pub isotropy: f64,
    /// Area of the skin, cm².
    pub skin_cm2: f64,
    /// Volume inside the skin, mL.
    pub volume_ml: f64,
    /// Mass, g.
    pub mass_g: f64,
}

impl Report {
    /// Sums up the organs' figures.
    pub(crate) fn sum_up(&mut self) {
        let organs = &self.organs;
        let worst = |get: fn(&OrganReport) -> f64| organs.iter().map(get).fold(0.0, f64::max);
        self.spheres = organs.iter().map(|o| o.spheres).sum();
        self.springs = organs.iter().map(|o| o.springs).sum();
        self.tetrahedra = organs.iter().map(|o| o.tetrahedra).sum();
        self.volume_ml = organs.iter().map(|o| o.volume_ml).sum();
        self.mass_g = organs.iter().map(|o| o.mass_g).sum();
        let mean = |value: fn(&OrganReport) -> f64, weight: fn(&OrganReport) -> f64| {
            let total: f64 = organs.iter().map(weight).sum();
            let sum: f64 = organs.iter().map(|o| value(o) * weight(o)).sum();
            if total > 0.0 { sum / total } else { 0.0 }
        };
        self.coverage = mean(|o| o.coverage, |o| o.volume_ml);
        self.gap_mean_mm = mean(|o| o.gap_mean_mm, |o| o.skin_cm2);
        self.isotropy = mean(|o| o.isotropy, |o| o.spheres as f64);
        self.tetra_shape_min = organs
            .iter()
            .filter_map(|o| o.tetra_shape_min)
            .reduce(f64::min);
        self.gap_95_mm = worst(|o| o.gap_95_mm);
        self.gap_max_mm = worst(|o| o.gap_max_mm);
        self.protrusion_max_mm = worst(|o| o.protrusion_max_mm);
        self.components = organs.iter().map(|o| o.components).max().unwrap_or(0);
        self.min_degree = organs.iter().map(|o| o.min_degree).min().unwrap_or(0);
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: built in {:.2} s", self.scene, self.build_s)?;
        writeln!(
            f,
            "{:<14}{:>8}{:>8}{:>7}{:>8}{:>7}{:>8}{:>9}{:>9}{:>9}{:>7}{:>6}{:>6}{:>9}{:>8}",
            "organ",
            "spheres",
            "springs",
            "tetra",
            "cover",
            "gap95",
            "gap max",
            "outside",
            "isotropy",
            "pieces",
            "degree",
            "held",
            "tied",
            "volume",
            "time"
        )?;
        for o in &self.organs {
            writeln!(
                f,
                "{:<14}{:>8}{:>8}{:>7}{:>6.1} %{:>5.1}mm{:>6.1}mm{:>7.2}mm{:>9.2}{:>9}{:>7}{:>6}{:>6}{:>7.1}mL{:>7.2}s",
                o.name,
                o.spheres,
                o.springs,
                o.tetrahedra,
                100.0 * o.coverage,
                o.gap_95_mm,
                o.gap_max_mm,
                o.protrusion_max_mm,
                o.isotropy,
                o.components,
                o.min_degree,
                o.held,
                o.attached,
                o.volume_ml,
                o.build_s
            )?;
        }
        writeln!(
            f,
            "{:<14}{:>8}{:>8}{:>7}{:>6.1} %{:>5.1}mm{:>6.1}mm{:>7.2}mm{:>9.2}{:>9}{:>7}{:>6}{:>6}{:>7.1}mL{:>7.2}s",
            "all",
            self.spheres,
            self.springs,
            self.tetrahedra,
            100.0 * self.coverage,
            self.gap_95_mm,
            self.gap_max_mm,
            self.protrusion_max_mm,
            self.isotropy,
            self.components,
            self.min_degree,
            self.organs.iter().map(|o| o.held).sum::<usize>(),
            self.organs.iter().map(|o| o.attached).sum::<usize>(),
            self.volume_ml,
            self.build_s
        )?;
        if let Some(shape) = self.tetra_shape_min {
            writeln!(
                f,
                "worst tetrahedron: V/L³ = {shape:.4} (regular 0.118, sliver below 0.015, inverted below 0); \
                 mass {:.0} g",
                self.mass_g
            )?;
        }
        writeln!(
            f,
            "tick: about {:.0} µs on one core of {}, every organ awake",
            self.tick_us,
            crate::cost::MACHINE
        )?;
        for overlap in &self.overlaps {
            let note = if overlap.attached { "note" } else { "warning" };
            writeln!(f, "{note}: {overlap}")?;
        }
        for warning in &self.warnings {
            writeln!(f, "warning: {warning}")?;
        }
        for o in &self.organs {
            writeln!(
                f,
                "{}: {} vertices, {} triangles; {}; {} spheres: {}",
                o.name, o.vertices, o.triangles, o.mesh, o.spheres, o.spheres_because
            )?;
            if let Some(cells) = &o.cells {
                writeln!(
                    f,
                    "{}: {} cells have {:.1} % of its volume and cover {:.1} % of it; worst shape {:.3} \
                     (a box 1, flat 0)",
                    o.name,
                    cells.cells,
                    100.0 * cells.volume_share,
                    100.0 * cells.covered,
                    cells.shape_min
                )?;
            }
            if let Some((number_max, fault)) = o.too_stiff() {
                writeln!(
                    f,
                    "warning: {}: {fault}: its stiffness number is {:.2} in {} substeps a tick, \
                     allowed is at most {number_max}; use fewer spheres or a softer material",
                    o.name, o.stiffness_number, o.substeps
                )?;
            }
        }
        Ok(())
    }
}

impl OrganReport {
    /// If the organ's stiffness number is too large: the largest allowed number and the
    /// consequence.
    fn too_stiff(&self) -> Option<(f64, String)> {
        let (number_max, fault) = match self.tetrahedra {
            0 if self.is_tube => (
                elastic::TUBE_STIFFNESS_NUMBER_MAX,
                format!(
                    "it is softer than its material, by about {:.0} %",
                    100.0 * self.missing()
                ),
            ),
            0 => (
                elastic::STIFFNESS_NUMBER_MAX,
                "it is softer than its material".to_owned(),
            ),
            _ => (
                elastic::TETRA_STIFFNESS_NUMBER_MAX,
                "strong compression, to less than half its height, may invert it".to_owned(),
            ),
        };
        (self.stiffness_number > number_max).then_some((number_max, fault))
    }

    /// Share of its material's stiffness that a tube beyond its largest number lacks. 3 % at that
    /// number.
    fn missing(&self) -> f64 {
        (1.0 - elastic::TUBE_STIFFNESS_LIMIT / self.stiffness_number).max(0.03)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_warned_of_from_0_2_tubes_from_2_4_and_tetrahedra_from_0_6() {
        let told = |tetrahedra, is_tube, stiffness_number| {
            let organ = OrganReport {
                is_tube,
                name: "liver".to_owned(),
                tetrahedra,
                stiffness_number,
                substeps: 16,
                ..OrganReport::default()
            };
            let report = Report {
                organs: vec![organ],
                ..Report::default()
            };
            report.to_string()
        };
        let words = |tetrahedra, stiffness_number| told(tetrahedra, false, stiffness_number);
        for (tetrahedra, number) in [(0, 0.2), (1, 0.3), (1, 0.6)] {
            let said = words(tetrahedra, number);
            assert!(!said.contains("stiffness number"), "{said}");
        }
        let soft = words(0, 0.21);
        assert!(
            soft.contains("liver: it is softer than its material"),
            "{soft}"
        );
        assert!(
            soft.contains("0.21 in 16 substeps a tick, allowed is at most 0.2;"),
            "{soft}"
        );
        let squeezed = words(1, 0.61);
        assert!(squeezed.contains("may invert it"), "{squeezed}");
        assert!(squeezed.contains("allowed is at most 0.6;"), "{squeezed}");
        assert!(!squeezed.contains("softer than"), "{squeezed}");
        assert!(!told(0, true, 2.4).contains("softer than"));
        for (number, lacks) in [(2.41, "by about 3 %"), (10.0, "by about 75 %")] {
            let tube = told(0, true, number);
            assert!(tube.contains(lacks), "{tube}");
            assert!(tube.contains("allowed is at most 2.4;"), "{tube}");
        }
    }
}
