//! The text of a ride file in blocks of whole lines, unpacked and recoded on the way.
//!
//! A compressed text is never held unpacked: a block is about a megabyte, and both the unpacked
//! size and (in [`Source::most_cells`]) the numbers made of it are bounded by the packed size.

use std::io::{self, Cursor, Read};

use encoding_rs::{Encoding, UTF_16BE, UTF_16LE};
use encoding_rs_io::DecodeReaderBytesBuilder;
use flate2::bufread::MultiGzDecoder;

use crate::error::Problem;
#[cfg(feature = "spreadsheets")]
use crate::formats::xlsx;
use crate::formats::zstd::Zstd;
use crate::formats::{spreadsheet, track};
use crate::options::Limits;

const BLOCK: usize = 1 << 20;
/// Bytes by which the encoding of a text is recognised.
const HEAD: u64 = 64;

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
    most_numbers: usize,
}

/// How a file is packed, and what unpacks it.
type Packed<'a> = (&'static str, Box<dyn Read + 'a>);

pub fn unpacking(bytes: &[u8]) -> Option<Packed<'_>> {
    match bytes {
        [0x1f, 0x8b, ..] => Some(("gzip", Box::new(MultiGzDecoder::new(bytes)))),
        [0x28, 0xb5, 0x2f, 0xfd, ..] => Some(("zstd", Box::new(Zstd::new(bytes)))),
        _ => None,
    }
}

impl<'a> Source<'a> {
    pub fn open(bytes: &'a [u8], limits: &Limits) -> Result<Self, Problem> {
        if bytes.len() as u64 > limits.bytes {
            return Err(Problem::TooLarge {
                bytes: bytes.len() as u64,
                limit: limits.bytes,
            });
        }
        let (format, mut reader): Packed<'a> = match unpacking(bytes) {
            Some(packed) => packed,
            None if spreadsheet::is_xlsx(bytes) => {
                let text = of_workbook(bytes, limits)?;
                let text = Cursor::new(text.into_bytes());
                (spreadsheet::FORMAT, Box::new(text))
            }
            None if track::is_track(bytes) => {
                let text = track::text(bytes)?;
                (track::FORMAT, Box::new(Cursor::new(text.into_bytes())))
            }
            None if utf16(bytes).is_some() => ("UTF-16", Box::new(bytes)),
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
            .take(HEAD)
            .read_to_end(&mut head)
            .map_err(corrupt)?;
        let reader = DecodeReaderBytesBuilder::new()
            .encoding(utf16(&head))
            .utf8_passthru(true)
            .strip_bom(true)
            .build(Cursor::new(head).chain(reader));
        Ok(Self::Stream(Stream {
            reader: Box::new(reader),
            format,
            buffer: vec![0; BLOCK],
            used: 0,
            filled: 0,
            ended: false,
            packed: bytes.len(),
            unpacked: 0,
            most_unpacked: limits.most_unpacked(bytes.len()),
            most_numbers: limits.most_numbers(bytes.len()),
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
                let limit = stream.most_numbers;
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

/// The UTF-16 of a text, by its byte order mark, or else by the zeros that half of its letters have on one side and none on the other.
fn utf16(bytes: &[u8]) -> Option<&'static Encoding> {
    let head = &bytes[..bytes.len().min(HEAD as usize)];
    let zeros = |at| head.chunks_exact(2).filter(|pair| pair[at] == 0).count();
    let half = head.len().div_ceil(4);
    match (head, zeros(0), zeros(1)) {
        ([0xff, 0xfe, ..], ..) => Some(UTF_16LE),
        ([0xfe, 0xff, ..], ..) => Some(UTF_16BE),
        ([_, _, ..], 0, zeros) if zeros >= half => Some(UTF_16LE),
        ([_, _, ..], zeros, 0) if zeros >= half => Some(UTF_16BE),
        _ => None,
    }
}

/// What a file that is not text seems to be.
pub fn binary(head: &[u8]) -> Option<String> {
    const KNOWN: &[(&[u8], &str)] = &[
        (
            b"PK\x03\x04",
            "a zip archive (unpack it and send the files in it) or a spreadsheet (save it as .xlsx or CSV)",
        ),
        (
            b"\xd0\xcf\x11\xe0",
            "an old Excel workbook (save it as .xlsx or CSV)",
        ),
        (b"TDSm", "a LabVIEW TDMS file (export it as CSV)"),
        (b"MDF     ", "an MDF measurement file (export it as CSV)"),
        (
            b"\x93NUMPY",
            "a NumPy array (save it with savetxt, or as .mat)",
        ),
        (b"#ROSBAG", "a ROS bag (export it with rostopic echo -p)"),
        (
            b"\x89HDF",
            "an HDF5 file that MATLAB did not write (save it as CSV, or as .mat v7)",
        ),
        (b"\x1f\x8b", "a gzip file inside another"),
        (b"\x28\xb5\x2f\xfd", "a zstd file inside another"),
        (b"PAR1", "a Parquet file"),
        (b"SQLite format 3", "an SQLite database"),
        (b"%PDF", "a PDF document"),
        (b"\x89PNG", "a PNG picture"),
        (b"\xff\xd8\xff", "a JPEG picture"),
    ];
    if let Some((_, what)) = KNOWN.iter().find(|(magic, _)| head.starts_with(magic)) {
        return Some((*what).to_owned());
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
mod tests;
