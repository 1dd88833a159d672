//! Matrices of MATLAB files as columns of numbers, whatever the level of the file.

use crate::error::{Problem, ReadError};

/// A column that the file offers; of length 0 if it does not hold numbers.
#[derive(Clone)]
pub struct Offer {
    pub name: String,
    pub length: usize,
    /// Whether an imaginary part goes with it, which no channel has.
    pub complex: bool,
    /// Whether it is a table, timetable or other object, whose numbers only MATLAB can read.
    pub object: bool,
    /// Rows of its matrix, if that has a row for each channel and not a column.
    pub wide: Option<usize>,
    /// The array of structures that it is in.
    pub structures: Option<String>,
}

impl Offer {
    /// Something that is no column of numbers.
    pub fn other(name: String) -> Self {
        Self {
            name,
            length: 0,
            complex: false,
            object: false,
            wide: None,
            structures: None,
        }
    }
}

/// The numbers of a column as they lie in the file.
pub struct Numbers<'a> {
    /// Their type, as level 5 counts types.
    kind: u32,
    bytes: &'a [u8],
    /// Every how many of them counts.
    step: usize,
    big_endian: bool,
}

pub type Visit<'v> = dyn FnMut(&Offer, &Numbers<'_>) -> Result<(), ReadError> + 'v;

impl<'a> Numbers<'a> {
    pub fn new(kind: u32, bytes: &'a [u8], big_endian: bool) -> Self {
        Numbers {
            kind,
            bytes,
            step: 1,
            big_endian,
        }
    }

    pub fn none() -> Self {
        Self::new(1, &[], false)
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

    /// Each `step`-th number from this one on.
    fn every(&self, step: usize, from: usize) -> Numbers<'a> {
        Numbers {
            bytes: &self.bytes[from * self.width()..],
            step,
            ..*self
        }
    }

    pub fn iter(&self) -> impl Iterator<Item = f64> {
        let chunks = self.bytes.chunks_exact(self.width()).step_by(self.step);
        chunks.map(|chunk| {
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

/// Visits the columns of a matrix, or its rows if these are longer.
pub fn visit_columns(
    name: &str,
    (rows, columns): (usize, usize),
    complex: bool,
    numbers: &Numbers<'_>,
    visit: &mut Visit<'_>,
) -> Result<(), ReadError> {
    if rows.checked_mul(columns) != Some(numbers.len()) {
        return Err(corrupt(&format!(
            "{name} does not contain {rows} x {columns} numbers"
        ))
        .into());
    }
    if rows == 1 || columns == 1 {
        let length = rows * columns;
        let offer = Offer {
            length,
            complex,
            ..Offer::other(name.to_owned())
        };
        return visit(&offer, numbers);
    }
    // A channel has more samples than a ride has channels.
    let wide = (rows < columns).then_some(rows);
    let (count, length) = (rows.min(columns), rows.max(columns));
    for index in 0..count.min(1024) {
        let offer = Offer {
            length,
            complex,
            wide,
            ..Offer::other(format!("{name}#{}", index + 1))
        };
        let part = match wide {
            Some(rows) => numbers.every(rows, index),
            None => numbers.part(index * rows, rows),
        };
        visit(&offer, &part)?;
    }
    Ok(())
}

pub fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
    String::from_utf8_lossy(&bytes[..end]).trim().to_owned()
}

pub fn corrupt(cause: &str) -> Problem {
    Problem::Corrupt {
        format: "MATLAB",
        cause: cause.to_owned(),
    }
}
