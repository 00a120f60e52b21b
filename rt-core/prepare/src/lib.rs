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
//!
//! # Held tissue
//!
//! Where a recipe holds an organ beyond a plane, preparation moves the spheres nearest to it onto
//! it. What deforms ends there, whatever the number of spheres.
//!
//! # How far spheres spread a force
//!
//! The spheres yield to a force on one vertex by `c_patch`, and to the same force spread over a
//! Gaussian of the skin by `c_wide`. They are fine enough for the latter; on a half-space it would
//! be `0.399 / (E* A)` locally. So what they yield to the vertex, locally, is
//! `c = c_patch − c_wide + 0.399 / (E* A)`, and they act as if they spread the force over a patch
//! of `0.399 / (E* c)`. Whatever is far away is in both and cancels, so a neighbourhood of a few
//! spacings is enough.
//!
//! # Layered tissue
//!
//! Cross-sections stand across the course of what fat and connective tissue lie around. Rays in
//! each find the inner and the outer outline. Layers between them are joined to hexahedra, and what
//! is hardly tissue is left out. Sections are parallel and rays straight, so that no cell is inside
//! out whatever the two surfaces are. Each cell names its neighbours and its region: Calot's
//! triangle, the lower third of the gallbladder's bed, or the rest of the bed.
//!
//! # Gravity
//!
//! An organ's surface is taken for its shape in the body, where its weight is in balance. Gravity
//! acts on it by the recipe's `gravity_share` only.
//!
//! # The same bytes
//!
//! The same recipe and meshes give the same scene on any number of threads, on every x86-64 and
//! whatever the C library: sines and roots come from `libm`, and `clippy.toml` forbids the others.

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
mod prepared;
pub mod room;
mod skeleton;
pub mod skin;
mod steady;
mod surface_nets;
pub mod tetra;

pub use cells::Filling;
pub use error::{MeshError, PrepareError, RecipeError};
pub use prepare::{Progress, prepare};
pub use prepared::Prepared;
pub use recipe::Recipe;
pub use report::Report;

/// A point or direction, metres.
pub type Vec3 = nalgebra::Vector3<f64>;
