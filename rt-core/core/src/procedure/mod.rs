//! The surgeon's work on tissue: what jaws, clips, scissors and current do, and what bleeds.

pub(crate) mod cautery;
pub mod clip;
pub(crate) mod cut;
pub(crate) mod grasp;
pub(crate) mod journal;
pub(crate) mod vessel;
