//! A table in any format: its columns, its cells, and the trait that takes its rows.

/// Type of a column. Any column may lack a value in a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Whole number, not negative.
    Whole,
    /// 64-bit floating point.
    Double,
    /// 32-bit floating point, as the simulation computes.
    Single,
    /// True or false; 1 or 0 in CSV.
    Flag,
    Text,
}

impl Kind {
    /// Name of the type, for people.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Whole => "whole number",
            Self::Double => "64-bit number",
            Self::Single => "32-bit number",
            Self::Flag => "true or false",
            Self::Text => "text",
        }
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Column {
    /// Name, with the unit last.
    pub(crate) name: String,
    pub(crate) kind: Kind,
    pub(crate) meaning: &'static str,
}

impl Column {
    pub(crate) fn new(name: impl Into<String>, kind: Kind, meaning: &'static str) -> Self {
        Self {
            name: name.into(),
            kind,
            meaning,
        }
    }
}

/// A value in a row.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Cell {
    Whole(u64),
    Double(f64),
    Single(f32),
    Flag(bool),
    Text(String),
    Absent,
}

impl Cell {
    /// A number, or no value if it is not finite.
    pub(crate) fn finite(number: f32) -> Self {
        match number.is_finite() {
            true => Self::Single(number),
            false => Self::Absent,
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        match text.is_empty() {
            true => Self::Absent,
            false => Self::Text(text.to_owned()),
        }
    }
}

/// Takes the rows of a table.
pub(crate) trait Sheet {
    /// Adds a row with a cell for each column.
    ///
    /// # Errors
    /// The error of the operating system.
    fn add(&mut self, row: &[Cell]) -> std::io::Result<()>;

    /// Completes the table.
    ///
    /// # Errors
    /// The error of the operating system.
    fn end(self: Box<Self>) -> std::io::Result<()>;
}
