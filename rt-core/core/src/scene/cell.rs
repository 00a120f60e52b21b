//! Cells of layered tissue: hexahedra of fat and connective tissue that are removed one by one.

use crate::capacity::{MAX_CELLS, MAX_SKIN_VERTICES};
use crate::math::Vec3;
use crate::scene::{SKIN_BINDINGS, Scene, SceneError};

/// Largest number of surface cells under one vertex of the contact skin.
pub const COLUMNS: usize = 6;

/// Index that stands for no cell.
pub const NO_CELL: u16 = u16::MAX;

/// A hexahedron of tissue.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cell {
    /// Spheres of one organ that carry the cell's centre, the nearest first. The cell belongs to
    /// the nearest sphere.
    pub spheres: [u16; SKIN_BINDINGS],
    /// Weights of the spheres; the sum is 1.
    pub weights: [f32; SKIN_BINDINGS],
    /// Neighbours across its faces, in pairs of opposite faces; [`NO_CELL`] where there is none.
    pub neighbours: [u16; 6],
    /// Centre at rest, world frame, m.
    pub center_m: Vec3,
    /// Distance between the opposite faces of each pair, m.
    pub extent_m: [f32; 3],
    /// Volume, m³.
    pub volume_m3: f32,
    /// Energy that removes the cell, J.
    pub energy_j: f32,
}

impl Cell {
    /// Sphere to which the cell belongs.
    pub(crate) fn sphere(&self) -> u32 {
        u32::from(self.spheres[0])
    }

    /// Neighbour across this face.
    pub(crate) fn across(&self, face: u8) -> u16 {
        self.neighbours
            .get(usize::from(face))
            .map_or(NO_CELL, |n| *n)
    }

    /// Extent perpendicular to this face, m.
    pub(crate) fn through_m(&self, face: u8) -> f32 {
        self.extent_m.get(usize::from(face / 2)).map_or(0.0, |m| *m)
    }
}

/// Cells under a vertex of a contact skin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Column {
    /// Cells at the surface; [`NO_CELL`] in unused places.
    pub cells: [u16; COLUMNS],
    /// Face of each of these cells behind which the next deeper cell lies.
    pub inwards: [u8; COLUMNS],
}

/// Layered tissue of all organs.
#[derive(Debug, Clone, Copy, Default)]
pub struct Layers<'a> {
    /// Cells.
    pub cells: &'a [Cell],
    /// Columns of all contact vertices; empty if there are no cells.
    pub columns: &'a [Column],
}

impl<'a> Layers<'a> {
    /// The cell with this index.
    pub(crate) fn cell(&self, index: u16) -> Option<&'a Cell> {
        self.cells.get(usize::from(index))
    }

    /// Cells under a contact vertex.
    pub(crate) fn column(&self, vertex: u16) -> Option<&'a Column> {
        self.columns.get(usize::from(vertex))
    }
}

impl<'a> Scene<'a> {
    /// Adds cells of layered tissue.
    ///
    /// # Errors
    /// If there are too many, a cell names a sphere that does not exist, a neighbour or column
    /// names a cell that does not exist, or a value is out of range.
    pub fn with_cells(mut self, layers: Layers<'a>) -> Result<Self, SceneError> {
        let too_many = |what, count, limit| SceneError::TooMany { what, count, limit };
        let (cells, columns) = (layers.cells, layers.columns);
        if cells.len() > MAX_CELLS {
            return Err(too_many("cells", cells.len(), MAX_CELLS));
        }
        if columns.len() > MAX_SKIN_VERTICES {
            return Err(too_many("columns", columns.len(), MAX_SKIN_VERTICES));
        }
        let exists = |cell: u16| usize::from(cell) < cells.len() || cell == NO_CELL;
        for (index, cell) in cells.iter().enumerate() {
            let spheres = cell.spheres.iter().map(|s| u32::from(*s));
            let foreign = |what, sphere| SceneError::Foreign {
                what,
                index,
                sphere,
            };
            for sphere in spheres {
                if sphere as usize >= self.spheres.len() {
                    return Err(foreign("cell", sphere));
                }
            }
            if let Some(other) = cell.neighbours.iter().find(|other| !exists(**other)) {
                return Err(foreign("neighbour of a cell", u32::from(*other)));
            }
            let value = |what, value, allowed| SceneError::Value {
                what,
                index,
                value,
                allowed,
            };
            let sum: f32 = cell.weights.iter().sum();
            if !cell.weights.iter().all(|w| w.abs() <= 8.0) || (sum - 1.0).abs() > 1.0e-3 {
                return Err(value("cell", sum, "weights of -8 to 8 that sum to 1"));
            }
            if !(1.0e-15..=1.0).contains(&cell.volume_m3) {
                return Err(value("volume of a cell", cell.volume_m3, "1e-15 to 1 m3"));
            }
            if !(1.0e-9..=1.0e6).contains(&cell.energy_j) {
                return Err(value("energy of a cell", cell.energy_j, "1e-9 to 1e6 J"));
            }
            let lengths = cell.extent_m.iter().chain(&cell.center_m);
            if let Some(bad) = lengths.into_iter().find(|m| !(-10.0..=10.0).contains(*m)) {
                return Err(value("length of a cell", *bad, "-10 to 10 m"));
            }
        }
        for (index, column) in columns.iter().enumerate() {
            if let Some(cell) = column.cells.iter().find(|cell| !exists(**cell)) {
                return Err(SceneError::Foreign {
                    what: "column of cells",
                    index,
                    sphere: u32::from(*cell),
                });
            }
        }
        self.layers = layers;
        Ok(self)
    }
}
