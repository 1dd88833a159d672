//! Which format a file has: a table from any of them, or from arrays.

use std::io::Read;

use crate::channels::table::Table;
use crate::error::{Problem, ReadError};
use crate::file::{Content, RideFile};
use crate::formats::meant::read_as_meant;
#[cfg(feature = "spreadsheets")]
use crate::formats::xlsx;
use crate::formats::{arrays, csv, fit, mat, source, spreadsheet, track};
use crate::options::{Limits, ReadOptions};

/// Bytes by which a packed file is recognised.
const HEAD: u64 = 4096;

pub fn table(file: &RideFile<'_>, options: &ReadOptions) -> Result<Table, ReadError> {
    match file.content {
        Content::Bytes(bytes) => of_bytes(bytes, options).map(read_as_meant),
        Content::Arrays(given) => arrays::read(&given, options),
    }
}

/// What a file seems to hold that is not read; none where it is no text.
pub fn glimpse(file: &RideFile<'_>, options: &ReadOptions) -> Option<Table> {
    match file.content {
        Content::Bytes(bytes) if !mat::is_mat(bytes) && !fit::is_fit(bytes) => {
            csv::glimpse(bytes, options)
        }
        _ => None,
    }
}

pub fn of_bytes(bytes: &[u8], options: &ReadOptions) -> Result<Table, ReadError> {
    if bytes.is_empty() {
        return Err(Problem::EmptyFile.into());
    }
    let Some((packing, unpacked)) = unpacked(bytes, &options.limits)? else {
        return plain(bytes, options);
    };
    // What is packed within, too, is bounded by the size of the whole.
    let mut options = options.clone();
    options.limits.bytes = options.limits.most_held(bytes.len());
    options.limits.numbers = options.limits.most_numbers(bytes.len());
    let mut table = plain(&unpacked, &options)?;
    table.format = format!("{packing}, {}", table.format);
    Ok(table)
}

fn plain(bytes: &[u8], options: &ReadOptions) -> Result<Table, ReadError> {
    if mat::is_mat(bytes) {
        mat::read(bytes, options)
    } else if fit::is_fit(bytes) {
        fit::read(bytes, options)
    } else if spreadsheet::is_xlsx(bytes) {
        of_workbook(bytes, options)
    } else {
        csv::read(bytes, options)
    }
}

/// The text of a sheet, whose size and cells are bounded by those of the workbook.
#[cfg(feature = "spreadsheets")]
fn of_workbook(bytes: &[u8], options: &ReadOptions) -> Result<Table, ReadError> {
    let length = bytes.len() as u64;
    let limit = options.limits.bytes;
    if length > limit {
        return Err(Problem::TooLarge {
            bytes: length,
            limit,
        }
        .into());
    }
    let sheet = xlsx::sheet(bytes, &options.limits)?;
    let mut table = csv::read(sheet.text.as_bytes(), options)?;
    table.format = match sheet.warning {
        Some(_) => "xlsx, first sheet with a table",
        None => "xlsx, first sheet",
    }
    .to_owned();
    table.warnings.extend(sheet.warning);
    Ok(table)
}

/// Refused where packed text is.
#[cfg(not(feature = "spreadsheets"))]
fn of_workbook(bytes: &[u8], options: &ReadOptions) -> Result<Table, ReadError> {
    csv::read(bytes, options)
}

/// How a file is packed and what, if this is not text, which is read in blocks. It is bounded as packed text is.
fn unpacked(bytes: &[u8], limits: &Limits) -> Result<Option<(&'static str, Vec<u8>)>, Problem> {
    let Some((format, mut reader)) = source::unpacking(bytes) else {
        return Ok(None);
    };
    let mut unpacked = Vec::new();
    let head = reader.by_ref().take(HEAD).read_to_end(&mut unpacked);
    if bytes.len() as u64 > limits.bytes || !is_whole(&unpacked) {
        // The reader of packed text says what is wrong with it.
        return Ok(None);
    }
    let limit = limits.most_held(bytes.len());
    let rest = (limit + 1).saturating_sub(unpacked.len() as u64);
    head.and_then(|_| reader.take(rest).read_to_end(&mut unpacked))
        .map_err(|error| Problem::Corrupt {
            format,
            cause: error.to_string(),
        })?;
    if unpacked.len() as u64 > limit {
        return Err(Problem::GzipBomb {
            packed: bytes.len(),
            what: "bytes",
            limit,
        });
    }
    Ok(Some((format, unpacked)))
}

/// Whether what begins so is not read in blocks of text.
fn is_whole(head: &[u8]) -> bool {
    mat::is_mat(head) || fit::is_fit(head) || spreadsheet::is_zip(head) || track::is_track(head)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::io::Write;

    use super::*;
    use crate::formats::level4;
    use crate::formats::zstd::tests::packed as zstd;

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        packer.write_all(bytes).unwrap();
        packer.finish().unwrap()
    }

    /// A file of each format that is not read in blocks.
    fn files() -> Vec<Vec<u8>> {
        let start = 1_000_000_000;
        let values = [0.0, 0.01, 0.02];
        let mat = ["t", "z_f"].map(|name| level4::tests::doubles(name, &values));
        #[cfg(feature = "spreadsheets")]
        let rows =
            ["t z_f", "0 1", "0.01 2"].map(|row| row.split(' ').map(str::to_owned).collect());
        vec![
            fit::tests::file(&[(start, 5000, 80), (start + 1, 5250, 80)]),
            track::tests::gpx("2026-05-01T10:00", &[5.0, 5.25]).into_bytes(),
            mat.concat(),
            mat::tests::plain(),
            #[cfg(feature = "spreadsheets")]
            xlsx::tests::workbook(&rows),
        ]
    }

    #[test]
    fn packed_files_are_read_as_the_plain_ones() {
        let options = ReadOptions::default();
        for plain in files() {
            let own = of_bytes(&plain, &options).unwrap();
            for (name, packed) in [("gzip", gzip(&plain)), ("zstd", zstd(&plain))] {
                let packed = of_bytes(&packed, &options).unwrap();
                assert_eq!(packed.columns, own.columns);
                assert_eq!(packed.format, format!("{name}, {}", own.format));
            }
        }
    }

    fn kind(bytes: &[u8]) -> &'static str {
        let error = of_bytes(bytes, &ReadOptions::default()).unwrap_err();
        error.kind()
    }

    #[test]
    fn packed_bombs_and_damage_are_refused() {
        // Members and frames follow each other in a file as `cat` puts them.
        let blanks = vec![b' '; 8 << 20];
        let blanks = [gzip(&blanks), zstd(&blanks)].map(|packed| packed.repeat(10));
        for plain in files() {
            let packed = [gzip(&plain), zstd(&plain)];
            for (packed, blanks) in packed.iter().zip(&blanks) {
                assert_eq!(kind(&[&packed[..], blanks].concat()), "gzip-bomb");
                assert_eq!(kind(&packed[..packed.len() - 3]), "corrupt-file");
            }
        }
        let packed = gzip(&files()[1]);
        assert_eq!(kind(&gzip(&packed)), "binary-file");
        assert_eq!(kind(&zstd(&packed)), "binary-file");
        assert_eq!(kind(&gzip(b"PK\x03\x04 no workbook")), "binary-file");
    }

    #[test]
    fn what_is_made_of_packed_files_is_bounded_by_the_packed_size() {
        let many = 3 << 20;
        let bytes = vec![1; many];
        let plain = level4::tests::matrix([50, many as u32, 1, 0], false, "z_f", &bytes);
        let options = ReadOptions {
            rate_hz: Some(100.0),
            ..ReadOptions::default()
        };
        assert_eq!(of_bytes(&plain, &options).unwrap().rows, many);
        let error = of_bytes(&gzip(&plain), &options).unwrap_err();
        assert_eq!(error.kind(), "too-many");
        // A matrix that a plain file of this size may hold packed, behind what no reader looks at.
        let other = mat::tests::element(9, &vec![0; 12 << 20]);
        let matrix = mat::tests::packed(&mat::tests::element(14, &vec![0; 70 << 20]));
        let plain = [mat::tests::plain(), other, matrix].concat();
        assert_eq!(kind(&gzip(&plain)), "gzip-bomb");
        assert!(of_bytes(&plain, &ReadOptions::default()).is_ok());
    }
}
