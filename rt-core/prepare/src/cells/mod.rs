//! Layered tissue: an organ of fat or connective tissue that lies around another organ. It is
//! filled with hexahedra in layers between the inner organ and its own surface (the paper's
//! multi-layer hexahedral model).
//!
//! 1. Parallel cross-sections are laid along the inner organ. The course is the line through their
//!    middles ([`course`]).
//! 2. In each section, rays from the course find the inner and the outer outline of the tissue
//!    ([`lattice`]).
//! 3. Layers lie evenly between the two outlines. The borders of the layers have a point on every
//!    ray.
//! 4. Eight points make a hexahedron: two neighbouring borders, on two neighbouring rays, in two
//!    neighbouring sections. Cells with little tissue are left out until the other cells have the
//!    organ's volume. Then small groups of cells are left out.
//! 5. Corners of faces without a neighbour are moved towards the organ's surface ([`fit`]).
//!
//! Each cell follows the organ's spheres near the cell's middle.

mod course;
mod fit;
mod hexa;
mod lattice;
mod region;
#[cfg(test)]
mod tests;

use rayon::prelude::*;
use shared_mem::scene::{
    COLUMNS, CellColumnRecord, CellRecord, NO_CELL, OrganKind, SceneData, VertexRecord,
};

use crate::Vec3;
use crate::bind;
use crate::field::{Field, Grid, Nearest, Sign};
use crate::mesh::Mesh;
use crate::pack::Ball;
use crate::recipe::{Layers, OrganPlan};
use crate::skin;

pub(crate) use region::Regions;

/// Fewest cells of a connected group that is kept. A smaller group would hang in the air.
const GROUP_MIN: usize = 8;
/// A cell counts as under a contact vertex if a face of the cell without a neighbour is at most
/// this far from the vertex, in cell sizes. A face turned away from the skin's normal counts as up
/// to two cell sizes farther. The nearest cell always counts.
const OVER_CELLS: f64 = 2.5;

/// Layered tissue at rest. Indices count within the organ.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Cells {
    /// Corners, world frame, m.
    pub(crate) corners: Vec<Vec3>,
    /// Corners of each cell. In a corner's place in the list, bit 0 is set forwards along the
    /// course, bit 1 forwards around it, bit 2 outwards.
    pub(crate) cells: Vec<[u32; 8]>,
    /// Neighbours of each cell: backwards and forwards along the course, backwards and forwards
    /// around it, inwards, outwards.
    pub(crate) neighbours: Vec<[Option<u32>; 6]>,
    /// Layer of each cell, 0 the innermost.
    pub(crate) layers: Vec<u8>,
}

/// Fit of cells to their organ.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize)]
pub struct Filling {
    /// Number of cells.
    pub cells: usize,
    /// Volume of all cells over the organ's volume.
    pub volume_share: f64,
    /// Share of the organ's volume that lies in a cell.
    pub covered: f64,
    /// Shape of the worst cell: the smallest triple product of the three edges at a corner over the
    /// product of their lengths. A box has 1, a flat corner 0.
    pub shape_min: f64,
}

impl Cells {
    /// Fills `own` with cells around the organ `around`. There are none if no ray meets tissue, or
    /// only small groups remain.
    pub(crate) fn new(own: &Mesh, around: &Mesh, plan: &Layers) -> Self {
        let grid = Grid::around(own.bounds(), plan.cell_m / 4.0, 2);
        let field = Field::new(own, grid, Sign::Closed);
        let Some(nearest) = Nearest::new(own) else {
            return Self::default();
        };
        let course = course::course(around, own, plan.cell_m);
        let lattice = lattice::Lattice::new(&course, &field, plan);
        let mut cells = lattice.cells(own.volume());
        cells.leave_out_small_groups();
        fit::onto_surface(&mut cells, &nearest, plan.cell_m);
        cells
    }

    /// True if there are no cells.
    pub(crate) fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// The corners of a cell, m.
    pub(crate) fn places(&self, cell: usize) -> [Vec3; 8] {
        self.cells[cell].map(|i| self.corners[i as usize])
    }

    fn leave_out_small_groups(&mut self) {
        let mut group = vec![usize::MAX; self.cells.len()];
        let mut sizes = Vec::new();
        for start in 0..self.cells.len() {
            if group[start] != usize::MAX {
                continue;
            }
            let (mut open, mut size) = (vec![start], 0);
            group[start] = sizes.len();
            while let Some(cell) = open.pop() {
                size += 1;
                for next in self.neighbours[cell].iter().flatten() {
                    let next = *next as usize;
                    if group[next] == usize::MAX {
                        group[next] = sizes.len();
                        open.push(next);
                    }
                }
            }
            sizes.push(size);
        }
        self.keep(|cell| sizes[group[cell]] >= GROUP_MIN);
    }

    /// Keeps the cells for which `stays` is true, and their corners.
    fn keep(&mut self, stays: impl Fn(usize) -> bool) {
        let kept: Vec<usize> = (0..self.cells.len()).filter(|&i| stays(i)).collect();
        let mut number = vec![None; self.cells.len()];
        for (new, &old) in (0u32..).zip(&kept) {
            number[old] = Some(new);
        }
        let mut corner_number = vec![u32::MAX; self.corners.len()];
        let mut corners = Vec::new();
        let mut cells = Vec::with_capacity(kept.len());
        for &old in &kept {
            cells.push(self.cells[old].map(|i| {
                let new = &mut corner_number[i as usize];
                if *new == u32::MAX {
                    *new = corners.len() as u32;
                    corners.push(self.corners[i as usize]);
                }
                *new
            }));
        }
        let renumbered =
            |i: &usize| self.neighbours[*i].map(|n| n.and_then(|n| number[n as usize]));
        self.neighbours = kept.iter().map(renumbered).collect();
        self.layers = kept.iter().map(|&i| self.layers[i]).collect();
        (self.corners, self.cells) = (corners, cells);
    }

    /// Measures the fit of the cells to `own`.
    pub(crate) fn filling(&self, own: &Mesh, cell_m: f64) -> Filling {
        let all = || (0..self.cells.len()).map(|i| self.places(i));
        let volume_m3: f64 = all().map(|places| hexa::volume_m3(&places)).sum();
        let field = Field::new(
            own,
            Grid::around(own.bounds(), cell_m / 3.0, 1),
            Sign::Closed,
        );
        let points: Vec<usize> = (0..field.grid.len())
            .filter(|&i| field.is_inside(i))
            .collect();
        let boxes: Vec<_> = all()
            .map(|places| (hexa::bounds(&places), places))
            .collect();
        let is_covered = |i: &&usize| {
            let p = field.grid.position(field.grid.coordinates(**i));
            boxes.iter().any(|([low, high], places)| {
                (0..3).all(|k| low[k] <= p[k] && p[k] <= high[k]) && hexa::holds(places, &p)
            })
        };
        let covered = points.par_iter().filter(is_covered).count();
        Filling {
            cells: self.cells.len(),
            volume_share: volume_m3 / own.volume(),
            covered: covered as f64 / points.len().max(1) as f64,
            shape_min: all().map(|p| hexa::shape(&p)).fold(1.0, f64::min),
        }
    }
}

/// Puts the cells of organ `organ` into the scene, which must already hold the organ's spheres and
/// contact skin.
pub(crate) fn append(
    scene: &mut SceneData,
    organ: usize,
    plan: &OrganPlan,
    (cells, own): (&Cells, &Mesh),
    regions: &Regions,
) {
    let Some(layers) = &plan.layers else {
        return;
    };
    let [first, count] = scene.organs[organ].spheres;
    let balls: Vec<Ball> = scene.spheres[first as usize..][..count as usize]
        .iter()
        .map(|s| Ball {
            center: Vec3::from(s.center_m.map(f64::from)),
            radius_m: f64::from(s.radius_m),
        })
        .collect();
    let spacing_m = libm::cbrt(own.volume() / balls.len() as f64);
    let first_cell = scene.cells.len();
    let first_corner = scene.cell_corners.len();
    let outside = Mesh {
        vertices: cells.corners.clone(),
        triangles: surface(cells),
    };
    let bound: Vec<VertexRecord> = bind::bind(&outside, &balls, first);
    scene.cell_corners.extend(bound);
    // The casts wrap only in scenes that the scene's check refuses for their number of cells or
    // corners.
    let number = |cell: Option<u32>| cell.map_or(NO_CELL, |i| (first_cell + i as usize) as u16);
    let records: Vec<CellRecord> = (0..cells.cells.len())
        .into_par_iter()
        .map(|i| {
            let places = cells.places(i);
            let center = places.iter().sum::<Vec3>() / 8.0;
            let (spheres, weights) = skin::carriers(&center, &balls, spacing_m);
            let volume_m3 = hexa::volume_m3(&places);
            let energy_j = volume_m3 * plan.material.density_kg_m3 * parts_j_kg(plan.kind);
            CellRecord {
                corners: cells.cells[i].map(|c| (first_corner + c as usize) as u16),
                neighbours: cells.neighbours[i].map(number),
                spheres: spheres.map(|s| (u32::from(s) + first) as u16),
                weights,
                center_m: center.map(|x| x as f32).into(),
                extent_m: hexa::extents_m(&places).map(|x| x as f32),
                volume_m3: volume_m3 as f32,
                energy_j: energy_j as f32,
                layer: cells.layers[i],
                region: regions.of(plan.kind, &center),
                reserved: [0; 2],
            }
        })
        .collect();
    scene.cells.extend(records);
    append_columns(scene, [first, count], cells, first_cell, layers.cell_m);
}

/// Share of the water in loose tissue that has boiled when the tissue parts. Steam bursts tissue
/// under an electrode (Honig 1975, 10.1109/tbme.1975.324541) long before all of its water has
/// boiled: in connective tissue, the steam of one hundredth of the water has ten times the tissue's
/// volume. Some steam escapes, and no source says how much. So a fifth of the water is assumed to
/// boil. Organ walls and cords are dense, so a larger share of their water must boil
/// (`rt_core::procedure::cautery`).
const STEAM_BURSTS: f64 = 0.2;

/// Energy that parts a cell of loose tissue, J per kg that the cell would weigh if tissue filled
/// it: the energy that heats the tissue from 37 to 100 °C and boils [`STEAM_BURSTS`] of its water.
/// Fat is one fifth water and connective tissue seven tenths (Duck, *Physical Properties of
/// Tissue*, 1990). Fat fills its cells. While sutures hang the gallbladder up, the connective
/// tissue around it is drawn out to strands and sheets with gaps between them: it is taken to fill
/// half of its cells.
fn parts_j_kg(kind: OrganKind) -> f64 {
    const LATENT_J_KG: f64 = 2.26e6;
    const RISE_K: f64 = 63.0;
    let (solid, water, heat_j_kg_k) = match kind {
        OrganKind::Fat => (1.0, 0.2, 2300.0),
        _ => (0.5, 0.7, 3400.0),
    };
    solid * (STEAM_BURSTS * water * LATENT_J_KG + RISE_K * heat_j_kg_k)
}

/// Triangles of all faces without a neighbour. Corners run anticlockwise seen from outside.
fn surface(cells: &Cells) -> Vec<[u32; 3]> {
    let mut triangles = Vec::new();
    for (cell, neighbours) in cells.cells.iter().zip(&cells.neighbours) {
        for (face, _) in neighbours.iter().enumerate().filter(|(_, n)| n.is_none()) {
            let [a, b, c, d] = hexa::FACES[face].map(|i| cell[i]);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    triangles
}

/// Records, for every contact vertex of this organ, the cells under the vertex. The contact
/// vertices of other organs keep their columns.
fn append_columns(
    scene: &mut SceneData,
    [first, count]: [u32; 2],
    cells: &Cells,
    first_cell: usize,
    cell_m: f64,
) {
    const NONE: CellColumnRecord = CellColumnRecord {
        cells: [NO_CELL; COLUMNS],
        inwards: [0; COLUMNS],
        reserved: [0; 2],
    };
    struct Face {
        cell: usize,
        face: usize,
        center: Vec3,
        outward: Vec3,
    }
    let mut faces = Vec::new();
    for (i, neighbours) in cells.neighbours.iter().enumerate() {
        for (face, _) in neighbours.iter().enumerate().filter(|(_, n)| n.is_none()) {
            let [a, b, c, d] = hexa::FACES[face].map(|k| cells.places(i)[k]);
            faces.push(Face {
                cell: i,
                face,
                center: (a + b + c + d) / 4.0,
                outward: (c - a).cross(&(d - b)).normalize(),
            });
        }
    }
    let place = |v: &shared_mem::scene::ContactVertexRecord| -> Vec3 {
        let parts = v.spheres.iter().zip(v.weights);
        parts
            .map(|(&s, w)| {
                Vec3::from(scene.spheres[usize::from(s)].center_m.map(f64::from)) * f64::from(w)
            })
            .sum()
    };
    let places: Vec<Vec3> = scene.contact_vertices.iter().map(place).collect();
    let own = |v: &shared_mem::scene::ContactVertexRecord| {
        let sphere = u32::from(v.spheres[0]);
        sphere >= first && sphere < first + count
    };
    let columns: Vec<CellColumnRecord> = scene
        .contact_vertices
        .par_iter()
        .zip(&places)
        .map(|(vertex, at)| {
            let mut record = NONE;
            if !own(vertex) {
                return record;
            }
            let [start, n] = vertex.fan.map(|x| x as usize);
            let outward: Vec3 = scene.contact_fans[start..start + n]
                .iter()
                .map(|[b, c]| {
                    let corner = |i: u16| places[usize::from(i)] - at;
                    corner(*b).cross(&corner(*c))
                })
                .sum();
            let outward = outward.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
            let mut near: Vec<(f64, usize)> = faces
                .iter()
                .enumerate()
                .map(|(i, f)| {
                    // A face turned away from the skin's normal counts as farther (`OVER_CELLS`).
                    let turned = 1.0 - f.outward.dot(&outward);
                    ((f.center - at).norm() + cell_m * turned, i)
                })
                .collect();
            near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let reach = near.first().map_or(0.0, |n| n.0.max(OVER_CELLS * cell_m));
            let chosen = near.iter().take_while(|n| n.0 <= reach);
            for (slot, (_, i)) in chosen.take(COLUMNS).enumerate() {
                record.cells[slot] = (first_cell + faces[*i].cell) as u16;
                record.inwards[slot] = hexa::opposite(faces[*i].face) as u8;
            }
            record
        })
        .collect();
    if scene.cell_columns.is_empty() {
        scene.cell_columns = columns;
        return;
    }
    for (to, from) in scene.cell_columns.iter_mut().zip(columns) {
        if from != NONE {
            *to = from;
        }
    }
}
