//! Adapts `rt_core::study::Tissue`, which runs Calot's own solvers, to the [`Method`] trait.

use rt_core::math::Pose;
use rt_core::scene::{
    Inside, Link, Material, Organ, RestSphere, Room, SUBSTEPS_MAX, Scene, SceneError, Skin, Tetra,
    TetraBatch, Trocar, batches,
};
use rt_core::study::Tissue;
use rt_core::tissue::paper::Paper;
use rt_core::tissue::{Bodies, Method as Solver};

use rt_core::time::TICK_S;
use rt_core::tool::{Capsule, Role};
use scene_prepare::skin::ContactSkin;

use super::{Ball, Env, Method, State, Surroundings};
use crate::body::{Body, V3};

/// Scene data and solver storage that a [`Tissue`] borrows.
pub(crate) struct Parts {
    bodies: Box<Bodies>,
    /// Storage of the paper's method; `None`: the neo-Hookean solid.
    paper: Option<Box<Paper>>,
    plan: Plan,
}

/// Contents of a scene of one organ.
struct Plan {
    organs: [Organ; 1],
    spheres: Vec<RestSphere>,
    links: Vec<Link>,
    batches: Vec<TetraBatch>,
    gravity_m_s2: V3,
    skin: ContactSkin,
}

impl Plan {
    /// Makes the scene. The instrument's port is at x = y = 0, z = 0.2 m.
    ///
    /// # Errors
    /// The scene is invalid.
    fn scene(&self) -> Result<Scene<'_>, SceneError> {
        let room = Room {
            gravity_m_s2: self.gravity_m_s2,
            world_from_device: Pose::identity(),
            world_from_tracker: Pose::identity(),
            instrument_port_m: V3::new(0.0, 0.0, 0.2),
            instrument_length_m: 0.33,
            endoscope_port_m: V3::new(0.1, 0.0, 0.2),
            world_from_camera: Pose::identity(),
            breath_s: 0.0,
            trocar: Trocar::NONE,
        };
        Scene::new(&self.organs, &self.spheres, &self.links, room)?
            .with_tetrahedra(&self.batches)?
            .with_skin(Skin {
                vertices: &self.skin.vertices,
                fans: &self.skin.fans,
                nearest: &self.skin.nearest,
            })
    }
}

/// Largest dimensionless stiffness `E dt² / (ρ h²)` for which one solver pass per substep gives the
/// material's stiffness within 3 %. `dt` is the length of the substep, s, and `h` the spacing of
/// the spheres, m.
const STIFFNESS_NUMBER_MAX: f64 = 0.2;
/// Largest number of a tube: the core knows what one pass adds to the compliance of its links.
const TUBE_STIFFNESS_NUMBER_MAX: f64 = 2.4;

impl Parts {
    /// Makes a scene of one organ. `paper`: stiffness and iterations of the paper's method; `None`:
    /// neo-Hookean.
    ///
    /// # Errors
    /// A tetrahedron is invalid.
    pub(crate) fn new(
        body: &Body,
        around: &Surroundings,
        paper: Option<(f32, u32)>,
    ) -> Result<Self, SceneError> {
        let is_held = |i: usize| body.supported.get(i).copied().unwrap_or(false);
        let spheres: Vec<RestSphere> = body
            .rest_m
            .iter()
            .zip(&body.mass_kg)
            .enumerate()
            .map(|(i, (x, mass))| RestSphere {
                center_m: *x,
                radius_m: if body.supported.is_empty() {
                    0.5 * body.spacing_m()
                } else {
                    body.radius_m[i]
                },
                mass_kg: *mass,
                held: is_held(i),
            })
            .collect();
        let link = |e: &crate::body::Edge| Link {
            a: e.nodes[0] as u32,
            b: e.nodes[1] as u32,
            rest_length_m: e.length_m,
            compliance_m_n: 1.0 / super::edge_stiffness(body, e),
        };
        let links: Vec<Link> = if paper.is_some() {
            body.edges.iter().map(link).collect()
        } else {
            body.springs.clone()
        };
        let tets: Vec<Tetra> = body
            .tets
            .iter()
            .map(|t| Tetra {
                spheres: t.nodes.map(|n| n as u32),
                volume_m3: t.volume_m3,
            })
            .collect();
        let mut packed = Vec::new();
        batches(&tets, &spheres, |batch| packed.push(batch))?;
        let h = f64::from(body.spacing_m());
        let number = body.tissue.young_pa * 1e-6 / (body.tissue.density_kg_m3 * h * h);
        let number_max = match body.tets.is_empty() {
            true => TUBE_STIFFNESS_NUMBER_MAX,
            false => STIFFNESS_NUMBER_MAX,
        };
        let substeps = (number / number_max).sqrt().ceil() as u32;
        let (stiffness, iterations) = paper.unwrap_or((1.0, 1));
        let organ = Organ {
            sphere_start: 0,
            sphere_count: spheres.len() as u32,
            link_start: 0,
            link_count: links.len() as u32,
            elastic_links: if paper.is_some() {
                0
            } else {
                links.len() as u32
            },
            batch_start: 0,
            batch_count: packed.len() as u32,
            substeps: if paper.is_some() {
                1
            } else {
                let substeps = substeps.max(body.substeps).clamp(1, SUBSTEPS_MAX);
                substeps.next_power_of_two()
            },
            gravity_share: 1.0,
            breath_m: V3::zeros(),
            inside: Inside::Solid,
            material: Material {
                young_pa: body.tissue.young_pa as f32,
                poisson: body.tissue.poisson as f32,
                retardation_s: body.tissue.retardation_s() as f32,
                stretch_stiffness: stiffness,
                laplacian_stiffness: stiffness,
                damping_per_s: around.damping_per_s,
                contact_stiffness_n_m: 500.0,
                friction: 0.0,
                toughness_j_m2: 0.0,
            },
        };
        Ok(Self {
            bodies: Box::default(),
            paper: paper.map(|_| Box::new(Paper::new(iterations))),
            plan: Plan {
                organs: [organ],
                spheres,
                links,
                batches: packed,
                gravity_m_s2: around.gravity_m_s2,
                skin: ContactSkin::default(),
            },
        })
    }

    /// Gives the organ this many times the product's substeps.
    pub(crate) fn finer(mut self, times: u32) -> Self {
        for organ in &mut self.plan.organs {
            organ.substeps = (organ.substeps * times).min(SUBSTEPS_MAX);
        }
        self
    }

    /// Removes the tissue's viscosity.
    pub(crate) fn without_viscosity(mut self) -> Self {
        for organ in &mut self.plan.organs {
            organ.material.retardation_s = 0.0;
        }
        self
    }

    /// Adds the contact skin, against which tools collide.
    pub(crate) fn with_skin(mut self, skin: ContactSkin) -> Self {
        self.plan.skin = skin;
        self
    }

    /// The tissue at rest, as a [`Method`].
    ///
    /// # Errors
    /// The scene is invalid.
    pub(crate) fn tissue(&mut self) -> Result<Product<'_>, SceneError> {
        let held = self.plan.spheres.iter().map(|s| s.held).collect();
        let has_skin = !self.plan.skin.vertices.is_empty();
        let tissue = self.bare()?;
        Ok(Product {
            tissue,
            held,
            has_skin,
        })
    }

    /// Gives every sphere this radius, m.
    pub(crate) fn widen(&mut self, radius_m: f32) {
        for sphere in &mut self.plan.spheres {
            sphere.radius_m = radius_m;
        }
    }

    /// Sets the stiffness between a tool and a sphere, N/m.
    pub(crate) fn meet_with(&mut self, contact_stiffness_n_m: f32) {
        for organ in &mut self.plan.organs {
            organ.material.contact_stiffness_n_m = contact_stiffness_n_m;
        }
    }

    /// The spheres at rest.
    pub(crate) fn spheres(&self) -> &[RestSphere] {
        &self.plan.spheres
    }

    /// The scene. The instrument's port is at x = y = 0, z = 0.2 m.
    ///
    /// # Errors
    /// The scene is invalid.
    pub(crate) fn scene(&self) -> Result<Scene<'_>, SceneError> {
        self.plan.scene()
    }

    /// The tissue at rest, without the wrapper of a [`Method`].
    ///
    /// # Errors
    /// The scene is invalid.
    pub(crate) fn bare(&mut self) -> Result<Tissue<'_>, SceneError> {
        let scene = self.plan.scene()?;
        let solver = match &mut self.paper {
            Some(paper) => Solver::Paper(paper),
            None => Solver::NeoHookean,
        };
        Ok(Tissue::new(scene, &mut self.bodies, solver))
    }
}

/// Calot's tissue as a method. Its tick is always 1 ms.
pub(crate) struct Product<'a> {
    tissue: Tissue<'a>,
    held: Vec<bool>,
    has_skin: bool,
}

impl Method for Product<'_> {
    fn step(&mut self, body: &Body, state: &mut State, _: &Env) {
        for (i, held) in (0_u32..).zip(&mut self.held) {
            let n = i as usize;
            let wanted = state.w_per_kg[n] <= 0.0;
            if wanted != *held {
                self.tissue.hold(i, wanted);
                *held = wanted;
            }
            if wanted {
                self.tissue.lead(i, &state.target_m[n]);
            } else if state.is_edited {
                self.tissue.put(i, &state.u_m[n], &state.v_m_s[n]);
            }
        }
        state.is_edited = false;
        let force = match state.ball.filter(|_| self.has_skin) {
            Some(ball) => {
                let pressed = self.tissue.press(&[ball.as_tip()]);
                state.put_back += pressed.quarantined;
                pressed.force_n
            }
            None => self.step_against_spheres(body, state),
        };
        state.feel(&force);
        for (i, (u, v)) in (0_u32..).zip(state.u_m.iter_mut().zip(&mut state.v_m_s)) {
            *u = self.tissue.displacement_m(i);
            *v = self.tissue.velocity_m_s(i);
        }
    }
}

impl Product<'_> {
    /// Advances one tick. Each substep projects free spheres out of the ball. Returns the force on
    /// the ball, N.
    fn step_against_spheres(&mut self, body: &Body, state: &mut State) -> V3 {
        let (ball, mut force) = (state.ball, V3::zeros());
        state.put_back += self.tissue.step_with(|tissue, step_s| {
            let Some(ball) = ball else { return };
            for (i, (radius, mass)) in (0_u32..).zip(body.radius_m.iter().zip(&body.mass_kg)) {
                let free = tissue.inverse_mass_per_kg(i) > 0.0;
                let push = ball.pushes(&tissue.center_m(i), *radius);
                if let Some(step) = push.filter(|_| free) {
                    tissue.move_by(i, &step);
                    force -= step * (mass / (step_s * TICK_S));
                }
            }
        });
        force
    }
}

impl Ball {
    /// Capsule of zero length at the ball, with its radius.
    fn as_tip(self) -> Capsule {
        Capsule {
            a_m: self.center_m,
            b_m: self.center_m,
            radius_m: self.radius_m,
            role: Role::Tip,
        }
    }
}
