//! From hand to light: when a light sensor on the screen saw a tick, or a motion.
//!
//! ```text
//! inputs of all ticks ─► flips ─┐
//! the window's pictures ────────┼─► pair ─► Place (medians, maxima) ─► report ─► page, text
//! the light sensor ─► edges ────┘
//! ```

mod page;
mod pair;
mod report;

pub use page::html;
pub use pair::{Arrived, Change, Pairs, pair};
pub use report::{FILE, Figures, Light, Report, Screen, Spread, text};
