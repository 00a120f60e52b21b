//! `evaluate reference`: convergence of the reference itself, with the same scene on finer and
//! finer meshes.

use crate::body::Tissue;
use crate::organ::Organ;
use crate::prepared::prepared;
use crate::scene::{Held, Kind, Scene};
use crate::solved::{self, tell};

/// Results of a scene on one mesh.
#[derive(Debug, Clone)]
pub(crate) struct Row {
    /// Name of the scene.
    pub(crate) scene: String,
    /// Layers of elements between the scene's planes.
    pub(crate) layers: usize,
    /// Nodes of the mesh of quadratic tetrahedra.
    pub(crate) nodes: usize,
    /// Force, N, or torque, N m.
    pub(crate) load: f64,
    /// Largest displacement of a probe, mm.
    pub(crate) displacement_mm: f64,
    /// Root mean square distance of the probes from their positions on the finest mesh, mm; 0 on
    /// the finest.
    pub(crate) rms_mm: f64,
    /// Largest distance of a probe from its position on the finest mesh, mm.
    pub(crate) max_mm: f64,
}

/// Solves the scenes whose names contain `only` on meshes with each number of `layers` (rising).
/// The probes are the centres of `spheres` spheres, except those that the scene holds.
///
/// # Errors
/// The reason in words.
pub(crate) fn run(layers: &[usize], spheres: usize, only: &str) -> Result<Vec<Row>, String> {
    let surface = Organ::Liver.mesh()?;
    let tissue = Tissue::LIVER;
    let mut rows = Vec::new();
    let kinds = [Kind::Sag, Kind::Pull, Kind::Twist(90), Kind::Press(3, 1)];
    for kind in kinds.into_iter().filter(|k| k.name().contains(only)) {
        let scene = Scene::new(kind, &surface);
        let (body, _) = prepared(&surface, spheres, tissue, &scene.planes())?;
        let held = body.held(&scene);
        let mut solved = Vec::new();
        // Contact on finer elements takes hours.
        let most = if scene.press.is_some() { 9 } else { usize::MAX };
        for &layers in layers.iter().filter(|&&layers| layers <= most) {
            eprintln!("reference, {}, {layers} layers …", kind.name());
            let one = solved::solve(&surface, &scene, &tissue, layers, &mut tell)
                .map_err(|e| e.to_string())?;
            solved.push((layers, one.displacement_m(&body.rest_m), one));
        }
        let Some((_, finest, _)) = solved.last() else {
            continue;
        };
        for (layers, displacement, one) in &solved {
            let free = || (0..held.len()).filter(|&i| held[i] == Held::Free);
            let errors: Vec<f64> = free()
                .filter_map(|i| Some((displacement[i]? - finest[i]?).norm() * 1e3))
                .collect();
            let squares: f64 = errors.iter().map(|e| e * e).sum();
            let row = Row {
                scene: kind.name(),
                layers: *layers,
                nodes: one.nodes(),
                load: one.load,
                displacement_mm: free()
                    .filter_map(|i| Some(displacement[i]?.norm() * 1e3))
                    .fold(0.0, f64::max),
                rms_mm: (squares / errors.len().max(1) as f64).sqrt(),
                max_mm: errors.iter().copied().fold(0.0, f64::max),
            };
            eprintln!("{row:?}");
            rows.push(row);
        }
    }
    Ok(rows)
}

/// The rows as `reference.csv`.
pub(crate) fn csv(rows: &[Row]) -> String {
    let mut text =
        "scene,layers,nodes,load_n_or_nm,displacement_mm,rms_to_finest_mm,max_to_finest_mm\n"
            .to_owned();
    for r in rows {
        text += &format!(
            "\"{}\",{},{},{:.6},{:.3},{:.4},{:.4}\n",
            r.scene, r.layers, r.nodes, r.load, r.displacement_mm, r.rms_mm, r.max_mm
        );
    }
    text
}
