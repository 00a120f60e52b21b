//! Preparation: organ meshes and a scene recipe in, a compiled scene out.
//!
//! ```text
//! recipe (TOML) ─ mesh files or built-in shapes
//!   → mesh      welded, oriented, closed or wrapped            mesh::, shape::
//!   → field     signed distance on a grid                      field::
//!   → spheres   packed inside the skin                         pack::
//!   → links     between spheres, ordered for the solver        links
//!   → binding   spheres that move each skin vertex             bind
//!   → cells     fat and connective tissue in layers            cells
//!   → room      ports, frames, the scripted hand's target      room
//!   → SceneData and a quality report
//! ```
//!
//! Preparation runs offline, so it may allocate and use threads. Lengths are in metres, and all
//! computation is in `f64`.
//!
//! # Held tissue
//!
//! Where a recipe holds an organ beyond a plane, preparation moves the spheres nearest to that
//! plane onto it. Deformation then ends at the plane, whatever the number of spheres. At other
//! borders a free sphere lies before the border and a held sphere beyond it. Only the tissue before
//! the border deforms. So the tissue between the two spheres is made stiffer, by the factor by
//! which the part that deforms is shorter than the whole.
//!
//! # Scenes that are turned
//!
//! An organ is packed on a grid along its mesh's own axes. So a scene that is turned and moved has
//! the same spheres, sag and force.
//!
//! # Patches over which spheres spread a force
//!
//! The spheres are coarse. So a force on one vertex of the skin meets the tissue as if it were
//! spread over a patch. The width of that patch follows from two compliances of the spheres:
//! `c_patch` under a force on the vertex, and `c_wide` under the same force spread over a Gaussian
//! of width `A` on the skin. The spheres are fine enough for the Gaussian, whose local compliance
//! on a half-space is known: `0.399 / (E* A)`. So the local compliance of the spheres at the vertex
//! is `c = c_patch − c_wide + 0.399 / (E* A)`, and the patch is `0.399 / (E* c)` wide. Distant
//! influences are in both compliances and cancel, so a neighbourhood of a few spacings is enough.
//!
//! # Layered tissue
//!
//! Fat or connective tissue lies around another organ. Parallel cross-sections are laid along that
//! inner organ. Rays in each section find the inner and the outer outline of the tissue. The space
//! between the outlines is divided into layers of hexahedra (cells). Cells with little tissue are
//! left out until the other cells have the organ's volume. Sections are parallel and rays straight,
//! so no cell is inside out, whatever the shape of the two outlines. Each cell stores its
//! neighbours and its region: Calot's triangle, the lower third of the gallbladder's bed, or the
//! rest of the bed.
//!
//! # Gravity
//!
//! The surface of an organ is taken as its shape in the body, in balance with its weight. So only
//! the share `gravity_share` of gravity, from the recipe, acts on the organ: by default none.
//!
//! # The same bytes
//!
//! The same recipe and meshes give the same scene with any number of threads, any x86-64 and any C
//! library: sines, cube roots and the like come from `libm`, and `clippy.toml` forbids those of the
//! standard library.

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
mod bowl;
mod budget;
mod cells;
pub mod held;
pub mod links;
pub mod order;
mod overlap;
pub mod pack;
pub mod patient;
mod prepare;
mod prepared;
mod rest;
pub mod room;
mod runs;
mod skeleton;
pub mod skin;
mod space;
mod support;
mod surface_nets;
pub mod tetra;
mod thin;
mod tube;

pub use cells::Filling;
pub use error::{MeshError, PrepareError, RecipeError};
pub use prepare::{Progress, prepare};
pub use prepared::Prepared;
pub use recipe::Recipe;
pub use report::Report;

/// A point or direction, metres.
pub type Vec3 = nalgebra::Vector3<f64>;
