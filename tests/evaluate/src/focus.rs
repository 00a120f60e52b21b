//! Meshes whose elements are small where a tool presses.

use fem_reference::graded;
use nalgebra::Vector3;
use scene_prepare::field::{Field, Nearest};
use scene_prepare::mesh::Mesh;

type Point = Vector3<f64>;

/// Wanted size of elements: proportional to the contact's radius where a tool touches, larger
/// elsewhere.
pub(crate) struct Focus {
    /// Lines on the surface along which the tool touches. For a contact at a point both ends are
    /// equal.
    pub(crate) lines: Vec<[Point; 2]>,
    /// Radius of the contact at the least depth, m. Within this distance of the lines, elements
    /// have the smallest size.
    pub(crate) least_m: f64,
    /// Radius of the contact at the greatest depth, m. Up to this distance from the lines the size
    /// is proportional to the distance. So the number of elements in the contact is the same at
    /// every depth.
    pub(crate) most_m: f64,
    /// Size of an element as a share of the contact's radius.
    pub(crate) share: f64,
    /// Size of an element far from the tool, m.
    pub(crate) largest_m: f64,
}

/// Growth of the size per distance outside the contact at the greatest depth.
const GROWTH: f64 = 1.5;

impl Focus {
    /// Size of the smallest elements, m.
    pub(crate) fn finest_m(&self) -> f64 {
        self.share * self.least_m
    }

    /// Wanted size of elements at a place, m.
    pub(crate) fn size_m(&self, p: &Point) -> f64 {
        let off = |[a, b]: &[Point; 2]| {
            let axis = b - a;
            let along = (p - a).dot(&axis) / axis.norm_squared().max(1e-18);
            (p - a - axis * along.clamp(0.0, 1.0)).norm()
        };
        let off_m = self.lines.iter().map(off).fold(f64::MAX, f64::min);
        let outside_m = (off_m - self.most_m).max(0.0);
        let inside_m = off_m.clamp(self.least_m, self.most_m.max(self.least_m));
        (self.share * inside_m + GROWTH * outside_m).min(self.largest_m)
    }
}

/// Fills the part of a closed surface that lies above a plane. Below the plane the body is held.
pub(crate) fn fill(
    surface: &Mesh,
    field: &Field,
    focus: &Focus,
    (axis, plane_m): (usize, f64),
) -> Result<fem_reference::Mesh, fem_reference::FemError> {
    let mut bounds = surface.bounds();
    bounds[0][axis] = plane_m;
    let [min, max] = bounds;
    let distance = |p: &Point| field.at(p).max(plane_m - p[axis]);
    let size_m = |p: &Point| focus.size_m(p);
    let mut mesh = graded(min, max, focus.finest_m(), size_m, distance)?;
    let Some(nearest) = Nearest::new(surface) else {
        return Ok(mesh);
    };
    // Straight element edges cut off the rim where the plane meets the surface. So the nodes of
    // this rim are moved out to the surface.
    let on_plane = |p: &Point| p[axis] < plane_m + ON_PLANE_M;
    let to_edge = |p: &Point| {
        let mut q = *p;
        for _ in 0..12 {
            let mut slope = field.outward(&q);
            slope[axis] = 0.0;
            q -= slope * (field.at(&q) / slope.norm_squared().max(0.1));
        }
        q
    };
    mesh.stretch_corners(|p, beside| {
        let is_rim = on_plane(p) && beside.iter().any(|other| !on_plane(other));
        let edge = if is_rim { to_edge(p) } else { *p };
        if (edge - p).norm() < size_m(p) {
            edge
        } else {
            *p
        }
    });
    // Straight edges between surface nodes lie inside the body. They would make it too small, with
    // an error of second order in the element size. So they are curved.
    mesh.curve_boundary(|p| {
        let is_rim = || field.at(p).abs() < 0.12 * size_m(p);
        match on_plane(p) {
            false => nearest.point(p),
            true if is_rim() => to_edge(p),
            true => *p,
        }
    });
    Ok(mesh)
}

/// A point no farther than this from the plane counts as lying on it, m.
pub(crate) const ON_PLANE_M: f64 = 2e-4;
