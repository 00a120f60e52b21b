//! Close picture of the place of an error. It shows the organs at rest and the instrument's shaft,
//! seen from the side of the endoscope. A ring marks the place.

use std::io::Cursor;

use image::{ImageFormat, Rgb, RgbImage};
use shared_mem::scene::OrganKind;

use super::outline::Outlines;
use crate::assessment::Hands;
use crate::vector::{Vec3, axis, cross, dot, norm, scaled, sub, sum, unit, wide};

/// Width and height of a close picture, pixels.
pub const CLOSE_SIZE: [usize; 2] = [320, 240];
/// Samples along each side of a pixel.
const FINER: usize = 2;
/// Distance of the eye from the place, m.
const EYE_M: f64 = 0.06;
/// Least depth that is drawn, m. Tissue nearer to the eye would hide the place.
const NEAR_M: f64 = 0.03;
/// Width of the picture at the depth of the place, m.
const WIDTH_M: f64 = 0.05;
/// Radius and length of the instrument's shaft, m.
const SHAFT_M: [f64; 2] = [2.5e-3, 0.1];
/// Sides of the shaft.
const SHAFT_SIDES: usize = 14;
/// Radius of the ring, and half the width of its line, pixels.
const RING: [f64; 2] = [30.0, 1.8];
/// Width of the ring's dark edge, pixels.
const RING_EDGE: f64 = 1.6;
const BACKGROUND: [f64; 3] = [58.0, 26.0, 24.0];
const METAL: [f64; 3] = [196.0, 200.0, 206.0];

/// Draws the place of an error. `place` is the organ concerned, if any, and the position, world
/// frame, m. The organ concerned shows through surfaces in front of it. Returns `None` if the scene
/// has no surfaces.
#[must_use]
pub fn close_picture(
    organs: &Outlines,
    place: (Option<&str>, [f32; 3]),
    hands: Option<&Hands>,
) -> Option<RgbImage> {
    if !organs.is_any() {
        return None;
    }
    let (concerned, at_m) = place;
    let shift = to_rest(organs, concerned, wide(at_m));
    let empty = Canvas::at(sum(wide(at_m), shift), hands);
    let (mut canvas, mut alone) = (empty.clone(), empty);
    for (name, kind, triangles) in organs.surfaces() {
        for triangle in triangles {
            canvas.draw(triangle.map(wide), colour(kind));
            if Some(name) == concerned {
                alone.draw(triangle.map(wide), colour(kind));
            }
        }
    }
    canvas.show_through(&alone);
    if let Some(hands) = hands {
        canvas.shaft(sum(wide(hands.tip_m), shift), hands.shaft);
    }
    Some(ringed(&canvas.picture()))
}

/// The organ may have moved away from its place at rest, where the picture draws it. This is the
/// displacement from `place` to the nearest corner of the organ at rest, m. Instrument and ring are
/// moved by it, so that the picture shows them at the organ. It is zero without the organ, or if
/// the organ is farther away than `MOVED_M`.
fn to_rest(organs: &Outlines, concerned: Option<&str>, place: Vec3) -> Vec3 {
    let own = organs
        .surfaces()
        .filter(|(name, ..)| Some(*name) == concerned);
    let corners = own.flat_map(|(.., triangles)| triangles.iter().flatten());
    let ways = corners.map(|corner| sub(wide(*corner), place));
    let nearest = ways.min_by(|a, b| norm(*a).total_cmp(&norm(*b)));
    nearest
        .filter(|way| norm(*way) <= MOVED_M)
        .unwrap_or_default()
}

/// The picture as PNG.
pub(super) fn png(picture: &RgbImage) -> Option<Vec<u8>> {
    let mut png = Cursor::new(Vec::new());
    picture.write_to(&mut png, ImageFormat::Png).ok()?;
    Some(png.into_inner())
}

/// Colours of tissue under the endoscope's light.
const fn colour(kind: Option<OrganKind>) -> [f64; 3] {
    match kind {
        Some(OrganKind::Liver) => [168.0, 74.0, 62.0],
        Some(OrganKind::Gallbladder) => [128.0, 158.0, 112.0],
        Some(OrganKind::CysticDuct | OrganKind::BileDuct) => [196.0, 184.0, 84.0],
        Some(OrganKind::CysticArtery | OrganKind::Vessel) => [214.0, 84.0, 84.0],
        Some(OrganKind::Fat | OrganKind::ConnectiveTissue) => [226.0, 202.0, 120.0],
        _ => [206.0, 146.0, 138.0],
    }
}

/// Largest displacement of an organ that the picture takes into account, m.
const MOVED_M: f64 = 0.05;
/// Share of the colour of the organ concerned where other surfaces hide it.
const THROUGH: f64 = 0.5;

/// A camera, and the depth and colour of the nearest surface at each sample.
#[derive(Clone)]
struct Canvas {
    eye_m: Vec3,
    /// Directions to the right, upwards and ahead.
    axes: [Vec3; 3],
    size: [usize; 2],
    depth_m: Vec<f64>,
    colour: Vec<[f64; 3]>,
}

impl Canvas {
    fn at(place: Vec3, hands: Option<&Hands>) -> Self {
        // Without hands the picture looks from the front.
        let (back, up) = hands.map_or(([0.0, 0.0, 1.0], [0.0, 1.0, 0.0]), |it| {
            let lens = wide(it.world_from_camera.position_m);
            (sub(lens, place), axis(&it.world_from_camera, 1))
        });
        let back = unit(back).unwrap_or([0.0, 0.0, 1.0]);
        let right = unit(cross(up, back)).unwrap_or([1.0, 0.0, 0.0]);
        let size = CLOSE_SIZE.map(|it| it * FINER);
        Self {
            eye_m: sum(place, scaled(back, EYE_M)),
            axes: [right, cross(back, right), scaled(back, -1.0)],
            size,
            depth_m: vec![f64::INFINITY; size[0] * size[1]],
            colour: vec![BACKGROUND; size[0] * size[1]],
        }
    }

    /// Column, row (from the top) and depth of a place.
    fn project(&self, place: Vec3) -> Vec3 {
        let to = sub(place, self.eye_m);
        let [right, up, depth] = self.axes.map(|it| dot(to, it));
        let [width, height] = self.size.map(|it| it as f64);
        let scale = width * EYE_M / WIDTH_M / depth.max(1e-6);
        [
            0.5 * width + scale * right,
            0.5 * height - scale * up,
            depth,
        ]
    }

    fn draw(&mut self, corners: [Vec3; 3], colour: [f64; 3]) {
        let [a, b, c] = corners.map(|it| self.project(it));
        if a[2].min(b[2]).min(c[2]) < NEAR_M {
            return;
        }
        let range = |which: usize| {
            let [low, high] = [f64::min, f64::max].map(|of| of(of(a[which], b[which]), c[which]));
            let most = self.size.get(which).copied().unwrap_or(0) as f64;
            let end = |it: f64| it.clamp(0.0, most) as usize;
            end(low)..end(high + 1.0)
        };
        let (columns, rows) = (range(0), range(1));
        let area = edge(a, b, c);
        if columns.is_empty() || rows.is_empty() || area.abs() < 1e-9 {
            return;
        }
        let shade = self.shade(corners);
        let colour = colour.map(|it| it * shade);
        for row in rows {
            for column in columns.clone() {
                let at = [column as f64 + 0.5, row as f64 + 0.5, 0.0];
                let weights = [edge(b, c, at), edge(c, a, at), edge(a, b, at)];
                let [u, v, w] = weights.map(|it| it / area);
                if u < 0.0 || v < 0.0 || w < 0.0 {
                    continue;
                }
                let depth_m = 1.0 / (u / a[2] + v / b[2] + w / c[2]);
                let place = row * self.size[0] + column;
                if let (Some(nearest_m), Some(shown)) =
                    (self.depth_m.get_mut(place), self.colour.get_mut(place))
                    && depth_m < *nearest_m
                {
                    (*nearest_m, *shown) = (depth_m, colour);
                }
            }
        }
    }

    /// Lets an organ, drawn in `alone`, show through surfaces in front of it.
    fn show_through(&mut self, alone: &Self) {
        let seen = alone.depth_m.iter().zip(&alone.colour);
        let own = self.depth_m.iter().zip(&mut self.colour);
        for ((nearest_m, shown), (depth_m, colour)) in own.zip(seen) {
            if depth_m.is_finite() && depth_m > nearest_m {
                *shown = sum(scaled(*shown, 1.0 - THROUGH), scaled(*colour, THROUGH));
            }
        }
    }

    /// Light on a triangle from a lamp at the eye, which fades with the distance.
    fn shade(&self, [a, b, c]: [Vec3; 3]) -> f64 {
        let to_eye = sub(self.eye_m, scaled(sum(a, sum(b, c)), 1.0 / 3.0));
        let normal = unit(cross(sub(b, a), sub(c, a))).unwrap_or([0.0; 3]);
        let facing = dot(normal, unit(to_eye).unwrap_or([0.0; 3])).abs();
        let near = (EYE_M / norm(to_eye).max(1e-3)).clamp(0.35, 1.3);
        (0.25 + 0.8 * facing) * near
    }

    fn shaft(&mut self, tip: Vec3, along: Vec3) {
        let Some(along) = unit(along) else { return };
        let aside = unit(cross(along, self.axes[2])).unwrap_or(self.axes[0]);
        let other = cross(along, aside);
        let rim = |number: usize, at_m: f64| {
            let angle = core::f64::consts::TAU * number as f64 / SHAFT_SIDES as f64;
            let out = sum(scaled(aside, angle.cos()), scaled(other, angle.sin()));
            sum(tip, sum(scaled(along, at_m), scaled(out, SHAFT_M[0])))
        };
        // Short pieces, because a piece that begins nearer than `NEAR_M` is not drawn.
        let pieces = 25;
        let ends = (0..=pieces).map(|it| SHAFT_M[1] * f64::from(it) / f64::from(pieces));
        let ends: Vec<f64> = ends.collect();
        for pair in ends.windows(2) {
            let &[from_m, to_m] = pair else { continue };
            for side in 0..SHAFT_SIDES {
                let [a, b] = [rim(side, from_m), rim(side + 1, from_m)];
                let [c, d] = [rim(side + 1, to_m), rim(side, to_m)];
                self.draw([a, b, c], METAL);
                self.draw([a, c, d], METAL);
            }
        }
    }

    /// The picture with the mean of each pixel's samples.
    fn picture(&self) -> RgbImage {
        let [width, height] = CLOSE_SIZE.map(|it| it as u32);
        RgbImage::from_fn(width, height, |column, row| {
            let mut mean = [0.0; 3];
            for sample in 0..FINER * FINER {
                let x = column as usize * FINER + sample % FINER;
                let y = row as usize * FINER + sample / FINER;
                let colour = self.colour.get(y * self.size[0] + x);
                mean = sum(mean, colour.copied().unwrap_or_default());
            }
            let share = 1.0 / (FINER * FINER) as f64;
            Rgb(mean.map(|it| (it * share).clamp(0.0, 255.0) as u8))
        })
    }
}

/// Twice the signed area of a triangle in the picture.
fn edge(a: Vec3, b: Vec3, c: Vec3) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The picture with a ring around its middle: white with a dark edge, to be seen on any tissue.
fn ringed(picture: &RgbImage) -> RgbImage {
    let middle = CLOSE_SIZE.map(|it| 0.5 * it as f64);
    RgbImage::from_fn(picture.width(), picture.height(), |column, row| {
        let [x, y] = [f64::from(column) + 0.5, f64::from(row) + 0.5];
        let off = ((x - middle[0]).hypot(y - middle[1]) - RING[0]).abs();
        match off {
            off if off <= RING[1] => Rgb([255, 255, 255]),
            off if off <= RING[1] + RING_EDGE => Rgb([20, 20, 20]),
            _ => *picture.get_pixel(column, row),
        }
    })
}

#[cfg(test)]
mod tests {
    use shared_mem::message::PoseMsg;

    use super::*;

    /// A square of 40 mm in the plane z = `z_m`.
    fn square(kind: OrganKind, z_m: f32) -> Outlines {
        let [low, high] = [-0.02, 0.02];
        let corners = [[low, low], [high, low], [high, high], [low, high]];
        let [a, b, c, d] = corners.map(|[x, y]| [x, y, z_m]);
        Outlines::test(kind, vec![[a, b, c], [a, c, d]])
    }

    fn drawn(organs: &Outlines, hands: Option<&Hands>) -> RgbImage {
        let picture = close_picture(organs, (None, [0.0; 3]), hands).unwrap();
        let png = png(&picture).unwrap();
        image::load_from_memory(&png).unwrap().to_rgb8()
    }

    #[test]
    fn the_place_is_in_the_ring_and_the_organ_around_it() {
        let picture = drawn(&square(OrganKind::Liver, 0.0), None);
        assert_eq!(picture.dimensions(), (320, 240));
        let [middle, ring] = [picture.get_pixel(160, 120), picture.get_pixel(190, 120)];
        assert!(middle[0] > middle[1] + 50, "the liver is red: {middle:?}");
        assert_eq!(ring.0, [255; 3]);
        // 50 mm are 320 pixels, so the square of 40 mm is 256 wide.
        let is_organ = |column: u32| picture.get_pixel(column, 60)[0] > 100;
        assert!(is_organ(36) && !is_organ(28) && is_organ(284) && !is_organ(292));
    }

    #[test]
    fn the_ring_is_at_the_organ_that_was_moved() {
        let at = [0.01, 0.01, 0.03f32].map(f64::from);
        let liver = square(OrganKind::Liver, 0.0);
        let way = to_rest(&liver, Some("liver"), at);
        let rest = sum(at, way);
        let corner = [0.02, 0.02, 0.0];
        assert!(
            norm(sub(rest, corner)) < 1e-6,
            "its nearest corner: {rest:?}"
        );
        let unmoved = [
            to_rest(&liver, Some("bile duct"), at),
            to_rest(&liver, Some("liver"), [0.5, 0.0, 0.0]),
        ];
        assert!(unmoved.iter().all(|way| norm(*way) < 1e-12));
    }

    #[test]
    fn tissue_far_in_front_of_the_place_is_left_out() {
        let far = drawn(&square(OrganKind::Liver, 0.04), None);
        assert_eq!(
            far.get_pixel(160, 120).0,
            BACKGROUND.map(|it| it as u8),
            "it would hide the place"
        );
    }

    #[test]
    fn the_picture_is_seen_from_the_endoscope_and_shows_the_shaft() {
        // The endoscope looks from the right (+x) with y up; the shaft rises from the tip.
        let half = 0.5f32.sqrt();
        let hands = Hands {
            world_from_camera: PoseMsg {
                position_m: [0.1, 0.0, 0.0],
                orientation: [0.0, half, 0.0, half],
            },
            tip_m: [0.0, 0.004, 0.0],
            shaft: [0.0, 1.0, 0.0],
        };
        let side = drawn(&square(OrganKind::Liver, 0.0), Some(&hands));
        let metal = side.get_pixel(160, 40);
        assert!(metal[2] > 100, "the shaft is above the place: {metal:?}");
        // The square is seen from its edge.
        assert!(side.get_pixel(100, 120)[2] < 40);
    }

    #[test]
    fn the_organ_concerned_shows_through_what_hides_it() {
        let square = |z_m: f32| {
            let corner = |x: f32, y: f32| [x, y, z_m];
            let middle = corner(0.0, 0.0);
            let rim = [corner(-0.02, -0.02), corner(0.02, -0.02), corner(0.0, 0.02)];
            let [a, b, c] = rim;
            vec![[middle, a, b], [middle, b, c], [middle, c, a]]
        };
        let duct = Outlines::test(OrganKind::BileDuct, square(0.0));
        let both = duct.with("wall", OrganKind::Liver, square(0.01));
        let at = |concerned| {
            let picture = close_picture(&both, (Some(concerned), [0.0; 3]), None).unwrap();
            picture.get_pixel(160, 126).0
        };
        let [hidden, through] = [at("wall"), at("liver")];
        assert!(through[1] > hidden[1] + 30, "{hidden:?} {through:?}");
    }

    #[test]
    fn a_scene_without_surfaces_has_no_picture() {
        let place = (None, [0.0; 3]);
        assert_eq!(close_picture(&Outlines::default(), place, None), None);
    }
}
