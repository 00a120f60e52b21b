//! Boxes, and a spherical shell that is bent from boxes.

use super::Mesh;
use crate::Vec3;

/// A box from `min_m` to `max_m`, cut into `cells` bricks of six tetrahedra each.
#[must_use]
pub fn block(min_m: Vec3, max_m: Vec3, cells: [usize; 3]) -> Mesh {
    let cells = cells.map(|n| n.max(1));
    let [nx, ny, nz] = cells.map(|n| n + 1);
    let number = |i: usize, j: usize, k: usize| (i + nx * (j + ny * k)) as u32;
    let mut corners = Vec::with_capacity(nx * ny * nz);
    for k in 0..nz {
        for j in 0..ny {
            for i in 0..nx {
                let share = Vec3::new(
                    i as f64 / cells[0] as f64,
                    j as f64 / cells[1] as f64,
                    k as f64 / cells[2] as f64,
                );
                corners.push(min_m + (max_m - min_m).component_mul(&share));
            }
        }
    }
    let mut tets = Vec::new();
    for k in 0..cells[2] {
        for j in 0..cells[1] {
            for i in 0..cells[0] {
                // Kuhn's six tetrahedra: each follows the brick's edges from one corner to the
                // opposite corner, in another order of axes.
                for order in [
                    [0, 1, 2],
                    [1, 2, 0],
                    [2, 0, 1],
                    [1, 0, 2],
                    [0, 2, 1],
                    [2, 1, 0],
                ] {
                    let mut at = [i, j, k];
                    let mut tet = [number(i, j, k); 4];
                    for (step, axis) in order.into_iter().enumerate() {
                        at[axis] += 1;
                        tet[step + 1] = number(at[0], at[1], at[2]);
                    }
                    tets.push(tet);
                }
            }
        }
    }
    Mesh::from_linear(corners, &tets)
}

/// The octant `x, y, z ≥ 0` of a thick spherical shell, with `around` cells along an eighth of a
/// circle and `through` cells through the wall. All nodes of the curved sides lie exactly on their
/// spheres.
#[must_use]
pub fn shell_octant(inner_m: f64, outer_m: f64, around: usize, through: usize) -> Mesh {
    let unit = block(Vec3::zeros(), Vec3::repeat(1.0), [around, around, through]);
    let patch = |axis: usize| {
        unit.clone().mapped(move |p| {
            let mut direction = Vec3::zeros();
            direction[axis] = 1.0;
            // The tangent gives equal angles instead of equal lengths on the cube's side.
            direction[(axis + 1) % 3] = (p.x * std::f64::consts::FRAC_PI_4).tan();
            direction[(axis + 2) % 3] = (p.y * std::f64::consts::FRAC_PI_4).tan();
            direction.normalize() * (inner_m + (outer_m - inner_m) * p.z)
        })
    };
    Mesh::joined(&[patch(0), patch(1), patch(2)], 1e-9 * outer_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_has_its_volume_and_sides() {
        let mesh = block(Vec3::zeros(), Vec3::new(2.0, 1.0, 0.5), [3, 2, 1]);
        assert!((mesh.volume_m3(None).expect("sound") - 1.0).abs() < 1e-12);
        assert_eq!(mesh.tets.len(), 36);
        assert_eq!(mesh.faces.len(), 4 * (3 * 2 + 2 + 3));
        assert_eq!(mesh.nodes.len(), 7 * 5 * 3);
    }

    #[test]
    fn an_octant_is_closed_and_converges_to_its_volume() {
        let exact = std::f64::consts::PI / 6.0 * (8.0 - 1.0);
        let error = |n: usize| {
            let mesh = shell_octant(1.0, 2.0, n, n);
            (mesh.volume_m3(None).expect("sound") / exact - 1.0).abs()
        };
        let mesh = shell_octant(1.0, 2.0, 2, 2);
        let open = mesh.faces.len();
        // Each patch has 4 cells of 2 triangles inside, as many outside, and 4 cells at each of its
        // planes.
        assert_eq!(open, 3 * (2 * 8) + 3 * 2 * 8);
        assert!(error(2) < 2e-3 && error(4) < error(2) / 8.0);
    }
}
