//! The course: the line through the middles of the cross-sections, the midline of the inner organ.

use nalgebra::{Matrix3, SymmetricEigen};

use crate::Vec3;
use crate::mesh::Mesh;

/// The middle of a section is the mean of the inner organ's vertices within this distance of the
/// section, in cell sizes.
const SLAB_CELLS: f64 = 2.0;
/// Number of rounds that smooth the course.
const ROUNDS: usize = 4;

/// Parallel cross-sections at equal distances along a line.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CrossSections {
    /// Unit vectors, right-handed: the first is normal to the sections, the other two lie in them.
    pub(super) axes: [Vec3; 3],
    /// Middle of each section, where its rays start, m.
    pub(super) middles: Vec<Vec3>,
}

/// Lays sections perpendicular to the longest principal axis of the inner organ `around`, about
/// `cell_m` apart, from one end of the layered tissue `own` to the other.
pub(super) fn course(around: &Mesh, own: &Mesh, cell_m: f64) -> CrossSections {
    let mean = around.vertices.iter().sum::<Vec3>() / around.vertices.len().max(1) as f64;
    let spread = around.vertices.iter().fold(Matrix3::zeros(), |sum, p| {
        let from = p - mean;
        sum + from * from.transpose()
    });
    let eigen = SymmetricEigen::new(spread);
    let along = eigen
        .eigenvectors
        .column(eigen.eigenvalues.imax())
        .into_owned();
    // Both directions along the axis are valid. Always choose the same one.
    let along = if along[along.iamax()] < 0.0 {
        -along
    } else {
        along
    };
    let least = along.iamin();
    let across = Vec3::ith(least, 1.0).cross(&along).normalize();
    let axes = [along, across, along.cross(&across)];
    let heights = || own.vertices.iter().map(|p| p.dot(&along));
    let low = heights().fold(f64::INFINITY, f64::min);
    let high = heights().fold(f64::NEG_INFINITY, f64::max);
    let steps = ((high - low) / cell_m).ceil().clamp(1.0, 1000.0) as usize;
    let step_m = (high - low) / steps as f64;
    let height = |i: usize| low + step_m * i as f64;
    let found: Vec<Option<Vec3>> = (0..=steps)
        .map(|i| {
            let near = |p: &&Vec3| (p.dot(&along) - height(i)).abs() < SLAB_CELLS * cell_m;
            let (count, sum) = around
                .vertices
                .iter()
                .filter(near)
                .fold((0, Vec3::zeros()), |(n, sum), p| (n + 1, sum + p));
            (count > 0).then(|| sum / f64::from(count))
        })
        .collect();
    let nearest = |i: usize| {
        let known = (0..=steps).filter(|&k| found[k].is_some());
        let k = known.min_by_key(|&k| k.abs_diff(i));
        k.and_then(|k| found[k]).unwrap_or(mean)
    };
    let mut middles: Vec<Vec3> = (0..=steps).map(nearest).collect();
    for _ in 0..ROUNDS {
        let old = middles.clone();
        for i in 1..steps {
            middles[i] = (old[i - 1] + old[i] * 2.0 + old[i + 1]) / 4.0;
        }
    }
    for (i, middle) in middles.iter_mut().enumerate() {
        *middle += along * (height(i) - middle.dot(&along));
    }
    CrossSections { axes, middles }
}
