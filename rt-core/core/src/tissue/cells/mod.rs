//! Layered tissue (fat, connective tissue) that is removed cell by cell.
//!
//! A cell is removed when it has absorbed the energy that boils it away (`burn`), or when the
//! attachments of its sphere have torn (`strand`). The contact skin sinks by the thickness of the
//! removed cells under it (`Cells::sunk_m`). A sphere that has lost all cells touches nothing. The
//! stiffness of a sphere's links and attachments falls with the remaining share of its cells. All
//! of this depends on the set of removed cells, not on the order of removal.

mod strand;
#[cfg(test)]
mod tests;

use crate::capacity::MAX_CELLS;
use crate::hash::Hash;
use crate::math::Vec3;
use crate::scene::{Anchor, Cell, Scene};
use crate::tissue::Bodies;
use crate::tissue::per_sphere::PerSphere;
use crate::words::{Event, EventKind, SphereBits};

/// Value in `Cells::heat_code` of a removed cell.
pub const REMOVED: u8 = u8::MAX;

/// Depth added to a contact skin under which no cell is left, m: more than the distance at which
/// tools are tracked.
const OPEN_DEPTH_M: f32 = 0.015;
/// Largest number of cells in the column under a vertex of the contact skin.
const COLUMN_CELLS_MAX: usize = 32;
/// Unit in which volumes are summed, m³ (10 µm cubed). Sums of integers do not depend on their
/// order.
const VOLUME_UNIT_M3: f32 = 1.0e-15;

/// State of every cell.
#[derive(Debug, Clone)]
pub(crate) struct Cells {
    /// Heat absorbed, J.
    heat_j: [f32; MAX_CELLS],
    /// Heat absorbed as a share of the energy that removes the cell, 0 to 254; or [`REMOVED`].
    heat_code: [u8; MAX_CELLS],
    /// True if a neighbour is missing or removed.
    is_exposed: [bool; MAX_CELLS],
    /// Initial and remaining volume of the cells of each sphere, in [`VOLUME_UNIT_M3`].
    initial_units: PerSphere<u32>,
    remaining_units: PerSphere<u32>,
    removed: u32,
    /// Hash of all heat and removals since the last reset.
    history: Hash,
}

/// A cell that was just removed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Removed {
    pub(crate) cell: u16,
    pub(crate) organ: u8,
    /// Its last position, world frame, m.
    pub(crate) at_m: Vec3,
}

impl Removed {
    /// Its event.
    pub(crate) fn event(&self) -> Event {
        Event {
            kind: EventKind::Removed,
            organ: Some(u32::from(self.organ)),
            at_m: self.at_m,
            value: f32::from(self.cell),
        }
    }
}

impl Cells {
    pub(crate) const fn new() -> Self {
        Self {
            heat_j: [0.0; MAX_CELLS],
            heat_code: [0; MAX_CELLS],
            is_exposed: [false; MAX_CELLS],
            initial_units: PerSphere::new(0),
            remaining_units: PerSphere::new(0),
            removed: 0,
            history: Hash::new(),
        }
    }

    /// Restores every cell, cold.
    pub(crate) fn reset(&mut self, scene: &Scene<'_>) {
        for sphere in 0..scene.spheres.len() as u32 {
            *self.initial_units.at_mut(sphere) = 0;
        }
        let cells = scene.layers.cells.iter().zip(&mut self.heat_j);
        for (((cell, heat_j), heat_code), exposed) in
            cells.zip(&mut self.heat_code).zip(&mut self.is_exposed)
        {
            (*heat_j, *heat_code) = (0.0, 0);
            *exposed = (0..6).any(|face| scene.layers.cell(cell.across(face)).is_none());
            let initial_units = self.initial_units.at_mut(cell.sphere());
            *initial_units = initial_units.saturating_add(volume_units(cell));
        }
        for sphere in 0..scene.spheres.len() as u32 {
            *self.remaining_units.at_mut(sphere) = *self.initial_units.at(sphere);
        }
        self.removed = 0;
        self.history = Hash::new();
    }

    /// Heat absorbed by each of the first `count` cells, as a share of the energy that removes it,
    /// 0 to 254; or [`REMOVED`].
    pub(crate) fn heat_code(&self, count: usize) -> &[u8] {
        self.heat_code.get(..count).unwrap_or(&self.heat_code)
    }

    /// Hash of all heat and removals since the last reset.
    pub(crate) fn history(&self) -> u32 {
        self.history.folded()
    }

    /// True if the cell is not removed.
    pub(crate) fn is_present(&self, cell: u16) -> bool {
        let heat_code = self.heat_code.get(usize::from(cell));
        heat_code.is_some_and(|heat_code| *heat_code != REMOVED)
    }

    pub(crate) fn is_exposed(&self, cell: u16) -> bool {
        let exposed = self.is_exposed.get(usize::from(cell));
        exposed.copied().unwrap_or(false)
    }

    /// True if the sphere has cells.
    fn has_cells(&self, sphere: u32) -> bool {
        *self.initial_units.at(sphere) > 0
    }

    /// Remaining share of the cells of a sphere; 1 for a sphere without cells.
    pub(crate) fn remaining_share(&self, sphere: u32) -> f32 {
        match *self.initial_units.at(sphere) {
            0 => 1.0,
            initial_units => *self.remaining_units.at(sphere) as f32 / initial_units as f32,
        }
    }

    /// Depth by which the contact skin has sunk at one of its vertices, m.
    pub(crate) fn sunk_m(&self, vertex: u16, scene: &Scene<'_>) -> f32 {
        if self.removed == 0 {
            return 0.0;
        }
        let Some(column) = scene.layers.column(vertex) else {
            return 0.0;
        };
        let (mut sum_m, mut count) = (0.0, 0.0f32);
        for (first, inwards) in column.cells.iter().zip(column.inwards) {
            let mut next = scene.layers.cell(*first).map(|cell| (*first, cell));
            count += if next.is_some() { 1.0 } else { 0.0 };
            for _ in 0..COLUMN_CELLS_MAX {
                let Some((index, cell)) = next else {
                    break;
                };
                if self.is_present(index) {
                    break;
                }
                sum_m += cell.through_m(inwards);
                let behind = cell.across(inwards);
                next = scene.layers.cell(behind).map(|cell| (behind, cell));
                sum_m += if next.is_none() { OPEN_DEPTH_M } else { 0.0 };
            }
        }
        if count > 0.0 { sum_m / count } else { 0.0 }
    }

    /// Adds heat to a cell. Returns true if the absorbed heat suffices to remove the cell; the
    /// caller then removes it ([`Bodies::remove_cell`]).
    pub(crate) fn add_heat(&mut self, index: u16, cell: &Cell, energy_j: f32) -> bool {
        let place = usize::from(index);
        let (Some(heat_j), Some(heat_code)) =
            (self.heat_j.get_mut(place), self.heat_code.get_mut(place))
        else {
            return false;
        };
        // NaN counts as no heat.
        let is_heat = energy_j > 0.0 && energy_j.is_finite() && *heat_code != REMOVED;
        if !is_heat {
            return false;
        }
        *heat_j = (*heat_j + energy_j).min(cell.energy_j);
        let share = *heat_j / cell.energy_j;
        *heat_code = (share * f32::from(REMOVED - 1)) as u8; // `as` truncates
        self.history.word(u32::from(index));
        self.history.float(*heat_j);
        share >= 1.0
    }

    /// Marks a cell as removed. Returns true if it was present.
    fn mark_removed(&mut self, index: u16, cell: &Cell, scene: &Scene<'_>) -> bool {
        if !self.is_present(index) {
            return false;
        }
        if let Some(heat_code) = self.heat_code.get_mut(usize::from(index)) {
            *heat_code = REMOVED;
        }
        for face in 0..6 {
            let adjacent = cell.across(face);
            if scene.layers.cell(adjacent).is_some()
                && let Some(exposed) = self.is_exposed.get_mut(usize::from(adjacent))
            {
                *exposed = true;
            }
        }
        let remaining_units = self.remaining_units.at_mut(cell.sphere());
        *remaining_units = remaining_units.saturating_sub(volume_units(cell));
        self.removed = self.removed.saturating_add(1);
        self.history.word(u32::from(index) | 1 << 31);
        true
    }
}

/// Volume in [`VOLUME_UNIT_M3`].
fn volume_units(cell: &Cell) -> u32 {
    (cell.volume_m3 / VOLUME_UNIT_M3) as u32 // `as` saturates
}

impl Bodies {
    /// Present position of a cell's middle, world frame, m.
    pub(crate) fn cell_at_m(&self, cell: &Cell) -> Vec3 {
        let mut at_m = Vec3::zeros();
        for (sphere, weight) in cell.spheres.iter().zip(cell.weights) {
            at_m += self.nodes.at(u32::from(*sphere)).moved_m() * weight;
        }
        at_m + cell.center_m
    }

    /// Removes every cell whose middle `is_cleared`, without an event. Used at the start of a task.
    /// O(cells · attachments).
    pub(crate) fn clear_cells(
        &mut self,
        scene: &Scene<'_>,
        mut is_cleared: impl FnMut(&Self, &Vec3) -> bool,
    ) {
        for (index, cell) in (0u16..).zip(scene.layers.cells) {
            let at_m = self.cell_at_m(cell);
            if is_cleared(self, &at_m) {
                let _ = self.remove_cell(index, scene); // `None` if it is removed already
            }
        }
    }

    /// Removes a cell, and weakens the links and attachments of its sphere; `None` if the cell was
    /// removed before.
    pub(crate) fn remove_cell(&mut self, index: u16, scene: &Scene<'_>) -> Option<Removed> {
        let cell = scene.layers.cell(index)?;
        if !self.cells.mark_removed(index, cell, scene) {
            return None;
        }
        let sphere = cell.sphere();
        let remaining_units = self.cells.remaining_share(sphere);
        if remaining_units <= 0.0 {
            let bits = self.bits.at_mut(sphere);
            *bits = bits.with(SphereBits::REMOVED);
        }
        let organ = *self.organ.at(sphere);
        for (i, tie) in scene.attachments.iter().enumerate() {
            if tie.sphere == sphere || tie.to == Anchor::Sphere(sphere) {
                self.damage.weaken_tie(i, remaining_units);
            }
        }
        if let Some(organ_record) = scene.organs.get(usize::from(organ)) {
            for (i, link) in (organ_record.link_start..).zip(scene.links_of(organ_record)) {
                if link.a == sphere || link.b == sphere {
                    self.damage.weaken_link(i, remaining_units);
                }
            }
        }
        Some(Removed {
            cell: index,
            organ,
            at_m: self.cell_at_m(cell),
        })
    }
}
