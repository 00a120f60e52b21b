//! Reference solutions for the fast solvers: static equilibrium of a neo-Hookean body by finite
//! elements. Tests compare it with closed forms (`tests/`).
//!
//! ```text
//! mesh::graded / lattice / block / …     quadratic tetrahedra
//! Material                               energy, stress, stiffness (SI)
//! Problem { holds, gravity, tool }       a body, its holds and its loads
//! Problem::solve, solve_as_far           Newton, line search, load steps, sparse Cholesky
//! Locator                                the solution at any point
//! ```
//!
//! Positions and displacements are in metres in one right-handed frame, forces in newtons. The
//! solver uses one thread and a fixed order of operations: on one machine, equal inputs give
//! bit-identical results.

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
