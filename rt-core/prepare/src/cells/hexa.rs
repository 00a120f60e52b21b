//! One hexahedron. A corner has a number from 0 to 7. Bit `k` of the number is set if the corner
//! lies on the far side along direction `k`.

use crate::Vec3;

/// Corners of the faces, anticlockwise seen from outside: for bits 0, 1 and 2 in turn, the face
/// where the bit is 0, then the face where it is 1.
pub(super) const FACES: [[usize; 4]; 6] = [
    [0, 4, 6, 2],
    [1, 3, 7, 5],
    [0, 1, 5, 4],
    [2, 6, 7, 3],
    [0, 2, 3, 1],
    [4, 5, 7, 6],
];

/// The face opposite to this face.
pub(super) const fn opposite(face: usize) -> usize {
    face ^ 1
}

/// The point with these trilinear coordinates (shares from 0 to 1) along the directions of bits 0,
/// 1 and 2.
pub(super) fn at(p: &[Vec3; 8], [u, v, w]: [f64; 3]) -> Vec3 {
    let mut sum = Vec3::zeros();
    for (i, corner) in p.iter().enumerate() {
        let share = |bit: usize, x: f64| if i >> bit & 1 == 1 { x } else { 1.0 - x };
        sum += corner * (share(0, u) * share(1, v) * share(2, w));
    }
    sum
}

/// Determinant of the derivative of [`at`] with respect to the three shares.
fn jacobian(p: &[Vec3; 8], [u, v, w]: [f64; 3]) -> f64 {
    let mut ways = [Vec3::zeros(); 3];
    for (i, corner) in p.iter().enumerate() {
        let share = |bit: usize, x: f64| if i >> bit & 1 == 1 { x } else { 1.0 - x };
        let sign = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let [a, b, c] = [share(0, u), share(1, v), share(2, w)];
        ways[0] += corner * (sign(0) * b * c);
        ways[1] += corner * (sign(1) * a * c);
        ways[2] += corner * (sign(2) * a * b);
    }
    ways[0].dot(&ways[1].cross(&ways[2]))
}

/// Volume, m³, of a cell with bilinear faces.
pub(super) fn volume_m3(p: &[Vec3; 8]) -> f64 {
    let low = 0.5 - (1.0f64 / 12.0).sqrt();
    let places = [low, 1.0 - low];
    let mut sum = 0.0;
    for u in places {
        for v in places {
            for w in places {
                sum += jacobian(p, [u, v, w]) / 8.0;
            }
        }
    }
    sum
}

/// For each corner, the triple product of its three edges and the product of their lengths.
pub(super) fn corners(p: &[Vec3; 8]) -> [(f64, f64); 8] {
    std::array::from_fn(|i| {
        let edge = |bit: usize| {
            let way = p[i | 1 << bit] - p[i & !(1 << bit)];
            (way, way.norm())
        };
        let [(a, la), (b, lb), (c, lc)] = [edge(0), edge(1), edge(2)];
        (a.dot(&b.cross(&c)), la * lb * lc)
    })
}

/// Shape of the worst corner, the ratio of the two products: 1 in a box, 0 if flat, negative if
/// inside out.
pub(super) fn shape(p: &[Vec3; 8]) -> f64 {
    let share = |(product, lengths): (f64, f64)| product / lengths.max(f64::MIN_POSITIVE);
    corners(p).into_iter().map(share).fold(1.0, f64::min)
}

/// Mean length of the edges along each of the three directions, m.
pub(super) fn extents_m(p: &[Vec3; 8]) -> [f64; 3] {
    std::array::from_fn(|bit| {
        let pairs = (0..8).filter(|i| i >> bit & 1 == 0);
        pairs.map(|i| (p[i | 1 << bit] - p[i]).norm()).sum::<f64>() / 4.0
    })
}

/// Smallest and largest coordinates of the cell.
pub(super) fn bounds(p: &[Vec3; 8]) -> [Vec3; 2] {
    let all = p.iter().skip(1);
    all.fold([p[0]; 2], |[low, high], q| [low.inf(q), high.sup(q)])
}

/// True if the point lies inside the cell. Newton's method finds the point's trilinear coordinates.
pub(super) fn holds(p: &[Vec3; 8], point: &Vec3) -> bool {
    let mut share = Vec3::repeat(0.5);
    let step = 1e-4;
    for _ in 0..8 {
        let here = at(p, share.into());
        let way = |k: usize| {
            let mut ahead = share;
            ahead[k] += step;
            (at(p, ahead.into()) - here) / step
        };
        let ways = nalgebra::Matrix3::from_columns(&[way(0), way(1), way(2)]);
        let Some(inverse) = ways.try_inverse() else {
            return false;
        };
        share += inverse * (point - here);
        if share.amax() > 5.0 {
            return false;
        }
    }
    share.iter().all(|x| (-1e-3..=1.001).contains(x))
}
