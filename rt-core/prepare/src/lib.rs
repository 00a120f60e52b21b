//! Preparation: organ meshes and a scene recipe in, a compiled scene out.
//!
//! ```text
//! recipe (TOML) ─ mesh files or built-in shapes
//!   → mesh      welded, oriented, closed or wrapped            mesh::, shape::
//!   → field     signed distance on a grid                      field::
//!   → spheres   packed inside the skin                         pack::
//!   → links     one component, ordered for the solver          links
//!   → binding   which spheres move which skin vertex           bind
//!   → cells     fat and connective tissue in layers             cells
//!   → room      ports, frames, the scripted hand's target      room
//!   → SceneData and a quality report
//! ```
//!
//! Offline: it may allocate and use threads, but the same recipe and meshes give the same bytes
//! on any number of threads. Lengths are metres, everything is computed in `f64`.

pub mod cost;
pub mod delaunay;
mod elastic;
pub mod error;
pub mod field;
pub mod mesh;
pub mod recipe;
pub mod report;
pub mod shape;

mod attach;
pub mod bind;
mod budget;
mod cells;
pub mod held;
pub mod links;
pub mod order;
pub mod pack;
mod prepare;
pub mod room;
pub mod skin;
mod steady;
mod surface_nets;
pub mod tetra;

pub use cells::Filling;
pub use error::{MeshError, PrepareError, RecipeError};
pub use prepare::{Prepared, Progress, prepare};
pub use recipe::Recipe;
pub use report::Report;

/// A point or direction, metres.
pub type Vec3 = nalgebra::Vector3<f64>;
