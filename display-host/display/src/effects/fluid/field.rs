//! Thickness of the films of blood and bile, on a grid in the tissue at rest.
//!
//! The grid is the sum of all parcels, each spread by a kernel. The flow and the picture both use
//! this grid, so the picture shows the fluid that flows. The grid covers a window around the first
//! leak. It lies in the tissue at rest, so the film moves with the tissue that it wets.

use glam::Vec3;

use super::volume::{Volumes, WATER};

/// Side of a voxel, m.
pub const VOXEL_M: f32 = 0.001_2;
/// Numbers of voxels along x, y and z.
pub const SIZE: [usize; 3] = [96, 104, 96];
/// Radius over which a parcel is spread, m.
pub(super) const REACH_M: f32 = 0.002_4;
/// Thickness at the middle of a parcel of 1 m³, m. With it, the thickness integrated over a plane
/// through the middle is the parcel's volume.
pub(super) const MIDDLE_PER_M3: f32 = 3.0 / (core::f32::consts::PI * REACH_M * REACH_M);

/// Film at a voxel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Film {
    /// Thickness of blood, bile and water, m.
    pub thick_m: [f32; 3],
    /// Thickness of blood times the share of it that has clotted, m.
    pub clotted_m: f32,
}

impl Film {
    /// Thickness of all fluid, m.
    #[must_use]
    pub fn total_m(&self) -> f32 {
        self.thick_m.iter().sum()
    }
}

/// Range of voxels along x, y and z: index of the first, and index after the last.
pub type Block = [[usize; 2]; 3];

/// The films in the window.
#[derive(Debug, Clone)]
pub struct Field {
    low_m: Vec3,
    films: Vec<Film>,
    /// Voxels that are not dry.
    wet: Option<Block>,
}

impl Field {
    /// A dry window around this place of the tissue at rest.
    pub(super) fn around(middle_m: Vec3) -> Self {
        Self {
            low_m: middle_m - 0.5 * Self::extent_m(),
            films: vec![Film::default(); SIZE.iter().product()],
            wet: None,
        }
    }

    /// Extent of the window, m.
    pub(super) fn extent_m() -> Vec3 {
        Vec3::from(SIZE.map(|n| n as f32)) * VOXEL_M
    }

    /// True if the box lies in the window.
    pub(super) fn covers(&self, low_m: Vec3, high_m: Vec3) -> bool {
        let end_m = self.low_m + Self::extent_m();
        low_m.cmpge(self.low_m).all() && high_m.cmple(end_m).all()
    }

    /// Moves the window, which is dry then, by whole voxels towards this middle.
    pub(super) fn move_to(&mut self, middle_m: Vec3) {
        self.clear();
        let low_m = middle_m - 0.5 * Self::extent_m();
        self.low_m += ((low_m - self.low_m) / VOXEL_M).round() * VOXEL_M;
    }

    /// Corner of the window, m.
    #[must_use]
    pub fn low_m(&self) -> Vec3 {
        self.low_m
    }

    /// Voxels that are not dry.
    #[must_use]
    pub fn wet(&self) -> Option<Block> {
        self.wet
    }

    /// Film at a voxel; dry outside of the window.
    #[must_use]
    pub fn at(&self, [x, y, z]: [usize; 3]) -> Film {
        let inside = x < SIZE[0] && y < SIZE[1] && z < SIZE[2];
        let index = (z * SIZE[1] + y) * SIZE[0] + x;
        let film = self.films.get(index).filter(|_| inside);
        film.copied().unwrap_or_default()
    }

    /// Dries all voxels.
    pub(super) fn clear(&mut self) {
        let Some([xs, ys, zs]) = self.wet.take() else {
            return;
        };
        for z in zs[0]..zs[1] {
            for y in ys[0]..ys[1] {
                let row = (z * SIZE[1] + y) * SIZE[0];
                self.films[row + xs[0]..row + xs[1]].fill(Film::default());
            }
        }
    }

    /// Adds a parcel: volumes of blood, bile and water (m³), and the share of the blood that has
    /// clotted.
    pub(super) fn add(&mut self, at_m: Vec3, volume_m3: Volumes, clotted: f32) {
        let at = (at_m - self.low_m) / VOXEL_M - 0.5;
        let reach = REACH_M / VOXEL_M;
        let range = |k: usize| {
            let (low, high) = ((at[k] - reach).ceil(), (at[k] + reach).floor());
            let end = (high + 1.0).clamp(0.0, SIZE[k] as f32) as usize;
            [(low.max(0.0) as usize).min(end), end]
        };
        let block: Block = [range(0), range(1), range(2)];
        if block.iter().any(|[from, to]| from >= to) {
            return;
        }
        self.wet = Some(match self.wet {
            Some(wet) => core::array::from_fn(|k| {
                let ([a, b], [c, d]) = (wet[k], block[k]);
                [a.min(c), b.max(d)]
            }),
            None => block,
        });
        let own = volume_m3.map(|v| v as f32 * MIDDLE_PER_M3);
        let [xs, ys, zs] = block;
        for z in zs[0]..zs[1] {
            for y in ys[0]..ys[1] {
                let row = (z * SIZE[1] + y) * SIZE[0];
                for x in xs[0]..xs[1] {
                    let off = Vec3::new(x as f32, y as f32, z as f32) - at;
                    let left = 1.0 - off.length_squared() / (reach * reach);
                    if left > 0.0 {
                        let share = left * left;
                        let film = &mut self.films[row + x];
                        for (thick_m, own) in film.thick_m.iter_mut().zip(own) {
                            *thick_m += own * share;
                        }
                        film.clotted_m += own[0] * share * clotted;
                    }
                }
            }
        }
    }

    /// Share of water in the film at the voxel of a place.
    pub(super) fn water_share(&self, at_m: Vec3) -> f32 {
        let at = (at_m - self.low_m) / VOXEL_M;
        if !(at.cmpge(Vec3::ZERO).all() && at.is_finite()) {
            return 0.0;
        }
        let film = self.at(at.to_array().map(|v| v as usize));
        film.thick_m[WATER] / film.total_m().max(1e-9)
    }

    /// Thickness of all fluid at a place, m, and its gradient.
    pub(super) fn thickness(&self, at_m: Vec3) -> (f32, Vec3) {
        let at = (at_m - self.low_m) / VOXEL_M - 0.5;
        let low = at.floor();
        if !(low.cmpge(Vec3::ZERO).all() && at.is_finite()) {
            return (0.0, Vec3::ZERO);
        }
        let t = at - low;
        let [x, y, z] = low.to_array().map(|v| v as usize);
        let h = |i: usize, j: usize, k: usize| self.at([x + i, y + j, z + k]).total_m();
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        let edges = [[0, 0], [1, 0], [0, 1], [1, 1]];
        let ends = edges.map(|[j, k]| [h(0, j, k), h(1, j, k)]);
        let along = ends.map(|[a, b]| mix(a, b, t.x));
        let slope_x = ends.map(|[a, b]| b - a);
        let faces = [mix(along[0], along[1], t.y), mix(along[2], along[3], t.y)];
        let gradient = Vec3::new(
            mix(
                mix(slope_x[0], slope_x[1], t.y),
                mix(slope_x[2], slope_x[3], t.y),
                t.z,
            ),
            mix(along[1] - along[0], along[3] - along[2], t.z),
            faces[1] - faces[0],
        );
        (mix(faces[0], faces[1], t.z), gradient / VOXEL_M)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parcel_has_its_volume_over_a_plane_and_is_thickest_in_the_middle() {
        let mut field = Field::around(Vec3::ZERO);
        field.add(Vec3::ZERO, [1e-9, 1e-9, 1e-9], 0.5);
        // The grid is coarse, so the sum depends a little on the plane's place in it.
        let step_m = 0.000_1;
        for up_m in [0.0, 0.000_3, 0.000_6] {
            let mut field = Field::around(Vec3::ZERO);
            field.add(Vec3::Y * up_m, [1e-9, 1e-9, 1e-9], 0.5);
            let mut sum = 0.0;
            for i in -40..40 {
                for k in -40..40 {
                    let at = Vec3::new(i as f32 * step_m, up_m, k as f32 * step_m);
                    sum += field.thickness(at).0 * step_m * step_m;
                }
            }
            assert!((sum / 3e-9 - 1.0).abs() < 0.2, "{sum} at {up_m}");
        }
        let (middle, _) = field.thickness(Vec3::ZERO);
        let (beside, slope) = field.thickness(Vec3::X * 0.001);
        assert!(middle > beside && beside > 0.0 && slope.x < 0.0);
        assert!(field.thickness(Vec3::X * 0.004).0 <= 0.0);
        field.clear();
        assert!(field.thickness(Vec3::ZERO).0 <= 0.0 && field.wet().is_none());
    }

    #[test]
    fn fluid_outside_of_the_window_changes_nothing() {
        let mut field = Field::around(Vec3::ZERO);
        for far in [
            Vec3::splat(1.0),
            Vec3::splat(-1.0),
            Vec3::NAN,
            Vec3::INFINITY,
        ] {
            field.add(far, [1e-9; 3], 0.0);
            assert!(field.thickness(far).0 <= 0.0);
        }
        assert!(field.films.iter().all(|film| film.total_m() <= 0.0));
    }
}
