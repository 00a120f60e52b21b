//! The nearest point of a triangle.

use crate::Vec3;

/// The point of a triangle that is nearest to `p` (Ericson, Real-Time Collision Detection, 5.1.5).
pub(crate) fn closest_on_triangle(p: &Vec3, [a, b, c]: &[Vec3; 3]) -> Vec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return *a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
    if d3 >= 0.0 && d4 <= d3 {
        return *b;
    }
    let vc = d1 * d4 - d3 * d2;
    // An edge of length zero is skipped, because it would give 0 / 0.
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3 {
        return a + ab * (d1 / (d1 - d3));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
    if d6 >= 0.0 && d5 <= d6 {
        return *c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    let whole = (d4 - d3) + (d5 - d6);
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 && whole > 0.0 {
        return b + (c - b) * ((d4 - d3) / whole);
    }
    let sum = va + vb + vc;
    if sum <= 0.0 {
        return *a;
    }
    a + ab * (vb / sum) + ac * (vc / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An edge of length zero must not give 0 / 0: a sphere's radius would be NaN.
    #[test]
    fn a_triangle_without_area_has_a_nearest_point() {
        let [a, b] = [Vec3::zeros(), Vec3::x()];
        let p = Vec3::new(0.25, 1.0, 0.0);
        for corners in [[a, a, b], [a, b, a], [b, a, a], [b, b, a], [a, b, b]] {
            let found = closest_on_triangle(&p, &corners);
            assert!(
                (found - Vec3::x() * 0.25).norm() < 1e-12,
                "{corners:?} → {found}"
            );
        }
        assert_eq!(closest_on_triangle(&p, &[b, b, b]), b);
    }

    #[test]
    fn nearest_point_lies_on_face_edge_or_corner() {
        let t = [Vec3::zeros(), Vec3::x(), Vec3::y()];
        let cases = [
            ([0.25, 0.25, 3.0], [0.25, 0.25, 0.0]),
            ([0.5, -2.0, 0.0], [0.5, 0.0, 0.0]),
            ([1.0, 1.0, 0.0], [0.5, 0.5, 0.0]),
            ([-1.0, -1.0, 1.0], [0.0, 0.0, 0.0]),
            ([-1.0, 0.5, 0.0], [0.0, 0.5, 0.0]),
            ([3.0, 0.0, 1.0], [1.0, 0.0, 0.0]),
        ];
        for (p, expected) in cases {
            let found = closest_on_triangle(&Vec3::from(p), &t);
            assert!(
                (found - Vec3::from(expected)).norm() < 1e-12,
                "{p:?} → {found}"
            );
        }
    }
}
