//! Parameters as a Parquet file.

use std::sync::Arc;

use parquet::basic::{Compression, GzipLevel};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::{ParquetError, Result};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

use super::columns::{COLUMNS, Column, Values};
use crate::api::parameter_view::ParameterView;
use crate::store::parameter::ParameterRow;

/// A column in the language of Parquet's schemas.
fn field(column: &Column) -> String {
    let repetition = if column.required {
        "required"
    } else {
        "optional"
    };
    let (kind, annotation) = match column.values {
        Values::Text(_) => ("binary", "(string)"),
        Values::Json(_) => ("binary", "(json)"),
        Values::Number(_) => ("double", ""),
        Values::Identified => ("int64", "(timestamp(millis,true))"),
    };
    format!("{repetition} {kind} {} {annotation};", column.name)
}

/// A file that is written row group by row group.
pub struct Writer(SerializedFileWriter<Vec<u8>>);

impl Writer {
    pub fn new() -> Result<Self> {
        let fields: String = COLUMNS.iter().map(field).collect();
        let schema = parse_message_type(&format!("message parameters {{ {fields} }}"))?;
        let properties = WriterProperties::builder()
            .set_compression(Compression::GZIP(GzipLevel::default()))
            .set_created_by(concat!("veloid ", env!("CARGO_PKG_VERSION")).to_owned())
            .build();
        let writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(properties))?;
        Ok(Self(writer))
    }

    /// A row group with the columns of [`ParameterView`], the time as a timestamp.
    pub fn rows(&mut self, rows: Vec<ParameterRow>) -> Result<Vec<u8>> {
        let times: Vec<i64> = rows.iter().map(|row| row.identified_at).collect();
        let rows: Vec<ParameterView> = rows.into_iter().map(ParameterView::from).collect();
        let mut group = self.0.next_row_group()?;
        for of in &COLUMNS {
            let Some(mut column) = group.next_column()? else {
                return Err(ParquetError::General(of.name.to_owned()));
            };
            write(column.untyped(), of, &rows, &times)?;
            column.close()?;
        }
        group.close()?;
        self.0.flush()?;
        Ok(std::mem::take(self.0.inner_mut()))
    }

    /// What ends the file.
    pub fn end(self) -> Result<Vec<u8>> {
        self.0.into_inner()
    }
}

/// The values of a column.
fn write(
    writer: &mut ColumnWriter<'_>,
    column: &Column,
    rows: &[ParameterView],
    times: &[i64],
) -> Result<()> {
    let levels = |known: Vec<i16>| (!column.required).then_some(known);
    match (writer, column.values) {
        (ColumnWriter::Int64ColumnWriter(writer), Values::Identified) => {
            writer.write_batch(times, None, None)?;
        }
        (ColumnWriter::DoubleColumnWriter(writer), Values::Number(of)) => {
            let (values, known) = known(rows, of);
            writer.write_batch(&values, levels(known).as_deref(), None)?;
        }
        (ColumnWriter::ByteArrayColumnWriter(writer), Values::Text(of) | Values::Json(of)) => {
            let bytes =
                |row: &ParameterView| of(row).map(|text| ByteArray::from(text.into_bytes()));
            let (values, known) = known(rows, bytes);
            writer.write_batch(&values, levels(known).as_deref(), None)?;
        }
        _ => return Err(ParquetError::General("a column of another type".to_owned())),
    }
    Ok(())
}

/// The values that are there, and of each row whether it has one.
fn known<T>(
    rows: &[ParameterView],
    of: impl Fn(&ParameterView) -> Option<T>,
) -> (Vec<T>, Vec<i16>) {
    let all: Vec<Option<T>> = rows.iter().map(of).collect();
    let known = all.iter().map(|value| i16::from(value.is_some()));
    let known = known.collect();
    (all.into_iter().flatten().collect(), known)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;
    use uuid::Uuid;
    use veloid_engine::document::format_number::WIDE;

    use super::*;
    use crate::facts::Facts;

    fn facts() -> Facts {
        Facts {
            pressure_rear_bar: Some(2.5),
            tags: vec!["wet".into(), "race".into()],
            more: [("stem_mm".to_owned(), 90.0)].into(),
            ..Facts::default()
        }
    }

    #[test]
    fn what_is_written_reads_back() {
        let row = |value: f64, std_error, verdict: Option<&str>| ParameterRow {
            job_id: Uuid::from_u128(7),
            ride_id: Uuid::from_u128(8),
            file: "ride.csv".into(),
            method: "swarm".into(),
            axle: "front".into(),
            name: "k_n_m".into(),
            bike: "lab \u{fc}".into(),
            value,
            std_error,
            unit: "N/m".into(),
            verdict: verdict.map(str::to_owned),
            version: "1".into(),
            identified_at: 1_700_000_000_000,
            facts: std_error.map(|_| sqlx::types::Json(facts())),
        };
        let mut writer = Writer::new().unwrap();
        let mut bytes = writer.rows(vec![row(1.5, None, Some("named"))]).unwrap();
        bytes.extend(writer.rows(vec![row(2.5, Some(0.25), None)]).unwrap());
        bytes.extend(writer.end().unwrap());
        let reader = SerializedFileReader::new(bytes::Bytes::from(bytes)).unwrap();
        let rows: Vec<_> = reader
            .get_row_iter(None)
            .unwrap()
            .map(Result::unwrap)
            .collect();
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[0].get_string(1).unwrap(), "lab \u{fc}");
        assert_eq!(rows[0].get_timestamp_millis(2).unwrap(), 1_700_000_000_000);
        assert_eq!(
            (
                rows[0].get_double(6).unwrap(),
                rows[1].get_double(7).unwrap()
            ),
            (1.5, 0.25)
        );
        assert!(rows[0].is_null(7).unwrap() && rows[1].is_null(9).unwrap());
        assert_eq!(rows[0].get_string(9).unwrap(), "named");
        assert_eq!(rows[1].get_double(13).unwrap(), 2.5);
        assert_eq!(rows[1].get_string(19).unwrap(), "wet, race");
        assert_eq!(rows[1].get_string(21).unwrap(), "{\"stem_mm\":90.0}");
        assert_eq!(rows[1].get_string(23).unwrap(), "ride.csv");
        assert_eq!(rows[1].get_double(25).unwrap(), 2.5 + WIDE * 0.25);
        assert!(rows[0].is_null(24).unwrap());
        let page = format!("/jobs/{}", Uuid::from_u128(7));
        assert_eq!(rows[0].get_string(26).unwrap(), &page);
        assert!((11..22).all(|column| rows[0].is_null(column).unwrap()));
    }
}
