//! Layered tissue as a surgeon sees it: the remaining cells, their positions, and those given up.

use shared_mem::message::StateFrame;
use shared_mem::scene::{CellRecord, NO_CELL, SceneFile};

use crate::sight::{Sight, off_line};
use crate::vector::{Vec3, wide};

/// Cells within this distance of a given-up cell, at rest, count as given up, too, m.
const BESIDE_M: f64 = 0.002;

/// Length of the way from a duct towards the endoscope on which cells hide the duct, m.
const BEFORE_M: f64 = 0.015;

/// Layered tissue at rest.
#[derive(Debug)]
pub(crate) struct Field {
    pub(crate) cells: Vec<Cell>,
    /// Number of times that each cell was given up.
    tries: Vec<u8>,
    /// True for cells that hide duct and artery.
    hides: Vec<bool>,
}

#[derive(Debug)]
pub(crate) struct Cell {
    /// Position at rest, m.
    pub(crate) center: Vec3,
    spheres: Vec<(usize, f64)>,
    neighbours: [u16; 6],
    /// Half of the cell's longest edge, m.
    pub(crate) radius_m: f64,
    volume_m3: f64,
    pub(crate) region: u8,
}

impl Field {
    /// Stands for the cells that hide duct and artery ([`Self::mark_hiding`]), whatever their
    /// region. No scene has this region.
    pub(crate) const HIDES: u8 = u8::MAX;

    /// Marks the fat between these places and the camera ([`Self::HIDES`]). Returns true if there
    /// is any.
    pub(crate) fn mark_hiding(
        &mut self,
        places: &[Vec3],
        camera: Vec3,
        sight: &Sight,
        state: &StateFrame,
    ) -> bool {
        let hides = |cell: &Cell| {
            let at = cell.at(sight, state);
            places.iter().any(|place| {
                let ahead = (camera - place).cap_magnitude(BEFORE_M);
                (at - place).dot(&ahead) > 0.0
                    && off_line(at, [*place, place + ahead]) < cell.radius_m
            })
        };
        let fat = [CellRecord::TRIANGLE, CellRecord::NOWHERE];
        let cells = self.cells.iter().enumerate();
        self.hides = cells
            .map(|(index, cell)| {
                fat.contains(&cell.region) && self.is_left(index, state) && hides(cell)
            })
            .collect();
        self.hides.contains(&true)
    }

    /// True if a cell belongs to one of these regions.
    pub(crate) fn is_in(&self, index: usize, regions: &[u8]) -> bool {
        let hides = self.hides.get(index).copied().unwrap_or_default();
        let cell = self.cells.get(index);
        (hides && regions.contains(&Self::HIDES))
            || cell.is_some_and(|cell| regions.contains(&cell.region))
    }

    pub(crate) fn new(scene: &SceneFile) -> Self {
        let records = scene.cells();
        let cells = records.iter().map(|record| {
            let weights = record.spheres.iter().zip(record.weights);
            let weights = weights.filter(|(_, weight)| *weight != 0.0);
            Cell {
                center: wide(record.center_m),
                spheres: weights
                    .map(|(sphere, weight)| (usize::from(*sphere), f64::from(weight)))
                    .collect(),
                neighbours: record.neighbours,
                radius_m: 0.5
                    * record
                        .extent_m
                        .iter()
                        .fold(0.0, |a, b| f64::max(a, (*b).into())),
                volume_m3: record.volume_m3.into(),
                region: record.region,
            }
        });
        let cells: Vec<Cell> = cells.collect();
        Self {
            tries: vec![0; cells.len()],
            hides: vec![false; cells.len()],
            cells,
        }
    }

    /// Gives up a cell and its neighbours, which the same obstacle blocks.
    pub(crate) fn give_up(&mut self, index: usize) {
        let Some(at) = self.cells.get(index).map(|cell| cell.center) else {
            return;
        };
        for (cell, tries) in self.cells.iter().zip(&mut self.tries) {
            if (cell.center - at).norm() < BESIDE_M {
                *tries = tries.saturating_add(1);
            }
        }
    }

    /// Removed share of these regions, by volume.
    pub(crate) fn gone(&self, regions: &[u8], state: &StateFrame) -> f64 {
        let (mut gone, mut all) = (0.0, 0.0);
        for (index, (cell, shown)) in self.cells.iter().zip(&state.cells).enumerate() {
            if self.is_in(index, regions) {
                all += cell.volume_m3;
                gone += if *shown == StateFrame::GONE {
                    cell.volume_m3
                } else {
                    0.0
                };
            }
        }
        // A region without cells counts as gone.
        if all > 0.0 { gone / all } else { 1.0 }
    }

    /// Forgets all attempts.
    pub(crate) fn begin(&mut self) {
        self.tries.fill(0);
    }

    /// Number of times that a cell was given up.
    pub(crate) fn tries(&self, index: usize) -> u8 {
        self.tries.get(index).copied().unwrap_or(u8::MAX)
    }

    /// Cells within this distance of a cell, at rest.
    pub(crate) fn around(&self, index: usize, within_m: f64) -> Vec<usize> {
        let Some(at) = self.cells.get(index).map(|cell| cell.center) else {
            return Vec::new();
        };
        let cells = self.cells.iter().enumerate();
        let near = cells.filter(|(_, cell)| (cell.center - at).norm() < within_m);
        near.map(|(index, _)| index).collect()
    }

    pub(crate) fn is_left(&self, index: usize, state: &StateFrame) -> bool {
        let shown = state.cells.get(index).filter(|_| index < self.cells.len());
        shown.is_some_and(|shown| *shown != StateFrame::GONE)
    }

    /// True if a neighbour of the cell is missing.
    pub(crate) fn is_exposed(&self, cell: &Cell, state: &StateFrame) -> bool {
        let mut beside = cell.neighbours.iter();
        beside.any(|it| *it == NO_CELL || !self.is_left(usize::from(*it), state))
    }
}

impl Cell {
    /// Sphere that carries most of the cell.
    pub(crate) fn carrier(&self) -> Option<usize> {
        let most = self.spheres.iter().max_by(|a, b| a.1.total_cmp(&b.1));
        most.map(|(sphere, _)| *sphere)
    }

    /// Present position of a cell, m.
    pub(crate) fn at(&self, sight: &Sight, state: &StateFrame) -> Vec3 {
        let moved = self.spheres.iter();
        let moved = moved.map(|(sphere, weight)| sight.moved(*sphere, state) * *weight);
        self.center + moved.sum::<Vec3>()
    }
}
