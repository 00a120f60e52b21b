//! Errors of the link between two computers.

use std::path::PathBuf;

/// Script that makes the keys; the tests run it.
pub const MAKE_KEYS: &str = include_str!("../make_keys.sh");

/// Reasons for which the link fails.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// No certificates were named.
    #[error(
        "a link needs --cert, --key and --ca: only holders of a certificate of your authority may watch, and \
         everything is encrypted (on this computer alone, --insecure does without). `calot link keys` prints the script \
         that makes them with openssl"
    )]
    NoKeys,
    /// A key or certificate is unusable.
    #[error("{path}: {problem}")]
    Key {
        /// The file.
        path: PathBuf,
        /// The problem and its remedy.
        problem: String,
    },
    /// An address is invalid.
    #[error("'{given}' is not an address: {problem}")]
    Address {
        /// Address as given.
        given: String,
        /// The problem and its remedy.
        problem: &'static str,
    },
    /// The station cannot listen at the address.
    #[error("listening at {address}: {source}; choose another with --listen")]
    Listen {
        /// The address.
        address: String,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The other side sent an invalid message.
    #[error(
        "the other side sent {what}: it is of another version, or not Calot; end it or update it"
    )]
    Malformed {
        /// Description of the invalid message.
        what: &'static str,
    },
    /// The scene that arrived is invalid.
    #[error("the received scene is unusable: {0}")]
    Scene(#[from] shared_mem::scene::SceneError),
    /// A file cannot be written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The station's shared memory failed.
    #[error(transparent)]
    Service(#[from] shared_mem::service::ServiceError),
}
