//! MATLAB level 5 files (saved with -v6 or -v7): vectors, columns of matrices and fields of
//! structures become columns (`m#2` is the second of a matrix m).
//!
//! Read with bounds on everything, in two passes: names and shapes first, then only the columns
//! that hold channels.

use std::ops::Range;

use crate::channels::glimpse::Glimpse;
use crate::channels::table::{Spec, Table, measured};
use crate::error::{Problem, ReadError};
use crate::formats::header::{Offered, Recognised};
use crate::formats::level5::{File, HEADER, Offer, corrupt};
use crate::options::{ReadOptions, most_numbers};

pub fn is_mat(bytes: &[u8]) -> bool {
    bytes.starts_with(b"MATLAB ") && matches!(bytes.get(126..HEADER), Some(b"IM" | b"MI"))
}

/// Reads a .mat file.
pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<Table, ReadError> {
    if bytes.len() as u64 > options.limits.bytes {
        return Err(Problem::TooLarge {
            bytes: bytes.len() as u64,
            limit: options.limits.bytes,
        }
        .into());
    }
    if bytes.starts_with(b"MATLAB 7.3") {
        return Err(Problem::MatV73.into());
    }
    let big_endian = &bytes[126..HEADER] == b"MI";
    let file = File { bytes, big_endian };
    let offered = offered(&file, options)?;
    let recognised = recognised(&offered, options)?;
    let objects = objects(&offered);
    if !objects.is_empty() && !offered.iter().any(is_vector) {
        return Err(Problem::MatObjects { objects }.into());
    }
    let rows = rows(&offered, &recognised.specs)?;
    let most = options
        .limits
        .rows
        .min(most_numbers(bytes.len()) / recognised.specs.len().max(1));
    let taken = taken(rows, most, options)?;
    let mut table = Table {
        rows: taken.len(),
        warnings: [recognised.warnings, unread(objects)].concat(),
        unfound: recognised.unfound,
        format: "MATLAB level 5".to_owned(),
        ignored: (offered.iter().enumerate())
            .filter(|(i, _)| recognised.specs.iter().all(|s| s.number != i + 1))
            .map(|(_, offer)| offer.name.clone())
            .collect(),
        ..Table::default()
    };
    let mut number = 0;
    file.columns(&mut |offer, numbers| {
        number += 1;
        let values = numbers.iter().skip(taken.start);
        table
            .glimpses
            .push(Glimpse::of_numbers(&offer.name, values));
        let Some(spec) = recognised.specs.iter().find(|s| s.number == number) else {
            return Ok(());
        };
        let values: Vec<f64> = (numbers.iter().skip(taken.start))
            .take(taken.len())
            .collect();
        measured(&values, options.is_missing(b"NaN"))
            .map_err(|(at, problem)| spec.blame(problem).at_sample(taken.start + at + 1))?;
        table.columns.push((spec.clone(), values));
        Ok(())
    })?;
    Ok(table)
}

/// All columns of the file.
fn offered(file: &File, options: &ReadOptions) -> Result<Vec<Offer>, ReadError> {
    let mut offered = Vec::new();
    file.columns(&mut |column, _| {
        offered.push(column.clone());
        Ok(())
    })?;
    if offered.is_empty() {
        return Err(corrupt("no variables in it").into());
    }
    if offered.len() > options.limits.columns {
        return Err(Problem::TooMany {
            what: "columns",
            limit: options.limits.columns,
        }
        .into());
    }
    Ok(offered)
}

/// Whether it can be a channel. What MATLAB stores of its objects has no name.
fn is_vector(offer: &Offer) -> bool {
    offer.length > 1 && !offer.name.is_empty()
}

/// Names of the variables whose numbers only MATLAB can read.
fn objects(offered: &[Offer]) -> String {
    let objects = offered.iter().filter(|offer| offer.object);
    let names: Vec<&str> = objects.map(|offer| offer.name.as_str()).take(5).collect();
    names.join(", ")
}

fn unread(objects: String) -> Vec<String> {
    let found = (!objects.is_empty()).then_some(objects);
    let warning = |objects| Problem::MatObjects { objects }.to_string();
    found.map(warning).into_iter().collect()
}

/// The columns that hold channels.
fn recognised(offered: &[Offer], options: &ReadOptions) -> Result<Recognised, ReadError> {
    // Scalars and texts cannot be channels: unnamed, they are not recognised.
    let vectors: Vec<String> = (offered.iter())
        .map(|o| {
            if is_vector(o) {
                o.name.clone()
            } else {
                String::new()
            }
        })
        .collect();
    Offered {
        names: &vectors,
        units: &[],
        line: None,
    }
    .recognise(options)
}

/// Rows of the channels, of which all hold equally many real numbers.
fn rows(offered: &[Offer], specs: &[Spec]) -> Result<usize, ReadError> {
    let rows = specs
        .iter()
        .map(|s| offered[s.number - 1].length)
        .max()
        .unwrap_or(0);
    for spec in specs {
        let Offer {
            name,
            length: found,
            complex,
            ..
        } = &offered[spec.number - 1];
        if *complex {
            let variable = name.split('#').next().unwrap_or(name).to_owned();
            let problem = Problem::ComplexNumbers { variable };
            return Err(ReadError::from(problem).in_column(spec.number, &spec.header));
        }
        let found = *found;
        if found != rows {
            let problem = Problem::RaggedRow {
                found,
                expected: rows,
            };
            return Err(ReadError::from(problem).in_column(spec.number, &spec.header));
        }
    }
    Ok(rows)
}

/// The rows that are read, of at most so many.
fn taken(rows: usize, most: usize, options: &ReadOptions) -> Result<Range<usize>, ReadError> {
    if rows > most {
        return Err(Problem::TooMany {
            what: "rows",
            limit: most,
        }
        .into());
    }
    let (from, to) = options.rows.unwrap_or((0, rows));
    if rows > 0 && from >= rows {
        return Err(Problem::BadRows { from, to, rows }.into());
    }
    let to = to.min(rows);
    Ok(from.min(to)..to)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Written by scipy.io.savemat 1.x, past the header: t (1x4 double), z_f_mm (4x1 int16), a text
    /// and a scalar, unpacked.
    const PLAIN: &str = "0e00000050000000060000000800000006000000000000000500000008000000010000000400\
         00000100010074000000090000002000000000000000000000007b14ae47e17a843f7b14ae47\
         e17a943fb81e85eb51b89e3f0e0000004000000006000000080000000a000000000000000500\
         000008000000040000000100000001000000060000007a5f665f6d6d00000300000008000000\
         01000200030004000e0000003000000006000000080000000400000000000000050000000800\
         00000100000002000000010004006e6f746510000200686900000e0000003800000006000000\
         0800000006000000000000000500000008000000010000000100000001000200667300000900\
         0000080000000000000000005940";
    /// Packed: a structure ride with t, z_f and a structure more with u_f (single); a matrix m (4x2).
    const PACKED: &str = "0f00000094000000789ce3636060686064606003d21c40ccc40001ac503e231cb3301465a6a4\
         b2026956a8183f1097801457c5a73130e4e617a53230f001b9010c08f3d8b098c702a5418013\
         88151810a05a649dfbc3aa167b083dc57e875cebebc01df3ec2933f7823d847e00a55f40e90f\
         60731b1888f13f4c9c056a0f0b4329d0db20fd0e48fad909b80b242f007757833d44bb830300\
         22cc1b420f0000003a000000789ce36360602800623620e680d220c00ae5b300311310330261\
         2e90e6046207060c00151280d21250fa833d84e680f245a0b48c0300c8e9046d";

    fn file(hex: &str) -> Vec<u8> {
        let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
        bytes.resize(124, b' ');
        bytes.extend_from_slice(b"\x00\x01IM");
        let digits = |i| u8::from_str_radix(&hex[i..i + 2], 16).unwrap();
        bytes.extend((0..hex.len()).step_by(2).map(digits));
        bytes
    }

    fn columns(bytes: &[u8], map: &[(&str, &str)]) -> Result<Vec<(String, Vec<f64>)>, ReadError> {
        let map = map
            .iter()
            .map(|(a, b)| ((*a).into(), (*b).into()))
            .collect();
        let options = ReadOptions {
            map,
            ..ReadOptions::default()
        };
        let table = read(bytes, &options)?;
        Ok(table
            .columns
            .into_iter()
            .map(|(s, v)| (s.channel.name().to_owned(), v))
            .collect())
    }

    #[test]
    fn val_files_written_by_scipy() {
        assert!(is_mat(&file(PLAIN)) && !is_mat(b"MATLAB export,1,2"));
        let t = ("t".to_owned(), vec![0.0, 0.01, 0.02, 0.03]);
        let z = ("z_f".to_owned(), vec![1.0, 2.0, 3.0, 4.0]);
        assert_eq!(columns(&file(PLAIN), &[]).unwrap(), [t.clone(), z]);
        let table = read(&file(PLAIN), &ReadOptions::default()).unwrap();
        assert_eq!(table.ignored, ["note", "fs"]);
        assert_eq!(table.columns[1].0.unit.scale, 1e-3);
        let z = ("z_f".to_owned(), vec![0.25, 0.5, 0.75, 1.0]);
        let u = ("u_f".to_owned(), vec![0.0, 1.0, 2.0, 3.0]);
        assert_eq!(
            columns(&file(PACKED), &[]).unwrap(),
            [t.clone(), z.clone(), u.clone()]
        );
        let a = ("a_f".to_owned(), vec![1.0, 3.0, 5.0, 7.0]);
        assert_eq!(
            columns(&file(PACKED), &[("a_f", "m#2")]).unwrap(),
            [t, z, u, a]
        );
    }

    #[test]
    fn faults() {
        let kind = |bytes: &[u8], map: &[_]| columns(bytes, map).unwrap_err().kind();
        let mut bytes = file(PLAIN);
        bytes.truncate(bytes.len() - 4);
        assert_eq!(kind(&bytes, &[]), "corrupt-file");
        assert_eq!(kind(&file(""), &[]), "corrupt-file");
        assert_eq!(kind(&file(PACKED), &[("z_f", "x")]), "missing-column");
        let mut v73 = file(PLAIN);
        v73[..10].copy_from_slice(b"MATLAB 7.3");
        assert_eq!(kind(&v73, &[]), "mat-v73");
        let nan = file(&PLAIN.replace("7b14ae47e17a843f", "000000000000f87f"));
        let e = columns(&nan, &[]).unwrap_err();
        assert_eq!(
            (e.kind(), e.sample(), e.column()),
            ("not-finite", Some(2), Some((1, "t")))
        );
    }

    /// `z_f_mm` of [`PLAIN`] said to be complex; what no channel is read from may be what it likes.
    #[test]
    fn a_complex_channel_is_refused_by_name() {
        let complex = file(&PLAIN.replacen("0a00000000000000", "0a08000000000000", 1));
        let e = columns(&complex, &[]).unwrap_err();
        assert_eq!(
            (e.kind(), e.column()),
            ("complex-numbers", Some((2, "z_f_mm")))
        );
        assert!(e.to_string().contains("save real(z_f_mm)"), "{e}");
        let note = file(&PLAIN.replacen("7a5f665f6d6d", "6f746865725f", 1));
        assert!(columns(&note, &[]).is_ok());
        let note = file(&PLAIN.replacen("7a5f665f6d6d", "6f746865725f", 1).replacen(
            "0a00000000000000",
            "0a08000000000000",
            1,
        ));
        assert!(columns(&note, &[]).is_ok());
        // The second column of a complex matrix.
        let matrix = matrix(0x806, &[1.0, 2.0, 3.0, 4.0]);
        let e = columns(&matrix, &[("z_f", "m#2")]).unwrap_err();
        assert!(e.to_string().contains("save real(m) or imag(m)"), "{e}");
    }

    /// A matrix `m` of two columns with these flags.
    fn matrix(flags: u32, numbers: &[f64]) -> Vec<u8> {
        let element = |kind: u32, data: &[u8]| {
            let mut out = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
            out.extend(data);
            out.resize(out.len().next_multiple_of(8), 0);
            out
        };
        let data: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        let shape = [
            (numbers.len() as u32 / 2).to_le_bytes(),
            2_u32.to_le_bytes(),
        ]
        .concat();
        let parts = [
            element(6, &u64::from(flags).to_le_bytes()),
            element(5, &shape),
            element(1, b"m"),
            element(9, &data),
        ]
        .concat();
        let mut bytes = file("");
        bytes.extend(element(14, &parts));
        bytes
    }

    #[test]
    fn numbers_that_no_sensor_gives_are_refused() {
        let e = |x: f64| {
            columns(&matrix(6, &[1.0, 2.0, 3.0, x]), &[("z_f", "m#2")])
                .map_err(|e| (e.kind(), e.sample()))
        };
        assert_eq!(e(1e300), Err(("out-of-range", Some(2))));
        assert_eq!(e(f64::INFINITY), Err(("not-finite", Some(2))));
        assert!(e(-1e15).is_ok());
    }

    #[test]
    fn a_packed_bomb_is_refused() {
        use std::io::Write;
        let mut e = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
        // A matrix of 40 MB.
        e.write_all(&[14, 0, 0, 0, 0, 0, 0x80, 2]).unwrap();
        e.write_all(&vec![0; 40 << 20]).unwrap();
        let data = e.finish().unwrap();
        let mut bytes = file("0f000000");
        bytes.extend((data.len() as u32).to_le_bytes());
        bytes.extend(data);
        assert_eq!(columns(&bytes, &[]).unwrap_err().kind(), "gzip-bomb");
    }
}
