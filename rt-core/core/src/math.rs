//! Vectors, rotations and poses of the whole core: nalgebra in `f32`.

/// A point, direction, force or velocity in three dimensions.
pub type Vec3 = nalgebra::Vector3<f32>;
/// A rotation.
pub type Quat = nalgebra::UnitQuaternion<f32>;
/// A rigid transform; `world_from_tool` takes tool coordinates to world coordinates.
pub type Pose = nalgebra::Isometry3<f32>;

/// Square root, correctly rounded, so that it has the same bits on every machine and in every
/// build. (`f32::sqrt` is not in `core`.)
#[must_use]
#[inline(always)]
#[allow(unsafe_code)] // one instruction that every x86-64 has
pub fn sqrt(x: f32) -> f32 {
    #[cfg(target_arch = "x86_64")]
    {
        use core::arch::x86_64::{_mm_cvtss_f32, _mm_set_ss, _mm_sqrt_ss};
        // SAFETY: the intrinsics need SSE, which is part of x86-64 itself.
        unsafe { _mm_cvtss_f32(_mm_sqrt_ss(_mm_set_ss(x))) }
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        nalgebra::ComplexField::sqrt(x)
    }
}

/// Length of `v`.
#[must_use]
#[inline]
pub fn norm(v: &Vec3) -> f32 {
    sqrt(v.norm_squared())
}

/// `v` scaled to length one, or `None` if `v` is not finite or too short to have a direction.
#[must_use]
#[inline]
pub fn unit(v: &Vec3) -> Option<Vec3> {
    let length = norm(v);
    (length > 1.0e-9 && length.is_finite()).then(|| v / length)
}

/// True if all three components are finite.
#[must_use]
#[inline]
pub fn is_finite(v: &Vec3) -> bool {
    v.x.is_finite() && v.y.is_finite() && v.z.is_finite()
}

/// True if `pose` is finite and a rigid transform (its quaternion is a rotation).
#[must_use]
pub fn is_rigid(pose: &Pose) -> bool {
    let q = pose.rotation.coords;
    let norm_squared = q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w;
    is_finite(&pose.translation.vector) && (norm_squared - 1.0).abs() < 1.0e-3
}

/// A unit vector perpendicular to `v`, which may have any length. It is always the same for the
/// same `v`.
#[must_use]
pub fn perpendicular(v: &Vec3) -> Vec3 {
    let a = if v.x.abs() <= v.y.abs() && v.x.abs() <= v.z.abs() {
        Vec3::new(1.0, 0.0, 0.0)
    } else if v.y.abs() <= v.z.abs() {
        Vec3::new(0.0, 1.0, 0.0)
    } else {
        Vec3::new(0.0, 0.0, 1.0)
    };
    unit(&v.cross(&a)).unwrap_or(a)
}

/// Unit vector `from`, rotated towards the unit vector `to` by at most `angle_max` radians (a small
/// angle).
#[must_use]
pub fn rotated_towards(from: &Vec3, to: &Vec3, angle_max: f32) -> Vec3 {
    let turn = to - from;
    if turn.norm_squared() <= angle_max * angle_max {
        return *to;
    }
    // Perpendicular to `from`. Opposite vectors turn to an arbitrary side.
    let direction = unit(&(turn - from * from.dot(&turn))).unwrap_or_else(|| perpendicular(from));
    unit(&(from + direction * angle_max)).unwrap_or(*from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sqrt_is_exact_and_nan_below_zero() {
        assert!((sqrt(2.25) - 1.5).abs() < f32::EPSILON);
        assert!(sqrt(-1.0).is_nan());
        assert!(unit(&Vec3::zeros()).is_none());
        assert!(unit(&Vec3::new(f32::NAN, 0.0, 1.0)).is_none());
    }

    #[test]
    fn perpendicular_vector_is_a_unit_vector() {
        for v in [
            Vec3::new(1.0, 0.0, 0.0),
            Vec3::new(-3.0, 2.0, 1.0),
            Vec3::new(0.0, 0.0, 9.0),
        ] {
            let n = perpendicular(&v);
            assert!(n.dot(&v).abs() < 1.0e-6, "{n}");
            assert!((norm(&n) - 1.0).abs() < 1.0e-6);
        }
    }

    #[test]
    fn rotation_reaches_the_target_in_bounded_steps() {
        for to in [Vec3::y(), -Vec3::x(), Vec3::new(0.6, 0.0, -0.8)] {
            let mut at = Vec3::x();
            for _ in 0..320 {
                let next = rotated_towards(&at, &to, 0.01);
                assert!(norm(&(next - at)) < 0.010_01 && (norm(&next) - 1.0).abs() < 1.0e-5);
                at = next;
            }
            assert!(norm(&(at - to)) < 1.0e-6, "{at}");
        }
    }
}
