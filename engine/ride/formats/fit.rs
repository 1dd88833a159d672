//! Garmin FIT: speed and cadence of a head unit, by times of day. Format: "FIT Protocol", Garmin, 2023; message `record`.

use std::borrow::Cow;

use rustyfit::profile::typedef::MesgNum;
use rustyfit::proto::{Message, Value};
use rustyfit::{Decoder, DecoderEvent, StreamingIterator};

use crate::channels::glimpse::Glimpse;
use crate::channels::table::Table;
use crate::error::{Problem, ReadError};
use crate::formats::header::Offered;
use crate::options::ReadOptions;

const TIMESTAMP: u8 = 253;
/// What the fields of a record hold: number, name, units of the file in one of ours. Of two with one name the last goes before.
const FIELDS: [(u8, &str, f64); 7] = [
    (6, "v", 1e3),
    (73, "v", 1e3),
    (4, "cadence", 1.0),
    (5, "distance", 100.0),
    (2, "altitude", 5.0),
    (3, "heart_rate", 1.0),
    (7, "power", 1.0),
];
const NAMES: [&str; 6] = [
    "v",
    "cadence",
    "distance",
    "altitude",
    "heart_rate",
    "power",
];
/// Seconds from 1970 to the beginning of FIT's time, and the least stamp that counts from there; lower ones count from when the
/// device was switched on.
const EPOCH_S: f64 = 631_065_600.0;
const LEAST_DATE: u32 = 0x1000_0000;
const DAY_S: u32 = 86_400;

pub fn is_fit(bytes: &[u8]) -> bool {
    bytes.get(8..12) == Some(b".FIT")
}

/// Reads the records of a FIT file, of several if they are chained.
pub fn read(bytes: &[u8], options: &ReadOptions) -> Result<Table, ReadError> {
    let (length, limit) = (bytes.len() as u64, options.limits.bytes);
    if length > limit {
        return Err(Problem::TooLarge {
            bytes: length,
            limit,
        }
        .into());
    }
    let Records {
        stamps,
        values,
        warnings,
    } = records(bytes, options)?;
    let rows = stamps.len();
    let (from, to) = options.rows.unwrap_or((0, rows));
    if from >= rows {
        return Err(match rows {
            0 => Problem::HeaderOnly,
            _ => Problem::BadRows { from, to, rows },
        }
        .into());
    }
    let range = from..to.min(rows);
    let first = stamps[from];
    let reported = |n: &usize| values[*n].iter().any(|v| !v.is_nan());
    let reported: Vec<usize> = (0..NAMES.len()).filter(reported).collect();
    let names: Vec<String> = ["t"]
        .into_iter()
        .chain(reported.iter().map(|n| NAMES[*n]))
        .map(str::to_owned)
        .collect();
    let recognised = Offered {
        names: &names,
        units: &[],
        are_times: &[],
        paces: &[],
        line: None,
    }
    .recognise(options)?;
    let column = |number: usize| match number {
        1 => stamps[range.clone()]
            .iter()
            .map(|t| f64::from(*t) - f64::from(first))
            .collect(),
        number => values[reported[number - 2]][range.clone()].to_vec(),
    };
    let glimpses = (names.iter().zip(1..))
        .map(|(name, number)| Glimpse::of_numbers(name, column(number).into_iter()))
        .collect();
    Ok(Table {
        rows: range.len(),
        glimpses,
        epoch_s: (first >= LEAST_DATE).then(|| EPOCH_S + f64::from(first)),
        unfound: recognised.unfound,
        ignored: recognised.ignored,
        warnings: [recognised.warnings, warnings].concat(),
        format: "Garmin FIT".to_owned(),
        columns: (recognised.specs.into_iter())
            .map(|spec| (spec.clone(), column(spec.number)))
            .collect(),
        ..Table::default()
    })
}

/// One row for each second that was recorded.
#[derive(Default)]
struct Records {
    stamps: Vec<u32>,
    values: [Vec<f64>; NAMES.len()],
    /// What is damaged.
    warnings: Vec<String>,
}

fn records(bytes: &[u8], options: &ReadOptions) -> Result<Records, Problem> {
    let most = (options.limits.rows).min(options.limits.most_numbers(bytes.len()) / NAMES.len());
    let mut out = Records::default();
    let mut rest = bytes;
    while let Some(part) = Part::first_of(rest) {
        let before = out.stamps.len();
        let end = out.read(&part, most)?;
        let rows = out.stamps.len() - before;
        match (&part.damage, end) {
            (None, None) => {}
            (None, Some(cause)) => return Err(corrupt(cause)),
            (Some(damage), end) if rows == 0 => {
                let end = end.map(|cause| format!(" ({cause})")).unwrap_or_default();
                return Err(corrupt(format!("{damage}; no record is intact{end}")));
            }
            (Some(damage), _) => out.warnings.push(format!(
                "{damage}; the {rows} seconds recorded before its end or first damage are read"
            )),
        }
        rest = &rest[part.length..];
    }
    match rest.len() {
        0 => {}
        length if length == bytes.len() => return Err(corrupt("not a FIT file".to_owned())),
        length => (out.warnings).push(format!("{length} bytes after the checksum are not read")),
    }
    Ok(out)
}

fn corrupt(cause: String) -> Problem {
    Problem::Corrupt {
        format: "FIT",
        cause,
    }
}

/// One file of several that may be chained.
struct Part<'a> {
    /// Header and messages, and the checksum if it is right; the header declares the size that is there.
    bytes: Cow<'a, [u8]>,
    /// Bytes of the file that it takes up.
    length: usize,
    damage: Option<String>,
}

impl<'a> Part<'a> {
    /// What begins with a header, if anything does.
    fn first_of(rest: &'a [u8]) -> Option<Self> {
        let head = usize::from(*rest.first()?);
        if !matches!(head, 12 | 14) || rest.len() < head || !is_fit(rest) {
            return None;
        }
        let declared = u32::from_le_bytes(rest.get(4..8)?.try_into().ok()?) as usize;
        let end = head.saturating_add(declared);
        let found = rest.get(end..end.saturating_add(2));
        if let Some(found) = found {
            let found = u16::from_le_bytes([found[0], found[1]]);
            let expected = checksum(&rest[..end]);
            if (found == expected || found == checksum(&rest[head..end])) && has_sound_head(rest) {
                return Some(Self {
                    bytes: Cow::Borrowed(&rest[..end + 2]),
                    length: end + 2,
                    damage: None,
                });
            }
            if declared > 0 {
                let damage = match found {
                    0 => "the checksum is zero, as some devices write it".to_owned(),
                    _ => format!("the checksum is {found:#06x}, expected {expected:#06x}"),
                };
                return Some(Self::damaged(rest, head, end, end + 2, damage));
            }
        }
        let there = rest.len() - head;
        let (end, damage) = match declared {
            0 => {
                let is_closed = there >= 2 && checksum(&rest[head..]) == 0;
                let end = rest.len() - if is_closed { 2 } else { 0 };
                let damage = "the file declares a size of 0 bytes and so has no valid checksum";
                (end, damage.to_owned())
            }
            _ if end <= rest.len() => (end, "the checksum is missing".to_owned()),
            _ => {
                let damage = format!(
                    "the file is cut: {there} of {declared} bytes and no checksum are there"
                );
                (rest.len(), damage)
            }
        };
        Some(Self::damaged(rest, head, end, rest.len(), damage))
    }

    /// The messages up to `end`, under a header that says so. No checksum follows, lest its bytes complete a cut record.
    fn damaged(rest: &[u8], head: usize, end: usize, length: usize, damage: String) -> Self {
        let mut bytes = rest[..end].to_vec();
        let size = u32::try_from(end - head).unwrap_or(u32::MAX);
        bytes[4..8].copy_from_slice(&size.to_le_bytes());
        Self {
            bytes: Cow::Owned(bytes),
            length,
            damage: Some(damage),
        }
    }
}

/// Whether the checksum of the header is right, or is not given.
fn has_sound_head(file: &[u8]) -> bool {
    match file {
        [14, ..] => file[12..14] == [0, 0] || checksum(&file[..14]) == 0,
        _ => true,
    }
}

/// FIT's checksum: the cyclic redundancy check of polynomial 0xa001, by half bytes; 0 over bytes with their own checksum.
fn checksum(bytes: &[u8]) -> u16 {
    const HALVES: [u16; 16] = [
        0x0000, 0xcc01, 0xd801, 0x1400, 0xf001, 0x3c00, 0x2800, 0xe401, 0xa001, 0x6c00, 0x7800,
        0xb401, 0x5000, 0x9c01, 0x8801, 0x4400,
    ];
    let half = |crc: u16, bits: u8| (crc >> 4) ^ HALVES[usize::from((crc as u8 ^ bits) & 0xf)];
    let byte = |crc, byte: &u8| half(half(crc, *byte), *byte >> 4);
    bytes.iter().fold(0, byte)
}

impl Records {
    /// Adds the records of a part; why it ended early, if it did.
    fn read(&mut self, part: &Part<'_>, most: usize) -> Result<Option<String>, Problem> {
        let builder = Decoder::builder().expand_components(false).checksum(false);
        let mut decoder = builder.build();
        let mut events = decoder.stream(part.bytes.as_ref());
        while let Some(event) = events.next() {
            let message = match event {
                Ok(DecoderEvent::Message(message)) if message.num == MesgNum::RECORD => message,
                Ok(DecoderEvent::Crc(_)) => return Ok(None),
                Ok(_) => continue,
                Err(error) => return Ok(Some(error.to_string())),
            };
            if part.damage.is_some() && self.leaps(message) {
                return Ok(Some("a time is more than a day from the one before".into()));
            }
            self.add(message);
            if self.stamps.len() > most {
                return Err(Problem::TooMany {
                    what: "rows",
                    limit: most,
                });
            }
        }
        Ok(None)
    }

    /// Whether the time of a record is far from the last one, as where the bytes of a damaged file are out of step.
    fn leaps(&self, record: &Message) -> bool {
        let stamp = record.fields.iter().find(|f| f.num == TIMESTAMP);
        let stamp = stamp.and_then(|f| whole(&f.value));
        match (stamp, self.stamps.last()) {
            (Some(stamp), Some(last)) => *last >= LEAST_DATE && stamp.abs_diff(*last) > DAY_S,
            _ => false,
        }
    }

    fn add(&mut self, record: &Message) {
        let stamp = record.fields.iter().find(|f| f.num == TIMESTAMP);
        let Some(stamp) = stamp.and_then(|f| whole(&f.value)) else {
            return;
        };
        // What is recorded in one second may stand in several records.
        if self.stamps.last() != Some(&stamp) {
            self.stamps.push(stamp);
            self.values.iter_mut().for_each(|v| v.push(f64::NAN));
        }
        for (number, name, units) in FIELDS {
            let field = record.fields.iter().find(|f| f.num == number);
            let place = NAMES.iter().position(|n| *n == name);
            if let (Some(value), Some(place)) = (field.and_then(|f| whole(&f.value)), place)
                && let Some(last) = self.values[place].last_mut()
            {
                *last = f64::from(value) / units;
            }
        }
    }
}

/// A whole number; the largest of its type stands for none.
fn whole(value: &Value) -> Option<u32> {
    match value {
        Value::Uint8(v) => (*v < u8::MAX).then(|| u32::from(*v)),
        Value::Uint16(v) => (*v < u16::MAX).then(|| u32::from(*v)),
        Value::Uint32(v) => (*v < u32::MAX).then_some(*v),
        _ => None,
    }
}

#[cfg(test)]
pub mod tests;
