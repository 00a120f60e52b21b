//! Regions of the operation's field: Calot's triangle and the gallbladder's bed.

use shared_mem::scene::{CellRecord, OrganKind};

use crate::Vec3;
use crate::mesh::Mesh;
use crate::recipe::{OrganPlan, Surface};
use crate::shape::Form;

/// Tissue up to this far outside of the triangle's sides belongs to the triangle, m: the sides
/// along the cystic duct, the liver and the bile duct.
const MARGINS_M: [f64; 3] = [0.003; 3];
/// Margins under a cover ([`crate::shape::Anatomy::cover_mm`]). There the tissue on and beside the
/// bile duct does not belong to the triangle, because a surgeon keeps away from the bile duct.
const COVERED_M: [f64; 3] = [0.003, 0.003, -0.003];
/// Under a cover, tissue farther than this behind the triangle's plane does not belong to the
/// triangle, m: duct and artery keep an instrument in front from reaching it.
const BEHIND_M: f64 = 0.002;
/// The lower bed reaches from the neck over this share of the bed's length.
const LOWER: f64 = 1.0 / 3.0;

/// Calot's triangle and the gallbladder's bed; `None` if the scene lacks an organ that bounds the
/// region.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Regions {
    /// Corners, m: the cystic duct's end at the bile duct, the gallbladder's neck, and the bile
    /// duct's end at the liver.
    triangle: Option<[Vec3; 3]>,
    /// Margins of its sides, m.
    margins_m: [f64; 3],
    /// A place in front of the triangle's plane, if only tissue in front of the plane and at most
    /// [`BEHIND_M`] behind it belongs to the triangle.
    front: Option<Vec3>,
    /// The bed's end at the neck and its other end, m.
    bed: Option<[Vec3; 2]>,
}

impl Regions {
    /// Finds the regions among these organs.
    pub(crate) fn new(organs: &[OrganPlan], skins: &[Mesh]) -> Self {
        let find = |kind: OrganKind| {
            let at = organs.iter().position(|o| o.kind == kind);
            at.map(|i| &skins[i])
                .filter(|skin| !skin.vertices.is_empty())
        };
        let duct = find(OrganKind::CysticDuct);
        let bile = find(OrganKind::BileDuct);
        let (gallbladder, liver) = (find(OrganKind::Gallbladder), find(OrganKind::Liver));
        let neck = duct
            .zip(gallbladder)
            .map(|(duct, bladder)| nearest_of(duct, bladder));
        let triangle = duct
            .zip(bile)
            .zip(neck)
            .zip(liver)
            .map(|(((duct, bile), neck), liver)| {
                [nearest_of(duct, bile), neck, nearest_of(bile, liver)]
            });
        let bed = find(OrganKind::ConnectiveTissue)
            .zip(neck)
            .map(|(bed, neck)| {
                let by = |a: &&Vec3, b: &&Vec3| {
                    let off = |p: &Vec3| (p - neck).norm_squared();
                    off(a).total_cmp(&off(b))
                };
                let near = bed.vertices.iter().min_by(by).copied().unwrap_or(neck);
                let far = bed.vertices.iter().max_by(by).copied().unwrap_or(neck);
                [near, far]
            });
        let is_covered = organs.iter().any(|organ| match &organ.surface {
            Surface::Shape(shape) => shape.form == Form::Fat && shape.anatomy.cover_mm > 0.0,
            Surface::Mesh { .. } => false,
        });
        // The gallbladder hangs in front of the triangle.
        let front = gallbladder.filter(|_| is_covered).map(middle);
        let margins_m = if is_covered { COVERED_M } else { MARGINS_M };
        Self {
            triangle,
            margins_m,
            front,
            bed,
        }
    }

    /// Region of a place in tissue of this kind of organ ([`CellRecord::region`]).
    pub(crate) fn of(&self, kind: OrganKind, p: &Vec3) -> u8 {
        match kind {
            OrganKind::Fat => match self.triangle {
                Some(corners)
                    if is_over(&corners, &self.margins_m, p)
                        && !self
                            .front
                            .is_some_and(|front| is_behind(&corners, &front, p)) =>
                {
                    CellRecord::TRIANGLE
                }
                _ => CellRecord::NOWHERE,
            },
            OrganKind::ConnectiveTissue => match self.bed {
                Some([near, far]) => {
                    let way = far - near;
                    let share = (p - near).dot(&way) / way.norm_squared().max(1e-12);
                    if share < LOWER {
                        CellRecord::LOWER_BED
                    } else {
                        CellRecord::UPPER_BED
                    }
                }
                None => CellRecord::NOWHERE,
            },
            _ => CellRecord::NOWHERE,
        }
    }
}

/// The vertex of `mesh` that is nearest to a vertex of `other`.
fn nearest_of(mesh: &Mesh, other: &Mesh) -> Vec3 {
    let off = |p: &Vec3| {
        let all = other.vertices.iter().map(|q| (p - q).norm_squared());
        all.fold(f64::INFINITY, f64::min)
    };
    let near = mesh.vertices.iter().map(|p| (off(p), p));
    let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map_or_else(Vec3::zeros, |(_, p)| *p)
}

/// Mean of a mesh's vertices.
fn middle(mesh: &Mesh) -> Vec3 {
    mesh.vertices.iter().sum::<Vec3>() / mesh.vertices.len().max(1) as f64
}

/// True if the place lies farther than [`BEHIND_M`] behind the triangle's plane, seen from `front`.
fn is_behind(corners: &[Vec3; 3], front: &Vec3, p: &Vec3) -> bool {
    let [a, b, c] = *corners;
    let normal = (b - a).cross(&(c - a)).try_normalize(1e-12);
    normal.is_some_and(|normal| {
        let side = (front - a).dot(&normal).signum();
        (p - a).dot(&normal) * side < -BEHIND_M
    })
}

/// True if the place, projected onto the triangle's plane, lies in the triangle or at most
/// as far outside of each side as its margin.
fn is_over(corners: &[Vec3; 3], margins_m: &[f64; 3], p: &Vec3) -> bool {
    let [a, b, c] = *corners;
    let Some(normal) = (b - a).cross(&(c - a)).try_normalize(1e-12) else {
        return false;
    };
    let sides = [[a, b], [b, c], [c, a]];
    sides.iter().zip(margins_m).all(|([from, to], margin_m)| {
        let inward = normal.cross(&(to - from).normalize());
        (p - from).dot(&inward) > -margin_m
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tissue_behind_the_plane_is_told_from_tissue_in_front_whatever_the_corners_order() {
        let [a, b, c] = [[0.0, 0.0, 0.0], [0.03, 0.0, 0.0], [0.0, 0.03, 0.0]].map(Vec3::from);
        let front = Vec3::new(0.01, 0.01, 0.05);
        for corners in [[a, b, c], [a, c, b]] {
            let behind =
                |depth_m: f64| is_behind(&corners, &front, &Vec3::new(0.005, 0.005, -depth_m));
            assert!(behind(0.0021) && behind(0.01));
            assert!(!behind(0.0019) && !behind(-0.01));
        }
        // Corners on a line span no plane, so nothing is behind it.
        assert!(!is_behind(&[a, b, b], &front, &Vec3::new(0.0, 0.0, -0.1)));
    }
}
