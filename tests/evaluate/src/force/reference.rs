//! Force over depth by finite elements, on two meshes.

use std::path::Path;

use fem_reference::{Hold, Material, Mesh as Solid, Problem, Tool};
use nalgebra::Vector3;
use scene_prepare::field::{Field, Grid, Nearest, Sign};
use scene_prepare::mesh::Mesh;

use super::case::{Case, Placed, Shaped};
use super::curve::{Curve, DEPTHS_MM};
use super::kept::{found, keep};
use super::wrench::Wrench;
use crate::body::Tissue;
use crate::focus::{Focus, ON_PLANE_M, fill};

type Point = Vector3<f64>;

/// The greatest depth, m.
const DEEPEST_M: f64 = DEPTHS_MM[DEPTHS_MM.len() - 1] * 1e-3;

/// Edge of the cubes in the contact as a share of the contact's radius, on the finer mesh. Elements
/// are shorter than their cube: their edges are about a third of the radius. The coarser mesh has
/// elements [`COARSER`] times as large everywhere.
const SHARE: f64 = 0.37;
/// [`SHARE`] under a tool that touches along a line. The force hardly changes along the tool, and
/// with elements of a third of the radius the mesh would be too large to solve.
const LINE_SHARE: f64 = 0.6;
const COARSER: f64 = 1.5;
/// Size of elements far from the tool, as a share of the organ's smallest extent.
const LARGEST: f64 = 0.2;
/// A curve ends at the depth after which the solver needs load steps smaller than this share of the
/// next depth's load.
const SMALLEST_STEP: f64 = 1.0 / 16.0;
/// Version of the mesher that makes the meshes now. Versions 1 to 3 made elements as large as the
/// contact, which are too stiff at small depths.
const MESHER: usize = 4;
/// Version that marks references of [`Meshes::Large`], because version 3 had elements of that size.
const LARGE_MESHER: usize = 3;

/// Largest difference between the forces on two meshes of [`Meshes::Large`], %. The ends of open
/// jaws slip between such elements; there the forces differ by 100 %.
const LARGE_DOUBT_MAX_PCT: f64 = 12.0;

/// Meshes on which a reference is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Meshes {
    /// Elements of a third of the contact's radius, larger under a line contact. Solving takes
    /// minutes to hours.
    Fine,
    /// Elements about as large as the contact. Solving takes minutes.
    Large,
    /// Elements so large that the results are coarse. Solving takes seconds.
    Quick,
}

impl Meshes {
    /// Size of the elements of the finer mesh, as a multiple of that in [`Meshes::Fine`].
    const fn larger(self) -> f64 {
        match self {
            Self::Fine => 1.0,
            Self::Large => 1.6,
            Self::Quick => 2.5,
        }
    }

    const fn mesher(self) -> usize {
        match self {
            Self::Large => LARGE_MESHER,
            Self::Fine | Self::Quick => MESHER,
        }
    }

    /// True if this stored reference need not be solved again.
    fn is_met_by(self, found: &Curve) -> bool {
        found.mesher == MESHER || self == Self::Large && found.has_torque()
    }
}

/// The curve of a case. It is read from `folder` or from the repository if the current mesher made
/// its meshes, or any mesher if `any_mesher`. Otherwise it is solved and stored in `folder`.
///
/// # Errors
/// The reason in words.
pub(crate) fn curve(
    case: &Case,
    folder: &Path,
    meshes: Meshes,
    any_mesher: bool,
) -> Result<Curve, String> {
    let quick = meshes == Meshes::Quick;
    let is_enough = |found: &Curve| any_mesher || meshes.is_met_by(found);
    if let Some(curve) = found(case, folder, quick).filter(is_enough) {
        return Ok(curve);
    }
    let setup = Setup::new(case)?;
    let finer = meshes.larger();
    let (coarse_nodes, coarse) = setup.solve(COARSER * finer)?;
    let (nodes, fine) = setup.solve(finer)?;
    let curve = Curve {
        fine,
        coarse,
        nodes: [coarse_nodes, nodes],
        mesher: meshes.mesher(),
    };
    let doubt_pct = curve.doubt_pct();
    if meshes == Meshes::Large && doubt_pct > LARGE_DOUBT_MAX_PCT {
        return Err(format!(
            "{}: the forces on its two meshes differ by {doubt_pct:.0} %, allowed is \
             {LARGE_DOUBT_MAX_PCT:.0} %: elements of --large are too large for this tool",
            case.name()
        ));
    }
    keep(case, &curve, folder, quick)?;
    Ok(curve)
}

/// A case, ready to be meshed and solved.
pub(crate) struct Setup {
    case: Case,
    surface: Mesh,
    field: Field,
    pub(crate) placed: Placed,
}

impl Setup {
    /// # Errors
    /// The reason in words.
    pub(crate) fn new(case: &Case) -> Result<Self, String> {
        let surface = case.site.subject.mesh()?;
        let bounds = surface.bounds();
        let cell = (bounds[1] - bounds[0]).max() / 160.0;
        Ok(Self {
            case: *case,
            field: Field::new(&surface, Grid::around(bounds, cell, 4), Sign::Closed),
            placed: case.placed(&surface)?,
            surface,
        })
    }

    /// Wanted sizes of the elements, times `larger`.
    fn focus(&self, larger: f64) -> Focus {
        let radius_m = self.case.tool.radius_m();
        let share = match self.case.tool {
            Shaped::Tip(_) | Shaped::TwoTips => SHARE,
            Shaped::Shaft | Shaped::Jaws | Shaped::OpenJaws => LINE_SHARE,
        };
        let bounds = self.surface.bounds();
        let half_m = self.placed.half_m(DEEPEST_M, |p| self.field.at(p));
        let mut lines = self.placed.lines(self.case.tool, half_m);
        if let Some(nearest) = Nearest::new(&self.surface) {
            for end in lines.iter_mut().flatten() {
                *end = nearest.point(end);
            }
        }
        Focus {
            lines,
            least_m: (radius_m * DEPTHS_MM[0] * 1e-3).sqrt(),
            most_m: (radius_m * DEEPEST_M).sqrt(),
            share: share * larger,
            largest_m: LARGEST * larger * (bounds[1] - bounds[0]).min(),
        }
    }

    /// The body's free part, in elements `larger` times as large as on the finer mesh.
    ///
    /// # Errors
    /// The reason in words.
    pub(crate) fn mesh(&self, larger: f64) -> Result<Solid, String> {
        let focus = self.focus(larger);
        fill(
            &self.surface,
            &self.field,
            &focus,
            self.case.site.held_below,
        )
        .map_err(|e| format!("{}: {e}", self.case.name()))
    }

    /// True for nodes that are held.
    pub(crate) fn is_held(&self, p: &Point) -> bool {
        let (axis, plane) = self.case.site.held_below;
        p[axis] < plane + ON_PLANE_M
    }

    /// True near the tool, where it may touch.
    pub(crate) fn may_touch(&self, p: &Point) -> bool {
        let reach = 3.0 * self.case.tool.radius_m() + DEEPEST_M;
        let from_bar = |bar: &fem_reference::Bar| {
            let [a, b] = bar.ends_m;
            let along = (p - a).dot(&(b - a)) / (b - a).norm_squared().max(1e-12);
            (p - a - (b - a) * along.clamp(0.0, 1.0)).norm()
        };
        self.placed.bars.iter().any(|bar| from_bar(bar) < reach)
    }

    /// Number of nodes, and the wrench at each reached depth.
    fn solve(&self, larger: f64) -> Result<(usize, Vec<Wrench>), String> {
        self.solve_on(&self.mesh(larger)?, Law::Calot, &DEPTHS_MM)
    }

    /// Solves on a mesh with this material law. Returns the number of nodes, and the wrench at each
    /// of these depths that was reached.
    ///
    /// # Errors
    /// The reason in words.
    pub(crate) fn solve_on(
        &self,
        mesh: &Solid,
        law: Law,
        depths_mm: &[f64],
    ) -> Result<(usize, Vec<Wrench>), String> {
        let words = |e: fem_reference::FemError| format!("{}: {e}", self.case.name());
        let outward = self.placed.outward;
        let shift_m = move |share: f64| -outward * (share * DEEPEST_M);
        let problem = Problem {
            mesh,
            material: law.material().map_err(words)?,
            gravity_m_s2: Point::zeros(),
            holds: vec![Hold::fixed(mesh.nodes_where(|p| self.is_held(p)))],
            tool: Some(Tool {
                bars: self.placed.bars.clone(),
                behind: Some(outward),
                shift_m: Box::new(shift_m),
                faces: mesh.faces_where(|p| self.may_touch(p)),
            }),
        };
        let stops: Vec<f64> = depths_mm.iter().map(|mm| mm * 1e-3 / DEEPEST_M).collect();
        eprintln!("  {}: {} nodes", self.case.name(), mesh.nodes.len());
        let start = std::time::Instant::now();
        let mut tell = |share: f64| {
            eprintln!(
                "  {}: {} nodes, {:.1} mm, {:.0} s",
                self.case.name(),
                mesh.nodes.len(),
                share * DEEPEST_M * 1e3,
                start.elapsed().as_secs_f64()
            );
        };
        let (solutions, ended) = problem
            .solve_as_far(&stops, SMALLEST_STEP, &mut tell)
            .map_err(words)?;
        // The port moves with the tool.
        let wrench = |s: &fem_reference::Solution| {
            let torque_nm = s.tool_torque_nm(&(self.placed.port_m + shift_m(s.share)));
            Wrench::new(&self.placed, &s.tool_force_n, &torque_nm)
        };
        let wrenches: Vec<Wrench> = solutions.iter().map(wrench).collect();
        let forces: Vec<f64> = wrenches.iter().map(Wrench::out_n).collect();
        let end = if ended.is_some() { ", no further" } else { "" };
        eprintln!("  {}: {forces:.4?} N{end}", self.case.name());
        Ok((mesh.nodes.len(), wrenches))
    }
}

/// Energy of the tissue.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Law {
    /// Calot's energy.
    Calot,
    /// Energy that separates the change of volume from the change of shape.
    Isochoric,
}

impl Law {
    fn material(self) -> Result<Material, fem_reference::FemError> {
        let tissue = Tissue::LIVER;
        let calot = Material::new(tissue.young_pa, tissue.poisson, tissue.density_kg_m3)?;
        Ok(match self {
            Self::Calot => calot,
            Self::Isochoric => calot.isochoric(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_with_torque_on_large_elements_is_solved_once() {
        let torque = |x: f64| Curve {
            fine: vec![Wrench {
                force_n: Point::x(),
                torque_nm: Point::repeat(x),
            }],
            mesher: LARGE_MESHER,
            ..Curve::default()
        };
        let (known, unknown) = (torque(0.01), torque(f64::NAN));
        assert!(Meshes::Large.is_met_by(&known) && !Meshes::Large.is_met_by(&unknown));
        assert!(!Meshes::Fine.is_met_by(&known));
        let today = Curve {
            mesher: MESHER,
            ..unknown
        };
        assert!(Meshes::Fine.is_met_by(&today) && Meshes::Large.is_met_by(&today));
    }
}
