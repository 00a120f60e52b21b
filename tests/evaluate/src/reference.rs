//! The answer by finite elements.

use fem_reference::{FemError, Hold, Locator, Material, Mesh, Problem, lattice};
use nalgebra::Vector3;
use scene_prepare::field::{Field, Grid, Sign};

use crate::body::{Body, Tissue};
use crate::scene::{Kind, Scene};

type Point = Vector3<f64>;

/// What a scene ends in, at the spheres' centres.
pub(crate) struct Answer {
    /// Displacement of each sphere's centre, m.
    pub(crate) displacement_m: Vec<Point>,
    /// [`Scene::load`].
    pub(crate) load: f64,
    /// Relative growth of the volume.
    pub(crate) growth: f64,
}

/// Fills a closed surface with elements of about `size_m`.
pub(crate) fn mesh(surface: &scene_prepare::mesh::Mesh, size_m: f64) -> Result<Mesh, FemError> {
    let [min, max] = surface.bounds();
    let field = Field::new(
        surface,
        Grid::around([min, max], size_m / 6.0, 6),
        Sign::Closed,
    );
    lattice(min, max, size_m, |p| field.at(p))
}

/// The finite-element solution of a scene, before it is asked at any sphere.
pub(crate) struct Solved<'a> {
    mesh: &'a Mesh,
    displacement_m: Vec<Point>,
    load: f64,
    growth: f64,
}

/// Solves a scene. `progress` hears the share of the load that is carried.
pub(crate) fn solve<'a>(
    mesh: &'a Mesh,
    scene: &Scene,
    tissue: &Tissue,
    progress: &mut dyn FnMut(f64),
) -> Result<Solved<'a>, FemError> {
    let problem = Problem {
        mesh,
        material: Material::new(tissue.young_pa, tissue.poisson, tissue.density_kg_m3)?,
        gravity_m_s2: scene.gravity(),
        holds: vec![Hold::moved(
            mesh.nodes_where(|p| scene.is_held(p)),
            |p, share| scene.motion(p, share),
        )],
        tool: None,
    };
    let steps = if scene.kind == Kind::Twist { 5 } else { 3 };
    let stops: Vec<f64> = (1..=steps)
        .map(|i| f64::from(i) / f64::from(steps))
        .collect();
    let mut solutions = problem.solve(&stops, progress)?;
    let Some(end) = solutions.pop() else {
        return Err(FemError::NoElements { size_m: 0.0 });
    };
    let nodes = mesh
        .nodes
        .iter()
        .zip(&end.displacement_m)
        .zip(&end.reaction_n);
    let load = scene.load(nodes.map(|((x, u), r)| (*x, *u, -r)));
    let growth = mesh.volume_m3(Some(&end.displacement_m))? / mesh.volume_m3(None)? - 1.0;
    Ok(Solved {
        mesh,
        displacement_m: end.displacement_m,
        load,
        growth,
    })
}

impl Solved<'_> {
    /// The answer at a body's sphere centres.
    pub(crate) fn at(&self, body: &Body) -> Answer {
        let locator = Locator::new(self.mesh);
        let value = |x: &crate::body::V3| {
            let place = locator.find(&x.cast());
            place.map_or_else(Point::zeros, |p| locator.value(&p, &self.displacement_m))
        };
        Answer {
            displacement_m: body.rest_m.iter().map(value).collect(),
            load: self.load,
            growth: self.growth,
        }
    }
}
