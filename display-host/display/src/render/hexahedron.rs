//! Faces of a cell, which is a hexahedron.

/// Corners of a cell's faces, counter-clockwise as seen from outside.
pub(super) const FACES: [[usize; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];
/// Index of the inward face of a cell, and of its neighbour there.
pub(super) const INWARDS: usize = 4;
/// Index of the outward face of a cell, and of its neighbour there.
pub(super) const OUTWARDS: usize = 5;
