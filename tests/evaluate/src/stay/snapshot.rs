//! Places of the spheres of a scene, and what has changed since they were at rest.

use glam::{Mat3, Vec3};
use shared_mem::message::{SphereState, StateFrame};
use shared_mem::scene::{AttachmentRecord, SceneFile, WORLD};

/// Places of all spheres of a scene.
pub(super) struct Snapshot<'a> {
    scene: &'a SceneFile,
    /// Organ of each sphere.
    organ: Vec<usize>,
    places_m: Vec<Vec3>,
    is_removed: Vec<bool>,
}

/// Something that is worse than the aim allows, by how much, and whose.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Worst {
    pub(super) value: f32,
    /// The organ, and for two organs the other one.
    pub(super) organs: [usize; 2],
}

impl Worst {
    fn add(&mut self, value: f32, organs: [usize; 2]) {
        if value > self.value {
            *self = Self { value, organs };
        }
    }
}

impl<'a> Snapshot<'a> {
    pub(super) fn new(scene: &'a SceneFile, state: &StateFrame) -> Self {
        let spheres = state.spheres().unwrap_or(&[]);
        let mut organ = vec![0; spheres.len()];
        for (number, record) in scene.organs().iter().enumerate() {
            let [first, count] = record.spheres.map(|x| x as usize);
            organ[first..first + count].fill(number);
        }
        Self {
            scene,
            organ,
            places_m: spheres.iter().map(|it| Vec3::from(it.center_m)).collect(),
            is_removed: spheres
                .iter()
                .map(|it| it.bits & SphereState::GONE != 0)
                .collect(),
        }
    }

    /// A value of a sphere, with its organ.
    pub(super) fn of_sphere(&self, (value, sphere): (f32, usize)) -> Worst {
        let organ = self.organ.get(sphere).copied().unwrap_or_default();
        Worst {
            value,
            organs: [organ; 2],
        }
    }

    /// Largest distance of a sphere from its place in `before`, m.
    pub(super) fn moved_m(&self, before: &Self) -> Worst {
        let mut worst = Worst::default();
        for (i, organ) in self.organ.iter().enumerate() {
            if !self.is_removed[i] {
                let way_m = self.places_m[i].distance(before.places_m[i]);
                worst.add(way_m, [*organ; 2]);
            }
        }
        worst
    }

    /// Largest growth of an attachment since `before`, m. An attachment that tore counts too.
    pub(super) fn loosened_m(&self, before: &Self) -> Worst {
        let mut worst = Worst::default();
        for it in self.scene.attachments() {
            if self.is_removed[it.a as usize] {
                continue;
            }
            let grown_m = self.length_m(it) - before.length_m(it);
            let other = if it.b == WORLD { it.a } else { it.b };
            let organs = [it.a, other].map(|sphere| self.organ[sphere as usize]);
            worst.add(grown_m, organs);
        }
        worst
    }

    fn length_m(&self, it: &AttachmentRecord) -> f32 {
        let end_m = match it.b {
            WORLD => Vec3::from(it.anchor_m),
            b => self.places_m[b as usize],
        };
        self.places_m[it.a as usize].distance(end_m)
    }

    /// Largest depth of a sphere in another organ, m. An overlap of two spheres counts as far as it
    /// has grown since `before`. A sphere whose centre has come into a tetrahedron lies at least as
    /// deep as the thinnest sphere at a corner is thick.
    pub(super) fn inside_m(&self, before: &Self) -> Worst {
        let mut worst = Worst::default();
        let count = self.places_m.len();
        let radius_m = |i: usize| self.scene.spheres()[i].radius_m;
        for a in 0..count {
            for b in a + 1..count {
                if self.are_apart(a, b) {
                    let both_m = radius_m(a) + radius_m(b);
                    let overlap_m =
                        |it: &Self| (both_m - it.places_m[a].distance(it.places_m[b])).max(0.0);
                    let grown_m = overlap_m(self) - overlap_m(before);
                    worst.add(grown_m, [self.organ[a], self.organ[b]]);
                }
            }
        }
        for tetra in self.scene.tetrahedra() {
            let corners = tetra.spheres.map(usize::from);
            let deep_m = corners.map(radius_m).into_iter().fold(f32::MAX, f32::min);
            let [was, is] =
                [before, self].map(|it| Tetrahedron::new(corners.map(|i| it.places_m[i])));
            for a in 0..count {
                let came = self.are_apart(a, corners[0])
                    && is.contains(self.places_m[a])
                    && !was.contains(before.places_m[a]);
                if came {
                    worst.add(deep_m, [self.organ[a], self.organ[corners[0]]]);
                }
            }
        }
        worst
    }

    /// True if the spheres belong to two organs and neither is removed.
    fn are_apart(&self, a: usize, b: usize) -> bool {
        self.organ[a] != self.organ[b] && !self.is_removed[a] && !self.is_removed[b]
    }
}

/// A tetrahedron of tissue.
struct Tetrahedron {
    corner_m: Vec3,
    /// Shares of the three edges from that corner, by place; `None` if it is flat.
    shares: Option<Mat3>,
}

impl Tetrahedron {
    fn new(corners_m: [Vec3; 4]) -> Self {
        let [a, b, c, d] = corners_m;
        let edges_m = Mat3::from_cols(b - a, c - a, d - a);
        let is_solid = edges_m.determinant().abs() > f32::MIN_POSITIVE;
        Self {
            corner_m: a,
            shares: is_solid.then(|| edges_m.inverse()),
        }
    }

    fn contains(&self, at_m: Vec3) -> bool {
        self.shares.is_some_and(|shares| {
            let share = shares * (at_m - self.corner_m);
            share.min_element() > 0.0 && share.element_sum() < 1.0
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tetrahedron_contains_its_middle_and_no_place_beyond_a_face() {
        let corners_m = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        let hull = Tetrahedron::new(corners_m);
        assert!(hull.contains(Vec3::splat(0.25)));
        assert!(!hull.contains(Vec3::splat(0.34)));
        assert!(!hull.contains(Vec3::new(-0.01, 0.2, 0.2)));
        let flat = Tetrahedron::new([Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X + Vec3::Y]);
        assert!(!flat.contains(Vec3::ZERO));
    }
}
