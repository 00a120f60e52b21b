//! Where along a tool the skin is looked for.

use heapless::Vec;

use crate::capacity::{INSTRUMENT_STATIONS, MAX_STATIONS};
use crate::contact::law::Shape;
use crate::math::{self, Vec3};
use crate::tool::{Capsule, Role, Tool};

/// A place on a tool: the round end of a part, or the middle of a piece of its length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Station {
    /// On the part's axis, world frame, m.
    pub(crate) center_m: Vec3,
    /// Radius of the part, m.
    pub(crate) radius_m: f32,
    /// What touches here.
    pub(crate) shape: Shape,
}

/// A piece of a part is this many of its radii long.
const PIECE_RADII: f32 = 2.4;
/// No piece is shorter, m.
const PIECE_MIN_M: f32 = 0.004;

/// The stations of all parts, each with the number by which it is known from tick to tick: pieces
/// are counted from the far end `b`, so that they go with the instrument when the shaft slides
/// through its port. Pieces beyond what there is room for are left out, the ones nearest to the port
/// first.
pub(crate) fn stations(parts: &[Capsule]) -> Vec<(u8, Station), MAX_STATIONS> {
    let mut all = Vec::new();
    let of = |tool| parts.iter().filter(move |part| part.role.tool() == tool);
    let first = INSTRUMENT_STATIONS as u8;
    for (number, station) in (0..first).zip(&stations_of(of(Tool::Instrument))) {
        let _ = all.push((number, *station)); // there is room for all of both tools
    }
    for (number, station) in (first..MAX_STATIONS as u8).zip(&stations_of(of(Tool::Endoscope))) {
        let _ = all.push((number, *station));
    }
    all
}

/// The stations of a tool's parts.
fn stations_of<'a>(
    parts: impl DoubleEndedIterator<Item = &'a Capsule> + Clone,
) -> Vec<Station, INSTRUMENT_STATIONS> {
    let mut all = Vec::new();
    // Ends first: they are never left out. The shaft has none, it ends in the jaws.
    for part in parts.clone().filter(|part| part.role != Role::Shaft) {
        let radius_m = part.radius_m;
        let _ = all.push(Station {
            center_m: part.b_m,
            radius_m,
            shape: Shape::Ball { radius_m },
        }); // there are more places than parts
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
            let station = Station {
                center_m: part.b_m + along * from_end_m,
                radius_m,
                shape: Shape::Bar {
                    radius_m,
                    length_m: piece_m,
                },
            };
            if all.push(station).is_err() {
                return all;
            }
            from_end_m += piece_m;
        }
    }
    all
}
