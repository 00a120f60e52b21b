//! What meets what: the instrument and the skin of organs (`skin`) or organs that have none
//! (`tube`), with what follows where they touch (`touch`); the instrument and the endoscope (`rigid`).

mod constraint;
pub(crate) mod contact_force;
mod friction;
mod influence;
mod law;
mod part_box;
mod patch;
mod rigid;
mod separation;
pub(crate) mod skin;
pub(crate) mod tool_contact;
pub(crate) mod tube;
