//! Vectors in double precision.

use nalgebra::Vector3;

pub(crate) type Vec3 = Vector3<f64>;

/// A message's vector in double precision.
pub(crate) fn wide(v: [f32; 3]) -> Vec3 {
    Vec3::from(v.map(f64::from))
}
