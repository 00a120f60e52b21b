//! Reads the CSV files that this program writes: a header, commas, texts in quotes where they have
//! commas.

use std::path::Path;

/// A file, read.
pub(crate) struct Csv {
    header: Vec<String>,
    lines: Vec<Vec<String>>,
}

/// A line, with its header.
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
    /// If it cannot be read, or a line has not as many cells as the header.
    pub(crate) fn read(path: &Path) -> Result<Self, String> {
        let told = |what: &str| format!("{}: {what}", path.display());
        let text = std::fs::read_to_string(path).map_err(|e| told(&e.to_string()))?;
        let mut lines = text.lines().map(split);
        let header = lines.next().ok_or_else(|| told("empty"))?;
        let lines: Vec<_> = lines.collect();
        match lines.iter().position(|line| line.len() != header.len()) {
            Some(at) => Err(told(&format!(
                "line {} has not the cells of the header",
                at + 2
            ))),
            None => Ok(Self { header, lines }),
        }
    }

    /// Its lines after the header.
    pub(crate) fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.lines.iter().map(|cells| Row {
            header: &self.header,
            cells,
        })
    }

    /// The values of a column, each once, in the order in which they first stand.
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
    /// A cell, "" where there is no such column.
    pub(crate) fn text(&self, column: &str) -> &'a str {
        self.header
            .iter()
            .position(|name| name == column)
            .map_or("", |at| &self.cells[at])
    }

    /// A cell as a number, NaN where it is none.
    pub(crate) fn number(&self, column: &str) -> f64 {
        self.text(column).parse().unwrap_or(f64::NAN)
    }
}

fn split(line: &str) -> Vec<String> {
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
