//! Strategies of the property tests, in `src` and in `tests`.

use nalgebra::Vector3;
use proptest::prelude::*;

/// A vector whose components are within `reach` of zero.
pub(crate) fn vector(reach: f32) -> impl Strategy<Value = Vector3<f32>> {
    (-reach..reach, -reach..reach, -reach..reach).prop_map(|(x, y, z)| Vector3::new(x, y, z))
}
