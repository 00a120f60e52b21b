//! Light sensors. Each reports when light comes or goes, so that `calot photon` can measure when a
//! picture appears on the screen.
//!
//! ```text
//! pins   a photodiode that switches CTS, DSR, DCD or RI of a serial port ─┐
//! board  a photodiode on a switch of a pedal that speaks the rig protocol ├─► sensor ─► edges
//! sound  a photodiode at a sound card, as a stream of samples ────────────┘
//! ```
//!
//! A sensor has a thread of its own, which records the time of each edge. Nothing here is realtime.

mod board;
mod edge;
mod pins;
mod sensor;
mod sound;

pub use board::{BoardLight, PedalLight};
pub use edge::Edge;
pub use pins::{Pin, PinLight, PinReader};
pub use sensor::{LightInput, Seen, Sensor};
pub use sound::Sound;
