//! Packing of an organ: the spheres inside its surface, and the links and tetrahedra that join
//! them.

use crate::error::PrepareError;
use crate::held::{self, Plane};
use crate::links;
use crate::mesh::Mended;
use crate::pack::{self, Ball, Interior};
use crate::recipe::{OrganPlan, Packing};
use crate::tetra::{self, Tetra};

/// Spheres, links and tetrahedra of an organ.
pub(crate) struct Skeleton {
    pub(crate) balls: Vec<Ball>,
    pub(crate) links: Vec<[u32; 2]>,
    /// Pairs of spheres that follow each other along a tube.
    pub(crate) steps: Vec<[u32; 2]>,
    pub(crate) tets: Vec<Tetra>,
}

pub(crate) fn interior<'a>(
    plan: &OrganPlan,
    surface: &'a Mended,
    spheres: usize,
) -> Result<Interior<'a>, PrepareError> {
    Interior::new(&surface.mesh, surface.volume_m3, spheres).ok_or_else(|| PrepareError::Organ {
        organ: plan.name.clone(),
        problem: "is too thin to be filled with spheres; use more spheres, or a thicker mesh"
            .into(),
    })
}

pub(crate) fn skeleton(
    plan: &OrganPlan,
    interior: &Interior<'_>,
    volume_m3: f64,
    spheres: usize,
    planes: &[Plane],
) -> Skeleton {
    match plan.packing {
        Packing::Even => {
            let mut balls = pack::pack_evenly(interior, spheres);
            held::onto_planes(planes, interior, &mut balls);
            let tets = tetra::fill_between(interior, &balls, volume_m3, planes);
            Skeleton {
                links: links::link_edges(&balls, &tets),
                steps: Vec::new(),
                balls,
                tets,
            }
        }
        Packing::Paper => {
            let balls = pack::pack_as_paper(interior, spheres);
            let tets = tetra::fill(interior, &balls, volume_m3);
            Skeleton {
                links: links::link(&balls),
                steps: Vec::new(),
                balls,
                tets,
            }
        }
        Packing::Line => {
            let line = pack::pack_line(interior, spheres);
            Skeleton {
                links: links::link_line(&line),
                balls: line.balls,
                steps: line.steps,
                tets: Vec::new(),
            }
        }
    }
}
