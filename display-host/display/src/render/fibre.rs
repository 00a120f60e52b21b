//! Thin tubes of few sides: fibres of connective tissue, and threads. The fourth number of a
//! corner's position is the tube's negated radius. The shader needs the radius to widen tubes
//! thinner than a pixel. For a corner of skin, the fourth number is the displacement by a tool.

use glam::Vec3;

use crate::skinning::SkinnedVertex;

/// Number of corners of a cross-section, on a circle.
pub(super) const SIDES: usize = 3;
const SECTION: [[f32; 2]; SIDES] = [[1.0, 0.0], [-0.5, 0.866_025_4], [-0.5, -0.866_025_4]];

/// Writes the corners of a cross-section, which lies in the plane of two unit vectors.
pub(super) fn section(
    corners: &mut [SkinnedVertex],
    middle: Vec3,
    [across, up]: [Vec3; 2],
    radius_m: f32,
) {
    for (vertex, [x, y]) in corners.iter_mut().zip(SECTION) {
        let normal = across * x + up * y;
        vertex.position = (middle + normal * radius_m).extend(-radius_m).to_array();
        vertex.normal = normal.extend(0.0).to_array();
    }
}

/// Writes the corners of a tube along a path.
pub(super) fn tube(path: &[Vec3], radius_m: f32, corners: &mut [SkinnedVertex]) {
    let whole = path.first().zip(path.last()).map(|(a, b)| *b - *a);
    let across = whole.unwrap_or_default().normalize_or(Vec3::X);
    let across = across.any_orthonormal_vector();
    for (k, (middle, corners)) in path.iter().zip(corners.chunks_mut(SIDES)).enumerate() {
        let next = path.get(k + 1).or(path.last()).unwrap_or(middle);
        let along = (*next - path[k.saturating_sub(1)]).normalize_or(Vec3::X);
        let up = along.cross(across).normalize_or(Vec3::Y);
        section(corners, *middle, [up.cross(along), up], radius_m);
    }
}

/// Triangles of a tube with this many sections, whose first corner has index `first`.
pub(super) fn triangles(first: u32, sections: usize) -> impl Iterator<Item = u32> {
    let sides = SIDES as u32;
    (0..(sections as u32 - 1) * sides).flat_map(move |at| {
        let (ring, k) = (first + at / sides * sides, at % sides);
        let [a, b] = [ring + k, ring + (k + 1) % sides];
        let [c, d] = [a + sides, b + sides];
        [a, b, d, a, d, c]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable as _;

    #[test]
    fn a_tube_has_its_radius_all_along_and_faces_outwards() {
        let path = [Vec3::ZERO, Vec3::X, Vec3::new(1.5, 1.0, 0.0)];
        let mut corners = vec![SkinnedVertex::zeroed(); path.len() * SIDES];
        tube(&path, 0.1, &mut corners);
        let place = |i: u32| Vec3::from_slice(&corners[i as usize].position);
        for (i, corner) in corners.iter().enumerate() {
            let off = Vec3::from_slice(&corner.position) - path[i / SIDES];
            assert!((off.length() - 0.1).abs() < 1e-5 && (corner.position[3] + 0.1).abs() < 1e-6);
        }
        let indices: Vec<u32> = triangles(0, path.len()).collect();
        assert_eq!(indices.len(), 2 * SIDES * 6);
        for triangle in indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|k| place(triangle[k]));
            let normal = (b - a).cross(c - a);
            let out: Vec3 = triangle
                .iter()
                .map(|i| Vec3::from_slice(&corners[*i as usize].normal))
                .sum();
            assert!(normal.dot(out) > 0.0, "{triangle:?}");
        }
    }
}
