//! A soft body as the fast methods see it: sphere centres, tetrahedra between them, edges.

use std::collections::BTreeSet;

use scene_prepare::pack::{Interior, owners, pack_evenly};
use scene_prepare::tetra;

use crate::scene::{Kind, Scene};

/// A point or direction in single precision, as the realtime methods compute.
pub(crate) type V3 = nalgebra::Vector3<f32>;

/// What a body is made of, SI.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tissue {
    /// Young's modulus, Pa.
    pub(crate) young_pa: f64,
    /// Poisson's ratio.
    pub(crate) poisson: f64,
    /// Density, kg/m³.
    pub density_kg_m3: f64,
}

impl Tissue {
    /// Liver as the scenes have it, unless they say otherwise.
    pub(crate) const LIVER: Self = Self {
        young_pa: 5000.0,
        poisson: 0.45,
        density_kg_m3: 1060.0,
    };

    /// Shear modulus, Pa.
    pub(crate) fn mu(&self) -> f64 {
        self.young_pa / (2.0 * (1.0 + self.poisson))
    }

    /// Lamé's first constant, Pa.
    pub(crate) fn lame(&self) -> f64 {
        self.young_pa * self.poisson / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson))
    }
}

/// What holds a sphere.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Held {
    /// Nothing.
    Free,
    /// The scene's fixed end.
    Fixed,
    /// The end that the scene moves.
    Moved,
}

/// A tetrahedron at rest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tet {
    /// Its spheres.
    pub(crate) nodes: [usize; 4],
    /// Volume of tissue that it stands for, m³.
    pub volume_m3: f32,
    /// Derivatives of the last three barycentric coordinates by rest position, 1/m.
    pub(crate) slopes: [V3; 3],
}

/// An edge of the graph.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Edge {
    /// Its ends.
    pub(crate) nodes: [usize; 2],
    /// Length at rest, m.
    pub(crate) length_m: f32,
    /// Tissue that it stands for if edges carry all of it, m³.
    pub volume_m3: f32,
}

/// The body at rest.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    /// Sphere centres, m.
    pub(crate) rest_m: Vec<V3>,
    /// Mass of each sphere, kg.
    pub(crate) mass_kg: Vec<f32>,
    /// Tetrahedra in the order in which they are solved.
    pub(crate) tets: Vec<Tet>,
    /// Edges in the order in which they are solved.
    pub(crate) edges: Vec<Edge>,
    /// What it is made of.
    pub(crate) tissue: Tissue,
    /// Points spread evenly through the tissue, m.
    pub(crate) inside_m: Vec<V3>,
}

impl Body {
    /// Which spheres a scene holds. A plane passes between centres: the spheres whose centres lie
    /// behind it hold too little tissue, by half a spacing. So many are held that the tetrahedra
    /// which they hold altogether carry the tissue behind the plane.
    pub(crate) fn held(&self, scene: &Scene) -> Vec<Held> {
        let mut held = vec![Held::Free; self.rest_m.len()];
        let along = |x: &V3| f64::from(x[scene.axis]);
        let fixed = |x: &V3| scene.fixed_below_m - along(x);
        for i in self.behind(fixed) {
            held[i] = Held::Fixed;
        }
        if scene.kind != Kind::Sag {
            for i in self.behind(|x| along(x) - scene.free_below_m) {
                held[i] = Held::Moved;
            }
        }
        held
    }

    /// The spheres that hold what lies behind a plane; `depth` is positive there.
    fn behind(&self, depth: impl Fn(&V3) -> f64) -> impl Iterator<Item = usize> {
        let behind = self.inside_m.iter().filter(|x| depth(x) > 0.0).count();
        let share = behind as f64 / self.inside_m.len().max(1) as f64;
        let depths: Vec<f64> = self.rest_m.iter().map(&depth).collect();
        // Depth at which each tetrahedron is held altogether.
        let mut whole: Vec<(f64, f64)> = self
            .tets
            .iter()
            .map(|t| {
                let shallowest = t.nodes.iter().map(|&n| depths[n]);
                (shallowest.fold(f64::INFINITY, f64::min), f64::from(t.volume_m3))
            })
            .collect();
        whole.sort_by(|a, b| b.0.total_cmp(&a.0));
        let wanted = share * whole.iter().map(|t| t.1).sum::<f64>();
        let (mut sum, mut limit) = (0.0, f64::INFINITY);
        for (depth, volume) in whole {
            if sum + 0.5 * volume > wanted {
                break;
            }
            sum += volume;
            limit = depth;
        }
        (0..depths.len()).filter(move |&i| depths[i] >= limit)
    }

    /// Packs a closed mesh with `count` spheres, as preparation does.
    pub(crate) fn packed(
        mesh: &scene_prepare::mesh::Mesh,
        count: usize,
        tissue: Tissue,
    ) -> Option<Self> {
        let volume = mesh.volume();
        let interior = Interior::new(mesh, volume, count)?;
        let balls = pack_evenly(&interior, count);
        let centers: Vec<_> = balls.iter().map(|b| b.center).collect();
        let mut share = vec![0.0; centers.len()];
        let owner = owners(&interior, &centers);
        for &o in &owner {
            share[o as usize] += volume / owner.len() as f64;
        }
        let filled = tetra::fill(&interior, &balls, volume);
        let tets: Vec<_> = filled
            .iter()
            .map(|t| (t.spheres.map(|i| i as usize), t.volume_m3))
            .collect();
        let inside = interior.points.iter();
        Some(Self {
            inside_m: inside.map(|&p| interior.position(p).cast()).collect(),
            ..Self::new(&centers, &share, &tets, tissue)
        })
    }

    /// From centres, the volume nearest to each, and tetrahedra with theirs.
    pub(crate) fn new(
        centers: &[nalgebra::Vector3<f64>],
        share_m3: &[f64],
        tets: &[([usize; 4], f64)],
        tissue: Tissue,
    ) -> Self {
        let mut solid = Vec::new();
        let mut pairs = BTreeSet::new();
        for &(nodes, volume) in tets {
            let [a, b, c, d] = nodes.map(|i| centers[i]);
            let axes = nalgebra::Matrix3::from_columns(&[b - a, c - a, d - a]);
            let Some(inverse) = axes.try_inverse() else {
                continue;
            };
            let row = |i: usize| inverse.row(i).transpose().cast::<f32>();
            solid.push(Tet {
                nodes,
                volume_m3: volume as f32,
                slopes: [row(0), row(1), row(2)],
            });
            for i in 0..4 {
                for j in i + 1..4 {
                    pairs.insert((nodes[i].min(nodes[j]), nodes[i].max(nodes[j])));
                }
            }
        }
        let length = |&(i, j): &(usize, usize)| (centers[i] - centers[j]).norm();
        let mut squares = vec![0.0; centers.len()];
        for p in &pairs {
            squares[p.0] += length(p).powi(2);
            squares[p.1] += length(p).powi(2);
        }
        let edge = |p: &(usize, usize)| {
            let split = share_m3[p.0] / squares[p.0] + share_m3[p.1] / squares[p.1];
            Edge {
                nodes: [p.0, p.1],
                length_m: length(p) as f32,
                volume_m3: (length(p).powi(2) * split) as f32,
            }
        };
        Self {
            rest_m: centers.iter().map(|c| c.cast()).collect(),
            mass_kg: share_m3
                .iter()
                .map(|v| (v * tissue.density_kg_m3) as f32)
                .collect(),
            tets: solid,
            edges: pairs.iter().map(edge).collect(),
            tissue,
            inside_m: centers.iter().map(|c| c.cast()).collect(),
        }
    }

    /// Deformation gradient of a tetrahedron under displacements.
    pub(crate) fn gradient(tet: &Tet, at: impl Fn(usize) -> V3) -> nalgebra::Matrix3<f32> {
        let mut f = nalgebra::Matrix3::identity();
        let origin = at(tet.nodes[0]);
        for (slope, &n) in tet.slopes.iter().zip(&tet.nodes[1..]) {
            f += (at(n) - origin) * slope.transpose();
        }
        f
    }

    /// Relative growth of the volume under displacements.
    pub(crate) fn growth(&self, u: &[V3]) -> f64 {
        let (mut now, mut rest) = (0.0, 0.0);
        for t in &self.tets {
            let volume = f64::from(t.volume_m3);
            now += volume * f64::from(Self::gradient(t, |n| u[n]).determinant());
            rest += volume;
        }
        now / rest - 1.0
    }
}
