//! Finds the skin below and above a place. The triangles that face upwards are sorted into columns.

use glam::{Vec2, Vec3};

use super::super::stain::Skin;
use super::surface::{Place, Surface};

/// Width of a column, m.
const COLUMN_M: f32 = 0.004;
/// Number of columns along a side.
const SIDE: usize = 48;
/// Cosine of the angle between a triangle's normal and the vertical. Triangles with a smaller
/// cosine do not count as facing upwards.
const LEVEL: f32 = 0.05;

/// Columns around a place.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    right: Vec3,
    back: Vec3,
    up: Vec3,
    low: Vec2,
    first: Vec<u32>,
    triangles: Vec<u32>,
}

impl Columns {
    /// Sorts the triangles that face upwards into columns around this place.
    pub(super) fn around(middle_m: Vec3, up: Vec3, surface: &mut Surface, skin: &Skin<'_>) -> Self {
        let right = up.any_orthonormal_vector();
        let mut made = Self {
            right,
            back: right.cross(up),
            up,
            low: Vec2::ZERO,
            first: Vec::new(),
            triangles: Vec::new(),
        };
        made.low = made.flat(middle_m) - 0.5 * COLUMN_M * SIDE as f32;
        let mut found: Vec<(u32, u32)> = Vec::new();
        for triangle in 0..skin.triangles().len() as u32 {
            let corners = surface.corners(triangle, skin);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
            if normal.dot(up) <= LEVEL * normal.length() {
                continue;
            }
            let flat = corners.map(|at| made.flat(at) - made.low);
            let column = |v: f32| (v / COLUMN_M).clamp(-1.0, SIDE as f32) as i32;
            let low = flat[0].min(flat[1]).min(flat[2]);
            let high = flat[0].max(flat[1]).max(flat[2]);
            for y in column(low.y).max(0)..=column(high.y).min(SIDE as i32 - 1) {
                for x in column(low.x).max(0)..=column(high.x).min(SIDE as i32 - 1) {
                    found.push((y as u32 * SIDE as u32 + x as u32, triangle));
                }
            }
        }
        found.sort_unstable();
        made.first = vec![0; SIDE * SIDE + 1];
        for (column, _) in &found {
            made.first[*column as usize + 1] += 1;
        }
        for k in 1..made.first.len() {
            made.first[k] += made.first[k - 1];
        }
        made.triangles = found.into_iter().map(|(_, triangle)| triangle).collect();
        made
    }

    fn flat(&self, at: Vec3) -> Vec2 {
        Vec2::new(at.dot(self.right), at.dot(self.back))
    }

    /// Place on the skin that is nearest below `at` (`is_below`) or nearest above it, and its
    /// vertical distance, m.
    pub(super) fn nearest(
        &self,
        at: Vec3,
        is_below: bool,
        surface: &mut Surface,
        skin: &Skin<'_>,
    ) -> Option<(Place, f32)> {
        let flat = self.flat(at);
        let column = (flat - self.low) / COLUMN_M;
        let inside = column.cmpge(Vec2::ZERO).all() && column.cmplt(Vec2::splat(SIDE as f32)).all();
        if !inside {
            return None;
        }
        let column = column.y as usize * SIDE + column.x as usize;
        let own = self.first[column] as usize..self.first[column + 1] as usize;
        let mut best: Option<(Place, f32)> = None;
        for &triangle in &self.triangles[own] {
            let corners = surface.corners(triangle, skin);
            let [a, b, c] = corners.map(|corner| self.flat(corner));
            let area = (b - a).perp_dot(c - a);
            if area.abs() < 1e-14 {
                continue;
            }
            let weights = [
                (b - flat).perp_dot(c - flat) / area,
                (c - flat).perp_dot(a - flat) / area,
                (a - flat).perp_dot(b - flat) / area,
            ];
            if weights.iter().any(|w| *w < -1e-4) {
                continue;
            }
            let heights = corners.map(|corner| corner.dot(self.up));
            let height: f32 = heights.iter().zip(weights).map(|(h, w)| h * w).sum();
            let off = height - at.dot(self.up);
            let far = if is_below { -off } else { off };
            if far > 2e-4 && best.is_none_or(|(_, nearest)| far < nearest) {
                best = Some((Place { triangle, weights }, far));
            }
        }
        best
    }
}
