//! Layered tissue (fat, connective tissue) that is removed cell by cell.
//!
//! A cell is removed when it has taken the energy that boils it away (`burn`), or when the
//! attachments of its sphere have torn (`strand`). The contact skin sinks by the thickness that is
//! missing under it (`Cells::sunk_m`). A sphere that has lost all cells meets nothing. The
//! stiffness of a sphere's links and attachments falls with the share of its cells that is left.
//! All of this depends on the set of removed cells, not on their order.

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

/// Value in `Cells::shown` of a removed cell.
pub const REMOVED: u8 = u8::MAX;

/// Depth added to a contact skin under which nothing is left, m: more than the distance at which
/// tools are tracked.
const OPEN_M: f32 = 0.015;
/// Largest number of cells behind each other under a contact vertex.
const DEEP: usize = 32;
/// Unit in which volumes are summed, m³ (10 µm cubed). Sums of integers do not depend on their
/// order.
const UNIT_M3: f32 = 1.0e-15;

/// State of every cell.
#[derive(Debug, Clone)]
pub(crate) struct Cells {
    /// Heat taken, J.
    taken_j: [f32; MAX_CELLS],
    /// Share of the energy taken, 0 to 254, or [`REMOVED`].
    shown: [u8; MAX_CELLS],
    /// True if a neighbour is missing or removed.
    is_exposed: [bool; MAX_CELLS],
    /// Volume of the cells of each sphere, at first and remaining, in [`UNIT_M3`].
    whole: PerSphere<u32>,
    left: PerSphere<u32>,
    removed: u32,
    /// Hash of everything that was given and removed since the last reset.
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
    pub(crate) fn reported(&self) -> Event {
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
            taken_j: [0.0; MAX_CELLS],
            shown: [0; MAX_CELLS],
            is_exposed: [false; MAX_CELLS],
            whole: PerSphere::new(0),
            left: PerSphere::new(0),
            removed: 0,
            history: Hash::new(),
        }
    }

    /// Restores every cell, cold.
    pub(crate) fn rest(&mut self, scene: &Scene<'_>) {
        for sphere in 0..scene.spheres.len() as u32 {
            *self.whole.at_mut(sphere) = 0;
        }
        let cells = scene.layers.cells.iter().zip(&mut self.taken_j);
        for (((cell, taken_j), shown), exposed) in
            cells.zip(&mut self.shown).zip(&mut self.is_exposed)
        {
            (*taken_j, *shown) = (0.0, 0);
            *exposed = (0..6).any(|face| scene.layers.cell(cell.across(face)).is_none());
            let whole = self.whole.at_mut(cell.sphere());
            *whole = whole.saturating_add(units(cell));
        }
        for sphere in 0..scene.spheres.len() as u32 {
            *self.left.at_mut(sphere) = *self.whole.at(sphere);
        }
        self.removed = 0;
        self.history = Hash::new();
    }

    /// Heat taken by each of the first `count` cells, as a share of the energy that removes it, 0
    /// to 254; or [`REMOVED`].
    pub(crate) fn shown(&self, count: usize) -> &[u8] {
        self.shown.get(..count).unwrap_or(&self.shown)
    }

    /// Hash of everything that was done to cells.
    pub(crate) fn history(&self) -> u32 {
        self.history.folded()
    }

    /// True if the cell is not removed.
    pub(crate) fn is_there(&self, cell: u16) -> bool {
        let shown = self.shown.get(usize::from(cell));
        shown.is_some_and(|shown| *shown != REMOVED)
    }

    pub(crate) fn is_exposed(&self, cell: u16) -> bool {
        let exposed = self.is_exposed.get(usize::from(cell));
        exposed.copied().unwrap_or(false)
    }

    /// True if the sphere has cells.
    fn has_cells(&self, sphere: u32) -> bool {
        *self.whole.at(sphere) > 0
    }

    /// Remaining share of the cells of a sphere; 1 for a sphere without cells.
    pub(crate) fn left_of(&self, sphere: u32) -> f32 {
        match *self.whole.at(sphere) {
            0 => 1.0,
            whole => *self.left.at(sphere) as f32 / whole as f32,
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
            for _ in 0..DEEP {
                let Some((index, cell)) = next else {
                    break;
                };
                if self.is_there(index) {
                    break;
                }
                sum_m += cell.through_m(inwards);
                let behind = cell.across(inwards);
                next = scene.layers.cell(behind).map(|cell| (behind, cell));
                sum_m += if next.is_none() { OPEN_M } else { 0.0 };
            }
        }
        if count > 0.0 { sum_m / count } else { 0.0 }
    }

    /// Gives heat to a cell. Returns true if the heat suffices to remove the cell, which the caller
    /// then does ([`Bodies::remove_cell`]).
    pub(crate) fn give(&mut self, index: u16, cell: &Cell, energy_j: f32) -> bool {
        let place = usize::from(index);
        let (Some(taken_j), Some(shown)) = (self.taken_j.get_mut(place), self.shown.get_mut(place))
        else {
            return false;
        };
        // NaN counts as no heat.
        let gives = energy_j > 0.0 && energy_j.is_finite() && *shown != REMOVED;
        if !gives {
            return false;
        }
        *taken_j = (*taken_j + energy_j).min(cell.energy_j);
        let share = *taken_j / cell.energy_j;
        *shown = (share * f32::from(REMOVED - 1)) as u8; // `as` cuts off
        self.history.word(u32::from(index));
        self.history.float(*taken_j);
        share >= 1.0
    }

    /// Marks a cell as removed. Returns true if it was there.
    fn take(&mut self, index: u16, cell: &Cell, scene: &Scene<'_>) -> bool {
        if !self.is_there(index) {
            return false;
        }
        if let Some(shown) = self.shown.get_mut(usize::from(index)) {
            *shown = REMOVED;
        }
        for face in 0..6 {
            let adjacent = cell.across(face);
            if scene.layers.cell(adjacent).is_some()
                && let Some(exposed) = self.is_exposed.get_mut(usize::from(adjacent))
            {
                *exposed = true;
            }
        }
        let left = self.left.at_mut(cell.sphere());
        *left = left.saturating_sub(units(cell));
        self.removed = self.removed.saturating_add(1);
        self.history.word(u32::from(index) | 1 << 31);
        true
    }
}

/// Volume in [`UNIT_M3`].
fn units(cell: &Cell) -> u32 {
    (cell.volume_m3 / UNIT_M3) as u32 // `as` saturates
}

impl Bodies {
    /// Present middle of a cell, world frame, m.
    pub(crate) fn cell_at_m(&self, cell: &Cell) -> Vec3 {
        let mut at_m = Vec3::zeros();
        for (sphere, weight) in cell.spheres.iter().zip(cell.weights) {
            at_m += self.nodes.at(u32::from(*sphere)).moved_m() * weight;
        }
        at_m + cell.center_m
    }

    /// Removes every cell whose middle `is_cleared`, without an event. O(cells · attachments): at
    /// the start of a task.
    pub(crate) fn clear_cells(
        &mut self,
        scene: &Scene<'_>,
        mut is_cleared: impl FnMut(&Self, &Vec3) -> bool,
    ) {
        for (index, cell) in (0u16..).zip(scene.layers.cells) {
            let at_m = self.cell_at_m(cell);
            if is_cleared(self, &at_m) {
                let _ = self.remove_cell(index, scene); // none if it is gone already
            }
        }
    }

    /// Removes a cell, and weakens the links and attachments of its sphere; `None` if the cell was
    /// removed before.
    pub(crate) fn remove_cell(&mut self, index: u16, scene: &Scene<'_>) -> Option<Removed> {
        let cell = scene.layers.cell(index)?;
        if !self.cells.take(index, cell, scene) {
            return None;
        }
        let sphere = cell.sphere();
        let left = self.cells.left_of(sphere);
        if left <= 0.0 {
            let bits = self.bits.at_mut(sphere);
            *bits = bits.with(SphereBits::REMOVED);
        }
        let organ = *self.organ.at(sphere);
        for (i, tie) in scene.attachments.iter().enumerate() {
            if tie.sphere == sphere || tie.to == Anchor::Sphere(sphere) {
                self.parted.leave_of_tie(i, left);
            }
        }
        if let Some(own) = scene.organs.get(usize::from(organ)) {
            for (i, link) in (own.link_start..).zip(scene.links_of(own)) {
                if link.a == sphere || link.b == sphere {
                    self.parted.leave_of_link(i, left);
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
