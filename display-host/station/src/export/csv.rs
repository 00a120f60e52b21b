//! A table as CSV (RFC 4180, with line feeds): numbers in their shortest form that keeps every bit.

use std::fs::File;
use std::io::{self, BufWriter, Write as _};
use std::path::Path;

use store::csv_field;

use super::table::{Cell, Column, Sheet};

/// A CSV file under construction.
pub(crate) struct Csv {
    to: BufWriter<File>,
    line: String,
}

impl Csv {
    /// Creates the file, which no other user can read, and writes the names of the columns.
    pub(crate) fn create(path: &Path, columns: &[Column]) -> io::Result<Self> {
        let mut to = BufWriter::new(session::create_private(path)?);
        let names: Vec<&str> = columns.iter().map(|it| it.name.as_str()).collect();
        writeln!(to, "{}", names.join(","))?;
        Ok(Self {
            to,
            line: String::new(),
        })
    }
}

impl Sheet for Csv {
    fn add(&mut self, row: &[Cell]) -> io::Result<()> {
        use core::fmt::Write as _;
        let line = &mut self.line;
        line.clear();
        for (i, cell) in row.iter().enumerate() {
            if i > 0 {
                line.push(',');
            }
            // Writing to a string cannot fail.
            let _ = match cell {
                Cell::Whole(it) => write!(line, "{it}"),
                Cell::Double(it) => write!(line, "{it}"),
                Cell::Single(it) => write!(line, "{it}"),
                Cell::Flag(it) => write!(line, "{}", u8::from(*it)),
                Cell::Text(it) => write!(line, "{}", csv_field(it)),
                Cell::Absent => Ok(()),
            };
        }
        line.push('\n');
        self.to.write_all(self.line.as_bytes())
    }

    fn end(mut self: Box<Self>) -> io::Result<()> {
        self.to.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::Kind;
    use super::*;

    #[test]
    fn a_row_keeps_every_bit_and_every_character() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        let kinds = [
            Kind::Whole,
            Kind::Single,
            Kind::Double,
            Kind::Flag,
            Kind::Text,
            Kind::Text,
        ];
        let columns = kinds.map(|kind| Column::new("n", kind, "a column"));
        let mut csv = Csv::create(&path, &columns).unwrap();
        let (single, double) = (0.1f32 + 0.2f32, 0.1f64 + 0.2f64);
        csv.add(&[
            Cell::Whole(u64::MAX),
            Cell::Single(single),
            Cell::Double(double),
            Cell::Flag(true),
            Cell::from("a,\"b\""),
            Cell::Absent,
        ])
        .unwrap();
        Box::new(csv).end().unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        let line = text.lines().nth(1).unwrap();
        assert_eq!(
            line,
            format!("{},{single},{double},1,\"a,\"\"b\"\"\",", u64::MAX)
        );
        assert_eq!(format!("{single}").parse(), Ok(single));
        assert_eq!(csv_field("=1+1"), "'=1+1");
    }
}
