//! Error of a command.

/// Any error of a command, with a message for the user.
pub(crate) type Problem = Box<dyn std::error::Error>;
