//! Distance to a surface: exact at any point, and signed on a grid.

mod crossing;
mod grid;
mod nearest;
mod signed;
mod triangle;

pub(crate) use crossing::{overlap, shared_stretches};
pub use grid::Grid;
pub use nearest::Nearest;
pub use signed::{Field, Sign};
pub(crate) use triangle::closest_on_triangle;
