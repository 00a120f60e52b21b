//! Ascension's Flock-of-Birds protocol, as its serial trackers (Flock of Birds, miniBIRD,
//! laserBIRD) speak it: one bird, records of position and quaternion, streamed.

pub mod device;
mod tracker;
pub mod wire;

pub(crate) use tracker::BAUD;
pub use tracker::BirdTracker;
