//! Converts between the library's axes and ours.
//!
//! In the library x points to the user, y to the right and z up (CHAI3D's documentation, chapter on
//! haptic devices; CHAI3D's driver passes the library's numbers on unchanged). In Calot x points to
//! the right, y up and z to the user. Both are right-handed, and each axis of one is an axis of the
//! other.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use rt_core::math::{Quat, Vec3};

/// Largest deviation of a rotation matrix `R` from an orthonormal one: the norm of `R Rᵀ − 1`.
const SKEW_MAX: f64 = 0.05;

/// A vector of the library in our axes: a position, velocity, force or torque.
pub(super) fn ours([x, y, z]: [f64; 3]) -> Vec3 {
    Vec3::new(y as f32, z as f32, x as f32)
}

/// One of our vectors in the library's axes.
pub(super) fn theirs(vector: &Vec3) -> [f64; 3] {
    [vector.z, vector.x, vector.y].map(f64::from)
}

/// Rotation of the handle from a matrix of the library, row by row. `None` when it is no rotation.
/// The handle's own axes are exchanged in the same way, so the library's identity is ours.
pub(super) fn rotation(rows: &[f64; 9]) -> Option<Quat> {
    let [xx, xy, xz, yx, yy, yz, zx, zy, zz] = *rows;
    let matrix = Matrix3::new(yy, yz, yx, zy, zz, zx, xy, xz, xx);
    let off = (matrix * matrix.transpose() - Matrix3::identity()).norm();
    // The comparison is written so that a matrix with NaN is refused too.
    if !(off <= SKEW_MAX && matrix.determinant() > 0.0) {
        return None;
    }
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
    Some(q.cast())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn directions_of_the_library_are_converted_and_back() {
        assert_eq!(ours([0.0, 1.0, 0.0]), Vec3::x(), "right");
        assert_eq!(ours([0.0, 0.0, 1.0]), Vec3::y(), "up");
        assert_eq!(ours([1.0, 0.0, 0.0]), Vec3::z(), "to the user");
        let back = theirs(&ours([1.0, 2.0, 3.0]));
        assert!((Vec3::from(back.map(|x| x as f32)) - Vec3::new(1.0, 2.0, 3.0)).norm() < 1e-6);
    }

    #[test]
    fn a_matrix_that_is_no_rotation_is_refused() {
        assert!(rotation(&[f64::NAN; 9]).is_none());
        assert!(rotation(&[0.0; 9]).is_none());
        let mirror = [-1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        assert!(rotation(&mirror).is_none());
    }

    proptest! {
        /// Rotating and converting a vector gives the same result in either order.
        #[test]
        fn rotating_and_converting_commute(
            turn in [-3.0f64..3.0, -3.0..3.0, -3.0..3.0],
            point in [-1.0f64..1.0, -1.0..1.0, -1.0..1.0],
        ) {
            let theirs = Rotation3::from_scaled_axis(nalgebra::Vector3::from(turn));
            let rows: Vec<f64> = theirs.matrix().transpose().iter().copied().collect();
            let mine = rotation(&rows.try_into().unwrap()).unwrap();
            let turned = theirs * nalgebra::Vector3::from(point);
            prop_assert!((mine * ours(point) - ours(turned.into())).norm() < 1e-5);
        }
    }
}
