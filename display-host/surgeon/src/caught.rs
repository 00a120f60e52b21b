//! What hangs on the hook: a duct or vessel, or fat. Whoever pulled on would tear it.
//!
//! Tissue that was pushed in follows a hook that withdraws, because it returns to its place. So only
//! what moves away from its place at rest hangs.

use shared_mem::scene::CellRecord;

use crate::hold::{ELECTRODE_M, Hook};
use crate::sight::{Bar, off_line};
use crate::vector::Vec3;
use crate::work::Work;

/// A duct or vessel within this distance of the hook may hang on the hook, m.
const HANGS_M: f64 = 0.0012;
/// A duct or vessel that has moved along with the hook by this distance hangs on the hook, m.
const COMES_ALONG_M: f64 = 0.004;
/// Fat whose nearest cell is within this distance of the electrode may hang on it, m.
const HOLDS_M: f64 = 0.0005;
/// Fat that has moved along with the electrode by this distance hangs on it, m. Fat gives way more
/// than tubes do.
const FAT_ALONG_M: f64 = 0.006;

/// A sphere of what may hang on the hook, and its position when the hook came near.
pub(crate) type Hanging = (usize, Vec3);

impl Work<'_> {
    /// The duct or vessel nearest to the hook, if it has come along with it.
    pub(crate) fn tube_along(&self, hanging: &mut Option<Hanging>) -> Option<Hanging> {
        let electrode = self.electrode()?;
        let state = &self.seen.state;
        let hook = Hook::seen(electrode, self.sight.port());
        let tubes = self.sight.delicate(self.works(), 0.03, state);
        let tubes = tubes.iter().filter(|bar| bar.tube.is_some());
        let room_m = |bar: &&Bar| hook.room([*bar]).0;
        let nearest = tubes.min_by(|a, b| room_m(a).total_cmp(&room_m(b)));
        let near = nearest.filter(|bar| room_m(bar) < HANGS_M);
        let near = near.and_then(|bar| bar.tube.map(|sphere| (sphere, bar.ends[0])));
        self.comes_along(hanging, near, COMES_ALONG_M)
    }

    /// The fat nearest to the electrode, if it has come along with it. Strands of the gallbladder's
    /// bed do not count: they are there to be pulled.
    pub(crate) fn fat_along(&self, hanging: &mut Option<Hanging>) -> Option<Hanging> {
        let electrode = self.electrode()?;
        let state = &self.seen.state;
        let cells = self.field.cells.iter().enumerate().filter(|(index, cell)| {
            let is_fat = [CellRecord::TRIANGLE, CellRecord::NOWHERE].contains(&cell.region);
            is_fat && self.field.is_left(*index, state)
        });
        let near = cells.filter_map(|(_, cell)| {
            let off_m = off_line(cell.at(&self.sight, state), electrode);
            let room_m = off_m - cell.radius_m - ELECTRODE_M;
            (room_m < HOLDS_M).then_some((room_m, cell))
        });
        let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0));
        let near = nearest.and_then(|(_, cell)| {
            let sphere = cell.carrier()?;
            Some((sphere, self.sight.now(sphere, state)))
        });
        self.comes_along(hanging, near, FAT_ALONG_M)
    }

    /// What hangs, if the sphere that first came near has moved along by more than `most_m`.
    fn comes_along(
        &self,
        hanging: &mut Option<Hanging>,
        near: Option<Hanging>,
        most_m: f64,
    ) -> Option<Hanging> {
        let state = &self.seen.state;
        let now = |sphere| {
            [
                self.sight.now(sphere, state),
                self.sight.moved(sphere, state),
            ]
        };
        hangs(hanging, near, most_m, now).then_some(*hanging)?
    }
}

/// True if the sphere that first came near has moved by more than `most_m`, away from its place at
/// rest, and something has been near ever since. `near` is the sphere now near, if any, and its
/// position. `now` gives the position of a sphere, and its displacement from rest.
fn hangs(
    hanging: &mut Option<Hanging>,
    near: Option<Hanging>,
    most_m: f64,
    now: impl Fn(usize) -> [Vec3; 2],
) -> bool {
    *hanging = near.map(|near| hanging.unwrap_or(near));
    hanging.is_some_and(|(sphere, was)| {
        let [now, moved] = now(sphere);
        let before = was - (now - moved);
        (now - was).norm() > most_m && moved.norm() > before.norm()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_duct_hangs_on_the_hook_once_it_has_come_along() {
        let at = |mm: f64| Vec3::x() * (mm * 1e-3);
        let mut hanging = None;
        let mut look = |sphere: Option<usize>, moved_mm: f64| {
            let near = sphere.map(|it| (it, at(moved_mm)));
            hangs(&mut hanging, near, COMES_ALONG_M, |_| [at(moved_mm); 2])
        };
        // The tube came near at 2 mm. Later another of its spheres may be the nearest.
        assert!(!look(Some(7), 2.0) && !look(Some(8), 5.0));
        assert!(look(Some(8), 6.5));
        // A tube that the hook has left no longer hangs, however far it goes.
        assert!(!look(None, 20.0) && !look(Some(7), 20.0) && !look(Some(7), 23.0));
        assert!(look(Some(7), 24.5));
    }

    #[test]
    fn tissue_that_returns_to_its_place_does_not_hang() {
        let at = |mm: f64| Vec3::x() * (mm * 1e-3);
        let mut hanging = None;
        let mut look = |moved_mm: f64| {
            hangs(&mut hanging, Some((7, at(moved_mm))), COMES_ALONG_M, |_| {
                [at(moved_mm); 2]
            })
        };
        // It was pushed by 8 mm, follows the hook home, and then beyond its place.
        assert!(!look(-8.0) && !look(-3.0) && !look(0.0) && !look(7.0));
        assert!(look(8.5));
    }
}
