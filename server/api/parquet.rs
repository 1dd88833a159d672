//! Parameters as a Parquet file.

use std::sync::Arc;

use parquet::basic::{Compression, ZstdLevel};
use parquet::column::writer::ColumnWriter;
use parquet::data_type::ByteArray;
use parquet::errors::{ParquetError, Result};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;

use super::parameter_view::ParameterView;
use crate::store::parameter::ParameterRow;

const SCHEMA: &str = "
    message parameters {
        required binary job (string);
        required binary bike (string);
        required int64 identified_at (timestamp(millis,true));
        required binary method (string);
        required binary axle (string);
        required binary name (string);
        required double value;
        optional double std_error;
        required binary unit (string);
        optional binary verdict (string);
        required binary version (string);
        required boolean made_up;
    }";

/// One row group with the columns of [`ParameterView`], the time as a timestamp.
pub fn file(rows: Vec<ParameterRow>) -> Result<Vec<u8>> {
    let times: Vec<i64> = rows.iter().map(|row| row.identified_at).collect();
    let rows: Vec<ParameterView> = rows.into_iter().map(ParameterView::from).collect();
    let schema = Arc::new(parse_message_type(SCHEMA)?);
    let properties = WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::try_new(3)?))
        .set_created_by(concat!("veloid ", env!("CARGO_PKG_VERSION")).to_owned())
        .build();
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    let mut number = 0;
    while let Some(mut column) = group.next_column()? {
        match column.untyped() {
            ColumnWriter::Int64ColumnWriter(column) => {
                column.write_batch(&times, None, None)?;
            }
            ColumnWriter::DoubleColumnWriter(column) if number == 6 => {
                let values: Vec<f64> = rows.iter().map(|row| row.value).collect();
                column.write_batch(&values, None, None)?;
            }
            ColumnWriter::DoubleColumnWriter(column) => {
                let values: Vec<f64> = rows.iter().filter_map(|row| row.std_error).collect();
                let known = levels(&rows, |row| row.std_error.is_some());
                column.write_batch(&values, Some(&known), None)?;
            }
            ColumnWriter::ByteArrayColumnWriter(column) => {
                let texts: Vec<ByteArray> =
                    rows.iter().filter_map(|row| text(row, number)).collect();
                let known = levels(&rows, |row| row.verdict.is_some());
                let known = (number == 9).then_some(known.as_slice());
                column.write_batch(&texts, known, None)?;
            }
            ColumnWriter::BoolColumnWriter(column) => {
                let values: Vec<bool> = rows.iter().map(|row| row.made_up).collect();
                column.write_batch(&values, None, None)?;
            }
            _ => return Err(ParquetError::General(format!("column {number}"))),
        }
        column.close()?;
        number += 1;
    }
    group.close()?;
    writer.into_inner()
}

fn levels(rows: &[ParameterView], known: impl Fn(&ParameterView) -> bool) -> Vec<i16> {
    rows.iter().map(|row| i16::from(known(row))).collect()
}

/// The text in a column, counted as in the schema.
fn text(row: &ParameterView, column: usize) -> Option<ByteArray> {
    let text = match column {
        0 => return Some(row.job.to_string().into_bytes().into()),
        1 => &row.bike,
        3 => &row.method,
        4 => &row.axle,
        5 => &row.name,
        8 => &row.unit,
        9 => row.verdict.as_ref()?,
        _ => &row.version,
    };
    Some(text.as_str().into())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use parquet::file::reader::{FileReader, SerializedFileReader};
    use parquet::record::RowAccessor;
    use uuid::Uuid;

    use super::*;

    #[test]
    fn what_is_written_reads_back() {
        let row = |value: f64, std_error, verdict: Option<&str>| ParameterRow {
            job_id: Uuid::from_u128(7),
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
            made_up: std_error.is_none(),
        };
        let bytes = file(vec![
            row(1.5, None, Some("named")),
            row(2.5, Some(0.25), None),
        ])
        .unwrap();
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
        assert!(rows[0].get_bool(11).unwrap() && !rows[1].get_bool(11).unwrap());
    }
}
