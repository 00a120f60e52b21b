//! The algebra that the whole core uses: nalgebra in `f32`.

/// A point, direction, force or velocity in three dimensions.
pub type Vec3 = nalgebra::Vector3<f32>;
/// A rotation.
pub type Quat = nalgebra::UnitQuaternion<f32>;
/// A rigid transform; `world_from_tool` takes tool coordinates to world coordinates.
pub type Pose = nalgebra::Isometry3<f32>;
