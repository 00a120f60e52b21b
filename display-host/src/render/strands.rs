//! Strands of connective tissue: fibres along the sides of its cells where the cells beside them are gone,
//! from what the tissue lies around to what it joins that to. They are anchored in the skins of both, stretch as
//! these part, and go with their cells.

use std::collections::HashMap;

use bytemuck::{Zeroable, cast_slice};
use glam::Vec3;
use shared_mem::scene::{CellRecord, NO_CELL, OrganKind, SceneFile};

use super::cells::{Buffers, FACES, carried};
use super::gpu::Gpu;
use crate::effects::chance;
use crate::skinning::motion::Motion;
use crate::skinning::{RestVertex, SkinnedVertex, pairs};

/// Fibres along a cell's side.
const FIBRES: u32 = 3;
/// Pieces of fibres at most; who has more shows no more.
const PIECES: usize = 4000;
/// Corners of a fibre's section.
const SIDES: usize = 3;
/// Radius of a fibre, m, and how much wider it is where it leaves tissue.
const THIN_M: f32 = 0.000_045;
const THICK_M: f32 = 0.000_09;
const ROOT: f32 = 2.4;
/// It stands off its cell's side by as much, m, and with its free end by more.
const OFF_M: f32 = 0.000_45;
const FREE_M: f32 = 0.001_1;
/// A fibre is anchored in skin within this of its cell, m.
const ANCHORED_M: f32 = 0.006;
/// And as far aside as this, of its cell's width.
const ASKEW: f32 = 1.2;
/// Inwards and outwards among a cell's neighbours.
const INWARDS: usize = 4;
const OUTWARDS: usize = 5;

/// A fibre's course along one cell.
#[derive(Debug, Clone, Copy)]
struct Piece {
    /// The cell's side that it runs along.
    side: [u32; 4],
    ends: [End; 2],
}

/// Between two corners of the side, and off it.
#[derive(Debug, Clone, Copy)]
struct End {
    corners: [u32; 2],
    share: f32,
    off_m: f32,
    radius_m: f32,
}

impl End {
    /// On the side, wherever its corners are.
    fn on_side(&self, place: impl Fn(u32) -> Vec3) -> Vec3 {
        place(self.corners[0]).lerp(place(self.corners[1]), self.share)
    }
}

/// Where fibres are anchored, inwards and outwards of the cells' corners: on skins, nowhere where none is near.
#[derive(Default)]
struct Anchors {
    places: Vec<RestVertex>,
    of_corners: [HashMap<u16, u32>; 2],
}

impl Anchors {
    /// Of the corners where connective tissue ends.
    fn of(scene: &SceneFile, corners: &[RestVertex], of_strands: &[bool]) -> Self {
        let holds = [OrganKind::Gallbladder, OrganKind::Liver].map(|kind| kind as u32);
        let skins = scene.organs().iter().filter(|it| holds.contains(&it.kind));
        let vertices: Vec<_> = skins
            .flat_map(|it| {
                let [first, count] = it.vertices.map(|n| n as usize);
                scene.vertices().get(first..first + count).unwrap_or(&[])
            })
            .collect();
        let mut anchors = Self::default();
        let cells = scene.cells().iter().zip(of_strands);
        for (cell, _) in cells.filter(|it| *it.1) {
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
                    // Straight across from the corner, where the skin's plane is there.
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

    /// Across from two corners of a cell.
    fn across(&self, way: usize, corners: [u32; 2]) -> Option<[u32; 2]> {
        let of = &self.of_corners[usize::from(way == OUTWARDS)];
        let anchor = |corner: u32| of.get(&u16::try_from(corner).ok()?).copied();
        Some([anchor(corners[0])?, anchor(corners[1])?])
    }
}

/// Fibres of a scene's connective tissue, as they are now.
#[derive(Default)]
pub(super) struct Strands {
    anchors: Anchors,
    pieces: Vec<Piece>,
    now: Vec<SkinnedVertex>,
    pub(super) buffers: Option<Buffers>,
}

impl Strands {
    /// Of a scene that may have some.
    pub(super) fn new(
        gpu: &Gpu,
        scene: &SceneFile,
        corners: &[RestVertex],
        of_strands: &[bool],
    ) -> Self {
        let buffers = Buffers::new(gpu, "strands", PIECES * 2 * SIDES, PIECES * SIDES * 6);
        Self {
            anchors: Anchors::of(scene, corners, of_strands),
            buffers: Some(buffers),
            ..Self::default()
        }
    }

    /// Where cells `of_strands` are still there beside some that are gone.
    pub(super) fn grow(
        &mut self,
        gpu: &Gpu,
        cells: &[CellRecord],
        corners: &[RestVertex],
        of_strands: &[bool],
        is_gone: impl Fn(u16) -> bool,
    ) {
        let Some(buffers) = &mut self.buffers else {
            return;
        };
        self.pieces = pieces(cells, of_strands, &self.anchors, is_gone);
        let mut rest = Vec::with_capacity(self.pieces.len() * 2 * SIDES);
        let mut indices: Vec<u32> = Vec::with_capacity(self.pieces.len() * SIDES * 6);
        for piece in &self.pieces {
            let first = rest.len() as u32;
            for end in &piece.ends {
                let anchors = &self.anchors.places;
                let vertex = |c: u32| match corners.get(c as usize) {
                    Some(corner) => corner,
                    None => &anchors[c as usize - corners.len()],
                };
                let corner = *vertex(end.corners[0]);
                let at = end.on_side(|c| vertex(c).position.into());
                rest.extend(
                    [RestVertex {
                        position: at.to_array(),
                        ..corner
                    }; SIDES],
                );
            }
            for k in 0..SIDES as u32 {
                let [a, b] = [first + k, first + (k + 1) % SIDES as u32];
                let [c, d] = [a, b].map(|it| it + SIDES as u32);
                indices.extend([a, b, d, a, d, c]);
            }
        }
        self.now = vec![SkinnedVertex::zeroed(); rest.len()];
        buffers.count = indices.len() as u32;
        gpu.queue.write_buffer(&buffers.rest, 0, cast_slice(&rest));
        gpu.queue
            .write_buffer(&buffers.indices, 0, cast_slice(&indices));
    }

    /// Moves them with the cells' corners, and with what they are anchored in.
    pub(super) fn follow(&mut self, gpu: &Gpu, places: &[Vec3], motions: &[Motion]) {
        let Some(buffers) = self.buffers.as_ref().filter(|it| it.count > 0) else {
            return;
        };
        let anchors: Vec<Vec3> = (self.anchors.places.iter())
            .map(|it| carried(it, motions))
            .collect();
        let place = |corner: u32| match places.get(corner as usize) {
            Some(place) => *place,
            None => anchors[corner as usize - places.len()],
        };
        for (piece, now) in self.pieces.iter().zip(self.now.chunks_mut(2 * SIDES)) {
            let [a, b, c, d] = piece.side.map(place);
            let off = (c - a).cross(d - b).normalize_or(Vec3::Y);
            let [from, to] = piece
                .ends
                .map(|end| (end.on_side(place) + off * end.off_m, end.radius_m));
            let along = (to.0 - from.0).normalize_or(off.any_orthonormal_vector());
            let across = off.cross(along).normalize_or(off.any_orthonormal_vector());
            let up = along.cross(across);
            for (ring, (middle, radius_m)) in now.chunks_mut(SIDES).zip([from, to]) {
                for (k, vertex) in ring.iter_mut().enumerate() {
                    let turn = k as f32 / SIDES as f32 * core::f32::consts::TAU;
                    let normal = across * turn.cos() + up * turn.sin();
                    vertex.position = (middle + normal * radius_m).extend(0.0).to_array();
                    vertex.normal = normal.extend(0.0).to_array();
                }
            }
        }
        gpu.queue
            .write_buffer(&buffers.now, 0, cast_slice(&self.now));
    }
}

fn pieces(
    cells: &[CellRecord],
    of_strands: &[bool],
    anchors: &Anchors,
    is_gone: impl Fn(u16) -> bool,
) -> Vec<Piece> {
    let mut found = Vec::new();
    let stands = |cell: u16| cell != NO_CELL && !is_gone(cell);
    for (i, cell) in cells.iter().enumerate() {
        if is_gone(i as u16) || of_strands.get(i) != Some(&true) {
            continue;
        }
        for (side, (face, next)) in FACES.iter().zip(cell.neighbours).take(INWARDS).enumerate() {
            if !is_gone(next) {
                continue;
            }
            // Going inwards keeps the side; its column has one number.
            let root = foot(cells, i);
            let inner: Vec<usize> = face.iter().copied().filter(|k| k & 4 == 0).collect();
            let [a, b] = [inner[0], inner[1]];
            let goes_on = |way: usize| {
                let beyond = cell.neighbours[way];
                let beside = cells.get(usize::from(beyond));
                stands(beyond) && beside.is_some_and(|it| is_gone(it.neighbours[side]))
            };
            for fibre in 0..FIBRES {
                let own = chance((root as u32 * 4 + side as u32) * FIBRES + fibre) * 0.5 + 0.5;
                let end = |way: usize, level: u32, corners: [usize; 2]| {
                    let any =
                        chance(root as u32 * 97 + side as u32 * 31 + fibre * 7 + level * 1009);
                    let beyond = cell.neighbours[way];
                    let corners = corners.map(|k| u32::from(cell.corners[k]));
                    let is_anchored = beyond == NO_CELL && anchors.across(way, corners).is_some();
                    // It goes on, ends where its next cell is gone, or leaves tissue.
                    let (off_m, wide) = match (goes_on(way) || is_anchored, is_gone(beyond)) {
                        (true, _) => (OFF_M * (0.3 + 0.7 * (any.x * 0.5 + 0.5)), 1.0),
                        (false, true) => (FREE_M * (any.y * 0.5 + 0.5), 0.3),
                        (false, false) => (0.0, ROOT),
                    };
                    End {
                        corners,
                        share: 0.06 + 0.88 * own.x,
                        off_m,
                        radius_m: wide * (THIN_M + (THICK_M - THIN_M) * own.y * own.y),
                    }
                };
                let level = u32::from(cell.layer);
                let piece = Piece {
                    side: face.map(|k| u32::from(cell.corners[k])),
                    ends: [
                        end(INWARDS, level, [a, b]),
                        end(OUTWARDS, level + 1, [a | 4, b | 4]),
                    ],
                };
                let anchored = [INWARDS, OUTWARDS].into_iter().zip(piece.ends);
                let anchored = anchored.filter(|(way, _)| cell.neighbours[*way] == NO_CELL);
                let anchored = anchored.filter_map(|(way, end)| {
                    // Not quite straight across.
                    let root = End {
                        corners: anchors.across(way, end.corners)?,
                        share: end.share + ASKEW * (own.z - 0.5),
                        off_m: 0.0,
                        radius_m: ROOT * end.radius_m,
                    };
                    let ends = if way == INWARDS {
                        [root, end]
                    } else {
                        [end, root]
                    };
                    Some(Piece { ends, ..piece })
                });
                for piece in core::iter::once(piece).chain(anchored) {
                    if found.len() < PIECES {
                        found.push(piece);
                    }
                }
            }
        }
    }
    found
}

/// The innermost cell of a cell's column, gone or not.
fn foot(cells: &[CellRecord], mut cell: usize) -> usize {
    // Layers are numbered by a byte: a loop ends.
    for _ in 0..=u8::MAX {
        match cells.get(cell).map(|it| it.neighbours[INWARDS]) {
            Some(inner) if inner != NO_CELL => cell = usize::from(inner),
            _ => break,
        }
    }
    cell
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two columns of two cells beside each other, along the course.
    fn columns() -> Vec<CellRecord> {
        let none = NO_CELL;
        let neighbours = [
            [none, 1, none, none, none, 2],
            [0, none, none, none, none, 3],
            [none, 3, none, none, 0, none],
            [2, none, none, none, 1, none],
        ];
        let cell = |(i, neighbours): (u16, [u16; 6])| {
            let (column, layer) = (i % 2, i / 2);
            let corner = |k: u16| (layer + (k >> 2)) * 6 + (k >> 1 & 1) * 3 + column + (k & 1);
            CellRecord {
                corners: core::array::from_fn(|k| corner(k as u16)),
                neighbours,
                layer: layer as u8,
                ..CellRecord::zeroed()
            }
        };
        (0..).zip(neighbours).map(cell).collect()
    }

    #[test]
    fn fibres_stand_where_a_cell_beside_is_gone_and_go_with_their_own() {
        let cells = columns();
        let none = Anchors::default();
        let grown = |gone: &[u16]| pieces(&cells, &[true; 4], &none, |cell| gone.contains(&cell));
        assert!(grown(&[]).is_empty());
        let one = grown(&[1]);
        assert_eq!(one.len(), FIBRES as usize);
        // Towards the one that is gone, from the inner edge of the cell to its outer.
        let [inner, outer] = one[0].ends;
        assert_eq!((inner.corners, outer.corners), ([1, 4], [7, 10]));
        // Rooted in what is there on both ends.
        assert!(inner.off_m <= 0.0 && outer.off_m <= 0.0);
        // The whole column beside: fibres go on from cell to cell.
        let both = grown(&[1, 3]);
        assert_eq!(both.len(), 2 * FIBRES as usize);
        let (lower, upper) = (both[0].ends[1], both[FIBRES as usize].ends[0]);
        assert_eq!(lower.corners, upper.corners);
        assert!(lower.off_m > 0.0 && (lower.off_m - upper.off_m).abs() < 1e-9);
        assert!((lower.share - upper.share).abs() < 1e-9);
        assert!(grown(&[0, 1, 2, 3]).is_empty());
        assert!(pieces(&cells, &[false; 4], &none, |cell| cell == 1).is_empty());
        // Anchored inwards: as many pieces more, from the anchor to where the fibre begins.
        let anchors = Anchors {
            places: Vec::new(),
            of_corners: [HashMap::from([(1, 18), (4, 19)]), HashMap::new()],
        };
        let held = pieces(&cells, &[true; 4], &anchors, |cell| cell == 1);
        assert_eq!(held.len(), 2 * FIBRES as usize);
        assert_eq!(held[1].ends[0].corners, [18, 19]);
        assert_eq!(held[1].ends[1].corners, held[0].ends[0].corners);
    }
}
