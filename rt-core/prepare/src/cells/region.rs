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
        let margins_m = if is_covered { COVERED_M } else { MARGINS_M };
        Self {
            triangle,
            margins_m,
            bed,
        }
    }

    /// Region of a place in tissue of this kind of organ ([`CellRecord::region`]).
    pub(crate) fn of(&self, kind: OrganKind, p: &Vec3) -> u8 {
        match kind {
            OrganKind::Fat => match self.triangle {
                Some(corners) if is_over(&corners, &self.margins_m, p) => CellRecord::TRIANGLE,
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
