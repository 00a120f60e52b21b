//! A soft body for the fast methods. It consists of sphere centres, tetrahedra between them and the
//! edges of the tetrahedra, or of cubes.

use std::collections::BTreeSet;

use rt_core::scene::Link;
use rt_core::tissue::neo_hookean::STIFFNESS_SHARE;
use scene_prepare::field::{Field, Grid, Sign};
use scene_prepare::recipe::{Material, MeshOptions};

use crate::scene::{Held, Scene};

/// A point or direction in single precision, as in the realtime methods.
pub(crate) type V3 = nalgebra::Vector3<f32>;

/// Material of a body, SI.
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
    /// Liver tissue. Cases use it unless they name another.
    pub(crate) const LIVER: Self = Self {
        young_pa: 5000.0,
        poisson: 0.45,
        density_kg_m3: 1060.0,
    };

    /// Retardation time, s: the viscosity of Calot's typical material divided by this Young's
    /// modulus.
    pub(crate) fn retardation_s(&self) -> f64 {
        let typical = Self::typical();
        typical.retardation_s * typical.young_pa / self.young_pa
    }

    /// Rate at which the velocity decays, 1/s: Calot's value for solid organs.
    pub(crate) fn damping_per_s(&self) -> f64 {
        Self::typical().damping_per_s
    }

    fn typical() -> Material {
        Material::typical(MeshOptions::default().kind)
    }

    /// Shear modulus, Pa.
    pub(crate) fn mu(&self) -> f64 {
        self.young_pa / (2.0 * (1.0 + self.poisson))
    }

    /// Lamé's first constant, Pa.
    pub(crate) fn lame(&self) -> f64 {
        self.young_pa * self.poisson / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson))
    }
}

/// A tetrahedron at rest.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Tet {
    /// Its spheres.
    pub(crate) nodes: [usize; 4],
    /// Volume of tissue that the tetrahedron represents, m³.
    pub volume_m3: f32,
    /// Derivatives of the last three barycentric coordinates with respect to the rest position,
    /// 1/m.
    pub(crate) slopes: [V3; 3],
}

/// Derivative of the determinant of `f`.
pub(crate) fn cofactor(f: &nalgebra::Matrix3<f32>) -> nalgebra::Matrix3<f32> {
    let (a, b, c) = (f.column(0), f.column(1), f.column(2));
    nalgebra::Matrix3::from_columns(&[b.cross(&c), c.cross(&a), a.cross(&b)])
}

/// An edge of the tetrahedra.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Edge {
    /// Its ends.
    pub(crate) nodes: [usize; 2],
    /// Length at rest, m.
    pub(crate) length_m: f32,
    /// Volume that the edge represents if the whole volume is divided among the edges, m³.
    pub volume_m3: f32,
}

/// The body at rest.
#[derive(Debug, Clone)]
pub(crate) struct Body {
    /// Sphere centres, m.
    pub(crate) rest_m: Vec<V3>,
    /// Radius of each sphere, m; 0 for nodes of cubes.
    pub(crate) radius_m: Vec<f32>,
    /// Mass of each sphere, kg.
    pub(crate) mass_kg: Vec<f32>,
    /// Tetrahedra in the order in which they are solved.
    pub(crate) tets: Vec<Tet>,
    /// Edges in the order in which they are solved.
    pub(crate) edges: Vec<Edge>,
    /// True for each sphere that preparation holds. Empty for cubes.
    pub(crate) supported: Vec<bool>,
    /// Springs of spheres that no tetrahedron joins. The springs are also among `edges`.
    pub(crate) springs: Vec<Link>,
    /// Smallest number of substeps in a tick, from preparation.
    pub(crate) substeps: u32,
    /// Material.
    pub(crate) tissue: Tissue,
    /// Corners of each cube, for the method with cubes; otherwise empty.
    pub(crate) cells: Vec<[usize; 8]>,
    /// Edge of the cubes, m.
    pub(crate) cell_m: f32,
}

impl Body {
    /// Hold on each sphere or node. A sphere that preparation holds gets the hold of the nearest
    /// plane. A node of cubes is held if it lies on a plane or beyond it.
    pub(crate) fn held(&self, scene: &Scene) -> Vec<Held> {
        let by_place = self.supported.is_empty();
        let place = |x: &V3| scene.held(&x.cast());
        let supported = |(x, supported): (&V3, &bool)| match supported {
            true => scene.nearest_hold(&x.cast()),
            false => Held::Free,
        };
        if by_place {
            self.rest_m.iter().map(place).collect()
        } else {
            self.rest_m
                .iter()
                .zip(&self.supported)
                .map(supported)
                .collect()
        }
    }

    /// Fills a closed mesh with about `cells` cubes. The scene's planes go through corners of
    /// cubes.
    pub(crate) fn of_cubes(
        mesh: &scene_prepare::mesh::Mesh,
        scene: &Scene,
        cells: usize,
        tissue: Tissue,
    ) -> Self {
        let [mut min, max] = mesh.bounds();
        let volume = mesh.volume();
        let free = scene.free_below_m - scene.fixed_below_m;
        let cell = free
            / (free / (volume / cells.max(1) as f64).cbrt())
                .round()
                .max(1.0);
        let start = &mut min[scene.axis];
        *start = scene.fixed_below_m - ((scene.fixed_below_m - *start) / cell).ceil() * cell;
        let field = Field::new(mesh, Grid::around([min, max], cell / 4.0, 2), Sign::Closed);
        let mut body = Self::new(&[], &[], &[], tissue);
        body.cell_m = cell as f32;
        let size = ((max - min) / cell).map(|n| n.ceil() as usize + 1);
        let mut numbers = std::collections::BTreeMap::new();
        for k in 0..size.z {
            for j in 0..size.y {
                for i in 0..size.x {
                    let low = min + nalgebra::Vector3::new(i as f64, j as f64, k as f64) * cell;
                    if field.at(&low.add_scalar(0.5 * cell)) >= 0.0 {
                        continue;
                    }
                    body.cells.push(std::array::from_fn(|c| {
                        let at = [i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)];
                        let place = at.map(|a| a as f64 * cell);
                        *numbers.entry(at).or_insert_with(|| {
                            let x = min + nalgebra::Vector3::from(place);
                            body.rest_m.push(x.cast());
                            body.rest_m.len() - 1
                        })
                    }));
                }
            }
        }
        // The cubes have the organ's mass, although their volume differs.
        let share = tissue.density_kg_m3 * volume / (8 * body.cells.len().max(1)) as f64;
        body.mass_kg = vec![0.0; body.rest_m.len()];
        for &n in body.cells.iter().flatten() {
            body.mass_kg[n] += share as f32;
        }
        body
    }

    /// Makes a body from sphere centres, the volume nearest to each, and tetrahedra with their
    /// volumes.
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
            radius_m: vec![0.0; centers.len()],
            mass_kg: share_m3
                .iter()
                .map(|v| (v * tissue.density_kg_m3) as f32)
                .collect(),
            tets: solid,
            edges: pairs.iter().map(edge).collect(),
            supported: Vec::new(),
            springs: Vec::new(),
            substeps: 1,
            tissue,
            cells: Vec::new(),
            cell_m: 0.0,
        }
    }

    /// Edge of a cube with the mean volume of a sphere's tissue, m.
    pub(crate) fn spacing_m(&self) -> f32 {
        let volume: f32 = self.mass_kg.iter().sum::<f32>() / self.tissue.density_kg_m3 as f32;
        (volume / self.rest_m.len().max(1) as f32).cbrt()
    }

    /// Force of the material on each sphere under these displacements, N: the sum of Calot's
    /// neo-Hookean tetrahedra and of the springs.
    pub(crate) fn pull_n(&self, u: &[V3]) -> Vec<V3> {
        let mu = STIFFNESS_SHARE * self.tissue.mu() as f32;
        let lambda = STIFFNESS_SHARE * self.tissue.lame() as f32 + mu;
        let mut pull = vec![V3::zeros(); u.len()];
        for tet in &self.tets {
            let f = Self::gradient(tet, |n| u[n]);
            let pressure = lambda * (f.determinant() - 1.0) - mu;
            let stress = f * mu + cofactor(&f) * pressure;
            for (slope, &n) in tet.slopes.iter().zip(&tet.nodes[1..]) {
                let force = stress * slope * tet.volume_m3;
                pull[n] -= force;
                pull[tet.nodes[0]] += force;
            }
        }
        for link in &self.springs {
            let [a, b] = [link.a as usize, link.b as usize];
            let across = self.rest_m[b] + u[b] - self.rest_m[a] - u[a];
            let stretch_m = across.norm() - link.rest_length_m;
            let force = across.normalize() * (stretch_m / link.compliance_m_n);
            pull[a] += force;
            pull[b] -= force;
        }
        pull
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
        for c in &self.cells {
            let at = |i: usize| self.rest_m[c[i]] + u[c[i]];
            // Mean edge of the cube along each axis.
            let edge = |bit: usize| -> V3 {
                let ends = (0..8).map(|i| if i >> bit & 1 == 1 { at(i) } else { -at(i) });
                ends.sum::<V3>() / 4.0
            };
            now += f64::from(edge(0).cross(&edge(1)).dot(&edge(2)));
            rest += f64::from(self.cell_m.powi(3));
        }
        for t in &self.tets {
            let volume = f64::from(t.volume_m3);
            now += volume * f64::from(Self::gradient(t, |n| u[n]).determinant());
            rest += volume;
        }
        now / rest - 1.0
    }
}
