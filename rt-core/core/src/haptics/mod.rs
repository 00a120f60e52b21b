//! From contact forces to the force at the handle, and its limits.

pub(crate) mod handle_force;
pub mod output_limit;
pub(crate) mod passivity;
pub(crate) mod proxy;
pub(crate) mod transition;
