//! Errors of a delivery.

use std::path::PathBuf;

use store::StoreError;

/// Reasons for which results do not reach a centre. What was not delivered stays in the store.
#[derive(Debug, thiserror::Error)]
pub enum DeliverError {
    /// No centre can have this address.
    #[error(
        "'{given}' is no address of a centre: {problem}. Allowed are postgres://USER@HOST:PORT/DATABASE, and \
         https://HOST/PATH of a learning record store"
    )]
    Address {
        /// Address as given, without a password.
        given: String,
        /// The problem.
        problem: String,
    },
    /// The password stands where every user of the computer can read it.
    #[error(
        "{to} has a password in --to, which every user of this computer can read in the list of processes. Write the \
         address into a file of mode 600 and name it with --to-file, or put the password into {variable}"
    )]
    Shown {
        /// Address without the password.
        to: String,
        /// Variable of the environment that holds a password.
        variable: &'static str,
    },
    /// A record store was named without its key.
    #[error(
        "{to} needs a user and a password: put them into CALOT_LRS_USER and CALOT_LRS_PASSWORD, or write \
         https://USER:PASSWORD@HOST/PATH into a file of mode 600 and name it with --to-file"
    )]
    NoPassword {
        /// Address.
        to: String,
    },
    /// A file that was named cannot be used.
    #[error("{path}: {problem}")]
    File {
        /// The file.
        path: PathBuf,
        /// The problem and its remedy.
        problem: String,
    },
    /// The centre does not answer.
    #[error(
        "{to} does not work at the moment ({problem}). Nothing is lost: the results wait in the store; try again when the centre \
         can be reached"
    )]
    Unreachable {
        /// Address.
        to: String,
        /// The problem.
        problem: String,
    },
    /// The certificate of the centre is not trusted.
    #[error(
        "{to}: its certificate is not trusted ({problem}). Name the certificate of the authority that signed it with \
         --ca FILE, and use the host name that stands in the certificate"
    )]
    Certificate {
        /// Address.
        to: String,
        /// The problem.
        problem: String,
    },
    /// The centre gives this user no access.
    #[error(
        "{to} refuses this user or password ({problem}). Ask whoever runs the centre for the right ones"
    )]
    Access {
        /// Address.
        to: String,
        /// Answer of the centre.
        problem: String,
    },
    /// The user lacks a right that a delivery needs.
    #[error(
        "{to}: this user may not do that ({problem}). Let the owner of the database run `calot store push` once, which \
         makes the tables, then: GRANT USAGE ON SCHEMA calot TO the_station; GRANT SELECT, INSERT, UPDATE, DELETE ON \
         ALL TABLES IN SCHEMA calot TO the_station"
    )]
    Rights {
        /// Address.
        to: String,
        /// Answer of the centre.
        problem: String,
    },
    /// The centre has another version.
    #[error("{to} has {found}; this program needs {needed}. Nothing was sent")]
    Version {
        /// Address.
        to: String,
        /// Version of the centre.
        found: String,
        /// Version that is needed, with the remedy.
        needed: &'static str,
    },
    /// The centre refuses one result.
    #[error("{to} refuses a result: {problem}")]
    Rejected {
        /// Address.
        to: String,
        /// Answer of the centre.
        problem: String,
    },
    /// The centre answers with something else.
    #[error("{to} answers as no {kind} does: {problem}. Look whether the address is right")]
    Answer {
        /// Address.
        to: String,
        /// Kind of centre that was expected.
        kind: &'static str,
        /// The problem.
        problem: String,
    },
    /// The store failed.
    #[error(transparent)]
    Store(#[from] StoreError),
}

/// An error with all its causes.
pub(crate) fn in_words(error: &dyn std::error::Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(it) = cause {
        let words = it.to_string();
        if !text.contains(&words) {
            text = format!("{text}: {words}");
        }
        cause = it.source();
    }
    printable(&text)
}

/// Start of a text from elsewhere, safe for a terminal.
pub(crate) fn printable(text: &str) -> String {
    let shown = text.trim().chars().take(300);
    shown
        .map(|it| if it.is_control() { ' ' } else { it })
        .collect()
}

/// Problem of a certificate, if that is the cause of an error.
pub(crate) fn certificate_problem(error: &(dyn std::error::Error + 'static)) -> Option<String> {
    let mut cause = Some(error);
    while let Some(it) = cause {
        if let Some(rustls::Error::InvalidCertificate(problem)) = it.downcast_ref() {
            return Some(problem.to_string());
        }
        // An error of the system hides the error that it carries from `source`.
        let carried = it.downcast_ref::<std::io::Error>();
        cause = match carried.and_then(std::io::Error::get_ref) {
            Some(inner) => Some(inner),
            None => it.source(),
        };
    }
    None
}
