//! Refusals of rules.

/// Reason why rules are refused.
#[derive(Debug, thiserror::Error)]
pub enum RulesError {
    /// The file cannot be read.
    #[error(
        "{path}: {source}; name a file of rules with --rules, or omit it to use the built-in ones"
    )]
    Io {
        /// Path of the file.
        path: std::path::PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The text is not TOML of the expected form.
    #[error("rules: {0}copy the built-in ones (`calot report --rules-file`) and edit the copy")]
    Form(String),
    /// A value is out of range.
    #[error("rules, line {line}: {what} is {value}; allowed is {allowed}")]
    Value {
        /// Line, from 1.
        line: usize,
        /// The value's name.
        what: String,
        /// The value.
        value: String,
        /// Allowed values.
        allowed: String,
    },
}
