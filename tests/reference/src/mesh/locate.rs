//! Finds the element that contains a point, and interpolates a nodal field at the point.

use super::Mesh;
use crate::Vec3;
use crate::element::{jacobian, shape, shape_gradients};

/// Position of a point in the mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// Index of the tetrahedron.
    pub tet: u32,
    /// The last three barycentric coordinates of the point.
    pub xi: Vec3,
}

/// Finds the element of any point. A point outside the mesh gets a nearby element, and values are
/// extrapolated from it.
pub struct Locator<'a> {
    mesh: &'a Mesh,
    origin: Vec3,
    cell_m: f64,
    size: [usize; 3],
    cells: Vec<Vec<u32>>,
}

impl<'a> Locator<'a> {
    /// Sorts the elements into a grid.
    #[must_use]
    pub fn new(mesh: &'a Mesh) -> Self {
        let first = mesh.nodes.first().copied().unwrap_or_default();
        let (min, max) = bounds(mesh.nodes.iter().copied(), first);
        let length = (max - min).max().max(f64::MIN_POSITIVE);
        let cell_m = length / (mesh.tets.len() as f64 / 4.0).cbrt().max(1.0);
        let count = (max - min).map(|l| (l / cell_m) as usize + 1);
        let mut locator = Self {
            mesh,
            origin: min,
            cell_m,
            size: [count.x, count.y, count.z],
            cells: vec![Vec::new(); count.x * count.y * count.z],
        };
        for (e, t) in mesh.tets.iter().enumerate() {
            let x = t.map(|n| mesh.nodes[n as usize]);
            let (low, high) = bounds(x.into_iter(), x[0]);
            let (a, b) = (locator.cell(&low), locator.cell(&high));
            for k in a[2]..=b[2] {
                for j in a[1]..=b[1] {
                    for i in a[0]..=b[0] {
                        let n = locator.number([i, j, k]);
                        locator.cells[n].push(e as u32);
                    }
                }
            }
        }
        locator
    }

    fn cell(&self, p: &Vec3) -> [usize; 3] {
        let at = |k: usize| ((p[k] - self.origin[k]) / self.cell_m).max(0.0) as usize;
        [0, 1, 2].map(|k| at(k).min(self.size[k] - 1))
    }

    fn number(&self, [i, j, k]: [usize; 3]) -> usize {
        i + self.size[0] * (j + self.size[1] * k)
    }

    /// Element and coordinates of a rest position. `None` only for a mesh without elements.
    #[must_use]
    pub fn find(&self, p: &Vec3) -> Option<Place> {
        let home = self.cell(p);
        let mut best: Option<(f64, Place)> = None;
        for reach in 0..=*self.size.iter().max()? {
            let span =
                |k: usize| home[k].saturating_sub(reach)..=(home[k] + reach).min(self.size[k] - 1);
            for k in span(2) {
                for j in span(1) {
                    for i in span(0) {
                        for &tet in &self.cells[self.number([i, j, k])] {
                            let xi = self.invert(tet, p);
                            let inside = xi.min().min(1.0 - xi.sum());
                            if best.is_none_or(|(value, _)| inside > value) {
                                best = Some((inside, Place { tet, xi }));
                            }
                        }
                    }
                }
            }
            if let Some((_, place)) = best {
                return Some(place);
            }
        }
        None
    }

    fn invert(&self, tet: u32, p: &Vec3) -> Vec3 {
        let x = self.mesh.tets[tet as usize].map(|n| self.mesh.nodes[n as usize]);
        let mut xi = Vec3::repeat(0.25);
        // Straight elements need one step, curved ones a few.
        for _ in 0..8 {
            let at: Vec3 = x.iter().zip(shape(&xi)).map(|(x, n)| x * n).sum();
            let Some(inverse) = jacobian(&x, &shape_gradients(&xi)).try_inverse() else {
                break;
            };
            let step = inverse * (p - at);
            xi += step;
            if step.amax() < 1e-12 {
                break;
            }
        }
        xi
    }

    /// Value of a nodal field at a place.
    #[must_use]
    pub fn value(&self, place: &Place, field: &[Vec3]) -> Vec3 {
        let nodes = self.mesh.tets[place.tet as usize];
        let parts = nodes.iter().zip(shape(&place.xi));
        parts.map(|(&n, share)| field[n as usize] * share).sum()
    }
}

fn bounds(points: impl Iterator<Item = Vec3>, first: Vec3) -> (Vec3, Vec3) {
    points.fold((first, first), |(a, b), p| (a.inf(&p), b.sup(&p)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shell_octant;

    #[test]
    fn a_quadratic_field_is_interpolated_exactly_everywhere() {
        let mesh = crate::block(Vec3::zeros(), Vec3::new(0.2, 0.1, 0.1), [5, 2, 3]);
        let field = |p: &Vec3| Vec3::new(p.x * p.y, p.z * p.z - p.x, 3.0 * p.y * p.z);
        let nodal: Vec<_> = mesh.nodes.iter().map(field).collect();
        let locator = Locator::new(&mesh);
        for i in 0..200 {
            let t = f64::from(i);
            let p = Vec3::new(0.2 * (t * 0.618 % 1.0), 0.1 * (t * 0.317 % 1.0), 0.0005 * t);
            let place = locator.find(&p).expect("some element");
            assert!((locator.value(&place, &nodal) - field(&p)).norm() < 1e-12);
        }
    }

    #[test]
    fn points_are_located_in_curved_elements_too() {
        let mesh = shell_octant(0.5, 1.0, 2, 2);
        let locator = Locator::new(&mesh);
        let p = Vec3::new(0.3, 0.4, 0.5);
        let place = locator.find(&p).expect("some element");
        assert!((locator.value(&place, &mesh.nodes) - p).norm() < 1e-10);
        assert!(place.xi.min() > -1e-6 && place.xi.sum() < 1.0 + 1e-6);
    }
}
