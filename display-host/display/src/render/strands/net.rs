//! The net of fibres and films, derived from the removed cells with reproducible randomness.

use glam::Vec3;
use shared_mem::scene::{CellRecord, NO_CELL};

use super::super::hexahedron::{FACES, INWARDS, OUTWARDS};
use super::anchors::Anchors;
use super::weave::Weave;
use crate::effects::chance;

/// Largest number of pieces. Further pieces are not shown.
pub(super) const PIECES: usize = 4000;
/// Largest number of films. Further films are not shown.
pub(super) const FILMS: usize = 1500;
/// Radius of the thinnest fibre, m. Most fibres are thin.
const THIN_M: f32 = 0.000_028;
/// Radius of the thickest fibre, m.
const THICK_M: f32 = 0.000_15;
/// Radius of a fibre's free end, as a share of the fibre's radius.
const FREE: f32 = 0.4;
/// Largest distance of a node from its cell's side, m.
const OFF_M: f32 = 0.000_5;
/// Largest distance of a free end from its cell's side, m.
const FREE_M: f32 = 0.001_1;
/// Largest bow of a fibre, as a share of its length at rest.
const BOW: f32 = 0.30;
/// Width of the range of an anchor's lateral offset, as a share of the cell's width.
const ASKEW: f32 = 1.2;
/// Number of nodes on a side between two cells of a column. Fibres meet at nodes.
const NODES: u32 = 2;
/// Range of a film's height along the two fibres of a fork, as shares of their length.
const FILM: [f32; 2] = [0.25, 0.65];
/// Share by which a film is lower in its middle.
const ARCH: f32 = 0.6;
/// Longest gap that fibres span, in cells.
const SPAN: usize = 2;

/// A piece of a fibre: along a cell, to an anchor, to the next column, or across a gap.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    /// Corners of the side of a cell along which the piece runs.
    pub(super) side: [u32; 4],
    pub(super) ends: [End; 2],
    /// Bow off the side and along the side, as shares of the piece's length at rest.
    pub(super) bow: [f32; 2],
}

/// An end of a piece: position between corners, and distance from the side.
#[derive(Debug, Clone, Copy)]
pub(super) struct End {
    /// Two pairs of corners. The line between the corners of each pair is divided at `shares[0]`.
    /// The line between the two points so found is divided at `shares[1]`.
    pub(super) corners: [u32; 4],
    pub(super) shares: [f32; 2],
    pub(super) off_m: f32,
    pub(super) radius_m: f32,
    /// True if the end widens into tissue.
    pub(super) is_root: bool,
}

impl End {
    /// Point of the end on the side, with the side's corners at `place`.
    pub(super) fn on_side(&self, place: impl Fn(u32) -> Vec3) -> Vec3 {
        let [a, b, c, d] = self.corners.map(place);
        let [u, v] = self.shares;
        a.lerp(b, u).lerp(c.lerp(d, u), v)
    }
}

/// A film in the fork of two fibres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Film {
    pub(super) pieces: [usize; 2],
    /// End of both fibres, 0 or 1, at which they fork.
    pub(super) end: usize,
    pub(super) height: f32,
}

impl Film {
    /// Place of a film's point along the fibres, as a share of their length. The point lies at the
    /// share `across` of the way from the first fibre to the second. It lies at the film's free
    /// edge, or else in the fork.
    pub(super) fn height_at(&self, across: f32, is_edge: bool) -> f32 {
        let arch = 1.0 - ARCH * (across * core::f32::consts::PI).sin();
        let up = if is_edge { self.height * arch } else { 0.0 };
        if self.end == 0 { up } else { 1.0 - up }
    }
}

/// Pieces of fibres, and films between them.
#[derive(Default)]
pub(super) struct Net {
    pub(super) pieces: Vec<Piece>,
    pub(super) films: Vec<Film>,
}

/// The data from which a net grows.
struct Ground<'a, G> {
    cells: &'a [CellRecord],
    weaves: &'a [Weave],
    anchors: &'a Anchors,
    is_gone: G,
}

impl Net {
    pub(super) fn of(
        cells: &[CellRecord],
        weaves: &[Weave],
        anchors: &Anchors,
        is_gone: impl Fn(u16) -> bool,
    ) -> Self {
        let ground = Ground {
            cells,
            weaves,
            anchors,
            is_gone,
        };
        let mut net = Self::default();
        for cell in 0..cells.len() {
            if ground.stands(cell as u16) && ground.weave(cell) != Weave::Plain {
                for side in 0..INWARDS {
                    ground.along(cell, side, &mut net);
                    ground.between(cell, side, &mut net);
                }
                for side in [1, 3] {
                    ground.over(cell, side, &mut net);
                }
            }
        }
        net
    }

    fn push(&mut self, piece: Piece) -> Option<usize> {
        let number = self.pieces.len();
        (number < PIECES).then(|| {
            self.pieces.push(piece);
            number
        })
    }

    /// Adds films in some of the forks of two neighbouring pieces.
    fn join(&mut self, pieces: [usize; 2], seed: u32) {
        let [first, second] = pieces.map(|it| self.pieces[it].ends);
        for end in 0..2 {
            let (a, b) = (first[end], second[end]);
            let apart = (a.shares[0] - b.shares[0]).abs() + (a.shares[1] - b.shares[1]).abs();
            let is_fork = a.corners == b.corners && apart < 1e-6;
            let is_root = a.is_root && b.is_root && apart < 0.7;
            let any = chance(seed.wrapping_add(end as u32 * 7)) * 0.5 + 0.5;
            if (is_fork || is_root) && any.x < 0.6 && self.films.len() < FILMS {
                let height = FILM[0] + (FILM[1] - FILM[0]) * any.y;
                self.films.push(Film {
                    pieces,
                    end,
                    height,
                });
            }
        }
    }
}

impl<G: Fn(u16) -> bool> Ground<'_, G> {
    fn stands(&self, cell: u16) -> bool {
        cell != NO_CELL && !(self.is_gone)(cell)
    }

    fn weave(&self, cell: usize) -> Weave {
        self.weaves.get(cell).copied().unwrap_or(Weave::Plain)
    }

    /// Corners of a side's inward edge.
    fn inner_edge(side: usize) -> [usize; 2] {
        let mut inner = FACES[side].into_iter().filter(|k| k & 4 == 0);
        [inner.next().unwrap_or(0), inner.next().unwrap_or(0)]
    }

    /// True if the next cell of the column remains and borders on a removed cell on the same side.
    fn goes_on(&self, cell: usize, side: usize, way: usize) -> bool {
        let beyond = self.cells[cell].neighbours[way];
        let beside = self.cells.get(usize::from(beyond));
        self.stands(beyond) && beside.is_some_and(|it| (self.is_gone)(it.neighbours[side]))
    }

    /// The two corners at which a side meets the next cell of its column.
    fn rim(&self, cell: usize, side: usize, way: usize) -> [u32; 2] {
        let outer = if way == OUTWARDS { 4 } else { 0 };
        Self::inner_edge(side).map(|k| u32::from(self.cells[cell].corners[k | outer]))
    }

    /// Seed from a column, its side, a level and a further number. The seed does not depend on the
    /// removed cells, so a removal moves no fibre.
    fn seed(&self, cell: usize, side: usize, level: u32, more: u32) -> u32 {
        let root = foot(self.cells, cell) as u32;
        (root * 4 + side as u32)
            .wrapping_mul(0x9e37_79b1)
            .wrapping_add(level * 131 + more)
    }

    /// Node of a side's fibres between this cell and the next of its column.
    fn node(&self, cell: usize, side: usize, way: usize, fibre: u32) -> End {
        let level = u32::from(self.cells[cell].layer) + u32::from(way == OUTWARDS);
        let choice = chance(self.seed(cell, side, level, 64 + fibre)).x * 0.5 + 0.5;
        let node = ((choice * NODES as f32) as u32).min(NODES - 1);
        let any = chance(self.seed(cell, side, level, 96 + node));
        let [a, b] = self.rim(cell, side, way);
        End {
            corners: [a, b, a, b],
            shares: [0.5 + 0.42 * any.x, 0.0],
            off_m: OFF_M * (0.65 + 0.35 * any.y),
            radius_m: 0.0,
            is_root: false,
        }
    }

    /// Adds fibres along a side that borders on a removed cell.
    fn along(&self, cell: usize, side: usize, net: &mut Net) {
        let it = &self.cells[cell];
        if !(self.is_gone)(it.neighbours[side]) {
            return;
        }
        let level = u32::from(it.layer);
        let (most, existing_share) = self.weave(cell).fibres();
        // The last piece of each of three kinds: along the cell, to its inward anchors, to its
        // outward anchors. Films may join the next piece of the same kind to it.
        let mut last = [None; 3];
        for fibre in 0..most {
            let own = chance(self.seed(cell, side, 0, fibre)) * 0.5 + 0.5;
            if own.z > existing_share {
                continue;
            }
            let thick = THIN_M * (THICK_M / THIN_M).powf(own.y * own.y);
            let root_share = 0.04 + 0.92 * own.x;
            let is_anchored = |way: usize| {
                let rim = self.rim(cell, side, way);
                it.neighbours[way] == NO_CELL && self.anchors.across(way, rim).is_some()
            };
            let end = |way: usize| {
                let [a, b] = self.rim(cell, side, way);
                let own_end = End {
                    corners: [a, b, a, b],
                    shares: [root_share, 0.0],
                    off_m: 0.0,
                    radius_m: thick,
                    is_root: true,
                };
                if self.goes_on(cell, side, way) || is_anchored(way) {
                    let node = self.node(cell, side, way, fibre);
                    End {
                        radius_m: thick,
                        ..node
                    }
                } else if (self.is_gone)(it.neighbours[way]) {
                    End {
                        off_m: FREE_M * own.y,
                        radius_m: FREE * thick,
                        is_root: false,
                        ..own_end
                    }
                } else {
                    own_end
                }
            };
            let sway = chance(self.seed(cell, side, level, 32 + fibre));
            let piece = Piece {
                side: FACES[side].map(|k| u32::from(it.corners[k])),
                ends: [end(INWARDS), end(OUTWARDS)],
                bow: [BOW * sway.x.abs(), BOW * sway.y],
            };
            let anchored = |way: usize| {
                // The root is offset, so that the fibre does not run straight to its anchor.
                let corners = self.anchors.across(way, self.rim(cell, side, way))?;
                let [a, b] = corners;
                let root = End {
                    corners: [a, b, a, b],
                    shares: [root_share + ASKEW * (sway.z * 0.5), 0.0],
                    off_m: 0.0,
                    radius_m: thick,
                    is_root: true,
                };
                let ends = match way {
                    INWARDS => [root, piece.ends[0]],
                    _ => [piece.ends[1], root],
                };
                is_anchored(way).then_some(Piece { ends, ..piece })
            };
            let drawn = [Some(piece), anchored(INWARDS), anchored(OUTWARDS)];
            for (last, piece) in last.iter_mut().zip(drawn) {
                let number = piece.and_then(|it| net.push(it));
                if let (Some(before), Some(number)) = (*last, number) {
                    net.join([before, number], self.seed(cell, side, level, 160 + fibre));
                }
                *last = number.or(*last);
            }
        }
    }

    /// Adds a fibre between the nodes of two neighbouring columns, for half of these pairs.
    fn between(&self, cell: usize, side: usize, net: &mut Net) {
        let next = self.cells[cell].neighbours[if side < 2 { 3 } else { 1 }];
        let beside = usize::from(next);
        let is_open = |it: usize| (self.is_gone)(self.cells[it].neighbours[side]);
        if self.weave(cell) != Weave::Dense
            || !self.stands(next)
            || self.weave(beside) != Weave::Dense
            || ![cell, beside].into_iter().all(is_open)
            || ![cell, beside]
                .into_iter()
                .all(|it| self.goes_on(it, side, OUTWARDS))
        {
            return;
        }
        let level = u32::from(self.cells[cell].layer);
        let any = chance(self.seed(cell, side, level, 192));
        if any.x > 0.0 {
            return;
        }
        let end = |it: usize| End {
            radius_m: THIN_M * (1.0 + any.z.abs()),
            ..self.node(it, side, OUTWARDS, 0)
        };
        net.push(Piece {
            side: FACES[side].map(|k| u32::from(self.cells[cell].corners[k])),
            ends: [end(cell), end(beside)],
            bow: [BOW * any.y.abs(), BOW * any.z],
        });
    }

    /// Adds fibres across a gap to the next remaining cell.
    fn over(&self, cell: usize, side: usize, net: &mut Net) {
        let mut next = self.cells[cell].neighbours[side];
        let mut gap = 0;
        while gap < SPAN && next != NO_CELL && (self.is_gone)(next) {
            gap += 1;
            next = self.cells[usize::from(next)].neighbours[side];
        }
        if gap == 0 || !self.stands(next) || self.weave(usize::from(next)) == Weave::Plain {
            return;
        }
        let level = u32::from(self.cells[cell].layer);
        let ends = [(cell, side), (usize::from(next), side ^ 1)];
        let mut last = None;
        for fibre in 0..2 {
            let any = chance(self.seed(cell, side, level, 224 + fibre)) * 0.5 + 0.5;
            if any.x * gap as f32 > self.weave(cell).spans() {
                continue;
            }
            let rims =
                ends.map(|(it, side)| [INWARDS, OUTWARDS].map(|way| self.rim(it, side, way)));
            let end = |which: usize| {
                let [inner, outer] = rims[which];
                let spot = chance(self.seed(cell, side, level, 240 + fibre * 2 + which as u32));
                End {
                    corners: [inner[0], inner[1], outer[0], outer[1]],
                    shares: [0.5 + 0.45 * spot.x, 0.5 + 0.45 * spot.y],
                    off_m: 0.0,
                    radius_m: THIN_M * (THICK_M / THIN_M).powf(any.y * any.y * 0.7),
                    is_root: true,
                }
            };
            let [[_, [a, b]], [_, [c, d]]] = rims;
            let number = net.push(Piece {
                side: [a, b, d, c],
                ends: [end(0), end(1)],
                bow: [BOW * (any.z - 0.7), BOW * (any.y - 0.5)],
            });
            if let (Some(before), Some(number)) = (last, number) {
                net.join([before, number], self.seed(cell, side, level, 250));
            }
            last = number.or(last);
        }
    }
}

/// Innermost cell of a cell's column, removed or not.
fn foot(cells: &[CellRecord], mut cell: usize) -> usize {
    // A byte numbers the layers, so no column is longer than this bound. The bound also ends a loop
    // in bad data.
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
    use std::collections::HashMap;

    use bytemuck::Zeroable as _;

    use super::*;

    /// Two neighbouring columns of two cells each.
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

    fn grown(gone: &[u16], weave: Weave, anchors: &Anchors) -> Net {
        Net::of(&columns(), &[weave; 4], anchors, |cell| {
            gone.contains(&cell)
        })
    }

    /// Pieces along a side, without those between columns.
    fn upright(net: &Net) -> Vec<Piece> {
        let is_upright = |it: &&Piece| it.ends[0].corners != it.ends[1].corners;
        net.pieces.iter().filter(is_upright).copied().collect()
    }

    #[test]
    fn fibres_grow_beside_a_removed_cell_and_vanish_with_their_own_cell() {
        let none = Anchors::default();
        let dense = |gone: &[u16]| upright(&grown(gone, Weave::Dense, &none));
        assert!(dense(&[]).is_empty());
        let one = dense(&[1]);
        let most = Weave::Dense.fibres().0 as usize;
        assert!((1..=most).contains(&one.len()), "{}", one.len());
        // The fibre is on the side of the removed cell and runs from the cell's inner edge to its
        // outer edge.
        let [inner, outer] = one[0].ends;
        assert_eq!(inner.corners[..2], [1, 4]);
        assert_eq!(outer.corners[..2], [7, 10]);
        // The fibre is rooted in tissue at both ends.
        assert!(inner.is_root && outer.is_root);
        assert!(dense(&[0, 1, 2, 3]).is_empty());
        assert!(grown(&[1], Weave::Plain, &none).pieces.is_empty());
    }

    #[test]
    fn fibres_beside_a_removed_column_go_on_and_meet_between_cells() {
        let both = upright(&grown(&[1, 3], Weave::Dense, &Anchors::default()));
        assert_eq!(both.len() % 2, 0);
        let (lower, upper) = both.split_at(both.len() / 2);
        let mut places = Vec::new();
        for (lower, upper) in lower.iter().zip(upper) {
            let [below, above] = [lower.ends[1], upper.ends[0]];
            assert_eq!(below.corners, above.corners);
            assert!(!below.is_root && below.off_m > 0.0);
            assert!((below.off_m - above.off_m).abs() < 1e-9);
            assert!((below.shares[0] - above.shares[0]).abs() < 1e-9);
            places.push((below.shares[0] * 1e6) as i32);
        }
        places.sort_unstable();
        places.dedup();
        assert!(places.len() <= NODES as usize, "{places:?}");
    }

    #[test]
    fn anchored_strand_goes_on_to_its_anchor() {
        let anchors = Anchors {
            of_corners: [HashMap::from([(1, 18), (4, 19)]), HashMap::new()],
            ..Anchors::default()
        };
        let held = upright(&grown(&[1], Weave::Dense, &anchors));
        let free = upright(&grown(&[1], Weave::Dense, &Anchors::default()));
        assert_eq!(held.len(), 2 * free.len());
        assert_eq!(held[1].ends[0].corners[..2], [18, 19]);
        assert_eq!(held[1].ends[1].corners, held[0].ends[0].corners);
    }

    /// Cells in a row, some of them removed.
    #[test]
    fn gaps_are_spanned_from_wall_to_wall_and_not_past_a_wall() {
        let none = NO_CELL;
        let row = |count: u16| -> Vec<CellRecord> {
            (0..count)
                .map(|i| CellRecord {
                    corners: core::array::from_fn(|k| i * 4 + (k as u16 >> 1) + (k as u16 & 1) * 4),
                    neighbours: [
                        i.checked_sub(1).unwrap_or(none),
                        if i + 1 < count { i + 1 } else { none },
                        none,
                        none,
                        none,
                        none,
                    ],
                    ..CellRecord::zeroed()
                })
                .collect()
        };
        let spans = |count: u16, gone: &[u16]| {
            let cells = row(count);
            let weaves = vec![Weave::Loose; cells.len()];
            let net = Net::of(&cells, &weaves, &Anchors::default(), |cell| {
                gone.contains(&cell)
            });
            let far = |it: &&Piece| {
                let [a, b] = it.ends.map(|end| end.corners);
                a.iter().all(|corner| !b.contains(corner)) && it.side[0] != it.ends[0].corners[0]
            };
            net.pieces.iter().filter(far).count()
        };
        // Fibres span gaps by chance, so this needs many rows.
        let some: usize = (3..40).map(|count| spans(count, &[count - 2])).sum();
        assert!(some > 0);
        let wide: usize = (8..40).map(|count| spans(count, &[2, 3, 4, 5])).sum();
        assert_eq!(wide, 0, "too wide");
        assert_eq!(spans(5, &[0, 4]), 0, "no wall on the other side");
    }
}
