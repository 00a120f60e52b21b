//! Overlap of a sphere with a part of an instrument, taken as a cylinder with flat ends (Algorithm
//! 1 of the inner-sphere paper).

use crate::math::{self, Vec3};
use crate::tool::Capsule;

/// Position of a sphere's centre, in the cylinder's own coordinates.
struct Local {
    /// Unit vector along the axis, towards the nearer end.
    axis: Vec3,
    /// Unit vector away from the axis.
    radial: Vec3,
    /// `x − h/2` of the paper: distance beyond the nearer end, m.
    beyond_end_m: f32,
    /// `d − r0` of the paper: distance outside the lateral surface, m.
    outside_m: f32,
}

fn local(center_m: &Vec3, part: &Capsule) -> Local {
    let along = part.b_m - part.a_m;
    let h = math::norm(&along);
    // A cylinder without length is a disc; any direction serves.
    let u = math::unit(&along).unwrap_or_else(|| Vec3::new(0.0, 0.0, 1.0));
    let from_middle = center_m - (part.a_m + part.b_m) * 0.5;
    let x = u.dot(&from_middle);
    let across = from_middle - u * x;
    Local {
        axis: if x < 0.0 { -u } else { u },
        // A centre on the axis gets an arbitrary but fixed direction.
        radial: math::unit(&across).unwrap_or_else(|| math::perpendicular(&u)),
        beyond_end_m: x.abs() - 0.5 * h,
        outside_m: math::norm(&across) - part.radius_m,
    }
}

/// Algorithm 1 of the paper: true if a sphere meets a cylinder. `p1`, `p2` are the ends of the
/// axis, `r0` is the radius, `c` and `r` are the sphere's.
#[must_use]
pub fn meets(c: &Vec3, r: f32, p1: &Vec3, p2: &Vec3, r0: f32) -> bool {
    let p0 = (p1 + p2) * 0.5;
    let h = math::norm(&(p2 - p1));
    let u = (p2 - p1) / h;
    let x = u.dot(&(c - p0)).abs();
    let n = math::norm(&(c - p0));
    let d = math::sqrt((n * n - x * x).max(0.0)); // rounding may leave it below zero
    if x < h / 2.0 {
        d < r0 + r
    } else if d < r0 {
        x - h / 2.0 < r
    } else {
        (x - h / 2.0) * (x - h / 2.0) + (d - r0) * (d - r0) < r * r
    }
}

/// Depth and normal of a sphere and a cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Touch {
    /// Depth of the overlap, m; negative: the gap.
    pub depth_m: f32,
    /// Unit vector from tissue to tool.
    pub normal: Vec3,
}

/// Depth and normal, from the signed distance of the sphere's centre to the solid cylinder; the
/// paper gives neither. Contact (`depth > 0`) agrees with Algorithm 1. For a centre inside the
/// cylinder, the distance is measured to the nearest face (lateral surface or end). So the depth is
/// continuous everywhere, and so is the force.
#[must_use]
pub fn touch(center_m: &Vec3, radius_m: f32, part: &Capsule) -> Touch {
    let Local {
        axis,
        radial,
        beyond_end_m,
        outside_m,
    } = local(center_m, part);
    let (distance_m, away) = if beyond_end_m > 0.0 && outside_m > 0.0 {
        let to_rim = axis * beyond_end_m + radial * outside_m;
        (math::norm(&to_rim), math::unit(&to_rim).unwrap_or(radial))
    } else if beyond_end_m > outside_m {
        (beyond_end_m, axis)
    } else {
        (outside_m, radial)
    };
    Touch {
        depth_m: radius_m - distance_m,
        normal: -away,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::vector;
    use crate::tool::Role;
    use proptest::prelude::*;

    /// Axis along x from −2 to 2, radius 1.
    const BAR: Capsule = Capsule {
        a_m: Vec3::new(-2.0, 0.0, 0.0),
        b_m: Vec3::new(2.0, 0.0, 0.0),
        radius_m: 1.0,
        role: Role::Shaft,
    };

    fn both(c: Vec3, r: f32) -> (bool, Touch) {
        (
            meets(&c, r, &BAR.a_m, &BAR.b_m, BAR.radius_m),
            touch(&c, r, &BAR),
        )
    }

    fn check(c: Vec3, r: f32, depth_m: f32, normal: Vec3) {
        let (meet, touch) = both(c, r);
        assert_eq!(meet, depth_m > 0.0, "{c}");
        assert!((touch.depth_m - depth_m).abs() < 1.0e-5, "{c} {touch:?}");
        assert!(
            math::norm(&(touch.normal - normal)) < 1.0e-5,
            "{c} {touch:?}"
        );
    }

    #[test]
    fn depth_and_normal_are_as_computed_by_hand_in_every_branch() {
        let y = Vec3::new(0.0, 1.0, 0.0);
        let x = Vec3::new(1.0, 0.0, 0.0);
        // Next to the lateral surface (x < h/2): d = 1.4, so depth 1 + 0.5 − 1.4.
        check(Vec3::new(1.0, 1.4, 0.0), 0.5, 0.1, -y);
        check(Vec3::new(1.0, -1.6, 0.0), 0.5, -0.1, y);
        // Beyond an end, over the disc (d < r0): x − h/2 = 0.3, and 0.6 at the other end.
        check(Vec3::new(2.3, 0.5, 0.0), 0.5, 0.2, -x);
        check(Vec3::new(-2.6, 0.5, 0.0), 0.5, -0.1, x);
        // Beyond the rim: 0.3 and 0.4 from it, so 0.5 away.
        check(
            Vec3::new(2.3, 1.4, 0.0),
            0.6,
            0.1,
            Vec3::new(-0.6, -0.8, 0.0),
        );
        check(
            Vec3::new(2.3, 1.4, 0.0),
            0.4,
            -0.1,
            Vec3::new(-0.6, -0.8, 0.0),
        );
        // Centre inside: the nearest face is the lateral surface, then the end.
        check(Vec3::new(0.0, 0.6, 0.0), 0.5, 0.9, -y);
        check(Vec3::new(1.9, 0.2, 0.0), 0.5, 0.6, -x);
    }

    #[test]
    fn a_centre_on_the_axis_and_a_disc_have_a_normal() {
        let (meet, on_axis) = both(Vec3::zeros(), 0.1);
        assert!(meet && (math::norm(&on_axis.normal) - 1.0).abs() < 1.0e-6);
        let disc = Capsule {
            b_m: BAR.a_m,
            ..BAR
        };
        let touch = touch(&Vec3::new(-2.0, 0.0, 0.5), 0.6, &disc);
        assert!((touch.depth_m - 0.1).abs() < 1.0e-6, "{touch:?}");
    }

    proptest! {
        /// `touch` finds contact exactly where Algorithm 1 does.
        #[test]
        fn touch_meets_where_the_paper_does(c in vector(5.0), a in vector(3.0), b in vector(3.0),
                                            r in 0.01f32..2.0, r0 in 0.01f32..1.5) {
            prop_assume!(math::norm(&(a - b)) > 0.01);
            let part = Capsule { a_m: a, b_m: b, radius_m: r0, role: Role::Tip };
            let touch = touch(&c, r, &part);
            prop_assume!(touch.depth_m.abs() > 1.0e-4); // rounding decides at the surface
            prop_assert_eq!(meets(&c, r, &a, &b, r0), touch.depth_m > 0.0);
        }

        /// Moving the sphere against the normal by the depth just ends the contact.
        #[test]
        fn moving_out_by_the_depth_ends_the_contact(c in vector(2.0), r in 0.5f32..2.0) {
            let first = touch(&c, r, &BAR);
            prop_assume!(first.depth_m > 0.0);
            let after = touch(&(c - first.normal * first.depth_m), r, &BAR);
            prop_assert!(after.depth_m.abs() < 1.0e-4, "{first:?} {after:?}");
        }

        /// Depth changes no faster than the sphere moves: no step in the force.
        #[test]
        fn depth_is_continuous(c in vector(4.0), step in vector(0.05)) {
            let change = touch(&c, 1.0, &BAR).depth_m - touch(&(c + step), 1.0, &BAR).depth_m;
            prop_assert!(change.abs() <= math::norm(&step) + 1.0e-5);
        }
    }
}
