//! The pixels of an identity image.

use shared_mem::message::{CapsuleMsg, PoseMsg};

use super::counted::{Counted, ORGANS_MAX};
use super::vector::{Vec3, dot, norm, sub};

/// Pixels along each side. At 10 cm a pixel is 0.9 mm wide.
const SIDE: usize = 160;
/// Half of the picture's field of view, rad (`display-host`, `Scope`).
const HALF_RAD: f32 = 0.61;
/// Nearest depth that is drawn, m.
const NEAR_M: f32 = 0.003;
/// Organ of a pixel that shows nothing.
const NOTHING: u8 = u8::MAX;
/// Organ of a pixel that shows an instrument.
const TOOL: u8 = u8::MAX - 1;

/// A place in the picture: pixels from its upper left corner, and depth, m.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    at: [f32; 2],
    depth_m: f32,
}

/// Depth of the nearest surface at each pixel, m, its organ, and all organs drawn at the pixel, one
/// bit each.
pub(super) struct Canvas {
    eye_m: Vec3,
    /// Right, up and back.
    axes: [Vec3; 3],
    depth_m: Vec<f32>,
    organ: Vec<u8>,
    covered: Vec<u16>,
    /// True for pixels within the endoscope's round picture.
    is_inside: Vec<bool>,
}

impl Canvas {
    pub(super) fn new() -> Self {
        let pixels = SIDE * SIDE;
        let is_inside = (0..pixels).map(|pixel| {
            let [x, y] = from_middle(pixel);
            x.hypot(y) <= 1.0
        });
        Self {
            eye_m: [0.0; 3],
            axes: [[0.0; 3]; 3],
            depth_m: vec![f32::INFINITY; pixels],
            organ: vec![NOTHING; pixels],
            covered: vec![0; pixels],
            is_inside: is_inside.collect(),
        }
    }

    /// Empties the picture for this camera.
    pub(super) fn begin(&mut self, camera: &PoseMsg) {
        self.eye_m = camera.position_m;
        self.axes = axes(camera.orientation);
        self.depth_m.fill(f32::INFINITY);
        self.organ.fill(NOTHING);
        self.covered.fill(0);
    }

    pub(super) fn project(&self, place: Vec3) -> Option<Spot> {
        let to = sub(place, self.eye_m);
        let [right, up, back] = self.axes.map(|axis| dot(to, axis));
        let depth_m = -back;
        let scale = 0.5 * SIDE as f32 / (HALF_RAD.tan() * depth_m);
        let middle = 0.5 * SIDE as f32;
        (depth_m > NEAR_M).then_some(Spot {
            at: [middle + scale * right, middle - scale * up],
            depth_m,
        })
    }

    /// True if the place lies within the round picture, hidden or not.
    pub(super) fn has(&self, place: Vec3) -> bool {
        self.pixel_of(place).is_some()
    }

    fn pixel_of(&self, place: Vec3) -> Option<(usize, f32)> {
        let spot = self.project(place)?;
        let inside = |at: f32| (0.0..SIDE as f32).contains(&at).then_some(at as usize);
        let [column, row] = [inside(spot.at[0])?, inside(spot.at[1])?];
        let pixel = row * SIDE + column;
        let inside = self.is_inside.get(pixel).copied().unwrap_or_default();
        inside.then_some((pixel, spot.depth_m))
    }

    /// True if the place is in the picture, and no surface lies `half_m` or more in front of it.
    pub(super) fn is_open(&self, place: Vec3, half_m: f32) -> bool {
        let found = self.pixel_of(place);
        found.is_some_and(|(pixel, depth_m)| {
            let shown_m = self.depth_m.get(pixel);
            shown_m.is_some_and(|shown_m| *shown_m > depth_m - half_m)
        })
    }

    /// Draws a triangle of an organ.
    pub(super) fn triangle(&mut self, corners: [Option<Spot>; 3], organ: u8) {
        let [Some(a), Some(b), Some(c)] = corners else {
            return;
        };
        let area = edge(a.at, b.at, c.at);
        if area.abs() < 1e-9 {
            return;
        }
        let [columns, rows] = [0, 1].map(|axis| {
            let all = [a.at[axis], b.at[axis], c.at[axis]];
            let [least, most] = [
                all.iter().copied().fold(f32::MAX, f32::min),
                all.iter().copied().fold(f32::MIN, f32::max),
            ];
            let end = |at: f32| at.clamp(0.0, SIDE as f32) as usize;
            // Pixels whose middle may lie within.
            end((least - 0.5).ceil())..end((most + 0.5).floor())
        });
        for row in rows {
            for column in columns.clone() {
                let middle = [column as f32 + 0.5, row as f32 + 0.5];
                let [u, v, w] = [
                    edge(b.at, c.at, middle),
                    edge(c.at, a.at, middle),
                    edge(a.at, b.at, middle),
                ]
                .map(|it| it / area);
                if u < 0.0 || v < 0.0 || w < 0.0 {
                    continue;
                }
                let depth_m = 1.0 / (u / a.depth_m + v / b.depth_m + w / c.depth_m);
                self.put(row * SIDE + column, depth_m, organ);
            }
        }
    }

    /// Draws a capsule of an instrument as balls along its axis.
    pub(super) fn capsule(&mut self, capsule: &CapsuleMsg) {
        let along = sub(capsule.b_m, capsule.a_m);
        let steps = (norm(along) / capsule.radius_m.max(0.0005)).clamp(1.0, 400.0) as usize;
        for step in 0..=steps {
            let share = step as f32 / steps as f32;
            let at = [0, 1, 2].map(|i| capsule.a_m[i] + along[i] * share);
            self.ball(at, capsule.radius_m);
        }
    }

    fn ball(&mut self, at: Vec3, radius_m: f32) {
        let Some(middle) = self.project(at) else {
            return;
        };
        let radius = radius_m * 0.5 * SIDE as f32 / (HALF_RAD.tan() * middle.depth_m);
        let [columns, rows] = middle.at.map(|at| {
            let end = |at: f32| at.clamp(0.0, SIDE as f32) as usize;
            end(at - radius)..end(at + radius + 1.0)
        });
        for row in rows {
            for column in columns.clone() {
                let [x, y] = [
                    column as f32 + 0.5 - middle.at[0],
                    row as f32 + 0.5 - middle.at[1],
                ];
                let inside = radius * radius - x * x - y * y;
                if inside >= 0.0 {
                    let depth_m = middle.depth_m - radius_m * inside.sqrt() / radius.max(1e-6);
                    self.put(row * SIDE + column, depth_m, TOOL);
                }
            }
        }
    }

    fn put(&mut self, pixel: usize, depth_m: f32, organ: u8) {
        if let Some(covered) = self.covered.get_mut(pixel) {
            *covered |= 1u16.checked_shl(organ.into()).unwrap_or(0);
        }
        if let (Some(nearest_m), Some(shown)) =
            (self.depth_m.get_mut(pixel), self.organ.get_mut(pixel))
            && depth_m < *nearest_m
        {
            (*nearest_m, *shown) = (depth_m, organ);
        }
    }

    pub(super) fn count(&self) -> Counted {
        let mut counted = Counted {
            organs: [[0; 2]; ORGANS_MAX],
            places: [[0.0; 2]; ORGANS_MAX],
            all: 0,
        };
        let pixels = self.is_inside.iter().zip(&self.organ).zip(&self.covered);
        for (pixel, ((is_inside, shown), covered)) in pixels.enumerate() {
            if !is_inside {
                continue;
            }
            counted.all += 1;
            let organs = counted.organs.iter_mut().zip(&mut counted.places);
            for (organ, ([visible, all], place)) in organs.enumerate() {
                *all += u32::from(covered >> organ & 1);
                if usize::from(*shown) == organ {
                    *visible += 1;
                    let at = from_middle(pixel);
                    *place = [place[0] + at[0], place[1] + at[1]];
                }
            }
        }
        counted
    }

    pub(super) fn pixels(&self) -> (usize, Vec<Option<usize>>) {
        let shown = self.organ.iter().zip(&self.is_inside);
        let organ = |(organ, is_inside): (&u8, &bool)| {
            (*is_inside && *organ < TOOL).then_some(usize::from(*organ))
        };
        (SIDE, shown.map(organ).collect())
    }
}

/// Place of a pixel's middle from the picture's middle, as shares of its radius.
fn from_middle(pixel: usize) -> [f32; 2] {
    let half = 0.5 * SIDE as f32;
    [pixel % SIDE, pixel / SIDE].map(|at| (at as f32 + 0.5 - half) / half)
}

/// Twice the signed area of a triangle.
fn edge(a: [f32; 2], b: [f32; 2], c: [f32; 2]) -> f32 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Axes of a frame with this rotation in world coordinates.
fn axes([x, y, z, w]: [f32; 4]) -> [Vec3; 3] {
    [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y + z * w),
            2.0 * (x * z - y * w),
        ],
        [
            2.0 * (x * y - z * w),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z + x * w),
        ],
        [
            2.0 * (x * z + y * w),
            2.0 * (y * z - x * w),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ]
}
