//! Drawing of dissected layered tissue: the faces of its cells replace the organ's skin.
//!
//! An untreated organ shows its fine skin. A cell is worked if it is removed, warm or next to a
//! removed cell. No skin is drawn over worked cells. The worked cells that remain show their open
//! faces instead; an open face borders on nothing or on a removed cell. Their neighbours show open
//! faces too, so that no seam opens at the skin's edge. Tissue is coloured by its position at rest,
//! so that skin and faces look alike. The corners follow the spheres and are smoothed over the
//! visible faces, which would otherwise look like bricks.

use bytemuck::{Zeroable, cast_slice};
use glam::Vec3;
use shared_mem::message::StateFrame;
use shared_mem::scene::{CellRecord, NO_CELL, OrganKind, SceneFile, VertexRecord};

use super::carried::{Buffers, carried};
use super::gpu::Gpu;
use super::hexahedron::FACES;
use super::look::COOKED;
use super::strands::{Anchors, Strands, Weave};
use crate::skinning::motion::Motion;
use crate::skinning::{RestVertex, SkinnedVertex, pairs};

/// Heat, from 0 to 254, from which a cell is warm.
const WARM: u8 = 12;
/// Number of rounds in which the corners are smoothed.
const ROUNDS: usize = 2;
/// Share of the way to the mean of its neighbours that a corner goes in one round.
const SMOOTHING: f32 = 0.5;
/// Degree of cooking, from 0 to 1, of tissue next to a removed cell.
const BESIDE_GONE: f32 = 0.35;

/// The drawn cells of a scene.
pub(super) struct Cells {
    cells: Vec<CellRecord>,
    /// Corners. Their ambient light is low, because a gap is dark.
    corners: Vec<RestVertex>,
    /// The states of the cells that are drawn at present.
    states: Vec<u8>,
    /// Triangles of the skin over cells: the index of each triangle, and the cell under it.
    over: Vec<(u32, u16)>,
    /// For each triangle of the skin: true if it is hidden over a worked cell. The list may be
    /// shorter than the skin, or empty. The remaining triangles are not hidden.
    pub(super) is_hidden: Vec<bool>,
    /// The original triangles of the skin.
    triangles: Vec<[u32; 3]>,
    /// Corners of the visible faces.
    faces: Vec<[u32; 4]>,
    /// Corners that smoothing moves: those not at an edge of the skin.
    is_loose: Vec<bool>,
    now: Vec<SkinnedVertex>,
    pub(super) buffers: Option<Buffers>,
    /// Fibre content of each cell's tissue.
    weaves: Vec<Weave>,
    pub(super) strands: Strands,
}

impl Cells {
    /// The cells of a scene with these skin triangles.
    pub(super) fn new(gpu: &Gpu, scene: &SceneFile, triangles: &[[u32; 3]]) -> Self {
        let cells = scene.cells().to_vec();
        let kind_of = |sphere: u16| {
            let own = |o: &&shared_mem::scene::OrganRecord| {
                u32::from(sphere) < o.spheres[0] + o.spheres[1]
            };
            scene.organs().iter().find(own).map_or(0, |o| o.kind)
        };
        let corner = |v: &VertexRecord| RestVertex {
            position: v.position_m,
            look: kind_of(v.spheres[0]) | COOKED << 4,
            normal: v.normal,
            ambient: 0.6,
            spheres: pairs(v.spheres),
            weights: pairs(v.weights),
        };
        let corners: Vec<RestVertex> = scene.cell_corners().iter().map(corner).collect();
        let count = corners.len();
        let weave = |cell: &CellRecord| match OrganKind::from_u32(kind_of(cell.spheres[0])) {
            Some(OrganKind::ConnectiveTissue) => Weave::Dense,
            Some(OrganKind::Fat) => Weave::Loose,
            _ => Weave::Plain,
        };
        let weaves: Vec<Weave> = cells.iter().map(weave).collect();
        let mut made = Self {
            states: vec![0; cells.len()],
            over: over(scene, &cells, triangles),
            triangles: triangles.to_vec(),
            is_hidden: Vec::new(),
            faces: Vec::new(),
            is_loose: vec![false; count],
            now: vec![SkinnedVertex::zeroed(); count],
            buffers: None,
            weaves,
            strands: Strands::default(),
            corners,
            cells,
        };
        if !made.cells.is_empty() {
            // A face has two triangles, and a cell has six faces.
            let indices = made.cells.len() * 6 * 6;
            made.buffers = Some(Buffers::new(gpu, "cells", count, indices));
        }
        if made.weaves.iter().any(|it| *it != Weave::Plain) {
            let anchors = Anchors::of(scene, &made.corners, &made.weaves);
            made.strands = Strands::new(gpu, anchors);
        }
        made
    }

    pub(super) fn len(&self) -> usize {
        self.cells.len()
    }

    /// Takes the states of the cells ([`StateFrame::cells`]); `skin` is the index buffer of the
    /// skin.
    pub(super) fn set(&mut self, gpu: &Gpu, states: &[u8], skin: &wgpu::Buffer) {
        if states.len() != self.cells.len() || states == self.states {
            return;
        }
        self.states.copy_from_slice(states);
        let shows = self.showing();
        self.collect_faces(&shows);
        self.colour();
        self.hide_skin(gpu, skin);
        let mut indices: Vec<u32> = Vec::with_capacity(self.faces.len() * 6);
        for [a, b, c, d] in &self.faces {
            indices.extend([a, b, c, a, c, d]);
        }
        if let Some(buffers) = &mut self.buffers {
            buffers.count = indices.len() as u32;
            let rest = cast_slice(&self.corners);
            gpu.queue.write_buffer(&buffers.rest, 0, rest);
            gpu.queue
                .write_buffer(&buffers.indices, 0, cast_slice(&indices));
        }
        let states = &self.states;
        let is_gone = |cell: u16| states.get(usize::from(cell)) == Some(&StateFrame::GONE);
        self.strands
            .grow(gpu, &self.cells, &self.corners, &self.weaves, is_gone);
    }

    fn is_gone(&self, cell: u16) -> bool {
        self.states.get(usize::from(cell)) == Some(&StateFrame::GONE)
    }

    /// True if a cell is worked: it is warm, or it or a neighbour is removed.
    fn is_worked(&self, cell: usize) -> bool {
        let gone = |n: &u16| self.is_gone(*n);
        self.states[cell] >= WARM || self.cells[cell].neighbours.iter().any(gone)
    }

    /// For each cell, true if its open faces are visible.
    fn showing(&self) -> Vec<bool> {
        let worked: Vec<bool> = (0..self.cells.len()).map(|i| self.is_worked(i)).collect();
        let beside = |cell: &CellRecord| {
            let is_worked = |n: &u16| worked.get(usize::from(*n)) == Some(&true);
            cell.neighbours.iter().any(is_worked)
        };
        let cells = self.cells.iter().zip(&worked).zip(&self.states);
        cells
            .map(|((cell, worked), state)| *state != StateFrame::GONE && (*worked || beside(cell)))
            .collect()
    }

    fn collect_faces(&mut self, shows: &[bool]) {
        self.faces.clear();
        self.is_loose.fill(true);
        for (i, cell) in self.cells.iter().enumerate() {
            for (face, next) in FACES.iter().zip(cell.neighbours) {
                let corners = face.map(|k| u32::from(cell.corners[k]));
                if next == NO_CELL && !self.is_worked(i) {
                    // The edge of the skin lies on this face.
                    for c in corners {
                        self.is_loose[c as usize] = false;
                    }
                }
                if shows[i] && (next == NO_CELL || self.is_gone(next)) {
                    self.faces.push(corners);
                }
            }
        }
    }

    /// Sets how cooked each corner looks, by the hottest cell around it.
    fn colour(&mut self) {
        let mut cooked = vec![0.0f32; self.corners.len()];
        for (cell, state) in self.cells.iter().zip(&self.states) {
            let heat = match *state {
                StateFrame::GONE => BESIDE_GONE,
                state => f32::from(state) / f32::from(StateFrame::GONE),
            };
            for corner in cell.corners {
                let at = &mut cooked[usize::from(corner)];
                *at = at.max(heat);
            }
        }
        for (corner, cooked) in self.corners.iter_mut().zip(cooked) {
            let share = (cooked.sqrt() * 65_535.0) as u32;
            corner.look = corner.look & 0xffff | share << 16;
        }
    }

    /// Hides the skin over worked cells.
    fn hide_skin(&mut self, gpu: &Gpu, skin: &wgpu::Buffer) {
        let Some(&(first, _)) = self.over.first() else {
            return;
        };
        let last = self.over.last().map_or(first, |(triangle, _)| *triangle);
        let range = first as usize..=last as usize;
        let mut shown = self.triangles[range].to_vec();
        let mut is_hidden = vec![false; last as usize + 1];
        for (triangle, cell) in &self.over {
            if self.is_worked(usize::from(*cell)) {
                is_hidden[*triangle as usize] = true;
                // A triangle without area is not drawn.
                let corners = &mut shown[(triangle - first) as usize];
                *corners = [corners[0]; 3];
            }
        }
        let offset = u64::from(first) * 12;
        gpu.queue
            .write_buffer(skin, offset, cast_slice(shown.as_flattened()));
        self.is_hidden = is_hidden;
    }

    /// Moves the corners with the spheres.
    pub(super) fn follow(&mut self, gpu: &Gpu, motions: &[Motion]) {
        let Some(buffers) = self.buffers.as_ref().filter(|it| it.count > 0) else {
            return;
        };
        let mut shows = vec![false; self.corners.len()];
        for corner in self.faces.as_flattened() {
            shows[*corner as usize] = true;
        }
        let mut places = vec![Vec3::ZERO; self.corners.len()];
        for ((place, corner), _) in places
            .iter_mut()
            .zip(&self.corners)
            .zip(&shows)
            .filter(|it| *it.1)
        {
            *place = carried(corner, motions);
        }
        self.even_out(&mut places);
        self.strands.follow(gpu, &places, motions);
        let mut normals = vec![Vec3::ZERO; self.corners.len()];
        for face in &self.faces {
            let [a, b, c, d] = face.map(|i| places[i as usize]);
            let normal = (c - a).cross(d - b);
            for i in face {
                normals[*i as usize] += normal;
            }
        }
        for ((now, place), normal) in self.now.iter_mut().zip(&places).zip(&normals) {
            now.position = place.extend(0.0).to_array();
            now.normal = normal.normalize_or(Vec3::Y).extend(0.0).to_array();
        }
        gpu.queue
            .write_buffer(&buffers.now, 0, cast_slice(&self.now));
    }

    /// Moves each corner that is not at the skin's edge towards the mean of its neighbours.
    fn even_out(&self, places: &mut [Vec3]) {
        for _ in 0..ROUNDS {
            let mut sums = vec![(Vec3::ZERO, 0.0f32); places.len()];
            for face in &self.faces {
                for k in 0..4 {
                    let [own, next] = [face[k], face[(k + 1) % 4]].map(|i| i as usize);
                    for (a, b) in [(own, next), (next, own)] {
                        sums[a].0 += places[b];
                        sums[a].1 += 1.0;
                    }
                }
            }
            for ((place, (sum, count)), loose) in places.iter_mut().zip(sums).zip(&self.is_loose) {
                if *loose && count > 0.0 {
                    *place = place.lerp(sum / count, SMOOTHING);
                }
            }
        }
    }
}

/// The nearest surface cell of each skin triangle of the organs that have cells.
fn over(scene: &SceneFile, cells: &[CellRecord], triangles: &[[u32; 3]]) -> Vec<(u32, u16)> {
    let corners = scene.cell_corners();
    let mut all = Vec::new();
    for organ in scene.organs() {
        let own = |sphere: u16| {
            let first = organ.spheres[0];
            (first..first + organ.spheres[1]).contains(&u32::from(sphere))
        };
        let mut faces = Vec::new();
        for (i, cell) in (0u16..).zip(cells).filter(|(_, cell)| own(cell.spheres[0])) {
            for (face, next) in FACES.iter().zip(cell.neighbours) {
                if next == NO_CELL {
                    let at =
                        |k: usize| Vec3::from(corners[usize::from(cell.corners[k])].position_m);
                    faces.push((face.iter().map(|k| at(*k)).sum::<Vec3>() / 4.0, i));
                }
            }
        }
        let [first, count] = organ.triangles;
        for number in first..first + count {
            let Some(triangle) = triangles.get(number as usize) else {
                break;
            };
            let place = |v: u32| {
                let vertex = scene.vertices().get(v as usize);
                vertex.map_or(Vec3::ZERO, |it| Vec3::from(it.position_m))
            };
            let middle = triangle.map(place).into_iter().sum::<Vec3>() / 3.0;
            let off = |face: &&(Vec3, u16)| face.0.distance_squared(middle);
            let nearest = faces.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
            if let Some((_, cell)) = nearest {
                all.push((number, *cell));
            }
        }
    }
    all
}
