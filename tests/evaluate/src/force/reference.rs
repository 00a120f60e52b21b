//! Force over depth by finite elements, on two meshes.

use std::path::{Path, PathBuf};

use fem_reference::{Hold, Material, Problem, Tool};
use nalgebra::Vector3;
use scene_prepare::field::{Field, Grid, Sign};
use scene_prepare::mesh::Mesh;

use super::case::{Case, Placed, Shaped, Subject};
use crate::body::Tissue;
use crate::focus::{Focus, ON_PLANE_M, fill};

type Point = Vector3<f64>;

/// Depths, mm.
pub(crate) const DEPTHS_MM: [f64; 8] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];

/// Sizes of the smallest elements of the coarser and the finer mesh, as multiples of the tool's
/// radius or of [`MEAN_M`], whichever is less.
const SIZES: [f64; 2] = [1.2, 0.9];
/// Element sizes under tips on an organ that is small enough for finer elements.
const FINE_SIZES: [f64; 2] = [0.9, 0.7];
/// Element sizes under jaws on the liver. Jaws are long for their radius, so finer elements would
/// be too many to solve.
const JAWS_SIZES: [f64; 2] = [1.6, 1.2];
const MEAN_M: f64 = 0.005;
/// Distance from the tool up to which elements keep their size, as a multiple of
/// [`Shaped::mean_m`]; farther off they grow. With a smaller region a free lobe bends up to 70 %
/// too far.
const NEAR_SIZES: f64 = 2.7;
/// Ratio of an element's length along a tool that lies on its side to its length across: forces
/// hardly change along the tool.
const STRETCH: f64 = 3.0;
/// A curve ends where the solver needs load steps below this share of the whole load.
const SMALLEST_STEP: f64 = 1.0 / 16.0;

/// Version of the mesher that makes a case's meshes. Version 1 cut off the edge of the held part.
/// Version 2 let elements grow along the line on which a tool touches, and made them too large
/// under thin and thick tips. Under tips of 5 mm version 2 makes the same meshes as version 3,
/// except for the gallbladder.
fn mesher(case: &Case) -> usize {
    match (case.site.subject, case.tool) {
        (Subject::Liver | Subject::Stomach, Shaped::Tip(5.0)) => 2,
        _ => 3,
    }
}

/// Force over depth by finite elements.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Curve {
    /// Force along the tool's way at the first depths of [`DEPTHS_MM`], up to the last equilibrium,
    /// N.
    pub(crate) force_n: Vec<f64>,
    /// Forces on the coarser mesh, N.
    pub(crate) coarse_n: Vec<f64>,
    /// Nodes of the coarser and the finer mesh.
    pub(crate) nodes: [usize; 2],
    /// Version of the mesher that made the meshes. [`mesher`] gives the current version.
    pub(crate) mesher: usize,
}

impl Curve {
    /// Root mean square difference between the forces on the two meshes, relative to the finer
    /// mesh, %.
    pub(crate) fn doubt_pct(&self) -> f64 {
        rms_pct(&self.coarse_n, &self.force_n)
    }
}

/// Least force at which a relative error means anything, N. Below it the tool hardly touches.
const TOUCHES_N: f64 = 0.005;

/// Relative errors of `values` against `truth`, at the depths that both have and at which the tool
/// touches.
pub(crate) fn off(values: &[f64], truth: &[f64]) -> Vec<f64> {
    let pairs = values.iter().zip(truth);
    let felt = pairs.filter(|(_, t)| **t >= TOUCHES_N);
    felt.map(|(v, t)| v / t - 1.0).collect()
}

/// Root mean square of [`off`], %.
pub(crate) fn rms_pct(values: &[f64], truth: &[f64]) -> f64 {
    let off = off(values, truth);
    let squares: f64 = off.iter().map(|e| e * e).sum();
    100.0 * (squares / off.len().max(1) as f64).sqrt()
}

/// The curve of a case. It is taken from `folder` or from the repository ([`RECORDED`]) if it was
/// found before with today's mesher, or with any mesher if `any_mesher`. Otherwise it is solved and
/// kept in `folder`.
///
/// # Errors
/// The reason in words.
pub(crate) fn curve(
    case: &Case,
    folder: &Path,
    quick: bool,
    any_mesher: bool,
) -> Result<Curve, String> {
    if let Some(curve) =
        found(case, folder, quick).filter(|c| any_mesher || c.mesher == mesher(case))
    {
        return Ok(curve);
    }
    let kept = place(case, folder, quick);
    let surface = case.site.subject.mesh()?;
    let placed = case.placed(&surface)?;
    let sizes = match (case.site.subject, case.tool) {
        _ if quick => [2.0, 1.6],
        (Subject::Gallbladder, Shaped::Tip(_)) => FINE_SIZES,
        (Subject::Liver, Shaped::Jaws | Shaped::OpenJaws) => JAWS_SIZES,
        _ => SIZES,
    };
    let unit_m = case.tool.radius_m().min(MEAN_M);
    let mut solved = Vec::new();
    for size in sizes {
        solved.push(solve(case, &surface, &placed, size * unit_m)?);
    }
    let [(nodes_before, coarse_n), (nodes, force_n)] = solved
        .try_into()
        .map_err(|_| "two meshes, two curves".to_owned())?;
    let curve = Curve {
        force_n,
        coarse_n,
        nodes: [nodes_before, nodes],
        mesher: mesher(case),
    };
    std::fs::write(&kept, text(&curve)).map_err(|e| format!("{}: {e}", kept.display()))?;
    Ok(curve)
}

/// Every curve that the repository keeps, in the form of [`csv`]. Solving them takes an hour.
const RECORDED: &str = include_str!("../../../results/force_reference.csv");

/// The curve that was found before, from `folder` or else from the repository.
pub(crate) fn found(case: &Case, folder: &Path, quick: bool) -> Option<Curve> {
    let text = std::fs::read_to_string(place(case, folder, quick));
    let kept = text.ok().and_then(|text| read(&text));
    kept.or_else(|| recorded(case, RECORDED).filter(|_| !quick))
}

/// The references as `force_reference.csv`. Nodes are 0 if their number was not kept. The coarser
/// mesh's force is empty at a depth that this mesh did not reach.
pub(crate) fn csv<'a>(curves: impl Iterator<Item = (&'a Case, &'a Curve)>) -> String {
    let mut text = "organ,site,tool,mesher,coarser_nodes,nodes,depth_mm,reference_n,\
                    coarser_reference_n\n"
        .to_owned();
    for (case, curve) in curves {
        let [before, nodes] = curve.nodes;
        for (i, (depth, force)) in DEPTHS_MM.iter().zip(&curve.force_n).enumerate() {
            let coarse = curve.coarse_n.get(i);
            text += &format!(
                "{},{},{before},{nodes},{depth},{force:.5},{}\n",
                columns(case),
                curve.mesher,
                coarse.map_or_else(String::new, |f| format!("{f:.5}")),
            );
        }
    }
    text
}

/// The columns that identify a case in a table.
fn columns(case: &Case) -> String {
    let (subject, site) = (case.site.subject.name(), case.site.name);
    format!("{subject},{site},\"{}\"", case.tool.name())
}

/// The curve of a case, from a table that [`csv`] wrote.
fn recorded(case: &Case, table: &str) -> Option<Curve> {
    let columns = columns(case) + ",";
    let own = table.lines().filter_map(|line| line.strip_prefix(&columns));
    let mut curve: Option<Curve> = None;
    for line in own {
        let words: Vec<&str> = line.split(',').collect();
        let [mesher, before, nodes, _, force, coarse] = words[..] else {
            return None;
        };
        let nodes = [before.parse().ok()?, nodes.parse().ok()?];
        let curve = curve.get_or_insert_with(|| Curve {
            force_n: Vec::new(),
            coarse_n: Vec::new(),
            nodes,
            mesher: 0,
        });
        curve.mesher = mesher.parse().ok()?;
        curve.force_n.push(force.parse().ok()?);
        curve.coarse_n.extend(coarse.parse::<f64>().ok());
    }
    curve
}

fn place(case: &Case, folder: &Path, quick: bool) -> PathBuf {
    folder.join(format!("{}.txt", file_name(&case.name(), quick)))
}

fn file_name(name: &str, quick: bool) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    let name: String = name.chars().map(plain).collect();
    if quick { name + "_quick" } else { name }
}

fn text(curve: &Curve) -> String {
    let line = |values: &[f64]| {
        let words: Vec<String> = values.iter().map(|f| format!("{f:.7}")).collect();
        words.join(" ")
    };
    let (mesher, [before, nodes]) = (curve.mesher, curve.nodes);
    format!(
        "{mesher} {before} {nodes}\n{}\n{}\n",
        line(&curve.coarse_n),
        line(&curve.force_n)
    )
}

fn read(text: &str) -> Option<Curve> {
    let mut lines = text.lines().map(|l| l.split_whitespace());
    let head: Option<Vec<usize>> = lines.next()?.map(|w| w.parse().ok()).collect();
    let (mesher, nodes) = match head?[..] {
        [before, nodes] => (1, [before, nodes]), // files of the first mesher had no number
        [mesher, before, nodes] => (mesher, [before, nodes]),
        _ => return None,
    };
    let mut forces = || -> Option<Vec<f64>> { lines.next()?.map(|w| w.parse().ok()).collect() };
    Some(Curve {
        mesher,
        nodes,
        coarse_n: forces()?,
        force_n: forces()?,
    })
}

/// Number of nodes, and the force at each depth that was reached.
fn solve(
    case: &Case,
    surface: &Mesh,
    placed: &Placed,
    size_m: f64,
) -> Result<(usize, Vec<f64>), String> {
    let words = |e: fem_reference::FemError| format!("{}: {e}", case.name());
    let radius_m = case.tool.radius_m();
    let bounds = surface.bounds();
    let cell = (bounds[1] - bounds[0]).max() / 160.0;
    let field = Field::new(surface, Grid::around(bounds, cell, 4), Sign::Closed);
    let deepest_m = DEPTHS_MM[DEPTHS_MM.len() - 1] * 1e-3;
    let focus = Focus {
        around: placed.at_m,
        along: placed.line,
        half_m: placed.half_m(deepest_m, |p| field.at(p)),
        near_m: NEAR_SIZES * case.tool.mean_m(MEAN_M),
        stretch: if case.tool.has_two_ends() {
            1.0
        } else {
            STRETCH
        },
    };
    let (axis, plane) = case.site.held_below;
    let mesh = fill(surface, &field, &focus, (axis, plane), size_m).map_err(words)?;
    let reach = 3.0 * radius_m + 0.008;
    let may_touch = |p: &Point| {
        let from_bar = |bar: &fem_reference::Bar| {
            let [a, b] = bar.ends_m;
            let along = (p - a).dot(&(b - a)) / (b - a).norm_squared().max(1e-12);
            (p - a - (b - a) * along.clamp(0.0, 1.0)).norm()
        };
        placed.bars.iter().any(|bar| from_bar(bar) < reach)
    };
    let tissue = Tissue::LIVER;
    let outward = placed.outward;
    let problem = Problem {
        mesh: &mesh,
        material: Material::new(tissue.young_pa, tissue.poisson, tissue.density_kg_m3)
            .map_err(words)?,
        gravity_m_s2: Point::zeros(),
        holds: vec![Hold::fixed(
            mesh.nodes_where(|p| p[axis] < plane + ON_PLANE_M),
        )],
        tool: Some(Tool {
            bars: placed.bars.clone(),
            behind: Some(outward),
            shift_m: Box::new(move |share| -outward * (share * deepest_m)),
            faces: mesh.faces_where(may_touch),
        }),
    };
    let stops: Vec<f64> = DEPTHS_MM.iter().map(|mm| mm * 1e-3 / deepest_m).collect();
    let start = std::time::Instant::now();
    let (solutions, ended) = problem
        .solve_as_far(&stops, SMALLEST_STEP, &mut |_| ())
        .map_err(words)?;
    let force_n: Vec<f64> = solutions
        .iter()
        .map(|s| s.tool_force_n.dot(&outward))
        .collect();
    eprintln!(
        "  reference, {}: line of {:.0} mm, {} nodes, {:.0} s, {:.4?} N{}",
        case.name(),
        focus.half_m * 2e3,
        mesh.nodes.len(),
        start.elapsed().as_secs_f64(),
        force_n,
        if ended.is_some() { ", no further" } else { "" }
    );
    Ok((mesh.nodes.len(), force_n))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_gives_back_what_it_was_given() {
        let cases = Case::all();
        let curve = |nodes: usize| Curve {
            force_n: vec![0.02, 0.05, 0.09123],
            coarse_n: vec![0.021, 0.049],
            nodes: [4000, nodes],
            mesher: 3,
        };
        let curves: Vec<Curve> = (1..=cases.len()).map(curve).collect();
        let table = csv(cases.iter().zip(&curves));
        for (case, curve) in cases.iter().zip(&curves) {
            assert_eq!(recorded(case, &table).as_ref(), Some(curve), "{table}");
        }
        assert_eq!(recorded(&cases[0], "nothing"), None);
    }

    /// The repository keeps references of existing cases only.
    #[test]
    fn recorded_reference_is_read() {
        let lines = RECORDED.lines().count() - 1;
        let cases = Case::all();
        let curves = cases.iter().filter_map(|case| recorded(case, RECORDED));
        let depths: usize = curves.map(|curve| curve.force_n.len()).sum();
        assert_eq!(depths, lines);
    }

    #[test]
    fn a_kept_curve_is_read_as_it_was() {
        let curve = Curve {
            force_n: vec![0.02, 0.05, 0.0912345],
            coarse_n: vec![0.021, 0.049],
            nodes: [4000, 7000],
            mesher: 3,
        };
        assert_eq!(read(&text(&curve)), Some(curve));
        assert_eq!(read("nonsense"), None);
        let mesher = |text| read(text).map(|curve| curve.mesher);
        assert_eq!(mesher("4000 7000\n0.02\n0.02\n"), Some(1));
        assert_eq!(mesher("3 4000 7000\n0.02\n0.02\n"), Some(3));
    }
}
