//! Figures and how they are shown: distributions of times, the machine that they were measured on,
//! charts as SVG and parts of HTML pages. It knows no station, scene or method.
//!
//! ```text
//! distribution ◄─ times   charts of times: histogram, course, exceedance
//! machine      ◄─ html    style, escaped text, the machine's table
//!                 panels  series side by side, heat maps
//! ```

mod distribution;
pub mod html;
mod machine;
pub mod panels;
pub mod times;

pub use distribution::{Distribution, Quantiles};
pub use machine::Machine;
