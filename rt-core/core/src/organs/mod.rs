//! Organs against organs: which spheres are near (`grid`, `pairs`), and what they do to each other
//! (`between`).

pub(crate) mod between;
mod grid;
pub(crate) mod pairs;
