//! Geometry of an assessment, in `f64`.

use shared_mem::message::PoseMsg;

pub(crate) type Vec3 = [f64; 3];

pub(crate) fn wide(v: [f32; 3]) -> Vec3 {
    v.map(f64::from)
}

pub(crate) fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn norm(a: Vec3) -> f64 {
    dot(a, a).sqrt()
}

pub(crate) fn distance(a: Vec3, b: Vec3) -> f64 {
    norm(sub(a, b))
}

pub(crate) fn sum(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn scaled(a: Vec3, by: f64) -> Vec3 {
    a.map(|x| x * by)
}

pub(crate) fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

/// Direction of a vector; `None` if it has none.
pub(crate) fn unit(a: Vec3) -> Option<Vec3> {
    let length = norm(a);
    (length > 1e-12).then(|| scaled(a, 1.0 / length))
}

/// Point between two: `share` of the way from the first to the second.
pub(crate) fn blend(from: Vec3, to: Vec3, share: f64) -> Vec3 {
    [0, 1, 2].map(|i| from[i] + (to[i] - from[i]) * share)
}

/// Axis of a pose's frame in world coordinates: 0 x, 1 y, otherwise z.
pub(crate) fn axis(pose: &PoseMsg, which: usize) -> Vec3 {
    let [x, y, z, w] = pose.orientation.map(f64::from);
    match which {
        0 => [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y + z * w),
            2.0 * (x * z - y * w),
        ],
        1 => [
            2.0 * (x * y - z * w),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z + x * w),
        ],
        _ => [
            2.0 * (x * z + y * w),
            2.0 * (y * z - x * w),
            1.0 - 2.0 * (x * x + y * y),
        ],
    }
}

/// Camera pose of an endoscope whose view is inclined by `off_rad` to its shaft and turned by
/// `turned_rad` about it, rad (0: down).
pub(crate) fn looking_off(shaft: &PoseMsg, [off_rad, turned_rad]: [f64; 2]) -> PoseMsg {
    let [x, y, z, w] = shaft.orientation.map(f64::from);
    let (sin, cos) = (-0.5 * off_rad).sin_cos();
    // The axis of this rotation is perpendicular to the shaft.
    let [a, b] = [sin * turned_rad.cos(), sin * turned_rad.sin()];
    let orientation = [
        w * a + x * cos - z * b,
        w * b + y * cos + z * a,
        z * cos + x * b - y * a,
        w * cos - x * a - y * b,
    ];
    PoseMsg {
        orientation: orientation.map(|it| it as f32),
        ..*shaft
    }
}

/// Angle of a point off the line of sight (−z) of a camera, rad, and its distance, m.
pub(crate) fn off_sight(camera: &PoseMsg, place: Vec3) -> (f64, f64) {
    let to = sub(place, wide(camera.position_m));
    let ahead = -dot(to, axis(camera, 2));
    let [right, up] = [0, 1].map(|which| dot(to, axis(camera, which)));
    (right.hypot(up).atan2(ahead), norm(to))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angled_one_looks_down_and_where_it_is_turned_to() {
        let angle = 30f64.to_radians();
        let see = |turned: f64| looking_off(&PoseMsg::IDENTITY, [angle, turned.to_radians()]);
        let (sin, cos) = angle.sin_cos();
        for (turned, place) in [
            (0.0, [0.0, -sin, -cos]),
            (180.0, [0.0, sin, -cos]),
            (90.0, [sin, 0.0, -cos]),
            (-90.0, [-sin, 0.0, -cos]),
        ] {
            assert!(off_sight(&see(turned), place).0 < 1e-6, "{turned}");
        }
        // The view is relative to the shaft, whatever the shaft's direction.
        let half = 0.5f32.sqrt();
        let turned = PoseMsg {
            orientation: [0.0, half, 0.0, half],
            ..PoseMsg::IDENTITY
        };
        assert!(off_sight(&looking_off(&turned, [angle, 0.0]), [-cos, -sin, 0.0]).0 < 1e-6);
        let straight = looking_off(&turned, [0.0, 1.0]);
        assert!(off_sight(&straight, [-1.0, 0.0, 0.0]).0 < 1e-6);
    }

    #[test]
    fn a_camera_sees_along_minus_z() {
        let straight = PoseMsg::IDENTITY;
        assert!(off_sight(&straight, [0.0, 0.0, -1.0]).0.abs() < 1e-12);
        let (angle, far) = off_sight(&straight, [1.0, 0.0, -1.0]);
        assert!((angle - 45f64.to_radians()).abs() < 1e-12 && (far - 2f64.sqrt()).abs() < 1e-12);
        assert!(off_sight(&straight, [0.0, 0.0, 1.0]).0 > 3.0, "behind");
        // After a quarter turn about y the camera looks along −x.
        let half = 0.5f32.sqrt();
        let turned = PoseMsg {
            orientation: [0.0, half, 0.0, half],
            ..straight
        };
        assert!(off_sight(&turned, [-1.0, 0.0, 0.0]).0 < 1e-6);
        for which in 0..3 {
            assert!((norm(axis(&turned, which)) - 1.0).abs() < 1e-6);
        }
    }
}
