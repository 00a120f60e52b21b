//! Error of a measurement.

/// A failure in words for the user.
pub type Problem = Box<dyn std::error::Error>;
