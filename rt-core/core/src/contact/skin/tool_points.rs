//! Points along a tool that are tested for contact with skin.

use heapless::Vec;

use crate::capacity::{INSTRUMENT_POINTS, MAX_TOOL_POINTS};
use crate::contact::law::Shape;
use crate::math::{self, Vec3};
use crate::tool::{Capsule, Role, Tool};

/// A point of a tool: the round end of a part, or the middle of a piece of its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ToolPoint {
    /// Position on the part's axis, world frame, m.
    pub(crate) center_m: Vec3,
    /// Radius of the part, m.
    pub(crate) radius_m: f32,
    /// Half of the piece's axis, m; zero for a round end.
    pub(crate) half_m: Vec3,
    /// Shape of the tool here.
    pub(crate) shape: Shape,
}

/// Length of a piece, in radii of the part. Longer pieces cost less time, but follow curved skin
/// less well.
const PIECE_RADII: f32 = 2.4;
/// Least length of a piece, m.
const PIECE_MIN_M: f32 = 0.004;

/// Points of all parts, each with a number that is constant from tick to tick. Pieces are numbered
/// from the distal end `b`, so they travel with the instrument when the shaft slides through its
/// port. When there is no room, the pieces nearest to the port are left out first.
pub(crate) fn tool_points(parts: &[Capsule]) -> Vec<(u8, ToolPoint), MAX_TOOL_POINTS> {
    let mut all = Vec::new();
    let of = |tool| parts.iter().filter(move |part| part.role.tool() == tool);
    let first = INSTRUMENT_POINTS as u8;
    for (number, point) in (0..first).zip(&points_of(of(Tool::Instrument))) {
        let _ = all.push((number, *point)); // room for the points of both tools
    }
    for (number, point) in (first..MAX_TOOL_POINTS as u8).zip(&points_of(of(Tool::Endoscope))) {
        let _ = all.push((number, *point));
    }
    all
}

/// Points of a tool's parts.
fn points_of<'a>(
    parts: impl DoubleEndedIterator<Item = &'a Capsule> + Clone,
) -> Vec<ToolPoint, INSTRUMENT_POINTS> {
    let mut all = Vec::new();
    // The round ends come first, so that they are never left out. The shaft has no round end,
    // because it ends in the jaws.
    for part in parts.clone().filter(|part| part.role != Role::Shaft) {
        let radius_m = part.radius_m;
        let _ = all.push(ToolPoint {
            center_m: part.b_m,
            radius_m,
            half_m: Vec3::zeros(),
            shape: Shape::Ball { radius_m },
        }); // room for the round end of every part
    }
    for part in parts.rev() {
        let back_m = part.a_m - part.b_m;
        let length_m = math::norm(&back_m);
        let Some(along) = math::unit(&back_m) else {
            continue;
        };
        let radius_m = part.radius_m;
        let piece_m = (PIECE_RADII * radius_m).max(PIECE_MIN_M);
        let mut from_end_m = 0.5 * piece_m;
        while from_end_m < length_m {
            let point = ToolPoint {
                center_m: part.b_m + along * from_end_m,
                radius_m,
                half_m: along * (0.5 * piece_m),
                shape: Shape::Cylinder {
                    radius_m,
                    length_m: piece_m,
                },
            };
            if all.push(point).is_err() {
                return all;
            }
            from_end_m += piece_m;
        }
    }
    all
}
