//! The contact skin, against which tools collide: a closed surface, coarser than the skin that the
//! display draws. Under an affine motion of the spheres, its vertices follow exactly.

mod curve;
mod patch;

use nalgebra::{Matrix4, Vector4};
use rayon::prelude::*;
use rt_core::scene::{NO_VERTEX, SKIN_BINDINGS, SkinVertex};

use crate::Vec3;
use crate::field::{Field, Grid, Sign};
use crate::mesh::Mesh;
use crate::pack::{Ball, Interior, OFF_SHARE};
use crate::surface_nets;
use crate::tetra::Tetra;

/// Edge of the skin's triangles, as a multiple of the spheres' spacing.
const EDGE_SPACINGS: f64 = 0.4;
/// Shortest edge, m: jaws do not feel details that are finer than the jaws are wide.
const EDGE_MIN_M: f64 = 0.0025;
/// Longest edge, m: over an edge of this length, an organ with a radius of 3 cm bulges by 0.1 mm.
const EDGE_MAX_M: f64 = 0.005;
/// Largest number of vertices of an organ's skin, approximately.
const VERTICES_MAX: f64 = 6000.0;
/// Width of the Gaussian that weights near spheres, as a multiple of the spheres' spacing.
const CARRY_SPACINGS: f64 = 1.2;
/// Largest weight of a sphere. With a larger one, a small motion of the sphere would swing the
/// vertex.
const WEIGHT_MAX: f64 = 2.0;

/// Fewest vertices of a skin: the number that surface nets have around 2 × 2 × 2 grid points.
const VERTICES_MIN: usize = 26;
/// Number of edges that are tried, each half of the one before: in a small organ from 2.5 mm to
/// 0.04 mm.
const EDGES_TRIED: usize = 7;
/// Numbers of triangles around a vertex that the realtime process accepts.
const FAN: std::ops::RangeInclusive<u32> = 3..=32;
/// Smallest patch that the realtime process accepts, m.
const PATCH_MIN_M: f32 = 1e-4;
/// Largest curvature that the realtime process accepts, 1/m.
const CURVATURE_MAX_PER_M: f32 = 1e4;

/// A contact skin. Indices count within the organ.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ContactSkin {
    /// Vertices.
    pub vertices: Vec<SkinVertex>,
    /// The two other corners of every triangle around each vertex, vertex by vertex.
    pub fans: Vec<[u16; 2]>,
    /// For each sphere, the nearest vertex.
    pub nearest: Vec<u16>,
}

impl ContactSkin {
    /// Makes the skin around `mesh`. Its vertices follow the spheres `balls`. Between the spheres
    /// lie the tetrahedra `tets`, of a material with this Poisson's ratio.
    #[must_use]
    pub fn new(
        interior: &Interior<'_>,
        mesh: &Mesh,
        balls: &[Ball],
        tets: &[Tetra],
        poisson: f64,
    ) -> Self {
        let finest = (mesh.area() / VERTICES_MAX).sqrt();
        let mut edge_m = (EDGE_SPACINGS * interior.spacing_m)
            .clamp(EDGE_MIN_M, EDGE_MAX_M)
            .max(finest);
        let tissue = patch::Tissue {
            balls,
            tets,
            poisson,
            spacing_m: interior.spacing_m,
        };
        // An organ of a few millimetres needs an edge below `EDGE_MIN_M`.
        for _ in 0..EDGES_TRIED {
            if let Some(skin) = Self::with_edge(interior, mesh, &tissue, edge_m) {
                return skin;
            }
            edge_m /= 2.0;
        }
        Self::default()
    }

    /// The skin with triangles of this edge. `None` if a shorter edge is needed: there are too few
    /// vertices, or a vertex has too many or too few triangles. The skin is empty if there are more
    /// vertices than indices.
    fn with_edge(
        interior: &Interior<'_>,
        mesh: &Mesh,
        tissue: &patch::Tissue<'_>,
        edge_m: f64,
    ) -> Option<Self> {
        let balls = tissue.balls;
        let own = interior.frame.own_mesh(mesh);
        let [min, max] = own.bounds();
        let low = min.add_scalar(-OFF_SHARE * edge_m);
        let grid = Grid::around([low, max], edge_m, 2);
        let field = Field::new(&own, grid, Sign::Closed);
        let values: Vec<f64> = field.distance_m.iter().map(|d| f64::from(*d)).collect();
        let coarse = surface_nets::surface(&field.grid, &values);
        let places: Vec<Vec3> = coarse
            .vertices
            .par_iter()
            .map(|p| interior.nearest.point(&interior.frame.world(p)))
            .collect();
        let fans = fans(&coarse, &places);
        let kept: Vec<usize> = (0..places.len()).filter(|&i| fans[i].len() >= 3).collect();
        if kept.len() >= usize::from(NO_VERTEX) {
            return Some(Self::default());
        }
        if kept.len() < VERTICES_MIN {
            return None;
        }
        let mut new_number = vec![NO_VERTEX; places.len()];
        for (new, old) in (0u16..).zip(&kept) {
            new_number[*old] = new;
        }
        let bound: Vec<_> = kept
            .par_iter()
            .map(|&i| carriers(&places[i], balls, interior.spacing_m))
            .collect();
        let mut skin = Self::default();
        for (&old, (spheres, weights)) in kept.iter().zip(bound) {
            let fan_start = skin.fans.len() as u32;
            let renumbered = fans[old].iter().map(|t| t.map(|i| new_number[i as usize]));
            skin.fans
                .extend(renumbered.filter(|t| !t.contains(&NO_VERTEX)));
            skin.vertices.push(SkinVertex {
                spheres,
                weights,
                fan_start,
                fan_count: skin.fans.len() as u32 - fan_start,
                patch_m: interior.spacing_m as f32,
                curvature_per_m: 0.0,
            });
        }
        let is_fan = |vertex: &SkinVertex| FAN.contains(&vertex.fan_count);
        if !skin.vertices.iter().all(is_fan) {
            return None;
        }
        let nearest = |ball: &Ball| {
            let off = |i: &usize| (places[*i] - ball.center).norm_squared();
            let nearest = kept.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
            nearest.map_or(NO_VERTEX, |i| new_number[*i])
        };
        skin.nearest = balls.par_iter().map(nearest).collect();
        let rest = skin.rest(kept.iter().map(|&i| places[i]).collect());
        patch::bake(&mut skin, &rest, tissue);
        curve::bake(&mut skin, &rest);
        for vertex in &mut skin.vertices {
            vertex.patch_m = vertex.patch_m.max(PATCH_MIN_M);
            let bulge_per_m = vertex.curvature_per_m;
            vertex.curvature_per_m = bulge_per_m.clamp(-CURVATURE_MAX_PER_M, CURVATURE_MAX_PER_M);
        }
        Some(skin)
    }

    fn rest(&self, places: Vec<Vec3>) -> patch::Rest {
        let scaled = |(vertex, at): (&SkinVertex, &Vec3)| {
            let fan = &self.fans[vertex.fan_start as usize..][..vertex.fan_count as usize];
            let corner = |i: u16| places[usize::from(i)] - at;
            let crosses = fan.iter().map(|&[b, c]| corner(b).cross(&corner(c)));
            crosses.collect::<Vec<Vec3>>()
        };
        let crosses: Vec<_> = self.vertices.iter().zip(&places).map(scaled).collect();
        let normal = |all: &Vec<Vec3>| {
            let sum: Vec3 = all.iter().sum();
            sum.try_normalize(0.0).unwrap_or_else(Vec3::zeros)
        };
        let area = |all: &Vec<Vec3>| all.iter().map(|c| c.norm()).sum::<f64>() / 6.0;
        patch::Rest {
            normals: crosses.iter().map(normal).collect(),
            areas: crosses.iter().map(area).collect(),
            places,
        }
    }
}

/// For each vertex, the two other corners of its triangles, in order around the vertex.
fn fans(mesh: &Mesh, places: &[Vec3]) -> Vec<Vec<[u32; 2]>> {
    let mut fans = vec![Vec::new(); places.len()];
    for &[a, b, c] in &mesh.triangles {
        fans[a as usize].push([b, c]);
        fans[b as usize].push([c, a]);
        fans[c as usize].push([a, b]);
    }
    for fan in &mut fans {
        for i in 1..fan.len() {
            let last: [u32; 2] = fan[i - 1];
            let next = (i..fan.len()).find(|&j| fan[j][0] == last[1]);
            if let Some(next) = next {
                fan.swap(i, next);
            }
        }
    }
    fans
}

/// The spheres that a place follows: the nearest ones, with weights ω that minimise `Σ ω²/φ` under
/// the conditions that `Σ ω = 1` and that `Σ ω X` is the place. `X` is a sphere's centre, φ a
/// Gaussian of its distance from the place.
pub(crate) fn carriers(
    place: &Vec3,
    balls: &[Ball],
    spacing_m: f64,
) -> ([u16; SKIN_BINDINGS], [f32; SKIN_BINDINGS]) {
    let mut near: Vec<(f64, usize)> = balls
        .iter()
        .enumerate()
        .map(|(i, ball)| ((ball.center - place).norm(), i))
        .collect();
    near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    near.truncate(SKIN_BINDINGS);
    let width_m = (CARRY_SPACINGS * spacing_m).max(near[0].0);
    let rows: Vec<(f64, Vector4<f64>)> = near
        .iter()
        .map(|&(distance, i)| {
            let from = (balls[i].center - place) / spacing_m;
            let share = libm::exp(-(distance / width_m).powi(2));
            (share, Vector4::new(1.0, from.x, from.y, from.z))
        })
        .collect();
    let mut weights = [0.0; SKIN_BINDINGS];
    // If the near spheres lie in a plane, no weights give a place outside of that plane. So the
    // condition on `Σ ω X` is softened, step by step until no weight is too large.
    let mut stay = 1e-6;
    loop {
        let mut moment = Matrix4::from_diagonal(&Vector4::new(0.0, stay, stay, stay));
        for (share, row) in &rows {
            moment += *share * row * row.transpose();
        }
        let solved = moment
            .try_inverse()
            .map(|inverse| inverse * Vector4::new(1.0, 0.0, 0.0, 0.0));
        if let Some(solved) = solved {
            let sum: f64 = rows
                .iter()
                .map(|(share, row)| share * row.dot(&solved))
                .sum();
            for (weight, (share, row)) in weights.iter_mut().zip(&rows) {
                *weight = share * row.dot(&solved) / sum;
            }
            if weights.iter().all(|w| w.abs() <= WEIGHT_MAX) {
                break;
            }
        }
        if stay > 1e3 {
            weights = [0.0; SKIN_BINDINGS];
            weights[0] = 1.0;
            break;
        }
        stay *= 10.0;
    }
    let mut spheres = [near[0].1 as u16; SKIN_BINDINGS];
    for (sphere, (_, i)) in spheres.iter_mut().zip(&near) {
        *sphere = *i as u16;
    }
    (spheres, weights.map(|w| w as f32))
}
