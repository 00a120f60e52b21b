//! How a command fails.

/// Anything that a command failed of, in words for the user.
pub(crate) type Problem = Box<dyn std::error::Error>;
