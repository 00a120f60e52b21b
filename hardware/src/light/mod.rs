//! Light sensors: each tells when light came or went, so that `calot photon` can say when a picture
//! was seen.
//!
//! ```text
//! pins   a photodiode that switches CTS, DSR, DCD or RI of a serial port ─┐
//! board  a photodiode on a switch of a pedal that speaks the rig protocol ├─► sensor ─► edges
//! sound  a photodiode at a sound card, as a stream of samples ────────────┘
//! ```
//!
//! A sensor has a thread of its own, which stamps the edges. Nothing here is realtime.

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
