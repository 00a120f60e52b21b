//! Parts that the drivers behind a vendor's library share: the table of its functions, a limit for
//! an opening that hangs, a word when the library ends the process, and the loader's errors.
//!
//! A library is opened at run time and never closed: nothing is linked, and vendors' drivers do not
//! survive a second loading.

mod ended;
mod opening;
mod refused;
mod symbols;

pub(crate) use opening::Door;
pub(crate) use refused::{Product, incomplete, refused};
pub(crate) use symbols::symbols;

/// Age above which a force is dropped: the thread that serves the device goes on when ours hangs.
pub(crate) const FORCE_AGE_NS: u64 = 50_000_000;
