//! Calot's display: it watches a station's controller over shared memory, skins the organs with
//! the spheres' motion, and shows them through an endoscope, in a window or into pictures.
//!
//! ```text
//! shared-mem services ─► feed (newest valid frames, counters) ─► render ─► window / PNG
//!                                       └─► ui (panel)           ├ skinning (GPU, and CPU twin)
//!                                                                ├ tissue, cavity, instrument
//!                                                                └ lens (scope, exposure, tone)
//! ```
//!
//! Nothing here feeds back into the controller but [`shared_mem::message::CommandMsg`]s, and
//! nothing here is realtime: every thread of a display stays off the tick's core.

pub mod album;
pub mod animation;
pub mod effects;
pub mod error;
pub mod feed;
pub mod gallery;
pub mod headless;
pub mod latency;
mod painter;
pub mod priority;
pub mod render;
pub mod report;
pub mod skinning;
pub mod sound;
pub mod ui;
pub mod window;
pub mod words;

pub use error::DisplayError;
