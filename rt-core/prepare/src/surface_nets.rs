//! Makes a closed triangle surface around the part of a grid where a function is negative.
//!
//! Surface nets have one vertex in each cell that the surface crosses, and one quadrilateral for
//! each grid edge that the surface crosses. A face of a cell is ambiguous if only the two corners
//! on one diagonal are inside. Then the smaller of the two outside values is first made negative,
//! so that the surface is manifold: every edge joins exactly two triangles.

use crate::Vec3;
use crate::field::Grid;
use crate::mesh::Mesh;

const NONE: u32 = u32::MAX;

/// The surface where `values`, one for each grid point, change sign. The border of the grid counts
/// as outside.
pub(crate) fn surface(grid: &Grid, values: &[f64]) -> Mesh {
    let mut values = values.to_vec();
    let [nx, ny, nz] = grid.size;
    for (index, value) in values.iter_mut().enumerate() {
        let at = grid.coordinates(index);
        let border = (0..3).any(|k| at[k] == 0 || at[k] + 1 == grid.size[k]);
        // As if half a cell outside, so that the surface closes before the border.
        if border && *value <= 0.0 {
            *value = 0.5 * grid.cell_m;
        }
        // A zero would put the vertices of neighbouring cells on one grid point.
        if *value == 0.0 {
            *value = 1e-9 * grid.cell_m;
        }
    }
    settle_crosswise_faces(grid, &mut values);

    let mut mesh = Mesh::default();
    let mut vertex_of_cell = vec![NONE; grid.len()];
    for z in 0..nz - 1 {
        for y in 0..ny - 1 {
            for x in 0..nx - 1 {
                if let Some(p) = crossing_of_cell(grid, &values, [x, y, z]) {
                    vertex_of_cell[grid.index([x, y, z])] = mesh.vertices.len() as u32;
                    mesh.vertices.push(p);
                }
            }
        }
    }
    for z in 1..nz - 1 {
        for y in 1..ny - 1 {
            for x in 1..nx - 1 {
                for axis in 0..3 {
                    quad(grid, &values, &vertex_of_cell, [x, y, z], axis, &mut mesh);
                }
            }
        }
    }
    mesh
}

/// Mean of the points where the surface crosses the cell's twelve edges; `None` if it crosses none.
fn crossing_of_cell(grid: &Grid, values: &[f64], cell: [usize; 3]) -> Option<Vec3> {
    let mut sum = Vec3::zeros();
    let mut count = 0.0;
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for corner in 0..4 {
            let mut from = cell;
            from[u] += corner & 1;
            from[v] += corner >> 1;
            let mut to = from;
            to[axis] += 1;
            let (a, b) = (values[grid.index(from)], values[grid.index(to)]);
            if (a < 0.0) != (b < 0.0) {
                sum += grid.position(from).lerp(&grid.position(to), a / (a - b));
                count += 1.0;
            }
        }
    }
    (count > 0.0).then(|| sum / count)
}

/// Adds two triangles between the four cells around a grid edge, if the surface crosses the edge.
fn quad(
    grid: &Grid,
    values: &[f64],
    vertex_of_cell: &[u32],
    from: [usize; 3],
    axis: usize,
    mesh: &mut Mesh,
) {
    let mut to = from;
    to[axis] += 1;
    let (a, b) = (values[grid.index(from)], values[grid.index(to)]);
    if (a < 0.0) == (b < 0.0) {
        return;
    }
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let cell = |du: usize, dv: usize| {
        let mut cell = from;
        cell[u] -= du;
        cell[v] -= dv;
        vertex_of_cell[grid.index(cell)]
    };
    // Cells around the edge, anticlockwise about the axis.
    let mut ring = [cell(1, 1), cell(0, 1), cell(0, 0), cell(1, 0)];
    if ring.contains(&NONE) {
        return;
    }
    if b < 0.0 {
        ring.reverse();
    }
    let p = ring.map(|i| mesh.vertices[i as usize]);
    // Split along the shorter diagonal.
    let [q, r, s, t] = ring;
    if (p[2] - p[0]).norm_squared() <= (p[3] - p[1]).norm_squared() {
        mesh.triangles.extend([[q, r, s], [q, s, t]]);
    } else {
        mesh.triangles.extend([[q, r, t], [r, s, t]]);
    }
}

fn settle_crosswise_faces(grid: &Grid, values: &mut [f64]) {
    loop {
        let mut changed = false;
        for index in 0..grid.len() {
            let at = grid.coordinates(index);
            for axis in 0..3 {
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                if at[u] + 1 >= grid.size[u] || at[v] + 1 >= grid.size[v] {
                    continue;
                }
                let mut face = [at; 4];
                face[1][u] += 1;
                face[2][u] += 1;
                face[2][v] += 1;
                face[3][v] += 1;
                let face = face.map(|at| grid.index(at));
                let inside = face.map(|i| values[i] < 0.0);
                if inside[0] == inside[2] && inside[1] == inside[3] && inside[0] != inside[1] {
                    let outside = if inside[0] {
                        [face[1], face[3]]
                    } else {
                        [face[0], face[2]]
                    };
                    let nearer = usize::from(values[outside[1]] < values[outside[0]]);
                    // A small value, so that the surface passes close to this corner.
                    values[outside[nearer]] = -1e-3 * grid.cell_m;
                    changed = true;
                }
            }
        }
        if !changed {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ball_has_its_volume_and_is_closed_outward() {
        let grid = Grid::around([Vec3::repeat(-0.05), Vec3::repeat(0.05)], 0.004, 2);
        let values: Vec<f64> = (0..grid.len())
            .map(|i| grid.position(grid.coordinates(i)).norm() - 0.05)
            .collect();
        let mesh = surface(&grid, &values);
        assert!(mesh.is_closed());
        let ball = 4.0 / 3.0 * std::f64::consts::PI * 0.05f64.powi(3);
        assert!(
            (mesh.volume() / ball - 1.0).abs() < 0.02,
            "{}",
            mesh.volume() / ball
        );
    }

    #[test]
    fn crosswise_corners_still_close() {
        let grid = Grid {
            origin: Vec3::zeros(),
            cell_m: 1.0,
            size: [6, 6, 6],
        };
        let mut values = vec![1.0; grid.len()];
        for at in [[2, 2, 2], [3, 3, 2], [3, 2, 3], [2, 3, 3]] {
            values[grid.index(at)] = -1.0;
        }
        assert!(surface(&grid, &values).is_closed());
    }
}
