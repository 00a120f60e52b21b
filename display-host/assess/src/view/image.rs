//! Identity image of an endoscope: the structure that each pixel shows.

use shared_mem::message::PoseMsg;
use shared_mem::scene::OrganKind;

use crate::anatomy::{Anatomy, Ball, Region};
use crate::tally::VIEW_HALF_RAD;
use crate::vector::{Vec3, axis, dot, sub, wide};

/// Pixels along each side. At 10 cm a pixel is 1.5 mm wide, less than a duct.
const SIDE: usize = 96;
/// Nearest depth that is drawn, m.
const NEAR_M: f64 = 0.005;
/// Spheres of one structure overlap, so a place up to this far behind the drawn surface counts as
/// seen, m.
const BEHIND_M: f64 = 0.002;

/// Depth of the nearest structure at each pixel, m, and its organ.
pub(super) struct Image {
    camera: PoseMsg,
    depth_m: Vec<f64>,
    organ: Vec<u32>,
}

/// A place in the picture: pixels from its left lower corner, and depth, m.
#[derive(Debug, Clone, Copy)]
struct Projected {
    at: [f64; 2],
    depth_m: f64,
    /// Pixels per metre at this depth.
    scale: f64,
}

impl Image {
    /// Draws everything that is still there.
    pub(super) fn of(camera: &PoseMsg, anatomy: &Anatomy, is_gone: &dyn Fn(usize) -> bool) -> Self {
        let mut image = Self {
            camera: *camera,
            depth_m: vec![f64::INFINITY; SIDE * SIDE],
            organ: vec![u32::MAX; SIDE * SIDE],
        };
        for ball in &anatomy.balls {
            if ball.cell.is_none_or(|cell| !is_gone(cell)) {
                image.draw(ball);
            }
        }
        image
    }

    fn project(&self, place: Vec3) -> Option<Projected> {
        let to = sub(place, wide(self.camera.position_m));
        let depth_m = -dot(to, axis(&self.camera, 2));
        let scale = 0.5 * SIDE as f64 / (VIEW_HALF_RAD.tan() * depth_m);
        (depth_m > NEAR_M).then(|| Projected {
            at: [0, 1].map(|which| 0.5 * SIDE as f64 + scale * dot(to, axis(&self.camera, which))),
            depth_m,
            scale,
        })
    }

    fn draw(&mut self, ball: &Ball) {
        let Some(middle) = self.project(ball.at_m) else {
            return;
        };
        let radius = ball.radius_m * middle.scale;
        let [columns, rows] = middle.at.map(|at| {
            let end = |at: f64| at.clamp(0.0, SIDE as f64) as usize;
            end(at - radius)..end(at + radius + 1.0)
        });
        for row in rows {
            for column in columns.clone() {
                let off = [column, row].map(|it| it as f64 + 0.5);
                let [right, up] = [0, 1].map(|i| off[i] - middle.at[i]);
                let inside = radius * radius - right * right - up * up;
                if inside < 0.0 {
                    continue;
                }
                let depth_m = middle.depth_m - inside.sqrt() / middle.scale;
                let place = row * SIDE + column;
                if let (Some(nearest_m), Some(organ)) =
                    (self.depth_m.get_mut(place), self.organ.get_mut(place))
                    && depth_m < *nearest_m
                {
                    (*nearest_m, *organ) = (depth_m, ball.organ);
                }
            }
        }
    }

    /// Depth and organ that the picture shows at a place in space, and the depth of that place, m.
    /// `None` outside of the picture.
    fn at(&self, place: Vec3) -> Option<(f64, u32, f64)> {
        let it = self.project(place)?;
        let inside = |at: f64| (0.0..SIDE as f64).contains(&at).then_some(at as usize);
        let [column, row] = [inside(it.at[0])?, inside(it.at[1])?];
        let pixel = row * SIDE + column;
        let (depth_m, organ) = (self.depth_m.get(pixel)?, self.organ.get(pixel)?);
        Some((*depth_m, *organ, it.depth_m))
    }

    /// Share of a region's cells, by volume, that are gone and whose place nothing hides; 0 for a
    /// region without cells.
    pub(super) fn seen_of_cells(
        &self,
        region: Region,
        anatomy: &Anatomy,
        is_gone: &dyn Fn(usize) -> bool,
    ) -> f64 {
        let (mut seen, mut all) = (0.0, 0.0);
        for ball in &anatomy.balls {
            let cell = ball
                .cell
                .and_then(|cell| Some((cell, anatomy.cells.get(cell)?)));
            let Some((cell, (_, volume_m3))) = cell.filter(|(_, it)| it.0 == region) else {
                continue;
            };
            all += volume_m3;
            // The place counts as seen up to the side of the cell that faces the lens.
            let is_open =
                |(shown_m, _, place_m): (f64, u32, f64)| shown_m > place_m - ball.radius_m;
            if is_gone(cell) && self.at(ball.at_m).is_some_and(is_open) {
                seen += volume_m3;
            }
        }
        if all > 0.0 { seen / all } else { 0.0 }
    }

    /// Share of a tube's spheres that the picture shows; 0 for a scene without it.
    pub(super) fn seen_of_tube(&self, kind: OrganKind, anatomy: &Anatomy) -> f64 {
        let Some(index) = anatomy.organs.iter().position(|it| it.kind == Some(kind)) else {
            return 0.0;
        };
        self.seen_of_organ(index as u32, anatomy)
    }

    /// Share of an organ's spheres that the picture shows.
    pub(super) fn seen_of_organ(&self, organ: u32, anatomy: &Anatomy) -> f64 {
        let (mut seen, mut all) = (0.0, 0.0);
        let own = anatomy.balls.iter();
        for ball in own.filter(|it| it.organ == organ && it.cell.is_none()) {
            all += 1.0;
            let is_seen = |(shown_m, shown, place_m): (f64, u32, f64)| {
                shown == organ && shown_m > place_m - ball.radius_m - BEHIND_M
            };
            seen += f64::from(self.at(ball.at_m).is_some_and(is_seen));
        }
        if all > 0.0 { seen / all } else { 0.0 }
    }
}
