#![allow(clippy::unwrap_used)]
use std::io::Write;

use super::*;
use crate::formats::level4::tests::{doubles, matrix as level4};

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

/// Written by scipy.io.savemat 1.x with format='4', whole: t (1x4 double), z_f_mm (1x4 int16) and a text.
const LEVEL_4: &str = "0000000001000000040000000000000002000000740000000000000000007b14ae47e17a843f7b14\
     ae47e17a943fb81e85eb51b89e3f1e000000010000000400000000000000070000007a5f665f6d6d\
     00010002000300040033000000010000000200000000000000050000006e6f7465006869";

fn file(hex: &str) -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
    bytes.resize(124, b' ');
    bytes.extend_from_slice(b"\x00\x01IM");
    bytes.extend(unhex(hex));
    bytes
}

fn unhex(hex: &str) -> Vec<u8> {
    let digits = |i| u8::from_str_radix(&hex[i..i + 2], 16).unwrap();
    (0..hex.len()).step_by(2).map(digits).collect()
}

/// A file of t and z_f.
pub fn plain() -> Vec<u8> {
    file(PLAIN)
}

/// A packed element.
pub fn packed(element: &[u8]) -> Vec<u8> {
    let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    packer.write_all(element).unwrap();
    let data = packer.finish().unwrap();
    let tag = [15, data.len() as u32].map(u32::to_le_bytes);
    [&tag.concat()[..], &data].concat()
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

pub fn element(kind: u32, data: &[u8]) -> Vec<u8> {
    let mut out = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
    out.extend(data);
    out.resize(out.len().next_multiple_of(8), 0);
    out
}

fn array(name: &str, flags: u32, shape: [u32; 2], contents: &[u8]) -> Vec<u8> {
    let parts = [
        element(6, &u64::from(flags).to_le_bytes()),
        element(5, &shape.map(u32::to_le_bytes).concat()),
        element(1, name.as_bytes()),
        contents.to_vec(),
    ];
    element(14, &parts.concat())
}

fn numbers(name: &str, rows: u32, numbers: &[f64]) -> Vec<u8> {
    let data: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    let shape = [rows, numbers.len() as u32 / rows];
    array(name, 6, shape, &element(9, &data))
}

fn with(variables: &[Vec<u8>]) -> Vec<u8> {
    [file(""), variables.concat()].concat()
}

/// A matrix `m` of two columns with these flags.
fn matrix(flags: u32, numbers: &[f64]) -> Vec<u8> {
    let data: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
    let shape = [numbers.len() as u32 / 2, 2];
    with(&[array("m", flags, shape, &element(9, &data))])
}

#[test]
fn nan_in_a_channel_is_a_missing_value() {
    let t = numbers("t", 3, &[0.0, 0.01, 0.02]);
    let bytes = with(&[t, numbers("z_f", 3, &[1.0, f64::NAN, 3.0])]);
    let table = read(&bytes, &ReadOptions::default()).unwrap();
    assert!(table.columns[1].1[1].is_nan());
    assert_eq!(table.warnings, ["NaN: 1 value is read as missing"]);
}

#[test]
fn a_wide_matrix_is_read_by_rows() {
    let bytes = with(&[numbers("d", 2, &[0.0, 5.0, 0.01, 6.0, 0.02, 7.0])]);
    let map = [("t", "d#1"), ("z_f", "d#2")];
    let read_columns = columns(&bytes, &map).unwrap();
    assert_eq!(read_columns[0].1, [0.0, 0.01, 0.02]);
    assert_eq!(read_columns[1].1, [5.0, 6.0, 7.0]);
    let options = ReadOptions {
        map: map
            .iter()
            .map(|(a, b)| ((*a).into(), (*b).into()))
            .collect(),
        ..ReadOptions::default()
    };
    let warnings = read(&bytes, &options).unwrap().warnings;
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].starts_with("d (2 x 3) has a row per channel"));
}

#[test]
fn vectors_of_another_length_are_left_out() {
    let vectors = [
        numbers("t", 2, &[0.0, 1.0]),
        numbers("u_f", 3, &[1.0, 2.0, 3.0]),
        numbers("z_f", 3, &[1.0, 2.0, 3.0]),
    ];
    let bytes = with(&vectors);
    assert_eq!(columns(&bytes, &[]).unwrap_err().kind(), "ragged-row");
    let options = ReadOptions {
        rate_hz: Some(200.0),
        ..ReadOptions::default()
    };
    let table = read(&bytes, &options).unwrap();
    assert_eq!((table.rows, table.columns.len()), (3, 2));
    let warning = "t has 2 values, the other channels 3: it is left out";
    assert_eq!(table.warnings, [warning]);
}

#[test]
fn arrays_of_structures_are_read_if_they_are_mapped() {
    let fields = [
        [5, 0, 4, 0, 8, 0, 0, 0].to_vec(),
        element(1, b"values\0\0"),
        numbers("", 3, &[0.0, 0.01, 0.02]),
        numbers("", 3, &[5.0, 6.0, 7.0]),
    ];
    let bytes = with(&[array("signals", 2, [1, 2], &fields.concat())]);
    let error = columns(&bytes, &[]).unwrap_err().to_string();
    assert!(error.contains("signals: an array of structures"), "{error}");
    let map = [("t", "signals(1).values"), ("z_f", "signals(2).values")];
    assert_eq!(columns(&bytes, &map).unwrap()[1].1, [5.0, 6.0, 7.0]);
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
    let bytes = with(&[packed(&element(14, &vec![0; 40 << 20]))]);
    assert_eq!(columns(&bytes, &[]).unwrap_err().kind(), "gzip-bomb");
}

#[test]
fn level_4_is_read_like_level_5() {
    let bytes = unhex(LEVEL_4);
    let table = read(&bytes, &ReadOptions::default()).unwrap();
    assert_eq!(table.format, "MATLAB level 4");
    assert_eq!(table.ignored, ["note"]);
    assert_eq!(table.columns[1].0.unit.scale, 1e-3);
    assert_eq!(columns(&bytes, &[]), columns(&file(PLAIN), &[]));
    let kind = |bytes: &[u8]| columns(bytes, &[]).unwrap_err().kind();
    for cut in 1..20 + 5 + 2 {
        assert_eq!(kind(&bytes[..bytes.len() - cut]), "corrupt-file", "{cut}");
    }
    assert_eq!(kind(&[&bytes[..], &[0]].concat()), "corrupt-file");
    let complex = level4([0, 2, 1, 1], false, "u_f", &[0; 32]);
    assert_eq!(
        kind(&[doubles("t", &[0.0, 0.01]), complex].concat()),
        "complex-numbers"
    );
    let many = vec![doubles("t", &[0.0, 0.01]); 513];
    assert_eq!(kind(&many.concat()), "too-many");
}
