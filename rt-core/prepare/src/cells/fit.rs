//! Moves the corners of faces without a neighbour towards the organ's surface.

use super::{Cells, hexa};
use crate::Vec3;
use crate::field::Nearest;

/// Corners farther from the surface than this stay where they are, in cell sizes.
const REACH_CELLS: f64 = 0.75;
/// Share of its first value that the triple product of the edges must keep at each corner of a
/// cell. A move that makes it smaller is refused, and so is one that makes it smaller than 2 % of
/// the product of the edges' lengths.
const LEFT: f64 = 0.2;
/// Shares of the way to the surface that are tried, the largest first.
const TRIES: [f64; 4] = [1.0, 0.7, 0.4, 0.2];
/// Number of rounds over the corners of faces without a neighbour.
const ROUNDS: usize = 2;

/// Moves each corner of a face without a neighbour towards the surface, by the largest of [`TRIES`]
/// that flattens none of the cells at the corner.
pub(super) fn onto_surface(cells: &mut Cells, surface: &Nearest<'_>, cell_m: f64) {
    let mut is_outside = vec![false; cells.corners.len()];
    let mut of_corner = vec![Vec::new(); cells.corners.len()];
    for (i, (cell, neighbours)) in cells.cells.iter().zip(&cells.neighbours).enumerate() {
        for corner in cell {
            of_corner[*corner as usize].push(i);
        }
        for (face, _) in neighbours.iter().enumerate().filter(|(_, n)| n.is_none()) {
            for k in hexa::FACES[face] {
                is_outside[cell[k] as usize] = true;
            }
        }
    }
    let first: Vec<_> = (0..cells.cells.len())
        .map(|i| hexa::corners(&cells.places(i)))
        .collect();
    for _ in 0..ROUNDS {
        for corner in (0..cells.corners.len()).filter(|&i| is_outside[i]) {
            let from = cells.corners[corner];
            let way: Vec3 = surface.point(&from) - from;
            if way.norm() > REACH_CELLS * cell_m {
                continue;
            }
            for share in TRIES {
                cells.corners[corner] = from + way * share;
                let keeps = |&i: &usize| {
                    let now = hexa::corners(&cells.places(i));
                    let mut pairs = now.iter().zip(&first[i]);
                    pairs.all(|((now, lengths), (before, _))| {
                        *now > LEFT * before && *now > 0.02 * lengths
                    })
                };
                if of_corner[corner].iter().all(keeps) {
                    break;
                }
                cells.corners[corner] = from;
            }
        }
    }
}
