//! Gallstones outside of the gallbladder: rigid parts, numbered after the clips.
//!
//! Stones that lay together in a gallbladder press on each other, so most have facets with rounded
//! edges. Some are mulberries of many small bumps. Each number has its own shape.

use glam::{Mat4, Quat, Vec3};
use shared_mem::message::{MAX_STONES, StoneMsg};

use super::layout::{PARTS, SHADING_STONES};
use super::look::CERAMIC;
use super::solid::{RigidVertex, sphere};
use crate::effects::chance;

/// Index of the first stone among the rigid parts; the same number is in `rigid.wgsl`.
pub(super) const FIRST_PART: usize = 32;
const _: () = assert!(FIRST_PART + MAX_STONES <= PARTS);
/// Subdivisions of the icosahedron of which a stone is made.
const FINENESS: u32 = 3;
/// One of so many stones is a mulberry.
const MULBERRY_EVERY: u32 = 4;
/// Planes that cut a faceted stone.
const FACETS: u32 = 9;
/// Sharpness of the edges between facets: the exponent of a smooth minimum.
const SHARPNESS: f32 = 22.0;
/// Bumps of a mulberry.
const BUMPS: u32 = 26;
/// Height of a mulberry's bumps, in radii.
const BUMP: f32 = 0.16;

/// Stones for the next frame.
#[derive(Debug, Clone, Default)]
pub(super) struct Stones {
    shown: Vec<StoneMsg>,
}

impl Stones {
    pub(super) fn set(&mut self, stones: &[StoneMsg]) {
        self.shown.clear();
        self.shown.extend_from_slice(stones);
    }

    /// Numbers of the stones.
    pub(super) fn numbers(&self) -> impl Iterator<Item = u32> + '_ {
        self.shown.iter().map(|it| it.number)
    }

    /// Poses of all parts for stones. A missing stone has size 0.
    pub(super) fn places(&self) -> [Mat4; MAX_STONES] {
        let mut places = [Mat4::ZERO; MAX_STONES];
        for stone in &self.shown {
            if let Some(place) = places.get_mut(stone.number as usize) {
                *place = Mat4::from_scale_rotation_translation(
                    Vec3::splat(stone.radius_m),
                    Quat::from_array(stone.orientation).normalize(),
                    Vec3::from(stone.at_m),
                );
            }
        }
        places
    }

    /// Centre and radius of the stones nearest to the lens, which shade the tissue around them, and
    /// their number.
    pub(super) fn shading(&self, eye: Vec3) -> ([[f32; 4]; SHADING_STONES], u32) {
        let far = |it: &StoneMsg| Vec3::from(it.at_m).distance_squared(eye);
        let mut near: Vec<&StoneMsg> = self.shown.iter().collect();
        near.sort_by(|a, b| far(a).total_cmp(&far(b)));
        let mut balls = [[0.0; 4]; SHADING_STONES];
        let mut count = 0;
        for (ball, stone) in balls.iter_mut().zip(near) {
            *ball = Vec3::from(stone.at_m).extend(stone.radius_m).to_array();
            count += 1;
        }
        (balls, count)
    }
}

/// Vertices and triangles of all possible stones, each of radius 1. All have equally many
/// triangles.
pub(super) fn all() -> (Vec<RigidVertex>, Vec<[u32; 3]>) {
    let (directions, faces) = sphere(FINENESS);
    let (mut vertices, mut triangles) = (Vec::new(), Vec::new());
    for number in 0..MAX_STONES as u32 {
        let base = vertices.len() as u32;
        let places: Vec<Vec3> = directions.iter().map(|d| *d * radius(number, *d)).collect();
        let mut normals = vec![Vec3::ZERO; places.len()];
        for face in &faces {
            let [a, b, c] = face.map(|i| places[i as usize]);
            for i in face {
                normals[*i as usize] += (b - a).cross(c - a);
            }
            triangles.push(face.map(|i| base + i));
        }
        vertices.extend(
            places
                .iter()
                .zip(normals)
                .map(|(place, normal)| RigidVertex {
                    position: place.to_array(),
                    look: CERAMIC,
                    normal: normal.normalize_or(*place).to_array(),
                    part: FIRST_PART as u32 + number,
                }),
        );
    }
    (vertices, triangles)
}

/// Distance of a stone's surface from its middle in a direction, in radii.
fn radius(number: u32, direction: Vec3) -> f32 {
    let own = |k: u32| chance(number.wrapping_mul(977).wrapping_add(k));
    let size = 1.0 + 0.05 * own(0).x;
    if number % MULBERRY_EVERY == MULBERRY_EVERY - 1 {
        let bump = |k| {
            let at = own(200 + k).normalize_or(Vec3::Y);
            let off = at.distance(direction) / 0.42;
            (1.0 - off * off).max(0.0)
        };
        let highest = (0..BUMPS).map(bump).fold(0.0, f32::max);
        return size * (0.92 - 0.5 * BUMP + BUMP * highest.sqrt());
    }
    let mut sum = 1.0;
    for k in 0..FACETS {
        let normal = own(100 + k).normalize_or(Vec3::X);
        let height = 0.80 + 0.08 * own(50 + k).y;
        sum += (normal.dot(direction).max(0.0) / height).powf(SHARPNESS);
    }
    size * 1.06 * sum.powf(-1.0 / SHARPNESS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stones_are_as_large_as_they_say_and_no_two_are_alike() {
        let (vertices, triangles) = all();
        let each = vertices.len() / MAX_STONES;
        assert_eq!(triangles.len() % MAX_STONES, 0);
        let own = |number: usize| &vertices[number * each..(number + 1) * each];
        for number in 0..MAX_STONES {
            let far = own(number).iter().map(|v| Vec3::from(v.position).length());
            let (mut least, mut most, mut sum) = (f32::MAX, 0.0f32, 0.0);
            for r in far {
                (least, most, sum) = (least.min(r), most.max(r), sum + r);
            }
            let mean = sum / each as f32;
            assert!(least > 0.6 && most < 1.2, "{number}: {least} to {most}");
            assert!((0.82..1.05).contains(&mean), "{number}: {mean}");
            for other in 0..number {
                let pairs = own(number).iter().zip(own(other));
                let apart: f32 = pairs
                    .map(|(a, b)| Vec3::from(a.position).distance(Vec3::from(b.position)))
                    .sum();
                assert!(apart / each as f32 > 0.02, "{number} is a copy of {other}");
            }
        }
    }

    #[test]
    fn only_the_nearest_stones_shade_and_absent_ones_have_no_size() {
        let stone = |number: u32| StoneMsg {
            at_m: [number as f32, 0.0, 0.0],
            radius_m: 0.002,
            orientation: [0.0, 0.0, 0.0, 1.0],
            number,
            is_held: 0,
        };
        let mut stones = Stones::default();
        stones.set(&(0..20).map(stone).collect::<Vec<_>>());
        let (balls, count) = stones.shading(Vec3::X * 19.0);
        assert_eq!(count as usize, SHADING_STONES);
        assert!(balls.iter().all(|ball| ball[0] > 7.0 && ball[3] > 0.0));
        let places = stones.places();
        assert!((places[3].transform_point3(Vec3::Y).y - 0.002).abs() < 1e-6);
        assert_eq!(places[20], Mat4::ZERO);
        stones.set(&[stone(99)]);
        assert_eq!(stones.places(), [Mat4::ZERO; MAX_STONES]);
    }
}
