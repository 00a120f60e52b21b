//! Ascension's Flock-of-Birds protocol, as its serial trackers speak it.

mod tracker;

pub use tracker::BirdTracker;
