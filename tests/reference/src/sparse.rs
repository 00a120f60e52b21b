//! The global stiffness matrix and its factorisation (faer's supernodal Cholesky).

use faer::Side;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};

use crate::element::Stiffness30;
use crate::{FemError, Mesh};

/// Marks a degree of freedom whose displacement is prescribed.
pub(crate) const HELD: u32 = u32::MAX;

/// Stiffness matrix of the free degrees of freedom. Only its lower triangle is stored.
pub(crate) struct System {
    /// Index of each degree of freedom (3 per node) among the unknowns, or [`HELD`].
    pub(crate) unknown: Vec<u32>,
    pub(crate) count: usize,
    matrix: SparseColMat<usize, f64>,
    symbolic: SymbolicLlt<usize>,
    /// For each element, the indices into the matrix's values of all pairs of its degrees of
    /// freedom (lower triangle).
    slots: Vec<[u32; 465]>,
}

impl System {
    pub(crate) fn new(mesh: &Mesh, held: &[bool]) -> Result<Self, FemError> {
        let mut count = 0;
        let number = |&held: &bool| {
            if held {
                HELD
            } else {
                count += 1;
                count as u32 - 1
            }
        };
        let unknown: Vec<u32> = held.iter().map(number).collect();
        let failed = |reason: String| FemError::Matrix {
            unknowns: count,
            reason,
        };
        let mut near: Vec<Vec<u32>> = vec![Vec::new(); mesh.nodes.len()];
        for t in &mesh.tets {
            for &a in t {
                near[a as usize].extend_from_slice(t);
            }
        }
        let mut starts = vec![0];
        let mut rows = Vec::new();
        for (node, near) in near.iter_mut().enumerate() {
            near.sort_unstable();
            near.dedup();
            for axis in 0..3 {
                let column = unknown[3 * node + axis];
                if column == HELD {
                    continue;
                }
                let dofs = near
                    .iter()
                    .flat_map(|&n| (0..3).map(move |i| 3 * n as usize + i));
                let below = dofs
                    .map(|d| unknown[d])
                    .filter(|&r| r != HELD && r >= column);
                rows.extend(below.map(|r| r as usize));
                starts.push(rows.len());
            }
        }
        let values = vec![0.0; rows.len()];
        let mut slots = Vec::with_capacity(mesh.tets.len());
        for t in &mesh.tets {
            let mut slot = [HELD; 465];
            for (pair, (i, j)) in pairs().enumerate() {
                let place = |d: usize| unknown[3 * t[d / 3] as usize + d % 3];
                slot[pair] = find(&starts, &rows, place(i), place(j));
            }
            slots.push(slot);
        }
        let pattern = SymbolicSparseColMat::new_checked(count, count, starts, None, rows);
        let symbolic = SymbolicLlt::try_new(pattern.as_ref(), Side::Lower)
            .map_err(|e| failed(format!("{e:?}")))?;
        Ok(Self {
            unknown,
            count,
            matrix: SparseColMat::new(pattern, values),
            symbolic,
            slots,
        })
    }

    pub(crate) fn clear(&mut self) {
        self.matrix.val_mut().fill(0.0);
    }

    pub(crate) fn add_element(&mut self, element: usize, k: &Stiffness30) {
        let values = self.matrix.val_mut();
        for (&slot, (i, j)) in self.slots[element].iter().zip(pairs()) {
            if slot != HELD {
                values[slot as usize] += k[(i, j)];
            }
        }
    }

    /// Adds to one entry. Entries above the diagonal are ignored, so the caller may add both
    /// triangles of a symmetric matrix.
    pub(crate) fn add(&mut self, row: u32, column: u32, value: f64) {
        if row == HELD || column == HELD || row < column {
            return;
        }
        let pattern = self.matrix.symbolic();
        let slot = find(pattern.col_ptr(), pattern.row_idx(), row, column);
        if slot != HELD {
            self.matrix.val_mut()[slot as usize] += value;
        }
    }

    /// Adds a share of the mean diagonal entry to every diagonal entry.
    pub(crate) fn shift(&mut self, share: f64) {
        let starts = self.matrix.symbolic().col_ptr().to_vec();
        let values = self.matrix.val_mut();
        // A sorted column of the lower triangle begins with its diagonal.
        let diagonal = || starts.iter().take(self.count);
        let mean = diagonal().map(|&s| values[s].abs()).sum::<f64>() / self.count.max(1) as f64;
        for &s in diagonal() {
            values[s] += share * mean;
        }
    }

    /// Solves for a right-hand side; `None` if the matrix is not positive definite.
    pub(crate) fn solve(&self, right_side: &[f64]) -> Option<Vec<f64>> {
        let symbolic = self.symbolic.clone();
        let factor =
            Llt::try_new_with_symbolic(symbolic, self.matrix.as_ref(), Side::Lower).ok()?;
        let mut x = faer::Col::from_fn(right_side.len(), |i| right_side[i]);
        factor.solve_in_place(x.as_mat_mut());
        let x: Vec<f64> = x.iter().copied().collect();
        x.iter().all(|v| v.is_finite()).then_some(x)
    }
}

/// Pairs of the lower triangle of 30 degrees of freedom, row by row.
fn pairs() -> impl Iterator<Item = (usize, usize)> {
    (0..30).flat_map(|i| (0..=i).map(move |j| (i, j)))
}

fn find(starts: &[usize], rows: &[usize], a: u32, b: u32) -> u32 {
    if a == HELD || b == HELD {
        return HELD;
    }
    let (row, column) = (a.max(b) as usize, a.min(b) as usize);
    let begin = starts[column];
    match rows[begin..starts[column + 1]].binary_search(&row) {
        Ok(at) => (begin + at) as u32,
        Err(_) => HELD,
    }
}
