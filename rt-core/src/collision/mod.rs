//! What meets what: the instrument and the skin of organs (`skin`) or organs that have none
//! (`tube`), with what follows where they touch (`touch`); spheres and spheres (`pairs`).

pub mod cylinder;
mod friction;
mod gap;
mod grid;
mod law;
pub(crate) mod pairs;
mod patch;
pub(crate) mod skin;
pub(crate) mod tool_contact;
mod touch;
pub(crate) mod tube;
