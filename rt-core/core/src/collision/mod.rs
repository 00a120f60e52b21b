//! What meets what: the instrument and the skin of organs (`skin`) or organs that have none
//! (`tube`), with what follows where they touch (`touch`); the instrument and the endoscope (`rigid`); organs and organs (`pairs`, `between`).

mod beside;
pub(crate) mod between;
pub(crate) mod contact_force;
pub mod cylinder;
mod friction;
mod gap;
mod grid;
mod law;
pub(crate) mod pairs;
mod part_box;
mod patch;
mod rigid;
pub(crate) mod skin;
pub(crate) mod tool_contact;
mod touch;
pub(crate) mod tube;
