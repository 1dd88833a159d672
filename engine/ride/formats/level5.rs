//! The elements of MATLAB level 5 files: arrays in arrays, packed or not. Format: "MAT-File Format", MathWorks, 2022,
//! chapter 1.

use std::io::Read;

use crate::error::{Problem, ReadError};
use crate::formats::matrix::{Numbers, Offer, Visit, corrupt, text, visit_columns};

const HEADER: usize = 128;
const DEEPEST: usize = 4;
/// Most structures of an array that are entered.
const MOST_STRUCTURES: usize = 1024;
/// Data types of elements.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Array classes.
const STRUCTURE: u8 = 2;
const NUMERIC: std::ops::RangeInclusive<u8> = 6..=15;
const OPAQUE: u8 = 17;
/// Flag of an array with an imaginary part.
const COMPLEX: u32 = 0x800;

pub fn begins(bytes: &[u8]) -> bool {
    bytes.starts_with(b"MATLAB ") && matches!(bytes.get(126..HEADER), Some(b"IM" | b"MI"))
}

/// Visits every column in the order of the file, of which no more than `limit` bytes are unpacked.
pub fn columns(bytes: &[u8], limit: u64, visit: &mut Visit<'_>) -> Result<(), ReadError> {
    let (header, rest) = bytes.split_at(HEADER.min(bytes.len()));
    let big_endian = header.ends_with(b"MI");
    let mut elements = Elements { rest, big_endian };
    // As for packed text: a bound on what is unpacked, whatever is in it.
    let most = limit.min((32 << 20) + 4 * bytes.len() as u64);
    let mut unpacked = 0;
    while let Some((kind, data)) = elements.next()? {
        match kind {
            COMPRESSED => {
                let inside = unpack(data, most - unpacked, big_endian)
                    .map_err(|e| corrupt(&e.to_string()))?;
                unpacked += inside.len() as u64;
                if unpacked > most {
                    return Err(Problem::GzipBomb {
                        packed: bytes.len(),
                        what: "bytes",
                        limit: most,
                    }
                    .into());
                }
                let mut inner = Elements {
                    rest: &inside,
                    big_endian,
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
    if class == STRUCTURE
        && depth < DEEPEST
        && let Some(count) = elements_of(&shape)
    {
        let width = parts.expect("its fields")?;
        let width = parts.u32(width).unwrap_or(0) as usize;
        let names = parts.expect("its fields")?;
        if width == 0 || width > 1024 {
            return Err(corrupt("field names of impossible length").into());
        }
        for at in 1..=count {
            for field in names.chunks(width).map(text) {
                let value = parts.expect("a field")?;
                if count == 1 {
                    matrix(parts.of(value), Some(&field), depth + 1, visit)?;
                    continue;
                }
                let prefix = format!("{name}({at}).");
                matrix(
                    parts.of(value),
                    Some(&field),
                    depth + 1,
                    &mut |offer, numbers| {
                        let offer = Offer {
                            name: format!("{prefix}{}", offer.name),
                            structures: Some(name.clone()),
                            ..offer.clone()
                        };
                        visit(&offer, numbers)
                    },
                )?;
            }
        }
        return Ok(());
    }
    if !NUMERIC.contains(&class) || shape.len() != 2 {
        return visit(&Offer::other(name), &Numbers::none());
    }
    let Some((kind, bytes)) = parts.next()? else {
        return visit(&Offer::other(name), &Numbers::none());
    };
    let numbers = Numbers::new(kind, bytes, parts.big_endian);
    visit_columns(&name, (shape[0], shape[1]), complex, &numbers, visit)
}

/// How many structures an array of them has, if so many can be channels.
fn elements_of(shape: &[usize]) -> Option<usize> {
    let count = shape
        .iter()
        .try_fold(1, |count: usize, n| count.checked_mul(*n))?;
    (1..=MOST_STRUCTURES).contains(&count).then_some(count)
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
