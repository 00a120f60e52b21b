//! Packs an organ with inner spheres.

mod even;
mod line;
mod paper;
mod quality;

pub use even::pack_evenly;
pub use line::{Line, pack_line};
pub use paper::{filling_sphere, pack_as_paper};
pub use quality::{Quality, isotropy};

use crate::Vec3;
use crate::field::{Field, Grid, Nearest, Sign};
use crate::mesh::{Mesh, OwnFrame};

/// Grid points along the mean spacing of the spheres.
const POINTS_PER_SPACING: f64 = 4.5;
/// Largest number of grid points of one organ, approximately.
const POINTS_MAX: f64 = 8e6;
/// Share of a cell by which grids are shifted off a mesh's outermost points. Points of the grid
/// would otherwise lie on a flat side, and rounding would decide whether they are inside.
pub(crate) const OFF_SHARE: f64 = 0.38;

/// Smallest radius of a sphere, m. The realtime process refuses a smaller one.
const RADIUS_MIN_M: f64 = 1e-5;

/// A sphere at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ball {
    /// Centre, m.
    pub center: Vec3,
    /// Radius, m.
    pub radius_m: f64,
}

/// The inside of an organ, on a grid.
pub struct Interior<'a> {
    /// Frame of the grid.
    pub frame: OwnFrame,
    /// Signed distance to the skin, on a grid in the organ's own frame.
    pub field: Field,
    /// Search for the exactly nearest point of the skin, world frame.
    pub nearest: Nearest<'a>,
    /// Numbers of the grid points inside.
    pub points: Vec<u32>,
    /// Mean spacing of the wanted spheres, m: the cube root of a sphere's share of the volume.
    pub spacing_m: f64,
}

impl<'a> Interior<'a> {
    /// Prepares a closed mesh for this many spheres. `None` if no grid point lies inside.
    #[must_use]
    pub fn new(mesh: &'a Mesh, volume_m3: f64, spheres: usize) -> Option<Self> {
        let spacing_m = libm::cbrt(volume_m3 / spheres as f64);
        let frame = OwnFrame::of(mesh);
        let own = frame.own_mesh(mesh);
        let [min, max] = own.bounds();
        let size = max - min;
        let coarsest = libm::cbrt(size.product() / POINTS_MAX);
        let cell_m = (spacing_m / POINTS_PER_SPACING).max(coarsest);
        let low = min.add_scalar(-OFF_SHARE * cell_m);
        let field = Field::new(&own, Grid::around([low, max], cell_m, 2), Sign::Closed);
        let inside = (0..field.grid.len()).filter(|&i| field.is_inside(i));
        let points: Vec<u32> = inside.map(|i| i as u32).collect();
        let nearest = Nearest::new(mesh)?;
        (!points.is_empty()).then_some(Self {
            frame,
            field,
            nearest,
            points,
            spacing_m,
        })
    }

    /// `D(c)` of paper Eq. 1, m: the exact distance of a place from the skin, world frame; negative
    /// outside.
    #[must_use]
    pub fn depth(&self, p: &Vec3) -> f64 {
        let distance = self.nearest.distance(p);
        if self.is_inside(p) {
            distance
        } else {
            -distance
        }
    }

    /// True if a place lies inside, world frame.
    #[must_use]
    pub fn is_inside(&self, p: &Vec3) -> bool {
        self.field.at(&self.frame.own(p)) < 0.0
    }

    /// A sphere that touches the surface from inside (paper Eq. 1), world frame. Its radius is at
    /// least a hundredth of the spacing and 0.01 mm, and at most `radius_max_m`.
    #[must_use]
    pub fn inscribed(&self, center: Vec3, radius_max_m: f64) -> Ball {
        let least_m = (0.01 * self.spacing_m).max(RADIUS_MIN_M).min(radius_max_m);
        let radius_m = self.depth(&center).clamp(least_m, radius_max_m);
        Ball { center, radius_m }
    }

    /// Position of a grid point, world frame.
    #[must_use]
    pub fn position(&self, point: u32) -> Vec3 {
        self.frame.world(&self.own_position(point))
    }

    /// Position of a grid point in the organ's own frame.
    #[must_use]
    pub fn own_position(&self, point: u32) -> Vec3 {
        self.field
            .grid
            .position(self.field.grid.coordinates(point as usize))
    }
}

/// The nearest of these centres for every point inside, in the order of [`Interior::points`].
#[must_use]
pub fn owners(interior: &Interior<'_>, centers: &[Vec3]) -> Vec<u32> {
    let own: Vec<Vec3> = centers.iter().map(|p| interior.frame.own(p)).collect();
    even::Owners::new(interior).assign(&own).to_vec()
}
