//! Present geometry of a fibre: its path, its thickness, and the drawn corners of the fibre and of
//! the films next to it.

use glam::Vec3;

use super::super::fibre::{SIDES, section};
use super::net::{Film, Piece};
use crate::skinning::SkinnedVertex;

/// Positions of the five rings, as shares of the piece's length: root, neck, middle, neck, root.
pub(super) const RINGS: [f32; 5] = [0.0, 0.16, 0.5, 0.84, 1.0];
/// Number of points in each of a film's two rows. Row 0 lies in the fork, row 1 at the free edge.
pub(super) const ACROSS: usize = 5;
/// Number of corners of a fibre's piece.
pub(super) const TUBE: usize = RINGS.len() * SIDES;
/// Number of corners of one side of a film.
pub(super) const SHEET: usize = 2 * ACROSS;
/// Radius of a fibre at its root, as a multiple of its radius elsewhere.
const ROOT: f32 = 2.6;

/// Present geometry of a piece.
#[derive(Clone, Copy)]
pub(super) struct PieceShape {
    ends: [Vec3; 2],
    bow: Vec3,
    /// Unit vector across the piece.
    across: Vec3,
    radii_m: [f32; 2],
    is_root: [bool; 2],
}

impl PieceShape {
    fn at(&self, share: f32) -> Vec3 {
        let swing = (share * core::f32::consts::PI).sin();
        self.ends[0].lerp(self.ends[1], share) + self.bow * (swing * swing)
    }

    fn radius_m(&self, share: f32) -> f32 {
        let [a, b] = self.radii_m;
        // The piece narrows behind its roots and in its middle.
        let flare = |is_root: bool, off: f32| match is_root {
            true => 1.0 + (ROOT - 1.0) * (1.0 - off / 0.2).max(0.0).powi(2),
            false => 1.0,
        };
        let waist = 1.0 - 0.25 * (share * core::f32::consts::PI).sin();
        let flare = flare(self.is_root[0], share) * flare(self.is_root[1], 1.0 - share);
        (a + (b - a) * share) * waist * flare
    }
}

impl Piece {
    pub(super) fn now(&self, length_m: f32, place: impl Fn(u32) -> Vec3 + Copy) -> PieceShape {
        let [a, b, c, d] = self.side.map(place);
        let off = (c - a).cross(d - b).normalize_or(Vec3::Y);
        let ends = self.ends.map(|end| end.on_side(place) + off * end.off_m);
        let along = ends[1] - ends[0];
        let across = off.cross(along).normalize_or(off.any_orthonormal_vector());
        // With `slack` < 1 the piece is stretched, so it is straighter and thinner. With a larger
        // `slack` it bows more.
        let slack = (length_m / along.length().max(1e-6)).clamp(0.2, 1.15);
        PieceShape {
            ends,
            bow: (off * self.bow[0] + across * self.bow[1]) * (length_m * slack * slack),
            across,
            radii_m: self.ends.map(|end| end.radius_m * slack.sqrt()),
            is_root: self.ends.map(|end| end.is_root),
        }
    }
}

impl PieceShape {
    pub(super) fn draw(&self, tube: &mut [SkinnedVertex]) {
        let along = (self.ends[1] - self.ends[0]).normalize_or(Vec3::X);
        let up = along.cross(self.across);
        for (ring, share) in tube.chunks_mut(SIDES).zip(RINGS) {
            section(
                ring,
                self.at(share),
                [self.across, up],
                self.radius_m(share),
            );
        }
    }
}

/// Draws both sides of a film. The second side is the first with the opposite normal.
pub(super) fn draw_film(
    film: &Film,
    first: &PieceShape,
    second: &PieceShape,
    sheet: &mut [SkinnedVertex],
) {
    let at = |across: f32, is_edge: bool| {
        let height = film.height_at(across, is_edge);
        first.at(height).lerp(second.at(height), across)
    };
    let [root, edge] = [at(0.5, false), at(0.5, true)];
    let normal = (at(1.0, true) - at(0.0, true))
        .cross(edge - root)
        .normalize_or(Vec3::Y);
    for (half, normal) in sheet.chunks_mut(SHEET).zip([normal, -normal]) {
        for (k, vertex) in half.iter_mut().enumerate() {
            let across = (k % ACROSS) as f32 / (ACROSS - 1) as f32;
            let place = at(across, k >= ACROSS);
            vertex.position = place.extend(0.0).to_array();
            vertex.normal = normal.extend(0.0).to_array();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::net::End;
    use super::*;

    #[test]
    fn a_fibre_is_thin_in_its_middle_and_thinner_when_drawn_out() {
        let end = |corner: u32, is_root| End {
            corners: [corner; 4],
            shares: [0.5, 0.0],
            off_m: 0.0,
            radius_m: 1e-4,
            is_root,
        };
        let piece = Piece {
            side: [0, 1, 2, 3],
            ends: [end(4, true), end(5, false)],
            bow: [0.2, 0.1],
        };
        let drawn = |length_m: f32| {
            let place = move |corner: u32| match corner {
                4 => Vec3::ZERO,
                5 => Vec3::X * length_m,
                it => Vec3::new((it % 2) as f32, (it / 2) as f32, 0.0),
            };
            piece.now(1e-3, place)
        };
        let (slack, taut) = (drawn(1e-3), drawn(4e-3));
        assert!(slack.radius_m(0.0) > 2.0 * slack.radius_m(0.5));
        assert!(taut.radius_m(0.5) < 0.6 * slack.radius_m(0.5));
        assert!(taut.bow.length() < 0.2 * slack.bow.length());
        assert!(slack.at(0.0).distance(Vec3::ZERO) < 1e-9);
        // A piece whose length has vanished must not give invalid numbers.
        let none = drawn(0.0);
        assert!(none.at(0.5).is_finite() && none.radius_m(0.5).is_finite());
    }
}
