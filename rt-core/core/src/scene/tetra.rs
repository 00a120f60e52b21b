//! Tetrahedra in batches of eight that share no sphere. One batch fills the lanes of a vector
//! register.

use crate::math::{self, Vec3};
use crate::scene::{RestSphere, SceneError};

/// Tetrahedra in a batch.
pub const LANES: usize = 8;

/// Shape `6 V / L³` below which a tetrahedron is refused as flat. L is the longest edge at the
/// first corner.
const SHAPE_MIN: f32 = 1.0e-3;

/// Four spheres of an organ and the tissue that they carry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tetra {
    /// Its corners, indices into the scene's spheres; `det(b − a, c − a, d − a)` is positive.
    pub spheres: [u32; 4],
    /// Volume of tissue that the tetrahedron represents, m³. Under the skin it is larger than the
    /// volume of the tetrahedron.
    pub volume_m3: f32,
}

/// Eight tetrahedra, lane by lane; made by [`batches`].
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(64))]
pub struct TetraBatch {
    /// Indices of the spheres, by corner, then lane.
    pub(crate) spheres: [[u16; LANES]; 4],
    /// Gradient of the shape function of corners 1 to 3, world axes, 1/m: corner, axis, lane. It
    /// is zero in an unused lane, which therefore changes nothing.
    pub(crate) gradients_per_m: [[[f32; LANES]; 3]; 3],
    /// Volume of tissue represented, m³, by lane; 0 in an unused lane.
    pub(crate) volume_m3: [f32; LANES],
}

impl TetraBatch {
    const EMPTY: Self = Self {
        spheres: [[0; LANES]; 4],
        gradients_per_m: [[[0.0; LANES]; 3]; 3],
        volume_m3: [0.0; LANES],
    };

    /// Calls `with` for each corner of each lane: the lane, the corner's sphere, its shape
    /// gradient, 1/m, and the volume represented, m³. The last two are zero in an unused lane.
    pub(crate) fn each_corner(&self, mut with: impl FnMut(usize, u32, Vec3, f32)) {
        for (lane, volume_m3) in self.volume_m3.iter().enumerate() {
            let at = |row: &[f32; LANES]| row.get(lane).copied().unwrap_or(0.0);
            let gradient = |[x, y, z]: &[[f32; LANES]; 3]| Vec3::new(at(x), at(y), at(z));
            let [b1, b2, b3] = self.gradients_per_m.each_ref().map(gradient);
            let gradients = [-(b1 + b2 + b3), b1, b2, b3];
            for (spheres, gradient) in self.spheres.iter().zip(gradients) {
                let sphere = spheres.get(lane).map_or(0, |it| u32::from(*it));
                with(lane, sphere, gradient, *volume_m3);
            }
        }
    }

    /// Corners of each lane in use.
    #[cfg(test)]
    pub(crate) fn corners(&self) -> impl Iterator<Item = [u32; 4]> + '_ {
        let [first, ..] = &self.gradients_per_m;
        (0..LANES).filter_map(move |lane| {
            let used = first
                .iter()
                .any(|axis| axis.get(lane).is_some_and(|g| *g != 0.0));
            let corner = |spheres: &[u16; LANES]| u32::from(*spheres.get(lane).unwrap_or(&0));
            used.then(|| self.spheres.each_ref().map(corner))
        })
    }

    fn uses(&self, lanes: usize, sphere: u32) -> bool {
        let mut used = self
            .spheres
            .iter()
            .flat_map(|corner| corner.iter().take(lanes));
        used.any(|&s| u32::from(s) == sphere)
    }

    fn set_lane(&mut self, lane: usize, tetra: &Tetra, gradients: &[Vec3; 3]) {
        for (corner, sphere) in self.spheres.iter_mut().zip(tetra.spheres) {
            if let Some(slot) = corner.get_mut(lane) {
                *slot = sphere as u16; // asserted in `capacity`
            }
        }
        for (corner, gradient) in self.gradients_per_m.iter_mut().zip(gradients) {
            for (axis, value) in corner.iter_mut().zip(gradient.iter()) {
                if let Some(slot) = axis.get_mut(lane) {
                    *slot = *value;
                }
            }
        }
        if let Some(slot) = self.volume_m3.get_mut(lane) {
            *slot = tetra.volume_m3;
        }
    }
}

/// Passes the tetrahedra of one organ to `keep` in batches, in their order. A batch ends after
/// eight tetrahedra, or if the next tetrahedron shares a sphere with it. Preparation orders the
/// tetrahedra so that most batches are full.
///
/// # Errors
/// If a tetrahedron is flat or inverted at rest, represents no volume, or names a sphere that does
/// not exist. The index in the error is that of the tetrahedron.
pub fn batches(
    tetrahedra: &[Tetra],
    spheres: &[RestSphere],
    mut keep: impl FnMut(TetraBatch),
) -> Result<(), SceneError> {
    let (mut batch, mut lanes) = (TetraBatch::EMPTY, 0);
    for (i, tetra) in tetrahedra.iter().enumerate() {
        let gradients = gradients(i, tetra, spheres)?;
        if lanes == LANES || tetra.spheres.iter().any(|&s| batch.uses(lanes, s)) {
            keep(batch);
            (batch, lanes) = (TetraBatch::EMPTY, 0);
        }
        if lanes == 0 {
            // Unused lanes read spheres of the same organ.
            for (corner, sphere) in batch.spheres.iter_mut().zip(tetra.spheres) {
                *corner = [sphere as u16; LANES];
            }
        }
        batch.set_lane(lanes, tetra, &gradients);
        lanes += 1;
    }
    if lanes > 0 {
        keep(batch);
    }
    Ok(())
}

fn gradients(index: usize, tetra: &Tetra, spheres: &[RestSphere]) -> Result<[Vec3; 3], SceneError> {
    let bad = |what, value, allowed| SceneError::Value {
        what,
        index,
        value,
        allowed,
    };
    if !(1.0e-15..=1.0).contains(&tetra.volume_m3) {
        return Err(bad("tetrahedron volume", tetra.volume_m3, "1e-15 to 1 m^3"));
    }
    let mut at = [Vec3::zeros(); 4];
    for (at, &sphere) in at.iter_mut().zip(&tetra.spheres) {
        let rest = spheres
            .get(sphere as usize)
            .ok_or_else(|| bad("tetrahedron sphere", sphere as f32, "a sphere of the scene"))?;
        *at = rest.center_m;
    }
    let [a, b, c, d] = at;
    let (x, y, z) = (b - a, c - a, d - a);
    let volume = x.cross(&y).dot(&z);
    let longest = math::norm(&x).max(math::norm(&y)).max(math::norm(&z));
    let shape = volume / (longest * longest * longest);
    if shape.is_nan() || shape < SHAPE_MIN {
        return Err(bad("tetrahedron shape 6 V / L^3", shape, "0.001 or more"));
    }
    Ok([y.cross(&z), z.cross(&x), x.cross(&y)].map(|normal| normal / volume))
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::scene::tests::sphere;
    use std::vec::Vec;

    fn grid() -> Vec<RestSphere> {
        let at = |i: u16| Vec3::new(f32::from(i % 3), f32::from(i / 3 % 3), f32::from(i / 9));
        (0..27).map(|i| sphere(at(i) * 0.01, 0.006)).collect()
    }

    fn pack(tetrahedra: &[[u32; 4]]) -> Result<Vec<TetraBatch>, SceneError> {
        let carry = |&spheres: &[u32; 4]| Tetra {
            spheres,
            volume_m3: 1.0e-6,
        };
        let tetrahedra: Vec<Tetra> = tetrahedra.iter().map(carry).collect();
        let mut packed = Vec::new();
        batches(&tetrahedra, &grid(), |batch| packed.push(batch))?;
        Ok(packed)
    }

    #[test]
    fn tetrahedra_that_share_a_sphere_are_kept_apart() {
        let packed = pack(&[[0, 1, 3, 9], [4, 5, 7, 13], [1, 2, 4, 10]]).unwrap();
        let corners: Vec<Vec<[u32; 4]>> = packed.iter().map(|b| b.corners().collect()).collect();
        assert_eq!(corners.len(), 2);
        assert_eq!(corners[0], [[0, 1, 3, 9], [4, 5, 7, 13]]);
        assert_eq!(corners[1], [[1, 2, 4, 10]]);
    }

    #[test]
    fn gradients_are_those_of_the_shape_functions() {
        let packed = pack(&[[0, 1, 3, 9]]).unwrap();
        for (corner, gradient) in packed[0].gradients_per_m.iter().enumerate() {
            for (axis, lanes) in gradient.iter().enumerate() {
                let expected = if axis == corner { 100.0 } else { 0.0 };
                assert!((lanes[0] - expected).abs() < 1.0e-3);
                assert!(lanes[1..].iter().all(|&g| g == 0.0), "not in use");
            }
        }
    }

    #[test]
    fn flat_inverted_and_foreign_tetrahedra_are_refused() {
        let refused = |corners| pack(&[corners]).unwrap_err();
        let place = |error| matches!(error, SceneError::Value { index: 0, .. });
        assert!(place(refused([0, 3, 1, 9])), "inverted");
        assert!(place(refused([0, 1, 3, 4])), "flat");
        assert!(place(refused([0, 1, 3, 27])), "no such sphere");
    }
}
