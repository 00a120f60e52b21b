//! A regular grid over a box.

use crate::Vec3;

/// A regular grid of points. Points are numbered x first, then y, then z.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Position of point 0, m.
    pub origin: Vec3,
    /// Spacing, m.
    pub cell_m: f64,
    /// Points along x, y, z.
    pub size: [usize; 3],
}

impl Grid {
    /// A grid that covers the box and `margin` cells around it.
    #[must_use]
    pub fn around([min, max]: [Vec3; 2], cell_m: f64, margin: usize) -> Self {
        let points = |k: usize| ((max[k] - min[k]) / cell_m).ceil() as usize + 2 * margin + 1;
        Self {
            origin: min.add_scalar(-cell_m * margin as f64),
            cell_m,
            size: [points(0), points(1), points(2)],
        }
    }

    /// Number of points.
    #[must_use]
    pub fn len(&self) -> usize {
        self.size.iter().product()
    }

    /// True if the grid has no points.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of a point.
    #[must_use]
    pub fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.size[0] * (y + self.size[1] * z)
    }

    /// Coordinates of the point with this number, in cells.
    #[must_use]
    pub fn coordinates(&self, index: usize) -> [usize; 3] {
        let row = index / self.size[0];
        [index % self.size[0], row % self.size[1], row / self.size[1]]
    }

    /// Position of a point, m.
    #[must_use]
    pub fn position(&self, [x, y, z]: [usize; 3]) -> Vec3 {
        self.origin + Vec3::new(x as f64, y as f64, z as f64) * self.cell_m
    }

    /// Numbers of the up to six neighbours of a point.
    pub(crate) fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> + use<> {
        let at = self.coordinates(index);
        let size = self.size;
        let stride = [1, size[0], size[0] * size[1]];
        (0..3).flat_map(move |k| {
            let down = (at[k] > 0).then(|| index - stride[k]);
            let up = (at[k] + 1 < size[k]).then(|| index + stride[k]);
            down.into_iter().chain(up)
        })
    }

    /// Range of the grid's coordinates along one axis that lie between two positions.
    pub(crate) fn span(&self, axis: usize, from_m: f64, to_m: f64) -> std::ops::Range<usize> {
        let low = ((from_m - self.origin[axis]) / self.cell_m).ceil().max(0.0) as usize;
        let high = ((to_m - self.origin[axis]) / self.cell_m).floor();
        let end = if high < 0.0 { 0 } else { high as usize + 1 };
        low.min(self.size[axis])..end.min(self.size[axis])
    }
}
