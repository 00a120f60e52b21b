//! Solves the scenes by finite elements.

use fem_reference::{FemError, Hold, Locator, Material, Mesh, Problem, Tool, lattice};
use nalgebra::Vector3;
use scene_prepare::field::{Field, Grid, Nearest, Sign};

use crate::body::{Body, Tissue, V3};
use crate::focus::{Focus, ON_PLANE_M, fill};
use crate::scene::{Kind, Press, Scene};

type Point = Vector3<f64>;

/// Final state of a scene at the spheres' centres.
pub(crate) struct Answer {
    /// Displacement of each sphere's centre, m; `None` for a mesh without elements.
    pub(crate) displacement_m: Vec<Option<Point>>,
    /// Load of the scene ([`Scene::load`]), or the force on the ball.
    pub(crate) load: f64,
    /// Relative growth of the volume.
    pub(crate) growth: f64,
}

/// Solution of a scene. It gives an [`Answer`] for any spheres.
pub(crate) struct Solved {
    mesh: Mesh,
    displacement_m: Vec<Point>,
    /// Load of the scene ([`Scene::load`]), or the force on the ball.
    pub(crate) load: f64,
    /// Relative growth of the volume.
    pub(crate) growth: f64,
}

/// Fills a closed surface with elements. A layer of corners lies on each of the scene's two planes,
/// with `layers` spaces between the planes. Otherwise the hold would end at the next layer beside
/// the plane.
pub(crate) fn mesh(
    surface: &scene_prepare::mesh::Mesh,
    scene: &Scene,
    layers: usize,
) -> Result<Mesh, FemError> {
    let bounds = surface.bounds();
    let [mut min, max] = bounds;
    let space = (scene.free_below_m - scene.fixed_below_m) / layers as f64;
    let size = 2.0 * space;
    let field = Field::new(
        surface,
        Grid::around(bounds, cell_m(bounds, size), 8),
        Sign::Closed,
    );
    // The lattice starts 1.5 sizes before `min`.
    let start = min[scene.axis] - 1.5 * size;
    let before = ((scene.fixed_below_m - start) / space).ceil();
    min[scene.axis] = scene.fixed_below_m - before * space + 1.5 * size;
    let mut mesh = lattice(min, max, size, |p| field.at(p))?;
    // Straight edges between surface nodes lie inside the body. They would make it too small, with
    // an error of second order in the element size. So they are curved.
    if let Some(nearest) = Nearest::new(surface) {
        mesh.curve_boundary(|p| nearest.point(p));
    }
    Ok(mesh)
}

/// Fills the free part of a closed surface: the part above the plane of the hold. Elements are
/// small where a ball presses: the radius of the ball's contact is `layers / CONTACT_LAYERS`
/// elements long.
fn pressed_mesh(
    surface: &scene_prepare::mesh::Mesh,
    scene: &Scene,
    press: &Press,
    layers: usize,
) -> Result<Mesh, FemError> {
    let bounds = surface.bounds();
    let field = Field::new(
        surface,
        Grid::around(bounds, cell_m(bounds, 0.0), 4),
        Sign::Closed,
    );
    let focus = Focus {
        lines: vec![[press.site_m; 2]],
        least_m: LEAST_RADII * press.radius_m,
        most_m: press.radius_m,
        share: CONTACT_LAYERS / layers as f64,
        largest_m: LARGEST * (bounds[1] - bounds[0]).min(),
    };
    fill(surface, &field, &focus, (scene.axis, scene.fixed_below_m))
}

/// Number of `layers` for which an element is as long as the contact's radius.
const CONTACT_LAYERS: f64 = 3.0;
/// Radius of the smallest contact that the mesh resolves, in radii of the ball.
const LEAST_RADII: f64 = 0.7;
/// Size of elements far from the ball, as a share of the organ's smallest extent.
const LARGEST: f64 = 0.15;

/// Edge of the cells of the grid that stores the distance to the surface, m.
fn cell_m([min, max]: [Point; 2], size_m: f64) -> f64 {
    (size_m / 6.0).max((max - min).max() / 200.0)
}

/// Prints the progress of a solution to standard error.
pub(crate) fn tell(share: f64) {
    eprintln!("  reference: {:.1} % of the load", share * 100.0);
}

/// Solves a scene. Without a ball, `layers` layers of elements lie between the scene's planes; with
/// a ball, see [`CONTACT_LAYERS`]. `progress` receives each reached share of the load.
pub(crate) fn solve(
    surface: &scene_prepare::mesh::Mesh,
    scene: &Scene,
    tissue: &Tissue,
    layers: usize,
    progress: &mut dyn FnMut(f64),
) -> Result<Solved, FemError> {
    let mesh = match &scene.press {
        Some(press) => pressed_mesh(surface, scene, press, layers)?,
        None => mesh(surface, scene, layers)?,
    };
    let is_fixed = |p: &Point| match scene.press {
        Some(_) => p[scene.axis] < scene.fixed_below_m + ON_PLANE_M,
        None => scene.is_fixed(p),
    };
    eprintln!("  reference: {} nodes", mesh.nodes.len());
    let problem = Problem {
        mesh: &mesh,
        material: Material::new(tissue.young_pa, tissue.poisson, tissue.density_kg_m3)?,
        gravity_m_s2: scene.gravity(),
        holds: vec![
            Hold::fixed(mesh.nodes_where(is_fixed)),
            Hold::moved(mesh.nodes_where(|p| scene.is_moved(p)), |p, share| {
                scene.motion(p, share)
            }),
        ],
        tool: scene.press.map(|press| {
            let near = |p: &Point| (p - press.site_m).norm() < 4.0 * press.radius_m + 0.003;
            let path = move |share| press.center_m(share);
            Tool::ball(press.radius_m, path, mesh.faces_where(near))
        }),
    };
    let steps = match scene.kind {
        Kind::Twist(degrees) => u32::from(degrees) / 18,
        Kind::Press(..) => 6,
        _ => 3,
    };
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
    let load = if scene.press.is_some() {
        end.tool_force_n.norm()
    } else {
        scene.load(nodes.map(|((x, u), r)| (scene.is_moved(x), *x, *u, -r)))
    };
    let grown_m3 = mesh.volume_m3(Some(&end.displacement_m))? - mesh.volume_m3(None)?;
    // In a press, the held tissue below the plane is not in the mesh.
    let growth = grown_m3 / surface.volume();
    drop(problem);
    Ok(Solved {
        mesh,
        displacement_m: end.displacement_m,
        load,
        growth,
    })
}

impl Solved {
    /// Number of nodes of the mesh.
    pub(crate) fn nodes(&self) -> usize {
        self.mesh.nodes.len()
    }

    /// Displacement at points, m, extrapolated outside the mesh.
    pub(crate) fn displacement_m(&self, points: &[V3]) -> Vec<Option<Point>> {
        let locator = Locator::new(&self.mesh);
        let value = |x: &V3| {
            let place = locator.find(&x.cast())?;
            Some(locator.value(&place, &self.displacement_m))
        };
        points.iter().map(value).collect()
    }

    /// The solution at a body's sphere centres.
    pub(crate) fn at(&self, body: &Body) -> Answer {
        Answer {
            displacement_m: self.displacement_m(&body.rest_m),
            load: self.load,
            growth: self.growth,
        }
    }
}
