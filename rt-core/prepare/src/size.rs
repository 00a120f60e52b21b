//! Sizes that an organ of a kind can have: a mesh in a wrong unit is questioned.

use shared_mem::scene::OrganKind;

use crate::Vec3;

/// Longest side of an organ or a part of one, mm, from a small child's to a large adult's. Adults
/// have, by Gray's Anatomy: liver 150 to 260, gallbladder 70 to 100, cystic duct 20 to 40, cystic
/// artery 10 to 40, bile duct 60 to 80, stomach 250 to 300. The least is about a third of the
/// smallest, the most about a half more than the largest. Parts of bowel, fat, wall and vessels are
/// of any length up to the body's.
fn longest_mm(kind: OrganKind) -> [f64; 2] {
    match kind {
        OrganKind::Liver => [50.0, 400.0],
        OrganKind::Gallbladder => [20.0, 160.0],
        OrganKind::CysticDuct => [5.0, 100.0],
        OrganKind::CysticArtery => [3.0, 100.0],
        OrganKind::BileDuct => [10.0, 200.0],
        OrganKind::Stomach => [80.0, 450.0],
        OrganKind::Intestine => [20.0, 1500.0],
        OrganKind::AbdominalWall => [40.0, 900.0],
        OrganKind::Fat | OrganKind::ConnectiveTissue | OrganKind::Vessel => [5.0, 900.0],
    }
}

/// Units by which meshes are often mistaken, and their length in metres.
const UNITS: [(&str, f64); 4] = [("m", 1.0), ("cm", 0.01), ("mm", 0.001), ("in", 0.0254)];

/// Three dimensions of a box, mm, longest first.
#[must_use]
pub(crate) fn dimensions_mm([min, max]: [Vec3; 2]) -> [f64; 3] {
    let mut sides: [f64; 3] = ((max - min) * 1e3).into();
    sides.sort_by(|a, b| b.total_cmp(a));
    sides
}

/// A doubt about the size of an organ of this kind, with the unit that would settle it. `unit_m` is
/// the length in metres that the mesh's unit was taken for.
#[must_use]
pub(crate) fn doubt(kind: OrganKind, size_mm: [f64; 3], unit_m: f64) -> Option<String> {
    let [least, most] = longest_mm(kind);
    let fits = |mm: f64| (least..=most).contains(&mm);
    if fits(size_mm[0]) {
        return None;
    }
    let fitting: Vec<&str> = UNITS
        .iter()
        .filter(|(_, metres)| fits(size_mm[0] / unit_m * metres))
        .map(|(name, _)| *name)
        .collect();
    let remedy = match fitting.as_slice() {
        [] => "give its unit or its scale (--unit, --scale; `unit`, `scale` in a recipe) or its kind (--kind; `kind`)".to_owned(),
        units => format!(
            "if its unit is another, give it (--unit, or `unit` in a recipe: {} would fit)",
            units.join(" or ")
        ),
    };
    Some(format!(
        "is {} across, but such an organ has {least:.0} to {most:.0} mm; {remedy}",
        length(size_mm[0])
    ))
}

/// A length for people.
fn length(mm: f64) -> String {
    if mm >= 2000.0 {
        format!("{:.1} m", 1e-3 * mm)
    } else if mm >= 10.0 {
        format!("{mm:.0} mm")
    } else {
        format!("{mm:.1} mm")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_liver_of_16_mm_or_16_m_is_questioned_with_the_unit_that_fits() {
        let liver = OrganKind::Liver;
        assert_eq!(doubt(liver, [160.0, 120.0, 90.0], 0.001), None);
        let small = doubt(liver, [16.0, 12.0, 9.0], 0.001).unwrap();
        assert!(
            small.contains("16 mm across") && small.contains("cm"),
            "{small}"
        );
        let large = doubt(liver, [16_000.0, 12_000.0, 9000.0], 1.0).unwrap();
        assert!(
            large.contains("16.0 m across") && large.contains("cm"),
            "{large}"
        );
        // Six inches that were taken for millimetres.
        let inches = doubt(liver, [6.3, 5.0, 4.0], 0.001).unwrap();
        assert!(
            inches.contains("6.3 mm") && inches.contains("in would fit"),
            "{inches}"
        );
    }

    #[test]
    fn a_size_that_no_unit_mends_asks_for_the_scale_or_kind() {
        let odd = doubt(OrganKind::Liver, [30.0, 30.0, 30.0], 0.03).unwrap();
        assert!(odd.contains("--scale") || odd.contains("--unit"), "{odd}");
        assert_eq!(doubt(OrganKind::Gallbladder, [30.0; 3], 0.001), None);
    }
}
