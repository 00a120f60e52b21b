//! A table as Parquet, without compression. A column may lack values in some rows; the other values
//! keep all their bits.

use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DoubleType, FloatType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::Type;

use super::table::{Cell, Column, Kind, Sheet};
use crate::build::build;

/// Rows that are collected in memory before they are written: about a minute of ticks.
const GROUP_ROWS: usize = 65_536;

/// A Parquet file under construction.
pub(crate) struct Columnar {
    to: SerializedFileWriter<File>,
    columns: Vec<Collected>,
    rows: usize,
}

/// Values of a column that are not written yet, and for each row 1 if it has a value, else 0.
struct Collected {
    values: Values,
    has: Vec<i16>,
}

enum Values {
    Whole(Vec<i64>),
    Double(Vec<f64>),
    Single(Vec<f32>),
    Flag(Vec<bool>),
    Text(Vec<ByteArray>),
}

impl Columnar {
    /// Creates the file, which no other user can read.
    pub(crate) fn create(path: &Path, columns: &[Column]) -> io::Result<Self> {
        let fields = columns.iter().map(field).collect::<Result<_, _>>();
        let schema = fields.and_then(|fields| {
            let group = Type::group_type_builder("table").with_fields(fields);
            group.build()
        });
        let properties = WriterProperties::builder().set_created_by(build()).build();
        let file = session::create_private(path)?;
        let schema = Arc::new(schema.map_err(io::Error::other)?);
        let to = SerializedFileWriter::new(file, schema, Arc::new(properties));
        Ok(Self {
            to: to.map_err(io::Error::other)?,
            columns: columns.iter().map(|it| Collected::new(it.kind)).collect(),
            rows: 0,
        })
    }

    fn write(&mut self) -> Result<(), ParquetError> {
        let mut group = self.to.next_row_group()?;
        for column in &mut self.columns {
            if let Some(writer) = group.next_column()? {
                column.write(writer)?;
            }
        }
        group.close()?;
        self.rows = 0;
        Ok(())
    }
}

impl Sheet for Columnar {
    fn add(&mut self, row: &[Cell]) -> io::Result<()> {
        for (column, cell) in self.columns.iter_mut().zip(row) {
            column.add(cell)?;
        }
        self.rows += 1;
        if self.rows >= GROUP_ROWS {
            self.write().map_err(io::Error::other)?;
        }
        Ok(())
    }

    fn end(mut self: Box<Self>) -> io::Result<()> {
        let written = match self.rows {
            0 => Ok(()),
            _ => self.write(),
        };
        let closed = written.and_then(|()| self.to.close());
        closed.map(|_| ()).map_err(io::Error::other)
    }
}

fn field(column: &Column) -> Result<Arc<Type>, ParquetError> {
    let (physical, logical) = match column.kind {
        // Times since 1970 and counts are far below 2^63.
        Kind::Whole => (Physical::INT64, None),
        Kind::Double => (Physical::DOUBLE, None),
        Kind::Single => (Physical::FLOAT, None),
        Kind::Flag => (Physical::BOOLEAN, None),
        Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
    };
    let field = Type::primitive_type_builder(&column.name, physical)
        .with_repetition(Repetition::OPTIONAL)
        .with_logical_type(logical);
    field.build().map(Arc::new)
}

impl Collected {
    fn new(kind: Kind) -> Self {
        let values = match kind {
            Kind::Whole => Values::Whole(Vec::new()),
            Kind::Double => Values::Double(Vec::new()),
            Kind::Single => Values::Single(Vec::new()),
            Kind::Flag => Values::Flag(Vec::new()),
            Kind::Text => Values::Text(Vec::new()),
        };
        Self {
            values,
            has: Vec::new(),
        }
    }

    fn add(&mut self, cell: &Cell) -> io::Result<()> {
        self.has.push(i16::from(*cell != Cell::Absent));
        match (&mut self.values, cell) {
            (_, Cell::Absent) => {}
            (Values::Whole(all), Cell::Whole(it)) => {
                all.push(i64::try_from(*it).map_err(io::Error::other)?);
            }
            (Values::Double(all), Cell::Double(it)) => all.push(*it),
            (Values::Single(all), Cell::Single(it)) => all.push(*it),
            (Values::Flag(all), Cell::Flag(it)) => all.push(*it),
            (Values::Text(all), Cell::Text(it)) => all.push(it.as_str().into()),
            _ => return Err(io::Error::other("a value of another type than its column")),
        }
        Ok(())
    }

    /// Writes the values and forgets them.
    fn write(&mut self, mut writer: SerializedColumnWriter<'_>) -> Result<(), ParquetError> {
        let has = Some(&self.has[..]);
        match &mut self.values {
            Values::Whole(all) => {
                writer.typed::<Int64Type>().write_batch(all, has, None)?;
                all.clear();
            }
            Values::Double(all) => {
                writer.typed::<DoubleType>().write_batch(all, has, None)?;
                all.clear();
            }
            Values::Single(all) => {
                writer.typed::<FloatType>().write_batch(all, has, None)?;
                all.clear();
            }
            Values::Flag(all) => {
                writer.typed::<BoolType>().write_batch(all, has, None)?;
                all.clear();
            }
            Values::Text(all) => {
                writer
                    .typed::<ByteArrayType>()
                    .write_batch(all, has, None)?;
                all.clear();
            }
        }
        self.has.clear();
        writer.close()
    }
}

#[cfg(test)]
mod tests {
    use parquet::file::reader::{FileReader as _, SerializedFileReader};
    use parquet::record::RowAccessor as _;

    use super::*;

    #[test]
    fn rows_come_back_over_several_groups_with_their_gaps() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.parquet");
        let columns = [
            Column::new("n", Kind::Whole, "n"),
            Column::new("x_m", Kind::Single, "x"),
            Column::new("name", Kind::Text, "name"),
        ];
        let rows = GROUP_ROWS + 3;
        let mut file = Columnar::create(&path, &columns).unwrap();
        let mixed = [Cell::Single(1.0), Cell::Absent, Cell::Absent];
        assert!(file.add(&mixed).is_err());
        let mut file = Columnar::create(&path, &columns).unwrap();
        for i in 0..rows {
            let x = match i % 2 {
                0 => Cell::Single(i as f32 * 0.1),
                _ => Cell::Absent,
            };
            file.add(&[Cell::Whole(i as u64), x, "liver".into()])
                .unwrap();
        }
        Box::new(file).end().unwrap();
        let reader = SerializedFileReader::new(File::open(&path).unwrap()).unwrap();
        assert_eq!(reader.num_row_groups(), 2);
        let found: Vec<_> = reader
            .get_row_iter(None)
            .unwrap()
            .map(Result::unwrap)
            .collect();
        assert_eq!(found.len(), rows);
        let last = &found[rows - 1];
        assert_eq!(last.get_long(0).unwrap(), rows as i64 - 1);
        assert_eq!(
            last.get_float(1).unwrap().to_bits(),
            ((rows - 1) as f32 * 0.1).to_bits()
        );
        assert_eq!(last.get_string(2).unwrap(), "liver");
        assert!(found[1].is_null(1).unwrap());
    }
}
