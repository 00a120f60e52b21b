//! Dents of tools in the skin.
//!
//! Inner spheres are too coarse to show the dent of a thin tool. The contact law of the controller
//! knows the rest: which piece of a tool presses on which organ, in which direction, and how far
//! the piece reaches below the skin that the spheres carry. A piece is a ball or a stretch of one
//! part. Each tick publishes these dents ([`DentMsg`]), and the picture shows no others. The drawn
//! skin is finer than the contact skin. In places the two are a few millimetres apart, so the depth
//! is measured again from the drawn skin.
//!
//! Skin under the piece moves by the whole depth. Skin beside the piece moves less, the farther
//! away it is. Below the skin, the displacement fades with depth, so slowly that no tissue folds.
//! So the opposite wall of a thin organ moves along, and no wall passes through another.

use bytemuck::{Pod, Zeroable};
use glam::Vec3;
use shared_mem::message::{DentMsg, MAX_DENTS};
use shared_mem::scene::OrganRecord;

/// A dent, in the layout of the shader.
#[repr(C)]
#[derive(Debug, Clone, Copy, Default, PartialEq, Pod, Zeroable)]
pub struct Dent {
    /// One end of the piece's axis, m; the fourth number is the piece's radius, m.
    pub a: [f32; 4],
    /// The other end of the axis, m; the fourth number is the depth of the dent, m.
    pub b: [f32; 4],
    /// Unit vector into the tissue; the fourth number is unused.
    pub into: [f32; 4],
    /// First sphere of the organ, and the first after its last; two unused numbers.
    pub spheres: [u32; 4],
}

/// Width of the shoulder between displaced and undisturbed skin at depth 0, m. `skinning.wgsl` has
/// the same number.
const SHOULDER_M: f32 = 0.0015;
/// Growth of the shoulder's width with the depth. The steepest slope is `0.86 depth / width`: below
/// 0.86 / 0.4 = 2.15 at every depth, so skin is stretched less than 2.4 times. `skinning.wgsl` has
/// the same number.
const SHOULDER_PER_DEPTH: f32 = 0.4;
/// Depth below the skin at which the displacement has fallen to 1/e, m. For a deep dent it is twice
/// the depth of the dent, so that tissue below the tool is pressed together by half at most.
const FADES_M: f32 = 0.005;
/// Drawn skin up to this height over the undisturbed skin is moved down to the tool's deepest
/// level, m.
const ROUGH_M: f32 = 0.001;

/// Width (sigma) of a Gaussian about the piece's axis, m. It weights the vertices of the drawn skin
/// in the mean of their heights. The width is half of the edge of a coarse skin's triangle.
const LEVEL_M: f32 = 0.0015;
/// Largest difference between the drawn and the published depth, m. Skin that is off by more than
/// twice this belongs to another wall.
const DIFFERS_M: f32 = 0.003;
/// Depth of a dent at which 63 % of the difference counts, m. The share is `1 − exp(−depth /
/// SETTLES_M)`, because a light touch must not make the skin jump.
const SETTLES_M: f32 = 0.0005;

/// Depth of a dent in the drawn skin, m. `near_m` are the undented vertices of the organ near the
/// dent.
pub(super) fn depth_m(dent: &DentMsg, near_m: impl Iterator<Item = Vec3>) -> f32 {
    let (center, into) = (Vec3::from(dent.center_m), -Vec3::from(dent.normal));
    let half = Vec3::from(dent.half_m);
    let (mut sum, mut weights) = (0.0, 0.0);
    for at in near_m {
        let off = at - beside(center - half, center + half, at, into);
        let along_m = off.dot(into);
        let deeper_m = dent.radius_m - along_m - dent.depth_m;
        let x = (off - into * along_m).length() / LEVEL_M;
        if deeper_m.abs() < 2.0 * DIFFERS_M && x < 3.0 {
            let weight = (-0.5 * x * x).exp();
            sum += deeper_m * weight;
            weights += weight;
        }
    }
    if weights <= 0.0 {
        return dent.depth_m;
    }
    let deeper_m = (sum / weights).clamp(-DIFFERS_M, DIFFERS_M);
    dent.depth_m + deeper_m * (1.0 - (-dent.depth_m / SETTLES_M).exp())
}

/// The dents of a frame on these organs, in the layout of the shader. Unused places are zero.
pub(super) fn dents(
    of: &[DentMsg],
    organs: &[OrganRecord],
    depth_m: impl Fn(&DentMsg) -> f32,
) -> [Dent; MAX_DENTS] {
    let mut all = [Dent::default(); MAX_DENTS];
    let known = of.iter().filter_map(|dent| {
        let [first, count] = organs.get(dent.organ as usize)?.spheres;
        let (center, half) = (Vec3::from(dent.center_m), Vec3::from(dent.half_m));
        Some(Dent {
            a: (center - half).extend(dent.radius_m).to_array(),
            b: (center + half).extend(depth_m(dent)).to_array(),
            into: (-Vec3::from(dent.normal)).extend(0.0).to_array(),
            spheres: [first, first + count, 0, 0],
        })
    });
    for (slot, dent) in all.iter_mut().zip(known) {
        *slot = dent;
    }
    all
}

/// Displacement of a vertex by dents, m. `share` returns the share of the vertex's weight that lies
/// on the spheres of a dent's organ. `around_m` is the distance to the vertex's neighbours. Skin at
/// most that far beside a piece goes down with the piece; otherwise a triangle would cut through
/// the piece. Twin of `dented` in `skinning.wgsl`.
pub(super) fn dented(
    dents: &[Dent],
    at: Vec3,
    around_m: f32,
    share: impl Fn([u32; 4]) -> f32,
) -> Vec3 {
    let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
    for dent in dents {
        let length = displaced_m(dent, at, around_m);
        if length.abs() <= 0.0 {
            continue;
        }
        let push = Vec3::from_slice(&dent.into) * (length * share(dent.spheres));
        // The fourth power lets the largest displacement win, and blends equal ones.
        let weight = push.length_squared() * push.length_squared();
        sum += push * weight;
        weights += weight;
    }
    if weights > 0.0 {
        sum / weights
    } else {
        Vec3::ZERO
    }
}

/// Displacement of a place by one dent, m.
fn displaced_m(dent: &Dent, at: Vec3, around_m: f32) -> f32 {
    let into = Vec3::from_slice(&dent.into);
    let (a, b) = (Vec3::from_slice(&dent.a), Vec3::from_slice(&dent.b));
    let (radius_m, depth_m) = (dent.a[3], dent.b[3]);
    let off = at - beside(a, b, at, into);
    let along_m = off.dot(into);
    let width_m = SHOULDER_M + SHOULDER_PER_DEPTH * depth_m.abs();
    let across_m =
        ((off - into * along_m).length() - half_width_m(radius_m, depth_m) - around_m).max(0.0);
    let x = across_m / width_m;
    if x > 3.0 {
        return 0.0;
    }
    // Depth of the place below the undisturbed skin.
    let below_m = along_m - (radius_m - depth_m);
    let under_m = if below_m >= 0.0 {
        depth_m * (-below_m / FADES_M.max(2.0 * depth_m)).exp()
    } else if below_m > -ROUGH_M {
        depth_m - below_m
    } else {
        // Skin farther up is beside the tool. It moves less, by half a metre per metre of height,
        // so it stays above the skin below it.
        ((depth_m + ROUGH_M).max(0.0) + 0.5 * (below_m + ROUGH_M)).max(0.0)
    };
    under_m * (-x * x).exp()
}

/// Half of the width of the piece at the level of the undisturbed skin, m.
fn half_width_m(radius_m: f32, depth_m: f32) -> f32 {
    let up_m = (radius_m - depth_m.max(0.0)).max(0.0);
    (radius_m * radius_m - up_m * up_m).max(0.0).sqrt()
}

/// Point of a segment nearest to the line through `at` along `into`.
fn beside(from: Vec3, to: Vec3, at: Vec3, into: Vec3) -> Vec3 {
    let flat = |v: Vec3| v - into * v.dot(into);
    let (axis, offset) = (flat(to - from), flat(at - from));
    let share = offset.dot(axis) / axis.length_squared().max(1e-12);
    from.lerp(to, share.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Distance of a vertex's neighbours in the tests' skin, m.
    const EDGE_M: f32 = 0.001;

    /// A ball of this radius, pressed this deep at the origin into skin in the plane z = 0.
    fn ball(radius_m: f32, depth_m: f32) -> Dent {
        let center = Vec3::Z * (radius_m - depth_m);
        Dent {
            a: center.extend(radius_m).to_array(),
            b: center.extend(depth_m).to_array(),
            into: Vec3::NEG_Z.extend(0.0).to_array(),
            spheres: [0, 1, 0, 0],
        }
    }

    fn moved(dents: &[Dent], at: Vec3) -> Vec3 {
        at + dented(dents, at, EDGE_M, |_| 1.0)
    }

    proptest! {
        #[test]
        fn skin_lies_on_the_tool_and_not_in_it(
            radius_m in 0.0008f32..0.005, depth_m in 1e-5f32..0.012, x in -0.02f32..0.02,
            rough_m in 0.0f32..0.0009,
        ) {
            let dent = ball(radius_m, depth_m);
            let center = Vec3::from_slice(&dent.a);
            let under = moved(&[dent], Vec3::Z * rough_m);
            prop_assert!((under.z + depth_m).abs() < 1e-6, "{under}");
            let beside = moved(&[dent], Vec3::new(x, 0.0, 0.0));
            let in_tool_m = radius_m - beside.distance(center);
            prop_assert!(in_tool_m < 1e-4, "{in_tool_m} m in the tool");
        }

        #[test]
        fn no_tissue_overtakes_other_tissue_and_none_is_torn(
            radius_m in 0.0008f32..0.005, depth_m in 1e-5f32..0.012,
            x in -0.02f32..0.02, z in -0.03f32..0.015,
        ) {
            let dent = [ball(radius_m, depth_m)];
            let at = Vec3::new(x, 0.0, z);
            let step = 1e-5;
            let here = moved(&dent, at);
            let below = moved(&dent, at - Vec3::Z * step);
            let beside = moved(&dent, at + Vec3::X * step);
            prop_assert!(here.z > below.z - 1e-8, "{here} over {below}");
            prop_assert!(here.distance(beside) < 2.4 * step, "{here} and {beside}");
            let far = Vec3::new(0.06, 0.0, z);
            prop_assert!(moved(&dent, far) == far);
        }
    }

    #[test]
    fn only_the_dented_organ_moves_and_two_tools_meet_in_the_middle() {
        let dent = ball(0.002, 0.003);
        assert!(dented(&[dent], Vec3::ZERO, EDGE_M, |_| 0.0) == Vec3::ZERO);
        let half = dented(&[dent], Vec3::ZERO, EDGE_M, |_| 0.5);
        assert!((half.z + 0.0015).abs() < 1e-6, "{half}");
        // A jaw on the opposite side of a fold of 4 mm makes the other dent.
        let mut other = dent;
        for end in [&mut other.a, &mut other.b] {
            end[2] = -0.004 - end[2];
        }
        other.into = Vec3::Z.extend(0.0).to_array();
        let middle = dented(&[dent, other], Vec3::Z * -0.002, EDGE_M, |_| 1.0);
        assert!(middle.length() < 1e-6, "{middle}");
    }
}
