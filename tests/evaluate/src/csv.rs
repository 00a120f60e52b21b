//! Reads CSV files with a header, commas, and quotes around texts that have commas.

use std::path::Path;

/// The content of a file.
pub(crate) struct Csv {
    header: Vec<String>,
    lines: Vec<Vec<String>>,
}

/// A line of the file, with the header that names its cells.
#[derive(Clone, Copy)]
pub(crate) struct Row<'a> {
    header: &'a [String],
    cells: &'a [String],
}

impl Csv {
    /// Reads a file.
    ///
    /// # Errors
    ///
    /// If the file cannot be read or is empty, or the number of cells differs between a line and
    /// the header.
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let told = |what: &str| format!("{}: {what}", path.display());
        let text = std::fs::read_to_string(path).map_err(|e| told(&e.to_string()))?;
        let mut lines = text.lines().map(split);
        let header = lines.next().ok_or_else(|| told("empty"))?;
        let lines: Vec<_> = lines.collect();
        match lines.iter().position(|line| line.len() != header.len()) {
            Some(at) => Err(told(&format!(
                "the number of cells in line {} differs from the header's; write the file again",
                at + 2
            ))),
            None => Ok(Self { header, lines }),
        }
    }

    /// The lines after the header.
    pub(crate) fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.lines.iter().map(|cells| Row {
            header: &self.header,
            cells,
        })
    }

    /// The distinct values of a column, in the order in which they first occur.
    pub(crate) fn distinct(&self, column: &str) -> Vec<String> {
        let mut found: Vec<String> = Vec::new();
        for row in self.rows() {
            let value = row.text(column);
            if !found.iter().any(|f| f == value) {
                found.push(value.to_owned());
            }
        }
        found
    }
}

impl<'a> Row<'a> {
    /// The text of a cell; "" if there is no such column.
    pub(crate) fn text(&self, column: &str) -> &'a str {
        self.header
            .iter()
            .position(|name| name == column)
            .map_or("", |at| &self.cells[at])
    }

    /// The number in a cell; NaN if it has none.
    pub(crate) fn number(&self, column: &str) -> f64 {
        self.text(column).parse().unwrap_or(f64::NAN)
    }
}

/// The cells of a line.
pub(crate) fn split(line: &str) -> Vec<String> {
    let (mut cells, mut quoted) = (vec![String::new()], false);
    for c in line.chars() {
        match (c, cells.last_mut()) {
            ('"', _) => quoted = !quoted,
            (',', _) if !quoted => cells.push(String::new()),
            (c, Some(cell)) => cell.push(c),
            (_, None) => {}
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commas_in_quotes_are_text() {
        assert_eq!(split("a,\"b, c\",,1"), ["a", "b, c", "", "1"]);
    }
}
