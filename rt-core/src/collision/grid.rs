//! A uniform grid over all spheres.

use crate::capacity::MAX_SPHERES;
use crate::math::Vec3;
use crate::soft_body::Bodies;

/// Cells along each axis.
const SIDE: usize = 16;
const CELLS: usize = SIDE * SIDE * SIDE;

/// Which spheres lie in which cell. Cells are at least one search reach wide, so that what is
/// within reach of a sphere lies in its own cell or a neighbouring one.
#[derive(Debug)]
pub(super) struct Grid {
    low_m: Vec3,
    per_m: f32,
    /// End of each cell's run in `spheres`; it starts where the one before ends.
    ends: [u16; CELLS],
    seen: [Seen; MAX_SPHERES],
}

/// A sphere as it was when the grid was built.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    center_m: [f32; 3],
    radius_m: f32,
    pub(super) sphere: u16,
}

impl Seen {
    const NONE: Self = Self {
        center_m: [0.0; 3],
        radius_m: 0.0,
        sphere: 0,
    };

    /// Whether it then came nearer than `reach_m` to `center_m`.
    #[inline(always)]
    pub(super) fn is_near(&self, center_m: &[f32; 3], reach_m: f32) -> bool {
        let [x, y, z] = self.center_m;
        let [u, v, w] = *center_m;
        let (x, y, z, within_m) = (x - u, y - v, z - w, self.radius_m + reach_m);
        x * x + y * y + z * z < within_m * within_m
    }
}

type Cell = [usize; 3];

fn slot(cell: Cell) -> usize {
    let [x, y, z] = cell;
    x + SIDE * (y + SIDE * z)
}

impl Grid {
    pub(super) const fn new() -> Self {
        Self {
            low_m: Vec3::new(0.0, 0.0, 0.0),
            per_m: 0.0,
            ends: [0; CELLS],
            seen: [Seen::NONE; MAX_SPHERES],
        }
    }

    /// Sorts these spheres into cells at least `reach_m` wide. O(spheres + cells).
    pub(super) fn build(&mut self, bodies: &Bodies, spheres: &[u16], reach_m: f32) {
        let center_m = |sphere: u16| bodies.nodes.at(u32::from(sphere)).center_m();
        let big = Vec3::new(f32::MAX, f32::MAX, f32::MAX);
        let (low, high) = spheres.iter().fold((big, -big), |(low, high), &sphere| {
            let center = center_m(sphere);
            (low.inf(&center), high.sup(&center))
        });
        self.low_m = low;
        self.per_m = reach_m
            .max((high - low).max() / SIDE as f32)
            .max(1.0e-6)
            .recip();
        self.ends.fill(0);
        for &sphere in spheres {
            let cell = slot(self.cell(&center_m(sphere)));
            if let Some(end) = self.ends.get_mut(cell) {
                *end += 1;
            }
        }
        // Running sums; then each cell's end walks down to its start as the cell is filled …
        let mut sum = 0;
        for end in &mut self.ends {
            sum += *end;
            *end = sum;
        }
        for &sphere in spheres.iter().rev() {
            let cell = slot(self.cell(&center_m(sphere)));
            let Some(end) = self.ends.get_mut(cell) else {
                continue;
            };
            *end = end.saturating_sub(1);
            if let Some(place) = self.seen.get_mut(usize::from(*end)) {
                *place = Seen {
                    center_m: center_m(sphere).into(),
                    radius_m: *bodies.radius_m.at(sphere.into()),
                    sphere,
                };
            }
        }
        // … and so each holds its start, which is the end of the one before.
        self.ends.rotate_left(1);
        if let Some(last) = self.ends.last_mut() {
            *last = sum;
        }
    }

    fn cell(&self, center_m: &Vec3) -> Cell {
        let at = (center_m - self.low_m) * self.per_m;
        // `as` saturates and takes NaN to 0.
        [at.x, at.y, at.z].map(|x| (x as usize).min(SIDE - 1))
    }

    /// Runs of spheres within reach of `center_m`, in a fixed order.
    pub(super) fn near(&self, center_m: &Vec3) -> impl Iterator<Item = &[Seen]> {
        let [x, y, z] = self.cell(center_m);
        let around = |i: usize| i.saturating_sub(1)..=(i + 1).min(SIDE - 1);
        around(z)
            .flat_map(move |z| around(y).map(move |y| (y, z)))
            .map(move |(y, z)| {
                let first = slot([x.saturating_sub(1), y, z]);
                let last = slot([(x + 1).min(SIDE - 1), y, z]);
                let start = first
                    .checked_sub(1)
                    .and_then(|i| self.ends.get(i))
                    .copied()
                    .unwrap_or(0);
                let end = self.ends.get(last).copied().unwrap_or(0);
                self.seen
                    .get(usize::from(start)..usize::from(end))
                    .unwrap_or(&[])
            })
    }
}
