//! Anchors of strands in the skins of the organs that their tissue joins.

use std::collections::HashMap;

use glam::Vec3;
use shared_mem::scene::{NO_CELL, OrganKind, SceneFile};

use super::super::hexahedron::{FACES, INWARDS, OUTWARDS};
use super::weave::Weave;
use crate::skinning::{RestVertex, pairs};

/// Largest distance from a cell's corner to the skin that anchors a fibre, m.
const ANCHORED_M: f32 = 0.006;

/// Points of the neighbouring skins at which fibres are anchored. A corner of a cell may have an
/// anchor on the skin inwards of it, and one on the skin outwards. A corner far from any skin has
/// none.
#[derive(Default)]
pub(in crate::render) struct Anchors {
    pub(super) places: Vec<RestVertex>,
    pub(super) of_corners: [HashMap<u16, u32>; 2],
}

impl Anchors {
    /// Anchors of the corners at which connective tissue ends.
    pub(in crate::render) fn of(
        scene: &SceneFile,
        corners: &[RestVertex],
        weaves: &[Weave],
    ) -> Self {
        let holds = [OrganKind::Gallbladder, OrganKind::Liver].map(|kind| kind as u32);
        let skins = scene.organs().iter().filter(|it| holds.contains(&it.kind));
        let vertices: Vec<_> = skins
            .flat_map(|it| {
                let [first, count] = it.vertices.map(|n| n as usize);
                scene.vertices().get(first..first + count).unwrap_or(&[])
            })
            .collect();
        let mut anchors = Self::default();
        let cells = scene.cells().iter().zip(weaves);
        for (cell, _) in cells.filter(|it| *it.1 == Weave::Dense) {
            for (side, way) in [INWARDS, OUTWARDS].into_iter().enumerate() {
                if cell.neighbours[way] != NO_CELL {
                    continue;
                }
                for corner in FACES[way].map(|k| cell.corners[k]) {
                    if anchors.of_corners[side].contains_key(&corner) {
                        continue;
                    }
                    let own = corners[usize::from(corner)];
                    let at = Vec3::from(own.position);
                    let off = |it: [f32; 3]| Vec3::from(it).distance_squared(at);
                    let nearest = vertices
                        .iter()
                        .min_by(|a, b| off(a.position_m).total_cmp(&off(b.position_m)));
                    let Some(skin) =
                        nearest.filter(|it| off(it.position_m) < ANCHORED_M * ANCHORED_M)
                    else {
                        continue;
                    };
                    // The anchor is the corner's projection onto the plane of the skin at its
                    // nearest vertex.
                    let normal = Vec3::from(skin.normal);
                    let across = normal * (at - Vec3::from(skin.position_m)).dot(normal);
                    anchors.places.push(RestVertex {
                        position: (at - across).to_array(),
                        spheres: pairs(skin.spheres),
                        weights: pairs(skin.weights),
                        ..own
                    });
                    let number = (corners.len() + anchors.places.len() - 1) as u32;
                    anchors.of_corners[side].insert(corner, number);
                }
            }
        }
        anchors
    }

    /// Anchors of two corners of a cell, in the direction `way`. `None` unless both have one.
    pub(super) fn across(&self, way: usize, corners: [u32; 2]) -> Option<[u32; 2]> {
        let of = &self.of_corners[usize::from(way == OUTWARDS)];
        let anchor = |corner: u32| of.get(&u16::try_from(corner).ok()?).copied();
        Some([anchor(corners[0])?, anchor(corners[1])?])
    }
}
