//! What can go wrong between two computers.

use std::path::PathBuf;

/// How keys are made; tests run it.
pub const MAKE_KEYS: &str = include_str!("../make_keys.sh");

/// What went wrong.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// No certificates were named.
    #[error(
        "a link needs --cert, --key and --ca: nobody without a certificate of your authority may look, and \
         nothing is sent in the clear (--insecure: on this computer alone). `calot link keys` prints the script \
         that makes them with openssl"
    )]
    NoKeys,
    /// A key or certificate cannot be used.
    #[error("{path}: {problem}")]
    Key {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and what to do.
        problem: String,
    },
    /// An address cannot be one.
    #[error("'{given}' is no address: {problem}")]
    Address {
        /// As it was given.
        given: String,
        /// What is wrong with it.
        problem: &'static str,
    },
    /// Nobody can connect.
    #[error("listening at {address}: {source}; choose another with --listen")]
    Listen {
        /// Where.
        address: String,
        /// The system's own words.
        source: std::io::Error,
    },
    /// The other side sent something else than it should.
    #[error(
        "the other side sent {what}: it is of another version, or not Calot; end it or update it"
    )]
    Malformed {
        /// What is wrong with it.
        what: &'static str,
    },
    /// The compiled scene that came is not the one that was asked for.
    #[error("the scene that came: {0}")]
    Scene(#[from] shared_mem::scene::SceneError),
    /// A file cannot be written.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's own words.
        source: std::io::Error,
    },
    /// The station's shared memory.
    #[error(transparent)]
    Service(#[from] shared_mem::service::ServiceError),
}
