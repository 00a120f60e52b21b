//! Organs of our own making, from signed distance functions.

use serde::Deserialize;

/// A procedural organ and its parameters, as the recipe's `shape` table names them.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "form", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Shape {
    /// A liver with its gallbladder fossa.
    Liver,
    /// A gallbladder in that fossa.
    Gallbladder,
}

impl Shape {
    pub(crate) fn from_table(table: toml::Table) -> Result<Self, String> {
        table
            .try_into()
            .map_err(|error: toml::de::Error| error.message().to_owned())
    }
}
