//! A precomputed tile of gradient noise with its gradient. One texture fetch gives a shader a bump
//! and its slope. The shader would need far more time to compute them.

use glam::Vec3;

/// Voxels along a side.
pub(super) const SIDE: usize = 64;
/// Noise cells along a side; `light.wgsl` divides by this number.
pub(super) const CELLS: usize = 8;

/// RGBA voxels, x fastest: the noise's gradient per noise cell, and its value.
#[must_use]
pub(super) fn tile() -> Vec<[f32; 4]> {
    let mut voxels = Vec::with_capacity(SIDE * SIDE * SIDE);
    let step = CELLS as f32 / SIDE as f32;
    for z in 0..SIDE {
        for y in 0..SIDE {
            for x in 0..SIDE {
                let centre = Vec3::new(x as f32, y as f32, z as f32) + 0.5;
                let (gradient, value) = noise(centre * step);
                voxels.push(gradient.extend(value).to_array());
            }
        }
    }
    voxels
}

/// Perlin's improved noise and its exact gradient. Both repeat every [`CELLS`].
#[must_use]
pub(super) fn noise(at: Vec3) -> (Vec3, f32) {
    let cell = at.floor();
    let w = at - cell;
    let fade = |t: f32| t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
    let slope = |t: f32| 30.0 * t * t * (t * (t - 2.0) + 1.0);
    let (fade, slope) = (
        [fade(w.x), fade(w.y), fade(w.z)],
        [slope(w.x), slope(w.y), slope(w.z)],
    );
    let (mut gradient, mut value) = (Vec3::ZERO, 0.0);
    for corner in 0..8u32 {
        let side = [corner & 1, corner >> 1 & 1, corner >> 2];
        let corner_at = Vec3::from_array(side.map(|s| s as f32));
        let direction = direction((cell + corner_at).to_array());
        let height = direction.dot(w - corner_at);
        let share: [f32; 3] =
            core::array::from_fn(|i| if side[i] == 1 { fade[i] } else { 1.0 - fade[i] });
        let change: [f32; 3] =
            core::array::from_fn(|i| if side[i] == 1 { slope[i] } else { -slope[i] });
        let all = share[0] * share[1] * share[2];
        value += height * all;
        gradient += direction * all
            + height
                * Vec3::new(
                    change[0] * share[1] * share[2],
                    share[0] * change[1] * share[2],
                    share[0] * share[1] * change[2],
                );
    }
    (gradient, value)
}

/// A tile of packed bumps (cellular noise; not the cells of layered tissue), RGBA, x fastest. The
/// first three values are the slope of the nearest bump's dome. The fourth is the distance to the
/// second nearest middle of a bump minus that to the nearest: 0 in the furrow between two bumps.
#[must_use]
pub(super) fn cells_tile() -> Vec<[f32; 4]> {
    let n = CELLS as i32;
    let mut middles = Vec::with_capacity(CELLS * CELLS * CELLS);
    for z in 0..CELLS as u32 {
        for y in 0..CELLS as u32 {
            for x in 0..CELLS as u32 {
                let jitter = [3, 71, 139].map(|k| 0.1 + 0.8 * hash(x + k, y + 2 * k, z + 3 * k));
                middles.push(Vec3::from_array(jitter));
            }
        }
    }
    let step = CELLS as f32 / SIDE as f32;
    let mut voxels = Vec::with_capacity(SIDE * SIDE * SIDE);
    for z in 0..SIDE {
        for y in 0..SIDE {
            for x in 0..SIDE {
                let at = (Vec3::new(x as f32, y as f32, z as f32) + 0.5) * step;
                let cell = at.floor().as_ivec3();
                let (mut first, mut second, mut to_first) =
                    (f32::INFINITY, f32::INFINITY, Vec3::ZERO);
                for d in 0..27i32 {
                    let c = cell + glam::IVec3::new(d % 3 - 1, d / 3 % 3 - 1, d / 9 - 1);
                    let [i, j, k] = c.to_array().map(|v| v.rem_euclid(n) as usize);
                    let middle = c.as_vec3() + middles[(k * CELLS + j) * CELLS + i];
                    let far = middle.distance(at);
                    if far < first {
                        (second, first, to_first) = (first, far, middle - at);
                    } else {
                        second = second.min(far);
                    }
                }
                voxels.push(
                    (to_first * 2.0)
                        .extend((second - first).min(1.0))
                        .to_array(),
                );
            }
        }
    }
    voxels
}

/// Pseudo-random number from 0 to 1 for a grid point.
#[must_use]
pub(super) fn hash(x: u32, y: u32, z: u32) -> f32 {
    let mut h =
        x.wrapping_mul(0x8da6_b343) ^ y.wrapping_mul(0xd816_3841) ^ z.wrapping_mul(0xcb1a_b31f);
    h ^= h >> 16;
    h = h.wrapping_mul(0x7feb_352d);
    h ^= h >> 15;
    h = h.wrapping_mul(0x846c_a68b);
    h ^= h >> 16;
    (h >> 8) as f32 / 16_777_216.0
}

fn direction(cell: [f32; 3]) -> Vec3 {
    let [x, y, z] = cell.map(|c| (c as i32).rem_euclid(CELLS as i32) as u32);
    let height = hash(x, y, z) * 2.0 - 1.0;
    let turn = hash(x + 101, y + 57, z + 13) * core::f32::consts::TAU;
    let flat = (1.0 - height * height).max(0.0).sqrt();
    // Perlin's gradients have length √2.
    Vec3::new(flat * turn.cos(), flat * turn.sin(), height) * core::f32::consts::SQRT_2
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gradient_is_the_value_s_derivative() {
        for i in 0..200u32 {
            let at = Vec3::new(hash(i, 0, 0), hash(i, 1, 0), hash(i, 2, 0)) * 8.0;
            let (gradient, _) = noise(at);
            for axis in 0..3 {
                let mut step = Vec3::ZERO;
                step[axis] = 1e-2;
                let numeric = (noise(at + step).1 - noise(at - step).1) / 2e-2;
                let error = (numeric - gradient[axis]).abs();
                assert!(
                    error < 5e-3,
                    "axis {axis} at {at}: {numeric} and {gradient}"
                );
            }
        }
    }

    #[test]
    fn cells_have_furrows_and_repeat() {
        let tile = cells_tile();
        assert_eq!(tile.len(), SIDE * SIDE * SIDE);
        let height = |x: usize, y: usize, z: usize| tile[(z * SIDE + y) * SIDE + x][3];
        // The tile continues across its border as it does inside.
        let jump = |a: usize, b: usize| {
            let all = (0..SIDE * SIDE)
                .map(|i| (height(a, i % SIDE, i / SIDE) - height(b, i % SIDE, i / SIDE)).abs());
            all.sum::<f32>() / (SIDE * SIDE) as f32
        };
        assert!(jump(SIDE - 1, 0) < 1.5 * jump(20, 21));
        let flat = tile.iter().filter(|v| v[3] < 0.08).count() as f32 / tile.len() as f32;
        assert!(flat > 0.05 && flat < 0.4, "{flat} is furrow");
    }

    #[test]
    fn tile_repeats_and_is_centred() {
        let a = noise(Vec3::new(0.3, 1.2, 7.9)).1;
        let b = noise(Vec3::new(0.3 + CELLS as f32, 1.2, 7.9 - CELLS as f32)).1;
        assert!((a - b).abs() < 1e-4);
        let tile = tile();
        let mean: f32 = tile.iter().map(|v| v[3]).sum::<f32>() / tile.len() as f32;
        let most = tile.iter().map(|v| v[3].abs()).fold(0.0, f32::max);
        assert!(
            mean.abs() < 0.03 && most > 0.5 && most < 1.3,
            "{mean} {most}"
        );
    }
}
