//! Layered tissue (fat, connective tissue) that is taken away bit by bit: how much heat each cell has
//! taken, and which are gone.
//!
//! A cell is gone when it has taken the energy that boils it away (`burn`), or when the strand for
//! which it stands has torn (`strand`). What is gone is not met: the contact skin over it has sunk by
//! what is missing under it (`Cells::sunk_m`), a sphere without any cells is there for nobody. What
//! remains of a sphere's cells is what remains of the bars at it. All of this is a function of the set
//! of cells that are gone, not of the order in which they went.

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

/// `Cells::shown` of a cell that is gone.
pub const GONE: u8 = u8::MAX;

/// A contact skin under which nothing is left lies so much deeper, m: farther than a tool is followed.
const OPEN_M: f32 = 0.015;
/// Cells behind each other under a contact vertex, at most.
const DEEP: usize = 32;
/// Volumes are summed in these units, so that sums do not hang on their order, m³: a micrometre's cube
/// times a thousand.
const UNIT_M3: f32 = 1.0e-15;

/// What has become of every cell.
#[derive(Debug, Clone)]
pub(crate) struct Cells {
    /// Heat taken, J.
    taken_j: [f32; MAX_CELLS],
    /// Share of the energy taken, 0 to 254, or [`GONE`].
    shown: [u8; MAX_CELLS],
    /// Something beside it is not there, or gone.
    is_exposed: [bool; MAX_CELLS],
    /// Volume of the cells that stand for each sphere, and of those that are left.
    whole: PerSphere<u32>,
    left: PerSphere<u32>,
    gone: u32,
    /// Of all that was ever given and taken since the last reset.
    history: Hash,
}

/// A cell that has just gone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Removed {
    pub(crate) cell: u16,
    pub(crate) organ: u8,
    /// Where it was, m.
    pub(crate) at_m: Vec3,
}

impl Removed {
    /// The event that tells of it.
    pub(crate) fn told(&self) -> Event {
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
            gone: 0,
            history: Hash::new(),
        }
    }

    /// Everything is there, and cold.
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
        self.gone = 0;
        self.history = Hash::new();
    }

    /// Heat taken by each of the first `count` as a share of what removes it, 0 to 254, or [`GONE`].
    pub(crate) fn shown(&self, count: usize) -> &[u8] {
        self.shown.get(..count).unwrap_or(&self.shown)
    }

    /// Of everything that was done to cells.
    pub(crate) fn history(&self) -> u32 {
        self.history.folded()
    }

    /// Whether the cell is there.
    pub(crate) fn is_there(&self, cell: u16) -> bool {
        let shown = self.shown.get(usize::from(cell));
        shown.is_some_and(|shown| *shown != GONE)
    }

    pub(crate) fn is_exposed(&self, cell: u16) -> bool {
        let exposed = self.is_exposed.get(usize::from(cell));
        exposed.copied().unwrap_or(false)
    }

    /// Whether any cells stand for a sphere.
    fn has_cells(&self, sphere: u32) -> bool {
        *self.whole.at(sphere) > 0
    }

    /// Share that is left of the cells that stand for a sphere; of one without any, all.
    pub(crate) fn left_of(&self, sphere: u32) -> f32 {
        match *self.whole.at(sphere) {
            0 => 1.0,
            whole => *self.left.at(sphere) as f32 / whole as f32,
        }
    }

    /// How far the contact skin has sunk at one of its vertices, m.
    pub(crate) fn sunk_m(&self, vertex: u16, scene: &Scene<'_>) -> f32 {
        if self.gone == 0 {
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

    /// Gives heat to a cell; whether that removes it, which [`Bodies::remove_cell`] does.
    pub(crate) fn give(&mut self, index: u16, cell: &Cell, energy_j: f32) -> bool {
        let place = usize::from(index);
        let (Some(taken_j), Some(shown)) = (self.taken_j.get_mut(place), self.shown.get_mut(place))
        else {
            return false;
        };
        // What is no number is nothing.
        let gives = energy_j > 0.0 && energy_j.is_finite() && *shown != GONE;
        if !gives {
            return false;
        }
        *taken_j = (*taken_j + energy_j).min(cell.energy_j);
        let share = *taken_j / cell.energy_j;
        *shown = (share * f32::from(GONE - 1)) as u8; // `as` cuts off
        self.history.word(u32::from(index));
        self.history.float(*taken_j);
        share >= 1.0
    }

    /// Marks a cell as gone; whether it was there.
    fn take(&mut self, index: u16, cell: &Cell, scene: &Scene<'_>) -> bool {
        if !self.is_there(index) {
            return false;
        }
        if let Some(shown) = self.shown.get_mut(usize::from(index)) {
            *shown = GONE;
        }
        for face in 0..6 {
            let beside = cell.across(face);
            if scene.layers.cell(beside).is_some()
                && let Some(exposed) = self.is_exposed.get_mut(usize::from(beside))
            {
                *exposed = true;
            }
        }
        let left = self.left.at_mut(cell.sphere());
        *left = left.saturating_sub(units(cell));
        self.gone = self.gone.saturating_add(1);
        self.history.word(u32::from(index) | 1 << 31);
        true
    }
}

/// Volume in [`UNIT_M3`].
fn units(cell: &Cell) -> u32 {
    (cell.volume_m3 / UNIT_M3) as u32 // `as` saturates
}

impl Bodies {
    /// Where the middle of a cell is, world frame, m.
    pub(crate) fn cell_at_m(&self, cell: &Cell) -> Vec3 {
        let mut at_m = Vec3::zeros();
        for (sphere, weight) in cell.spheres.iter().zip(cell.weights) {
            at_m += self.nodes.at(u32::from(*sphere)).moved_m() * weight;
        }
        at_m + cell.center_m
    }

    /// Removes every cell whose middle `is_cleared`, without a word. O(cells · attachments): for the
    /// beginning of a task.
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

    /// Removes a cell that is there; with it goes its share of the bars at its sphere.
    pub(crate) fn remove_cell(&mut self, index: u16, scene: &Scene<'_>) -> Option<Removed> {
        let cell = scene.layers.cell(index)?;
        if !self.cells.take(index, cell, scene) {
            return None;
        }
        let sphere = cell.sphere();
        let left = self.cells.left_of(sphere);
        if left <= 0.0 {
            let bits = self.bits.at_mut(sphere);
            *bits = bits.with(SphereBits::GONE);
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
