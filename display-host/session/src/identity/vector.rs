//! Vectors in single precision, as scenes and frames have them.

pub(super) type Vec3 = [f32; 3];

pub(super) fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [0, 1, 2].map(|i| a[i] - b[i])
}

pub(super) fn dot(a: Vec3, b: Vec3) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn norm(a: Vec3) -> f32 {
    dot(a, a).sqrt()
}

pub(super) fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Middle of some places; the origin for none.
pub(super) fn mean(places: &[Vec3]) -> Vec3 {
    let count = places.len().max(1) as f32;
    [0, 1, 2].map(|i| places.iter().map(|it| it[i]).sum::<f32>() / count)
}
