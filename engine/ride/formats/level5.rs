//! The elements of MATLAB level 5 files: arrays in arrays, packed or not. Format: "MAT-File Format", MathWorks, 2022,
//! chapter 1.

use std::io::Read;

use crate::error::{Problem, ReadError};

pub const HEADER: usize = 128;
const DEEPEST: usize = 4;
/// Data types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Array classes.
const STRUCTURE: u8 = 2;
const NUMERIC: std::ops::RangeInclusive<u8> = 6..=15;
const OPAQUE: u8 = 17;
/// Flag of an array with an imaginary part.
const COMPLEX: u32 = 0x800;

/// A column that the file offers; of length 0 if it does not hold numbers.
#[derive(Clone)]
pub struct Offer {
    pub name: String,
    pub length: usize,
    /// Whether an imaginary part goes with it, which no channel has.
    pub complex: bool,
    /// Whether it is a table, timetable or other object, whose numbers only MATLAB can read.
    pub object: bool,
}

impl Offer {
    /// Something that is no column of numbers.
    fn other(name: String) -> Self {
        Self {
            name,
            length: 0,
            complex: false,
            object: false,
        }
    }
}

/// The numbers of a column as they lie in the file.
pub struct Numbers<'a> {
    kind: u32,
    bytes: &'a [u8],
    big_endian: bool,
}

pub type Visit<'v> = dyn FnMut(&Offer, &Numbers<'_>) -> Result<(), ReadError> + 'v;

pub struct File<'a> {
    pub bytes: &'a [u8],
    pub big_endian: bool,
}

impl File<'_> {
    /// Visits every column in the order of the file.
    pub fn columns(&self, visit: &mut Visit<'_>) -> Result<(), ReadError> {
        let mut elements = Elements {
            rest: &self.bytes[HEADER..],
            big_endian: self.big_endian,
        };
        // As for packed text: a bound on what is unpacked, whatever is in it.
        let most = (32 << 20) + 4 * self.bytes.len() as u64;
        let mut unpacked = 0;
        while let Some((kind, data)) = elements.next()? {
            match kind {
                COMPRESSED => {
                    let inside = unpack(data, most - unpacked, self.big_endian)
                        .map_err(|e| corrupt(&e.to_string()))?;
                    unpacked += inside.len() as u64;
                    if unpacked > most {
                        return Err(Problem::GzipBomb {
                            packed: self.bytes.len(),
                            what: "bytes",
                            limit: most,
                        }
                        .into());
                    }
                    let mut inner = Elements {
                        rest: &inside,
                        big_endian: self.big_endian,
                    };
                    if let Some((MATRIX, data)) = inner.next()? {
                        matrix(inner.of(data), None, 0, visit)?;
                    }
                }
                MATRIX => matrix(elements.of(data), None, 0, visit)?,
                _ => {}
            }
        }
        Ok(())
    }
}

/// A packed element, as long as its tag says, up to `most` bytes and one.
fn unpack(packed: &[u8], most: u64, big_endian: bool) -> std::io::Result<Vec<u8>> {
    let mut decoder = flate2::read::ZlibDecoder::new(packed).take(most + 1);
    let mut inside = Vec::new();
    decoder.by_ref().take(8).read_to_end(&mut inside)?;
    let tag = Elements {
        rest: &[],
        big_endian,
    };
    let said = (inside.get(4..8))
        .and_then(|size| tag.u32(size))
        .unwrap_or(0);
    // Once and whole: a buffer that doubles is there twice while it grows.
    inside.reserve_exact(u64::from(said).min(most + 1) as usize);
    decoder.take(said.into()).read_to_end(&mut inside)?;
    Ok(inside)
}

/// One array: a numeric one is visited, a structure is entered, others are only named.
fn matrix(
    mut parts: Elements<'_>,
    field: Option<&str>,
    depth: usize,
    visit: &mut Visit<'_>,
) -> Result<(), ReadError> {
    let Some((_, flags)) = parts.next()? else {
        return Ok(());
    };
    let flags = parts.u32(flags).unwrap_or(0);
    let (class, complex) = (flags as u8, flags & COMPLEX != 0);
    if class == OPAQUE {
        let name = parts
            .next()?
            .map(|(_, name)| text(name))
            .unwrap_or_default();
        let offer = Offer {
            object: true,
            ..Offer::other(name)
        };
        return visit(&offer, &Numbers::none());
    }
    let shape: Vec<usize> = (parts.expect("its size")?.chunks_exact(4))
        .map(|b| parts.u32(b).unwrap_or(0) as usize)
        .collect();
    let own_name = text(parts.expect("its name")?);
    let name = field.map_or(own_name, str::to_owned);
    if class == STRUCTURE && depth < DEEPEST && shape.iter().all(|n| *n == 1) {
        let width = parts.expect("its fields")?;
        let width = parts.u32(width).unwrap_or(0) as usize;
        let names = parts.expect("its fields")?;
        if width == 0 || width > 1024 {
            return Err(corrupt("field names of impossible length").into());
        }
        for name in names.chunks(width) {
            let field = parts.expect("a field")?;
            matrix(parts.of(field), Some(&text(name)), depth + 1, visit)?;
        }
        return Ok(());
    }
    if !NUMERIC.contains(&class) || shape.len() != 2 {
        return visit(&Offer::other(name), &Numbers::none());
    }
    let Some((kind, bytes)) = parts.next()? else {
        return visit(&Offer::other(name), &Numbers::none());
    };
    let numbers = Numbers {
        kind,
        bytes,
        big_endian: parts.big_endian,
    };
    let (rows, columns) = (shape[0], shape[1]);
    if rows.checked_mul(columns) != Some(numbers.len()) {
        return Err(corrupt(&format!(
            "{name} does not contain {rows} x {columns} numbers"
        ))
        .into());
    }
    if rows == 1 || columns == 1 {
        let length = rows * columns;
        let offer = Offer {
            name,
            length,
            complex,
            object: false,
        };
        return visit(&offer, &numbers);
    }
    for column in 0..columns.min(1024) {
        let offer = Offer {
            name: format!("{name}#{}", column + 1),
            length: rows,
            complex,
            object: false,
        };
        visit(&offer, &numbers.part(column * rows, rows))?;
    }
    Ok(())
}

/// Data elements one after the other.
struct Elements<'a> {
    rest: &'a [u8],
    big_endian: bool,
}

impl<'a> Elements<'a> {
    fn of(&self, data: &'a [u8]) -> Elements<'a> {
        Elements {
            rest: data,
            big_endian: self.big_endian,
        }
    }

    fn u32(&self, bytes: &[u8]) -> Option<u32> {
        let bytes: [u8; 4] = bytes.get(..4)?.try_into().ok()?;
        Some(if self.big_endian {
            u32::from_be_bytes(bytes)
        } else {
            u32::from_le_bytes(bytes)
        })
    }

    /// Type and data of the next element.
    fn next(&mut self) -> Result<Option<(u32, &'a [u8])>, Problem> {
        if self.rest.len() < 8 {
            return Ok(None);
        }
        let (Some(tag), Some(size)) = (self.u32(self.rest), self.u32(&self.rest[4..])) else {
            return Ok(None);
        };
        let (kind, start, size, whole) = if tag >> 16 != 0 {
            let size = (tag >> 16) as usize;
            (tag & 0xffff, 4, size.min(4), 8)
        } else {
            let size = size as usize;
            let padded = if tag == COMPRESSED {
                size
            } else {
                size.next_multiple_of(8)
            };
            (tag, 8, size, 8 + padded)
        };
        let data = (self.rest.get(start..start + size))
            .ok_or_else(|| corrupt("it ends within a variable"))?;
        self.rest = self.rest.get(whole..).unwrap_or_default();
        Ok(Some((kind, data)))
    }

    fn expect(&mut self, what: &str) -> Result<&'a [u8], Problem> {
        let element = self.next()?;
        element
            .map(|(_, data)| data)
            .ok_or_else(|| corrupt(&format!("a variable without {what}")))
    }
}

impl<'a> Numbers<'a> {
    fn none() -> Self {
        Numbers {
            kind: 1,
            bytes: &[],
            big_endian: false,
        }
    }

    fn width(&self) -> usize {
        match self.kind {
            1 | 2 => 1,
            3 | 4 => 2,
            5..=7 => 4,
            _ => 8,
        }
    }

    fn len(&self) -> usize {
        self.bytes.len() / self.width()
    }

    fn part(&self, from: usize, length: usize) -> Numbers<'a> {
        let width = self.width();
        Numbers {
            bytes: &self.bytes[from * width..(from + length) * width],
            ..*self
        }
    }

    pub fn iter(&self) -> impl Iterator<Item = f64> {
        self.bytes.chunks_exact(self.width()).map(|chunk| {
            let mut b = [0; 8];
            b[..chunk.len()].copy_from_slice(chunk);
            if self.big_endian {
                b[..chunk.len()].reverse();
            }
            let [b0, b1, b2, b3, ..] = b;
            match self.kind {
                1 => f64::from(b0 as i8),
                2 => f64::from(b0),
                3 => f64::from(i16::from_le_bytes([b0, b1])),
                4 => f64::from(u16::from_le_bytes([b0, b1])),
                5 => f64::from(i32::from_le_bytes([b0, b1, b2, b3])),
                6 => f64::from(u32::from_le_bytes([b0, b1, b2, b3])),
                7 => f64::from(f32::from_le_bytes([b0, b1, b2, b3])),
                12 => i64::from_le_bytes(b) as f64,
                13 => u64::from_le_bytes(b) as f64,
                _ => f64::from_le_bytes(b),
            }
        })
    }
}

fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).trim().to_owned()
}

pub fn corrupt(cause: &str) -> Problem {
    Problem::Corrupt {
        format: "MATLAB",
        cause: cause.to_owned(),
    }
}
