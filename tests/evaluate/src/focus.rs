//! Meshes whose elements are small where a tool presses. A lattice of equal elements is mapped so
//! that elements grow with their distance from that place.

use fem_reference::lattice;
use nalgebra::Vector3;
use scene_prepare::field::{Field, Nearest};
use scene_prepare::mesh::Mesh;

type Point = Vector3<f64>;

/// A map between the space of a lattice of equal elements and real space. In real space, elements
/// grow with their distance from a line segment, whose length may be 0.
pub(crate) struct Focus {
    /// Middle of the segment.
    pub(crate) around: Point,
    /// Unit vector along the segment.
    pub(crate) along: Point,
    /// Half the segment's length, m.
    pub(crate) half_m: f64,
    /// Distance up to which elements about keep their size, m.
    pub(crate) near_m: f64,
    /// Ratio of an element's length along the segment to its length across it.
    pub(crate) stretch: f64,
}

impl Focus {
    /// The nearest point of a segment of this half length to `arm`, and the vector from there to
    /// `arm`. Both places are relative to the segment's middle.
    fn nearest(&self, arm: &Point, half_m: f64) -> (Point, Point) {
        let foot = self.along * self.along.dot(arm).clamp(-half_m, half_m);
        (foot, arm - foot)
    }

    fn out(&self, p: &Point) -> Point {
        let (foot, arm) = self.nearest(&(p - self.around), self.half_m / self.stretch);
        let q = arm.norm() / self.near_m;
        let far = if q > 1e-9 { q.sinh() / q } else { 1.0 };
        self.around + foot * self.stretch + arm * far
    }

    /// Ratio of the element size at a place to that at the segment.
    fn growth(&self, p: &Point) -> f64 {
        let (_, arm) = self.nearest(&(p - self.around), self.half_m);
        (1.0 + (arm.norm() / self.near_m).powi(2)).sqrt()
    }

    fn back(&self, p: &Point) -> Point {
        let (foot, arm) = self.nearest(&(p - self.around), self.half_m);
        let x = arm.norm() / self.near_m;
        let close = if x > 1e-9 { x.asinh() / x } else { 1.0 };
        self.around + foot / self.stretch + arm * close
    }

    /// A box around the image of another box under [`Self::back`].
    fn bounds(&self, [min, max]: [Point; 2]) -> [Point; 2] {
        let mut held = [Point::repeat(f64::MAX), Point::repeat(f64::MIN)];
        // The map pulls points towards the segment, so the box's faces bulge, most where they are
        // nearest to the segment. So the corners alone are not enough.
        for i in 0..4096 {
            let share = |shift: u32| f64::from(i >> shift & 15) / 15.0;
            let at = Point::new(share(0), share(4), share(8));
            let q = self.back(&(min + (max - min).component_mul(&at)));
            held = [held[0].inf(&q), held[1].sup(&q)];
        }
        held
    }
}

/// Fills the free part of a closed surface, which lies above the plane up to which the body is
/// held.
pub(crate) fn fill(
    surface: &Mesh,
    field: &Field,
    focus: &Focus,
    (axis, plane_m): (usize, f64),
    size_m: f64,
) -> Result<fem_reference::Mesh, fem_reference::FemError> {
    let mut bounds = surface.bounds();
    bounds[0][axis] = plane_m;
    let [min, max] = focus.bounds(bounds);
    let distance = |p: &Point| field.at(p).max(plane_m - p[axis]);
    let mut mesh = lattice(min, max, size_m, |p| distance(&focus.out(p)))?.mapped(|p| focus.out(p));
    let Some(nearest) = Nearest::new(surface) else {
        return Ok(mesh);
    };
    // Where the plane meets the surface, straight edges of elements cut off the rim. So the nodes
    // of the plane's rim are moved out to the surface.
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
        let size_m = size_m * focus.growth(p);
        if (edge - p).norm() < size_m { edge } else { *p }
    });
    // Straight edges between nodes of the surface lie inside it. They would make the body too
    // small, by an error of second order in the element size.
    mesh.curve_boundary(|p| {
        let is_rim = || field.at(p).abs() < 0.12 * size_m * focus.growth(p);
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
