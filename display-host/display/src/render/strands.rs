//! Strands of connective tissue next to removed cells. They form a net of fibres along the sides of
//! the remaining cells. The tissue joins two structures, and the net spans from one to the other.
//! Films fill some forks of the net, and a few fibres span the gaps. Fat has fewer such strands.
//! The strands are anchored in skins and cells. They get thinner and straighter as their anchors
//! move apart, and vanish with their cells.

mod anchors;
mod course;
mod net;
mod weave;

use bytemuck::{Zeroable, cast_slice};
use glam::Vec3;
use shared_mem::scene::{CellRecord, OrganKind};

pub(super) use self::anchors::Anchors;
use self::course::{ACROSS, PieceShape, RINGS, SHEET, TUBE, draw_film};
use self::net::{End, FILMS, Net, PIECES};
pub(super) use self::weave::Weave;
use super::carried::{Buffers, carried};
use super::fibre::{SIDES, triangles};
use super::gpu::Gpu;
use crate::skinning::motion::Motion;
use crate::skinning::{RestVertex, SkinnedVertex};

/// Ambient light of fibres, which are exposed.
const FREE: f32 = 0.8;
/// Ambient light of films, which transmit more than they reflect.
const SHEER: f32 = 0.35;

/// The present fibres of a scene's tissue.
#[derive(Default)]
pub(super) struct Strands {
    anchors: Anchors,
    net: Net,
    /// Lengths of the pieces at rest, m.
    lengths_m: Vec<f32>,
    now: Vec<SkinnedVertex>,
    pub(super) buffers: Option<Buffers>,
}

impl Strands {
    /// Strands for a scene whose tissue has fibres. No strand has grown yet.
    pub(super) fn new(gpu: &Gpu, anchors: Anchors) -> Self {
        let corners = PIECES * TUBE + FILMS * 2 * SHEET;
        let indices = PIECES * (RINGS.len() - 1) * SIDES * 6 + FILMS * 2 * (ACROSS - 1) * 6;
        Self {
            anchors,
            buffers: Some(Buffers::new(gpu, "strands", corners, indices)),
            ..Self::default()
        }
    }

    /// Grows fibres next to removed cells. The `weaves` of the cells tell how many fibres their
    /// tissue has.
    pub(super) fn grow(
        &mut self,
        gpu: &Gpu,
        cells: &[CellRecord],
        corners: &[RestVertex],
        weaves: &[Weave],
        is_gone: impl Fn(u16) -> bool,
    ) {
        let Some(buffers) = &mut self.buffers else {
            return;
        };
        self.net = Net::of(cells, weaves, &self.anchors, is_gone);
        let anchors = &self.anchors.places;
        let vertex = |c: u32| match corners.get(c as usize) {
            Some(corner) => *corner,
            None => anchors[c as usize - corners.len()],
        };
        let at = |end: &End| end.on_side(|c| vertex(c).position.into());
        let pieces = &self.net.pieces;
        let rests: Vec<[Vec3; 2]> = pieces
            .iter()
            .map(|it| [at(&it.ends[0]), at(&it.ends[1])])
            .collect();
        self.lengths_m = rests.iter().map(|[a, b]| a.distance(*b)).collect();
        let mut rest: Vec<RestVertex> = Vec::new();
        let mut indices: Vec<u32> = Vec::new();
        let painted = |piece: usize, share: f32, ambient: f32| {
            let [a, b] = rests[piece];
            let corner = vertex(pieces[piece].ends[usize::from(share > 0.5)].corners[0]);
            RestVertex {
                position: a.lerp(b, share).to_array(),
                ambient,
                look: corner.look & !15 | OrganKind::ConnectiveTissue as u32,
                ..corner
            }
        };
        for piece in 0..pieces.len() {
            let first = rest.len() as u32;
            for share in RINGS {
                rest.extend([painted(piece, share, FREE); SIDES]);
            }
            indices.extend(triangles(first, RINGS.len()));
        }
        for film in &self.net.films {
            // A film has two sides. Only the side that faces the camera is drawn.
            for side in 0..2u32 {
                let first = rest.len() as u32;
                for is_edge in [false, true] {
                    for k in 0..ACROSS {
                        let across = k as f32 / (ACROSS - 1) as f32;
                        let nearer = film.pieces[usize::from(across > 0.5)];
                        rest.push(painted(nearer, film.height_at(across, is_edge), SHEER));
                    }
                }
                for k in 0..ACROSS as u32 - 1 {
                    let [a, b] = [first + k, first + k + 1];
                    let [c, d] = [a, b].map(|it| it + ACROSS as u32);
                    match side {
                        0 => indices.extend([a, b, d, a, d, c]),
                        _ => indices.extend([a, d, b, a, c, d]),
                    }
                }
            }
        }
        self.now = vec![SkinnedVertex::zeroed(); rest.len()];
        buffers.count = indices.len() as u32;
        gpu.queue.write_buffer(&buffers.rest, 0, cast_slice(&rest));
        gpu.queue
            .write_buffer(&buffers.indices, 0, cast_slice(&indices));
    }

    /// Moves the strands with the cells' corners and their anchors.
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
        let pieces = self.net.pieces.iter().zip(&self.lengths_m);
        let shapes: Vec<PieceShape> = pieces
            .map(|(piece, length_m)| piece.now(*length_m, place))
            .collect();
        let (tubes, sheets) = self.now.split_at_mut(shapes.len() * TUBE);
        for (shape, tube) in shapes.iter().zip(tubes.chunks_mut(TUBE)) {
            shape.draw(tube);
        }
        let films = self.net.films.iter();
        for (film, sheet) in films.zip(sheets.chunks_mut(2 * SHEET)) {
            let [first, second] = film.pieces.map(|it| shapes[it]);
            draw_film(film, &first, &second, sheet);
        }
        gpu.queue
            .write_buffer(&buffers.now, 0, cast_slice(&self.now));
    }
}
