#![allow(clippy::unwrap_used)]
use super::*;
use crate::formats::zstd::tests::packed as zstd;
use std::io::Write;

fn all(bytes: &[u8]) -> Result<Vec<u8>, Problem> {
    let mut source = Source::open(bytes, &Limits::default())?;
    let mut out = Vec::new();
    while let Some(block) = source.next_block()? {
        out.extend_from_slice(block);
    }
    Ok(out)
}

fn gzip(text: &[u8]) -> Vec<u8> {
    let mut e = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
    e.write_all(text).unwrap();
    e.finish().unwrap()
}

fn in_utf16(text: &str, big: bool) -> Vec<u8> {
    let bytes = |unit: u16| match big {
        true => unit.to_be_bytes(),
        false => unit.to_le_bytes(),
    };
    text.encode_utf16().flat_map(bytes).collect()
}

#[test]
fn packed_and_recoded_text_is_the_same_text() {
    let text: String = (0..200_000)
        .map(|i| format!("{i};\u{b5}\u{1f6b2}\n"))
        .collect();
    let bytes = text.as_bytes();
    assert_eq!(all(bytes).unwrap(), bytes);
    assert_eq!(all(&[b"\xef\xbb\xbf", bytes].concat()).unwrap(), bytes);
    assert_eq!(all(&gzip(bytes)).unwrap(), bytes);
    assert_eq!(
        all(&[gzip(bytes), gzip(b"x\n")].concat()).unwrap(),
        [bytes, b"x\n"].concat()
    );
    assert_eq!(all(&zstd(bytes)).unwrap(), bytes);
    for big in [false, true] {
        let plain = in_utf16(&text, big);
        let marked = [in_utf16("\u{feff}", big), plain.clone()].concat();
        for file in [plain, marked] {
            assert_eq!(all(&file).unwrap(), bytes);
            assert_eq!(all(&gzip(&file)).unwrap(), bytes);
        }
    }
}

#[test]
fn blocks_end_with_lines() {
    let packed = gzip("0.123,4.5\n".repeat(300_000).as_bytes());
    let mut source = Source::open(&packed, &Limits::default()).unwrap();
    while let Some(block) = source.next_block().unwrap() {
        assert!(block.ends_with(b"\n") && block.len() <= BLOCK);
    }
}

#[test]
fn bombs_are_refused() {
    let zeros = vec![b'\n'; 100 << 20];
    let kind = |packed: &[u8]| all(packed).map(|text| text.len()).unwrap_err().kind();
    assert_eq!(kind(&gzip(&zeros)), "gzip-bomb");
    assert_eq!(kind(&zstd(&zeros)), "gzip-bomb");
    assert_eq!(kind(&gzip(&vec![b'x'; 2 << 20])), "line-too-long");
    let limits = Limits {
        bytes: 10,
        ..Limits::default()
    };
    assert_eq!(
        Source::open(&[b'1'; 11], &limits).err().unwrap().kind(),
        "too-large"
    );
}

#[test]
fn damaged_archives_are_refused() {
    let packed = gzip(b"t,z_f\n0,1\n");
    assert_eq!(
        all(&packed[..packed.len() - 6]).unwrap_err().kind(),
        "corrupt-file"
    );
    let packed = zstd(b"t,z_f\n0,1\n");
    assert_eq!(
        all(&packed[..packed.len() - 3]).unwrap_err().kind(),
        "corrupt-file"
    );
    assert_eq!(all(b"\x1f\x8bhello").unwrap_err().kind(), "corrupt-file");
}

#[cfg(not(feature = "spreadsheets"))]
#[test]
fn a_workbook_is_refused_with_what_this_build_lacks() {
    let fault = all(b"PK\x03\x04 xl/workbook.xml").unwrap_err();
    assert_eq!(fault.kind(), "not-built");
    assert!(fault.to_string().contains("`spreadsheets`"), "{fault}");
}

#[test]
fn binaries_are_reported_from_text() {
    assert!(binary(b"PK\x03\x04...").unwrap().contains("zip"));
    assert!(binary(b"t,z\x00").unwrap().contains("offset 3"));
    assert!(binary(&[0x01, 0x80, 0xff, 0x07, 0x41]).is_some());
    assert_eq!(binary("t,z_f [\u{b5}m]\r\n1,2\n\x1a".as_bytes()), None);
    assert_eq!(binary(b""), None);
}

#[test]
fn utf_16_without_a_mark_is_known_by_its_zeros() {
    let name = |bytes: &[u8]| utf16(bytes).map(Encoding::name);
    let header = "Zeit [\u{3bc}s];H\u{f6}he [mm]\n0;1\n";
    assert_eq!(name(&in_utf16(header, false)), Some("UTF-16LE"));
    assert_eq!(name(&in_utf16(header, true)), Some("UTF-16BE"));
    assert_eq!(name(&in_utf16("0;1\n", false)), Some("UTF-16LE"));
    let padded = [header.as_bytes(), &[0; 40]].concat();
    let others: [&[u8]; 7] = [b"", b"0", b"\0", b"0;", &padded, &[0; 64], &[1, 0, 0, 0]];
    for other in others {
        assert_eq!(name(other), None, "{other:?}");
    }
}

#[test]
fn a_broken_surrogate_costs_one_letter() {
    let mut file = in_utf16("\u{feff}0;1\n", false);
    for _ in 0..BLOCK {
        file.extend([0x00, 0xd8, b'1', 0]);
    }
    file.extend([b'\n', 0, b'2']);
    let text = "\u{fffd}1".repeat(BLOCK);
    let Source::Stream(mut stream) = Source::open(&file, &Limits::default()).unwrap() else {
        panic!("not recoded");
    };
    let mut read = String::new();
    stream.reader.read_to_string(&mut read).unwrap();
    assert_eq!(read, format!("0;1\n{text}\n\u{fffd}"));
}
