//! Parts that all drivers with a vendor's library share: the table of the library's functions, a
//! time limit for an opening that hangs, a message when the library ends the process, and the
//! errors of the dynamic loader.
//!
//! A library is opened at run time, so Calot links nothing of a vendor's. It is never closed,
//! because vendors' drivers do not survive a second loading.

mod ended;
mod opening;
mod refused;
mod symbols;

pub(crate) use opening::LibraryAccess;
pub(crate) use refused::{Product, incomplete, refused};
pub(crate) use symbols::symbols;

/// Age above which a force is dropped, ns. The thread that serves the device goes on when Calot's
/// tick hangs, and must not repeat the last force.
pub(crate) const FORCE_AGE_NS: u64 = 50_000_000;
