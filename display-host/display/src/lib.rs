//! Calot's display. It reads the state of a controller from shared memory, and moves the organs'
//! skins with the spheres of the tissue model. It shows the organs through an endoscope, in a
//! window or in pictures.
//!
//! ```text
//! shared-mem services ─► feed (newest valid frames, counters) ─► render ─► window / PNG
//!                                       └─► ui (panel)           ├ skinning (GPU, and CPU twin)
//!                                                                ├ tissue, cavity, instrument
//!                                                                └ lens (scope, exposure, tone)
//! ```
//!
//! Only [`shared_mem::message::CommandMsg`]s return to the controller. Nothing here is realtime:
//! every thread of a display stays off the core of the controller's realtime tick.

pub mod album;
pub mod animation;
pub mod effects;
pub mod error;
pub mod feed;
pub mod fonts;
pub mod gallery;
pub mod headless;
pub mod kept;
pub mod latency;
mod painter;
pub mod patch;
pub mod picture;
pub mod presentation;
pub mod priority;
pub mod render;
pub mod report;
pub mod skinning;
pub mod sound;
pub mod ui;
pub mod window;
pub mod words;

pub use error::DisplayError;
