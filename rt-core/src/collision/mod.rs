//! What meets what: the instrument and spheres (`tool_contact`), spheres and spheres
//! (`pairs`).

pub mod cylinder;
mod grid;
pub(crate) mod pairs;
pub(crate) mod tool_contact;
