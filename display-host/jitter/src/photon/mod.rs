//! Measures the time from hand to light: from a tick or a motion to its light on the screen. A
//! light sensor sees the light.
//!
//! ```text
//! inputs of all ticks ─► flips ─┐
//! the window's pictures ────────┼─► pair ─► Figures (medians, maxima) ─► report ─► page, text
//! the light sensor ─► edges ────┘
//! ```

mod page;
mod pair;
mod report;

pub use page::html;
pub use pair::{Arrived, Change, Pairs, pair};
pub use report::{FILE, Figures, Light, Report, Screen, Spread, text};
