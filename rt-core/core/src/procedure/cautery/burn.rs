//! Cells under the bare tip of the hook.

use heapless::Vec;

use crate::capacity::MAX_ORGANS;
use crate::procedure::cautery::{Dose, Electrode};
use crate::scene::{Cell, Scene};
use crate::tissue::cells::Removed;
use crate::tissue::{Bodies, Bounds};

/// Largest number of cells under a tip; further cells absorb no heat in this tick.
const TOUCHED_MAX: usize = 48;
/// Distance from the electrode's middle within which a cell is tested, m. This first check uses an
/// approximate position of the cell, from its nearest sphere alone.
const SEARCH_RADIUS_M: f32 = 0.010;

/// Radius of the ball that approximates a cell, as a share of the cell's longest side.
const RADIUS_SHARE: f32 = 0.5;

/// Contact area of an electrode with a cell, m².
#[derive(Debug, Clone, Copy)]
pub(crate) struct TouchedCell {
    pub(crate) cell: u16,
    pub(crate) organ: u8,
    pub(crate) area_m2: f32,
}

impl Bodies {
    /// Heats the exposed cells that an electrode touches, for a tick. `burnt` receives the organ
    /// and the heat of each cell, J; `removed` receives each cell that has boiled away.
    pub(crate) fn burn_cells(
        &mut self,
        touched: &[TouchedCell],
        dose: &Dose,
        scene: &Scene<'_>,
        mut burnt: impl FnMut(u8, f32),
        mut removed: impl FnMut(Removed),
    ) {
        for touched in touched {
            let energy_j = dose.total_j_m2() * touched.area_m2;
            let Some(record) = scene.layers.cell(touched.cell) else {
                continue;
            };
            burnt(touched.organ, energy_j);
            if self.cells.add_heat(touched.cell, record, energy_j)
                && let Some(cell) = self.remove_cell(touched.cell, scene)
            {
                removed(cell);
            }
        }
    }

    /// Exposed cells that an electrode touches. O(cells of organs near it).
    pub(crate) fn touched_cells(
        &self,
        electrode: &Electrode,
        scene: &Scene<'_>,
        bounds: &[Bounds; MAX_ORGANS],
    ) -> Vec<TouchedCell, TOUCHED_MAX> {
        let mut touched = Vec::new();
        let middle_m = electrode.middle_m();
        let mut around = Bounds::EMPTY;
        around.add(&middle_m, SEARCH_RADIUS_M);
        let mut near = [false; MAX_ORGANS];
        for ((near, bounds), _) in near.iter_mut().zip(bounds).zip(scene.organs) {
            *near = bounds.is_near(&around, 0.0);
        }
        for (index, cell) in (0u16..).zip(scene.layers.cells) {
            let is_candidate = self.cells.is_exposed(index) && self.cells.is_present(index);
            let organ = *self.organ.at(cell.sphere());
            if !is_candidate || !near.get(usize::from(organ)).is_some_and(|near| *near) {
                continue;
            }
            let approximate_m = cell.center_m + self.nodes.at(cell.sphere()).moved_m();
            if (approximate_m - middle_m).norm_squared() > SEARCH_RADIUS_M * SEARCH_RADIUS_M {
                continue;
            }
            let share = electrode.touches_ball(&self.cell_at_m(cell), radius_m(cell));
            if share > 0.0 {
                let area_m2 = face_m2(cell) * share;
                if touched
                    .push(TouchedCell {
                        cell: index,
                        organ,
                        area_m2,
                    })
                    .is_err()
                {
                    break;
                }
            }
        }
        touched
    }
}

fn radius_m(cell: &Cell) -> f32 {
    RADIUS_SHARE * cell.extent_m.iter().copied().fold(0.0, f32::max)
}

/// Mean cross-section of the cell perpendicular to its longest side, m².
fn face_m2(cell: &Cell) -> f32 {
    let longest_m = cell.extent_m.iter().copied().fold(1.0e-6, f32::max);
    cell.volume_m3 / longest_m
}
