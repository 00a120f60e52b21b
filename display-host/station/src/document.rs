//! JSON that `calot` writes for programs. Each document names its schema under the key `schema`;
//! `calot schema` prints the schemas. A new key keeps the version. A key that is removed, renamed
//! or changes its meaning needs a new version: a new file in `schemas`, and a new number here.

use serde::Serialize;

use crate::problem::Problem;
use crate::say;

/// Kind of a document.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Document {
    /// Name by which `calot schema` finds it.
    pub(crate) name: &'static str,
    /// `$id` of the schema, and content of the key `schema`.
    pub(crate) id: &'static str,
    /// JSON schema, draft 2020-12.
    pub(crate) schema: &'static str,
}

/// A value with the key `schema`, which comes first.
#[derive(Debug, Serialize)]
pub(crate) struct Tagged<T> {
    schema: &'static str,
    #[serde(flatten)]
    value: T,
}

macro_rules! documents {
    ($($constant:ident = $name:literal, $version:literal;)*) => {
        $(pub(crate) const $constant: Document = Document {
            name: $name,
            id: concat!("urn:calot:", $name, ":", $version),
            schema: include_str!(concat!("../schemas/", $name, ".", $version, ".json")),
        };)*
        /// Every kind of document.
        pub(crate) const ALL: &[Document] = &[$($constant),*];
    };
}

documents! {
    SUMMARY = "summary", 1;
    CONTROLLER = "controller", 1;
    REPORT = "report", 1;
    REPLAY = "replay", 1;
    WHAT_IF = "what-if", 1;
    REPAIR = "repair", 1;
    EXPORT = "export", 1;
    TRAINEE = "trainee", 1;
    SESSION = "session", 1;
    PROGRESS = "progress", 1;
    MERGED = "merged", 1;
    PUSHED = "pushed", 1;
    FORM = "form", 1;
    SHEET = "sheet", 1;
    ANSWERS = "answers", 1;
    STORE = "store", 1;
    PREPARATION = "preparation", 1;
    CHECK = "check", 1;
    JITTER = "jitter", 1;
    JITTER_DIFF = "jitter-diff", 1;
    PHOTON = "photon", 1;
    DEVICES = "devices", 1;
    WATCH = "watch", 1;
    CONFORMANCE = "conformance", 1;
    CALIBRATION = "calibration", 1;
    CHARACTERISTICS = "characteristics", 1;
    IGTLINK = "igtlink", 1;
    LINK_SERVE = "link-serve", 1;
    LINK_WATCH = "link-watch", 1;
    VIDEO_TRUTH = "video-truth", 1;
}

impl Document {
    /// The value as this document.
    pub(crate) const fn of<T: Serialize>(self, value: T) -> Tagged<T> {
        Tagged {
            schema: self.id,
            value,
        }
    }

    /// Prints the document over several lines.
    pub(crate) fn answer(self, value: impl Serialize) -> Result<(), Problem> {
        say::answer(serde_json::to_string_pretty(&self.of(value))?);
        Ok(())
    }

    /// Prints the document in one line.
    pub(crate) fn line(self, value: impl Serialize) -> Result<(), Problem> {
        say::answer(serde_json::to_string(&self.of(value))?);
        Ok(())
    }

    /// Prints an array of documents.
    pub(crate) fn array<T: Serialize>(
        self,
        values: impl IntoIterator<Item = T>,
    ) -> Result<(), Problem> {
        let all: Vec<Tagged<T>> = values.into_iter().map(|value| self.of(value)).collect();
        say::answer(serde_json::to_string_pretty(&all)?);
        Ok(())
    }
}
