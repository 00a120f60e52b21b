//! Boxes around parts of the tools.

use crate::tissue::Bounds;
use crate::tool::Capsule;

/// Box around a part, m.
pub(crate) fn part_box(part: &Capsule) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    bounds.add(&part.a_m, part.radius_m);
    bounds.add(&part.b_m, part.radius_m);
    bounds
}
