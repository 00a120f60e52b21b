//! Errors of the centre and of the stations that join one.

use std::path::PathBuf;

/// Error of a centre's program.
#[derive(Debug, thiserror::Error)]
pub enum CentreError {
    /// A file cannot be read or written.
    #[error("{path}: {problem}")]
    File {
        /// Its path.
        path: PathBuf,
        /// Reason.
        problem: String,
    },
    /// The list of stations and instructors is wrong.
    #[error("{path}: {what} is '{value}'; allowed is {allowed}")]
    Roster {
        /// Its path.
        path: PathBuf,
        /// Entry.
        what: &'static str,
        /// Its value.
        value: String,
        /// Values that are allowed.
        allowed: &'static str,
    },
    /// A folder of keys lacks a file, or holds one that cannot be used.
    #[error(
        "{folder} is no folder of keys: {problem}. It holds NAME.pem, NAME.key of mode 600 and ca.pem, as \
         `calot link keys` makes them"
    )]
    Keys {
        /// Its path.
        folder: PathBuf,
        /// Reason.
        problem: String,
    },
    /// An address cannot be listened at.
    #[error("cannot listen at {address}: {problem}. Name another with --page or --stations")]
    Listen {
        /// The address.
        address: String,
        /// Reason.
        problem: String,
    },
    /// The network's library refuses.
    #[error("{doing} failed: {problem}")]
    Network {
        /// Action that failed.
        doing: &'static str,
        /// Reason.
        problem: String,
    },
    /// zenoh would work in several threads, which breaks its connections.
    #[error("zenoh would use several threads; set {0}={1} before the program starts")]
    Threads(&'static str, &'static str),
    /// The program that reads the station does not start.
    #[error("cannot start `{program} tell`: {problem}. It belongs beside calot-centre")]
    Teller {
        /// The program.
        program: PathBuf,
        /// Reason.
        problem: String,
    },
    /// `calot tell` sent bytes that are no frame.
    #[error("`calot tell` sent {0}; use programs of one version")]
    Frame(String),
    /// A password is too short.
    #[error("the password has {0} characters; it needs 10 to 200")]
    Password(usize),
    /// The store fails.
    #[error(transparent)]
    Store(#[from] store::StoreError),
}

/// Translates an error of the network's library.
pub(crate) fn network(doing: &'static str) -> impl Fn(zenoh::Error) -> CentreError {
    move |error| CentreError::Network {
        doing,
        problem: error.to_string(),
    }
}
