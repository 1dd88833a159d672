//! The text of a ride file in blocks of whole lines, unpacked and recoded on the way.
//!
//! A compressed file is never held unpacked: a block is about a megabyte, and both the unpacked
//! size and (in [`Source::most_cells`]) the numbers made of it are bounded by the packed size.

use std::io::{self, Cursor, Read};

use crate::error::Problem;
#[cfg(feature = "spreadsheets")]
use crate::formats::xlsx;
use crate::formats::zstd::Zstd;
use crate::formats::{spreadsheet, track};
use crate::options::{Limits, most_numbers};

const BLOCK: usize = 1 << 20;

pub enum Source<'a> {
    Whole(Option<&'a [u8]>),
    Stream(Stream<'a>),
}

pub struct Stream<'a> {
    reader: Box<dyn Read + 'a>,
    format: &'static str,
    buffer: Vec<u8>,
    /// Bytes handed out from the front of the buffer, and bytes read into it.
    used: usize,
    filled: usize,
    ended: bool,
    packed: usize,
    unpacked: u64,
    most_unpacked: u64,
}

impl<'a> Source<'a> {
    pub fn open(bytes: &'a [u8], limits: &Limits) -> Result<Self, Problem> {
        if bytes.len() as u64 > limits.bytes {
            return Err(Problem::TooLarge {
                bytes: bytes.len() as u64,
                limit: limits.bytes,
            });
        }
        let packed: Option<(&'static str, Box<dyn Read + 'a>)> = match bytes {
            [0x1f, 0x8b, ..] => Some((
                "gzip",
                Box::new(flate2::bufread::MultiGzDecoder::new(bytes)),
            )),
            [0x28, 0xb5, 0x2f, 0xfd, ..] => Some(("zstd", Box::new(Zstd::new(bytes)))),
            _ if spreadsheet::is_xlsx(bytes) => {
                let text = of_workbook(bytes, limits)?;
                let text = Cursor::new(text.into_bytes());
                Some((spreadsheet::FORMAT, Box::new(text)))
            }
            _ if track::is_track(bytes) => {
                let text = track::text(bytes)?;
                Some((track::FORMAT, Box::new(Cursor::new(text.into_bytes()))))
            }
            _ => None,
        };
        let (format, mut reader) = match packed {
            Some(packed) => packed,
            None if matches!(bytes, [0xff, 0xfe, ..] | [0xfe, 0xff, ..]) => {
                ("UTF-16", Box::new(bytes) as Box<dyn Read + 'a>)
            }
            None => {
                let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
                return Ok(Self::Whole(Some(text)));
            }
        };
        let mut head = Vec::new();
        let corrupt = |e: io::Error| Problem::Corrupt {
            format,
            cause: e.to_string(),
        };
        (&mut reader)
            .take(3)
            .read_to_end(&mut head)
            .map_err(corrupt)?;
        let reader: Box<dyn Read + 'a> = match head.as_slice() {
            [0xef, 0xbb, 0xbf] => reader,
            [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => {
                let big_endian = head[0] == 0xfe;
                Box::new(Utf16::new(
                    Cursor::new(head.split_off(2)).chain(reader),
                    big_endian,
                ))
            }
            _ => Box::new(Cursor::new(head).chain(reader)),
        };
        Ok(Self::Stream(Stream {
            reader,
            format,
            buffer: vec![0; BLOCK],
            used: 0,
            filled: 0,
            ended: false,
            packed: bytes.len(),
            unpacked: 0,
            most_unpacked: limits.bytes.min((64 << 20) + 50 * bytes.len() as u64),
        }))
    }

    /// The next lines, all of them complete except perhaps the file's last; `None` at the end.
    pub fn next_block(&mut self) -> Result<Option<&[u8]>, Problem> {
        match self {
            Self::Whole(text) => Ok(text.take()),
            Self::Stream(stream) => stream.next_block(),
        }
    }

    /// `gzip`, `zstd`, `xlsx`, `GPX or TCX`, `UTF-16` or nothing.
    pub fn format(&self) -> Option<&'static str> {
        match self {
            Self::Whole(_) => None,
            Self::Stream(stream) => Some(stream.format),
        }
    }

    /// How many numbers may be made of a packed file, and the error beyond that.
    pub fn most_cells(&self) -> Option<(usize, Problem)> {
        match self {
            Self::Whole(_) => None,
            Self::Stream(stream) => {
                let limit = most_numbers(stream.packed);
                let bomb = Problem::GzipBomb {
                    packed: stream.packed,
                    what: "numbers",
                    limit: limit as u64,
                };
                Some((limit, bomb))
            }
        }
    }
}

impl Stream<'_> {
    fn next_block(&mut self) -> Result<Option<&[u8]>, Problem> {
        self.buffer.copy_within(self.used..self.filled, 0);
        self.filled -= self.used;
        self.used = 0;
        while !self.ended && self.filled < self.buffer.len() {
            match self.reader.read(&mut self.buffer[self.filled..]) {
                Ok(0) => self.ended = true,
                Ok(n) => {
                    self.filled += n;
                    self.unpacked += n as u64;
                }
                Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                Err(e) => {
                    return Err(Problem::Corrupt {
                        format: self.format,
                        cause: e.to_string(),
                    });
                }
            }
            if self.unpacked > self.most_unpacked {
                return Err(Problem::GzipBomb {
                    packed: self.packed,
                    what: "bytes",
                    limit: self.most_unpacked,
                });
            }
        }
        let text = &self.buffer[..self.filled];
        self.used = if self.ended {
            text.len()
        } else {
            memchr::memrchr(b'\n', text)
                .map(|i| i + 1)
                .ok_or(Problem::LineTooLong { limit: text.len() })?
        };
        Ok((self.used > 0).then(|| &self.buffer[..self.used]))
    }
}

#[cfg(feature = "spreadsheets")]
fn of_workbook(bytes: &[u8], limits: &Limits) -> Result<String, Problem> {
    xlsx::text(bytes, limits)
}

#[cfg(not(feature = "spreadsheets"))]
fn of_workbook(_: &[u8], _: &Limits) -> Result<String, Problem> {
    Err(Problem::NotBuilt {
        what: "an Excel workbook",
        feature: "spreadsheets",
    })
}

/// Recodes UTF-16 to UTF-8; a broken surrogate becomes U+FFFD.
struct Utf16<R> {
    inner: R,
    big_endian: bool,
    /// A code unit's first byte, a pair's first unit, and text not handed out yet.
    odd: Option<u8>,
    high: Option<u16>,
    ready: Vec<u8>,
    given: usize,
}

impl<R: Read> Utf16<R> {
    fn new(inner: R, big_endian: bool) -> Self {
        Self {
            inner,
            big_endian,
            odd: None,
            high: None,
            ready: Vec::new(),
            given: 0,
        }
    }

    fn refill(&mut self) -> io::Result<()> {
        let mut raw = [0; 16 << 10];
        let n = self.inner.read(&mut raw)?;
        let bytes = self.odd.take().into_iter().chain(raw[..n].iter().copied());
        let mut units: Vec<u16> = self.high.take().into_iter().collect();
        let mut first = None;
        for byte in bytes {
            match first.take() {
                None => first = Some(byte),
                Some(a) if self.big_endian => units.push(u16::from_be_bytes([a, byte])),
                Some(a) => units.push(u16::from_le_bytes([a, byte])),
            }
        }
        self.odd = first.filter(|_| n > 0);
        if n > 0 && units.last().is_some_and(|u| (0xd800..0xdc00).contains(u)) {
            self.high = units.pop();
        }
        self.ready.clear();
        self.given = 0;
        for c in char::decode_utf16(units) {
            let c = c.unwrap_or(char::REPLACEMENT_CHARACTER);
            self.ready
                .extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes());
        }
        if n > 0 && self.ready.is_empty() {
            return self.refill();
        }
        Ok(())
    }
}

impl<R: Read> Read for Utf16<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.given == self.ready.len() {
            self.refill()?;
        }
        let n = (&self.ready[self.given..]).read(out)?;
        self.given += n;
        Ok(n)
    }
}

/// What a file that is not text seems to be.
pub fn binary(head: &[u8]) -> Option<String> {
    const KNOWN: &[(&[u8], &str)] = &[
        (b"PK\x03\x04", "a zip archive or a spreadsheet"),
        (
            b"\x89HDF",
            "an HDF5 file that MATLAB did not write (save it as CSV, or as .mat v7)",
        ),
        (b"\x1f\x8b", "a gzip file inside another"),
        (b"\x28\xb5\x2f\xfd", "a zstd file inside another"),
        (b"MATLAB ", "a MATLAB file inside a compressed one"),
        (b"PAR1", "a Parquet file"),
        (b"SQLite format 3", "an SQLite database"),
        (b"%PDF", "a PDF document"),
        (b"\x89PNG", "a PNG picture"),
        (b"\xff\xd8\xff", "a JPEG picture"),
    ];
    if let Some((_, what)) = KNOWN.iter().find(|(magic, _)| head.starts_with(magic)) {
        return Some((*what).to_owned());
    }
    if head.get(8..12) == Some(b".FIT") {
        return Some("a Garmin FIT file".to_owned());
    }
    let head = &head[..head.len().min(4096)];
    let control = |b: &u8| matches!(b, 0..=8 | 14..=25 | 28..=31 | 127);
    if let Some(at) = head.iter().position(|b| *b == 0) {
        return Some(format!("a binary file (byte 0x00 at offset {at})"));
    }
    let odd = head.iter().filter(|b| control(b)).count();
    (odd * 50 > head.len()).then(|| {
        format!(
            "a binary file ({odd} control bytes in the first {})",
            head.len()
        )
    })
}

#[cfg(test)]
mod tests {
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

    fn utf16(text: &str, big: bool) -> Vec<u8> {
        let units = std::iter::once(0xfeff).chain(text.encode_utf16());
        units
            .flat_map(|u: u16| {
                if big {
                    u.to_be_bytes()
                } else {
                    u.to_le_bytes()
                }
            })
            .collect()
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
        assert_eq!(all(&utf16(&text, false)).unwrap(), bytes);
        assert_eq!(all(&gzip(&utf16(&text, true))).unwrap(), bytes);
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
}
