//! What meets what: the instrument and the skin of organs (`skin`) or the spheres of those that
//! have none (`tool_contact`), spheres and spheres (`pairs`).

pub mod cylinder;
mod grid;
pub(crate) mod pairs;
pub(crate) mod skin;
pub(crate) mod tool_contact;
