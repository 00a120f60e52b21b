//! A grid over the spheres of each organ. A search for the spheres near a place visits only the
//! grid cells around the place.

use crate::capacity::{MAX_ORGANS, MAX_SPHERES};
use crate::math::Vec3;
use crate::tissue::{Bodies, Bounds};

/// Mean number of spheres in a grid cell. With fewer spheres, a search visits more rows of cells,
/// and each row costs time.
const SPHERES_IN_CELL: usize = 2;
/// Cells of all organs together.
const CELLS: usize = MAX_SPHERES / SPHERES_IN_CELL + MAX_ORGANS;
/// Factor by which cells are widened, until they are few enough.
const WIDENING: f32 = 1.25;
/// Largest number of cells along the longest side of an organ's box.
const SIDE_MAX: f32 = 48.0;

/// The grid cells of an organ.
#[derive(Debug, Clone, Copy)]
struct OrganGrid {
    /// Box around the centres of its spheres, m.
    bounds: Bounds,
    cells_per_m: f32,
    sides: [usize; 3],
    /// Index of the organ's first cell.
    first_cell: usize,
    /// Reach of the widest sphere, m.
    reach_m: f32,
    count: usize,
}

impl OrganGrid {
    const NONE: Self = Self {
        bounds: Bounds::EMPTY,
        cells_per_m: 0.0,
        sides: [0; 3],
        first_cell: 0,
        reach_m: 0.0,
        count: 0,
    };

    /// Divides the box into `cells_max` cells at most.
    fn divide(&mut self, cells_max: usize) {
        let size_m = self.bounds.high_m - self.bounds.low_m;
        let mut width_m = (size_m.max() / SIDE_MAX).max(1.0e-5);
        self.sides = [1; 3];
        self.cells_per_m = 0.0;
        for _ in 0..32 {
            // `as` saturates and takes NaN to 0.
            let side = |m: f32| ((m / width_m) as usize).saturating_add(1);
            let sides = [size_m.x, size_m.y, size_m.z].map(side);
            let [x, y, z] = sides;
            if x.saturating_mul(y).saturating_mul(z) <= cells_max {
                (self.sides, self.cells_per_m) = (sides, width_m.recip());
                break;
            }
            width_m *= WIDENING;
        }
    }

    /// Index along each axis of the cell that contains a place, or of the nearest cell.
    fn cell(&self, at_m: &Vec3) -> [usize; 3] {
        let at = (at_m - self.bounds.low_m) * self.cells_per_m;
        let [sx, sy, sz] = self.sides;
        let cell = |x: f32, side: usize| (x as usize).min(side.saturating_sub(1));
        [cell(at.x, sx), cell(at.y, sy), cell(at.z, sz)]
    }

    fn slot(&self, [x, y, z]: [usize; 3]) -> usize {
        let [sx, sy, _] = self.sides;
        self.first_cell + x + sx * (y + sy * z)
    }
}

/// Spheres sorted by cell.
#[derive(Debug, Clone)]
pub(super) struct Grid {
    organs: [OrganGrid; MAX_ORGANS],
    /// End of each cell's run in `spheres`. The run starts at the end of the run before it.
    ends: [u16; CELLS],
    spheres: [GridSphere; MAX_SPHERES],
}

/// Position and reach of a sphere when the grid was built.
#[derive(Debug, Clone, Copy)]
pub(super) struct GridSphere {
    center_m: [f32; 3],
    reach_m: f32,
    pub(super) sphere: u16,
}

impl GridSphere {
    const NONE: Self = Self {
        center_m: [0.0; 3],
        reach_m: 0.0,
        sphere: 0,
    };

    /// True if this sphere's centre was nearer to `center_m` than the sum of its reach and
    /// `reach_m`.
    #[inline(always)]
    pub(super) fn is_near(&self, center_m: &[f32; 3], reach_m: f32) -> bool {
        let [x, y, z] = self.center_m;
        let [u, v, w] = *center_m;
        let (x, y, z, reach_sum_m) = (x - u, y - v, z - w, self.reach_m + reach_m);
        x * x + y * y + z * z < reach_sum_m * reach_sum_m
    }
}

impl Grid {
    pub(super) const fn new() -> Self {
        Self {
            organs: [OrganGrid::NONE; MAX_ORGANS],
            ends: [0; CELLS],
            spheres: [GridSphere::NONE; MAX_SPHERES],
        }
    }

    /// Sorts spheres, each with its reach, m, into cells. O(spheres + cells).
    pub(super) fn build(&mut self, bodies: &Bodies, spheres: &[u16], reach_m: impl Fn(u32) -> f32) {
        let center_m = |sphere: u32| bodies.nodes.at(sphere).center_m();
        let organ = |sphere: u32| usize::from(*bodies.organ.at(sphere));
        let all = || spheres.iter().map(|&sphere| u32::from(sphere));
        self.organs = [OrganGrid::NONE; MAX_ORGANS];
        for sphere in all() {
            if let Some(organ_grid) = self.organs.get_mut(organ(sphere)) {
                organ_grid.bounds.add(&center_m(sphere), 0.0);
                organ_grid.reach_m = organ_grid.reach_m.max(reach_m(sphere));
                organ_grid.count += 1;
            }
        }
        let mut first_cell = 0;
        for organ_grid in self
            .organs
            .iter_mut()
            .filter(|organ_grid| organ_grid.count > 0)
        {
            organ_grid.divide((organ_grid.count / SPHERES_IN_CELL).max(1));
            organ_grid.first_cell = first_cell;
            first_cell += organ_grid.sides.iter().product::<usize>();
        }
        self.ends.fill(0);
        for sphere in all() {
            let cell = self.slot(organ(sphere), &center_m(sphere));
            if let Some(end) = self.ends.get_mut(cell) {
                *end += 1;
            }
        }
        // Counting sort: running sums give the end of each cell. Filling a cell from its end moves
        // the entry down to the cell's start.
        let mut sum = 0;
        for end in &mut self.ends {
            sum += *end;
            *end = sum;
        }
        for sphere in all().rev() {
            let center_m = center_m(sphere);
            let cell = self.slot(organ(sphere), &center_m);
            let Some(end) = self.ends.get_mut(cell) else {
                continue;
            };
            *end = end.saturating_sub(1);
            if let Some(slot) = self.spheres.get_mut(usize::from(*end)) {
                *slot = GridSphere {
                    center_m: center_m.into(),
                    reach_m: reach_m(sphere),
                    sphere: sphere as u16, // sphere indices fit: asserted in `capacity`
                };
            }
        }
        // Each entry now holds the start of its cell, which is the end of the cell before it.
        self.ends.rotate_left(1);
        if let Some(last) = self.ends.last_mut() {
            *last = sum;
        }
    }

    fn slot(&self, organ: usize, at_m: &Vec3) -> usize {
        let organ_grid = self.organs.get(organ).unwrap_or(&OrganGrid::NONE);
        organ_grid.slot(organ_grid.cell(at_m))
    }

    /// Runs of spheres that may be nearer to `center_m` than the sum of their reach and `reach_m`,
    /// in a fixed order.
    pub(super) fn near(
        &self,
        center_m: &Vec3,
        reach_m: f32,
    ) -> impl Iterator<Item = &[GridSphere]> {
        let center_m = *center_m;
        let near = move |organ_grid: &&OrganGrid| {
            let mut around = Bounds::EMPTY;
            around.add(&center_m, reach_m + organ_grid.reach_m);
            organ_grid.count > 0 && organ_grid.bounds.is_near(&around, 1.0e-6)
        };
        self.organs.iter().filter(near).flat_map(move |organ_grid| {
            let reach_m = Vec3::repeat(reach_m + organ_grid.reach_m);
            let [x0, y0, z0] = organ_grid.cell(&(center_m - reach_m));
            let [x1, y1, z1] = organ_grid.cell(&(center_m + reach_m));
            let rows = (z0..=z1).flat_map(move |z| (y0..=y1).map(move |y| (y, z)));
            rows.map(move |(y, z)| {
                let before = organ_grid.slot([x0, y, z]).checked_sub(1);
                let start = before.and_then(|i| self.ends.get(i)).copied();
                let end = self.ends.get(organ_grid.slot([x1, y, z])).copied();
                let run = usize::from(start.unwrap_or(0))..usize::from(end.unwrap_or(0));
                self.spheres.get(run).unwrap_or(&[])
            })
        })
    }
}
