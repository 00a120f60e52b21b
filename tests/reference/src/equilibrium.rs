//! Static equilibrium by Newton's method with line search, in load steps.

use crate::contact::{Contact, Tool};
use crate::element::{self, Element};
use crate::sparse::{HELD, System};
use crate::{FemError, Material, Mesh, Vec3};

/// Displacement as a function of the rest position and of the share of the load from 0 to 1, m.
pub type Motion<'a> = Box<dyn Fn(&Vec3, f64) -> Vec3 + 'a>;

/// Nodes whose displacement is prescribed.
pub struct Hold<'a> {
    /// The nodes.
    pub nodes: Vec<u32>,
    /// Axes along which the displacement is prescribed.
    pub axes: [bool; 3],
    /// Displacement of each node.
    pub motion_m: Motion<'a>,
}

impl<'a> Hold<'a> {
    /// Nodes that stay where they are.
    #[must_use]
    pub fn fixed(nodes: Vec<u32>) -> Self {
        Self::moved(nodes, |_, _| Vec3::zeros())
    }

    /// Nodes that are moved along all three axes.
    #[must_use]
    pub fn moved(nodes: Vec<u32>, motion_m: impl Fn(&Vec3, f64) -> Vec3 + 'a) -> Self {
        Self {
            nodes,
            axes: [true; 3],
            motion_m: Box::new(motion_m),
        }
    }

    /// Nodes that slide freely in the plane perpendicular to one axis.
    #[must_use]
    pub fn sliding(nodes: Vec<u32>, axis: usize) -> Self {
        Self {
            axes: [axis == 0, axis == 1, axis == 2],
            ..Self::fixed(nodes)
        }
    }
}

/// A boundary value problem: a body, its holds and its loads.
pub struct Problem<'a> {
    /// The body at rest.
    pub mesh: &'a Mesh,
    /// Material of the body.
    pub material: Material,
    /// Gravity, m/s². The solver multiplies it by the share of the load.
    pub gravity_m_s2: Vec3,
    /// Prescribed displacements. If several holds prescribe one degree of freedom, the last one
    /// counts.
    pub holds: Vec<Hold<'a>>,
    /// The tool that presses, if any.
    pub tool: Option<Tool<'a>>,
}

/// One equilibrium.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// Share of the load at this equilibrium.
    pub share: f64,
    /// Displacement of every node, m.
    pub displacement_m: Vec<Vec3>,
    /// Force that the holds exert on every node, N; zero on free degrees of freedom.
    pub reaction_n: Vec<Vec3>,
    /// Force on the tool, N.
    pub tool_force_n: Vec3,
    /// Torque on the tool about the world's origin, N m. See [`Solution::tool_torque_nm`].
    tool_moment_nm: Vec3,
    /// Elastic energy, J.
    pub energy_j: f64,
    /// Newton iterations since the last solution.
    pub iterations: usize,
}

impl Solution {
    /// Torque on the tool about a point of the world, N m.
    #[must_use]
    pub fn tool_torque_nm(&self, about_m: &Vec3) -> Vec3 {
        self.tool_moment_nm - about_m.cross(&self.tool_force_n)
    }
}

/// Largest unbalanced force that counts as equilibrium, as a share of the largest nodal force.
const TOLERANCE: f64 = 1e-7;
/// [`TOLERANCE`] between two augmentations of the contact pressures.
const AUGMENTATION_TOLERANCE: f64 = 1e-4;
const ITERATIONS_MAX: usize = 25;
const STEP_MIN: f64 = 1.0 / 1024.0;
/// Contact has converged when an augmentation would change the pressures by at most this share.
const PRESSURE_CHANGE: f64 = 5e-3;
const AUGMENTATIONS_MAX: usize = 5;

struct State {
    u: Vec<Vec3>,
    share: f64,
    iterations: usize,
}

struct Solver<'a, 'p> {
    problem: &'a Problem<'p>,
    elements: Vec<Element>,
    /// Mass that each node carries, kg.
    mass_kg: Vec<f64>,
    system: System,
    contact: Option<Contact>,
}

impl Problem<'_> {
    /// Finds the equilibrium at each of the `stops`: rising shares of the load. If Newton's method
    /// does not converge, the load step is halved. `progress` receives each share that was reached.
    ///
    /// # Errors
    /// See [`FemError`].
    pub fn solve(
        &self,
        stops: &[f64],
        progress: &mut dyn FnMut(f64),
    ) -> Result<Vec<Solution>, FemError> {
        match self.solve_as_far(stops, STEP_MIN, progress)? {
            (solutions, None) => Ok(solutions),
            (_, Some(failed)) => Err(failed),
        }
    }

    /// Solves like [`solve`](Self::solve), but gives up when the load step falls below
    /// `smallest_step` times the next stop. Returns the solutions found so far, and the error that
    /// ended the search.
    ///
    /// # Errors
    /// When the mesh cannot be prepared; see [`FemError`].
    pub fn solve_as_far(
        &self,
        stops: &[f64],
        smallest_step: f64,
        progress: &mut dyn FnMut(f64),
    ) -> Result<(Vec<Solution>, Option<FemError>), FemError> {
        let mut solver = Solver::new(self)?;
        let mut state = State {
            u: vec![Vec3::zeros(); self.mesh.nodes.len()],
            share: 0.0,
            iterations: 0,
        };
        let mut solutions = Vec::new();
        for &stop in stops {
            let mut step = stop - state.share;
            while state.share < stop {
                let next = if stop - state.share - step < 1e-9 {
                    stop
                } else {
                    state.share + step
                };
                match solver.advance(&mut state, next) {
                    Ok(()) => {
                        progress(next);
                        step *= 1.5;
                    }
                    Err(failed) => {
                        step /= 2.0;
                        if step < smallest_step * stop.abs() {
                            return Ok((solutions, Some(failed)));
                        }
                    }
                }
            }
            solutions.push(solver.solution(&mut state));
        }
        Ok((solutions, None))
    }
}

impl<'a, 'p> Solver<'a, 'p> {
    fn new(problem: &'a Problem<'p>) -> Result<Self, FemError> {
        let mesh = problem.mesh;
        if mesh.tets.is_empty() {
            return Err(FemError::NoElements { size_m: 0.0 });
        }
        let elements = element::prepare(&mesh.nodes, &mesh.tets)?;
        let mut mass_kg = vec![0.0; mesh.nodes.len()];
        for (e, t) in elements.iter().zip(&mesh.tets) {
            for p in &e.points {
                for (&n, value) in t.iter().zip(p.values) {
                    mass_kg[n as usize] += value * p.weight_m3 * problem.material.density_kg_m3;
                }
            }
        }
        let mut held = vec![false; 3 * mesh.nodes.len()];
        for hold in &problem.holds {
            for &n in &hold.nodes {
                for axis in (0..3).filter(|&i| hold.axes[i]) {
                    held[3 * n as usize + axis] = true;
                }
            }
        }
        let young = problem.material.young_pa;
        Ok(Self {
            problem,
            elements,
            mass_kg,
            system: System::new(mesh, &held)?,
            contact: problem
                .tool
                .as_ref()
                .map(|tool| Contact::new(mesh, tool, young)),
        })
    }

    fn shift(&self, share: f64) -> Vec3 {
        self.problem
            .tool
            .as_ref()
            .map_or_else(Vec3::zeros, |tool| (tool.shift_m)(share))
    }

    /// Prescribed displacements at a share of the load, minus the present ones.
    fn remaining_motion(&self, u: &[Vec3], share: f64) -> Vec<Vec3> {
        let mut remaining_motion = vec![Vec3::zeros(); u.len()];
        for hold in &self.problem.holds {
            for &n in &hold.nodes {
                let n = n as usize;
                let target = (hold.motion_m)(&self.problem.mesh.nodes[n], share);
                for axis in (0..3).filter(|&i| hold.axes[i]) {
                    remaining_motion[n][axis] = target[axis] - u[n][axis];
                }
            }
        }
        remaining_motion
    }

    fn energy(&self, u: &[Vec3], share: f64) -> f64 {
        let problem = self.problem;
        let parts = self.elements.iter().zip(&problem.mesh.tets);
        let elastic: f64 = parts.map(|(e, t)| e.energy(&problem.material, t, u)).sum();
        let weight = problem.gravity_m_s2 * share;
        let work_of_weight: f64 = self
            .mass_kg
            .iter()
            .zip(u)
            .map(|(m, u)| m * weight.dot(u))
            .sum();
        let rest = &problem.mesh.nodes;
        let contact = self
            .contact
            .as_ref()
            .map_or(0.0, |c| c.energy(rest, u, &self.shift(share)));
        elastic - work_of_weight + contact
    }

    /// Unbalanced force of every node (the gradient of the energy), and the largest elastic nodal
    /// force, N.
    fn residual(&self, u: &[Vec3], share: f64) -> (Vec<Vec3>, f64) {
        let problem = self.problem;
        let mut r = vec![Vec3::zeros(); u.len()];
        for (e, t) in self.elements.iter().zip(&problem.mesh.tets) {
            let force = e.force(&problem.material, t, u);
            for (a, &n) in t.iter().enumerate() {
                r[n as usize] += force.fixed_rows::<3>(3 * a);
            }
        }
        let elastic = r.iter().map(|r| r.amax()).fold(0.0, f64::max);
        for (r, mass) in r.iter_mut().zip(&self.mass_kg) {
            *r -= problem.gravity_m_s2 * (mass * share);
        }
        if let Some(contact) = &self.contact {
            let shift = self.shift(share);
            for force in contact.contact_forces(&problem.mesh.nodes, u, &shift, true) {
                for (&n, s) in force.nodes.iter().zip(force.shares) {
                    r[n as usize] -= force.force_n * s;
                }
            }
        }
        (r, elastic)
    }

    /// Assembles the stiffness. Returns the nodal forces that the prescribed displacement `step`
    /// adds to the residual.
    fn assemble(
        &mut self,
        u: &[Vec3],
        share: f64,
        step: Option<&[Vec3]>,
        convex: bool,
    ) -> Vec<Vec3> {
        let mut added = vec![Vec3::zeros(); u.len()];
        let problem = self.problem;
        self.system.clear();
        for (i, (e, t)) in self.elements.iter().zip(&problem.mesh.tets).enumerate() {
            let k = e.stiffness(&problem.material, t, u, convex);
            self.system.add_element(i, &k);
            if let Some(step) = step {
                let mut local = element::Force30::zeros();
                for (a, &n) in t.iter().enumerate() {
                    local
                        .fixed_rows_mut::<3>(3 * a)
                        .copy_from(&step[n as usize]);
                }
                if local.amax() > 0.0 {
                    let force = k * local;
                    for (a, &n) in t.iter().enumerate() {
                        added[n as usize] += force.fixed_rows::<3>(3 * a);
                    }
                }
            }
        }
        if let Some(contact) = &self.contact {
            let shift = self.shift(share);
            for force in contact.contact_forces(&problem.mesh.nodes, u, &shift, convex) {
                for (&a, sa) in force.nodes.iter().zip(force.shares) {
                    for (&b, sb) in force.nodes.iter().zip(force.shares) {
                        for i in 0..3 {
                            for j in 0..3 {
                                let row = self.system.unknown[3 * a as usize + i];
                                let column = self.system.unknown[3 * b as usize + j];
                                self.system
                                    .add(row, column, sa * sb * force.stiffness[(i, j)]);
                            }
                        }
                    }
                }
            }
        }
        added
    }

    fn free_entries(&self, nodal: &[Vec3]) -> Vec<f64> {
        let mut free = vec![0.0; self.system.count];
        for (dof, &unknown) in self.system.unknown.iter().enumerate() {
            if unknown != HELD {
                free[unknown as usize] = nodal[dof / 3][dof % 3];
            }
        }
        free
    }

    fn displaced(&self, u: &[Vec3], step: &[f64], by: f64) -> Vec<Vec3> {
        let mut displaced = u.to_vec();
        for (dof, &unknown) in self.system.unknown.iter().enumerate() {
            if unknown != HELD {
                displaced[dof / 3][dof % 3] += by * step[unknown as usize];
            }
        }
        displaced
    }

    /// A descent direction: the Newton step. If its matrix is not positive definite, the step with
    /// a stiffness without negative curvature.
    fn direction(
        &mut self,
        u: &[Vec3],
        share: f64,
        prescribed: Option<&[Vec3]>,
    ) -> Option<Vec<f64>> {
        let (residual, _) = self.residual(u, share);
        for (convex, shift) in [(false, 0.0), (true, 0.0), (true, 1e-4), (true, 1e-1)] {
            let added = self.assemble(u, share, prescribed, convex);
            let total: Vec<Vec3> = residual.iter().zip(&added).map(|(r, a)| -(r + a)).collect();
            if shift > 0.0 {
                self.system.shift(shift);
            }
            if let Some(step) = self.system.solve(&self.free_entries(&total)) {
                return Some(step);
            }
        }
        None
    }

    /// Advances the state to a larger share of the load. On failure, the state stays as it was.
    fn advance(&mut self, state: &mut State, share: f64) -> Result<(), FemError> {
        let pressures = self.contact.as_ref().map(Contact::pressures);
        let before = state.u.clone();
        let done = self.try_advance(state, share);
        if done.is_ok() {
            state.share = share;
        } else {
            state.u = before;
            if let (Some(contact), Some(pressures)) = (&mut self.contact, pressures) {
                contact.restore(&pressures);
            }
        }
        done
    }

    fn try_advance(&mut self, state: &mut State, share: f64) -> Result<(), FemError> {
        let failed = FemError::NoEquilibrium {
            reached: state.share,
            residual_n: f64::NAN,
            iterations: 0,
        };
        // First, a linear step moves the free nodes along with the prescribed ones.
        let remaining_motion = self.remaining_motion(&state.u, share);
        let step = self
            .direction(&state.u, share, Some(&remaining_motion))
            .ok_or_else(|| failed.clone())?;
        let mut u = self.displaced(&state.u, &step, 1.0);
        for (u, remaining_motion) in u.iter_mut().zip(&remaining_motion) {
            *u += remaining_motion;
        }
        state.iterations += 1;
        let (shift, rest) = (self.shift(share), &self.problem.mesh.nodes);
        // If contact has not converged after the last augmentation, the remaining penetration is
        // small.
        for _ in 0..AUGMENTATIONS_MAX {
            if self.contact.is_none() {
                break;
            }
            self.equilibrate(&mut u, share, AUGMENTATION_TOLERANCE, state)?;
            let contact = self.contact.as_mut();
            if contact.is_none_or(|it| it.converged_or_augment(rest, &u, &shift, PRESSURE_CHANGE)) {
                break;
            }
        }
        self.equilibrate(&mut u, share, TOLERANCE, state)?;
        state.u = u;
        Ok(())
    }

    fn equilibrate(
        &mut self,
        u: &mut Vec<Vec3>,
        share: f64,
        tolerance: f64,
        state: &mut State,
    ) -> Result<(), FemError> {
        let mut energy = self.energy(u, share);
        let mut largest = f64::NAN;
        for iteration in 0..ITERATIONS_MAX {
            let failed = FemError::NoEquilibrium {
                reached: state.share,
                residual_n: largest,
                iterations: iteration,
            };
            let (residual, elastic) = self.residual(u, share);
            let free = self.free_entries(&residual);
            largest = free.iter().fold(0.0, |m: f64, r| m.max(r.abs()));
            if largest <= tolerance * elastic.max(self.smallest_force()) {
                return Ok(());
            }
            let step = self
                .direction(u, share, None)
                .ok_or_else(|| failed.clone())?;
            state.iterations += 1;
            let slope: f64 = free.iter().zip(&step).map(|(r, s)| r * s).sum();
            let mut by = 1.0;
            loop {
                let trial = self.displaced(u, &step, by);
                let reached = self.energy(&trial, share);
                // Near equilibrium the energy changes by less than its rounding error. Then the
                // largest unbalanced force must fall instead.
                let lower = reached <= energy + 1e-4 * by * slope;
                let flat = (reached - energy).abs() <= 1e-11 * energy.abs() && {
                    let r = self.free_entries(&self.residual(&trial, share).0);
                    r.iter().all(|r| r.abs() < largest)
                };
                if lower || flat {
                    (*u, energy) = (trial, reached);
                    break;
                }
                by /= 2.0;
                if by < 1e-6 {
                    return Err(failed);
                }
            }
        }
        Err(FemError::NoEquilibrium {
            reached: state.share,
            residual_n: largest,
            iterations: ITERATIONS_MAX,
        })
    }

    /// Tolerances refer to the largest elastic nodal force, or to this force if it is larger, N.
    fn smallest_force(&self) -> f64 {
        let volume: f64 = self
            .elements
            .iter()
            .flat_map(|e| &e.points)
            .map(|p| p.weight_m3)
            .sum();
        let element_m = (volume / self.elements.len() as f64).cbrt();
        1e-5 * self.problem.material.young_pa * element_m * element_m
    }

    fn solution(&self, state: &mut State) -> Solution {
        let problem = self.problem;
        let (mut reaction_n, _) = self.residual(&state.u, state.share);
        for (dof, &unknown) in self.system.unknown.iter().enumerate() {
            if unknown != HELD {
                reaction_n[dof / 3][dof % 3] = 0.0;
            }
        }
        let shift = self.shift(state.share);
        let rest = &problem.mesh.nodes;
        let (mut tool_force_n, mut tool_moment_nm) = (Vec3::zeros(), Vec3::zeros());
        if let Some(contact) = &self.contact {
            for force in contact.contact_forces(rest, &state.u, &shift, true) {
                tool_force_n -= force.force_n;
                tool_moment_nm -= force.at_m.cross(&force.force_n);
            }
        }
        let parts = self.elements.iter().zip(&problem.mesh.tets);
        Solution {
            share: state.share,
            reaction_n,
            tool_force_n,
            tool_moment_nm,
            energy_j: parts
                .map(|(e, t)| e.energy(&problem.material, t, &state.u))
                .sum(),
            iterations: std::mem::take(&mut state.iterations),
            displacement_m: state.u.clone(),
        }
    }
}
