//! Measured figures and their presentation: distributions of times, the machine that they were
//! measured on, charts as SVG and parts of HTML pages. The package knows no station and no scene.
//!
//! ```text
//! distribution ◄─ times   charts of times: histogram, course, exceedance
//! machine      ◄─ html    style, escaped text, the machine's table
//!                 bands   heat maps over time
//!                 panels  series side by side, heat maps
//!                 groups  groups of values beside each other
//! presentation            how pictures came to the screen
//! ```

pub mod bands;
mod distribution;
pub mod groups;
pub mod html;
mod machine;
pub mod panels;
mod presentation;
pub mod times;

pub use distribution::{Distribution, Quantiles};
pub use machine::Machine;
pub use presentation::PresentationSummary;
