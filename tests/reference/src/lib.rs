//! The reference against which the fast solvers are measured: static equilibrium of a neo-Hookean
//! body by finite elements, verified against closed forms (`tests/`).
//!
//! ```text
//! mesh::graded / lattice / block / …     quadratic tetrahedra
//! Material                               energy, stress, stiffness (SI)
//! Problem { holds, gravity, tool }       a body, its holds and loads
//! Problem::solve, solve_as_far           Newton, line search, load steps, sparse Cholesky
//! Locator                                the answer at any point
//! ```
//!
//! Positions and displacements are in metres in one right-handed frame, forces in newtons. The
//! solver uses one thread and a fixed order: the same input gives the same bits on the same
//! machine.

mod contact;
mod element;
mod equilibrium;
mod error;
mod material;
pub mod mesh;
mod sparse;

pub use contact::{Bar, Tool};
pub use equilibrium::{Hold, Motion, Problem, Solution};
pub use error::FemError;
pub use material::Material;
pub use mesh::{Locator, Mesh, block, graded, lattice, shell_octant};

/// A point or direction.
pub type Vec3 = nalgebra::Vector3<f64>;
