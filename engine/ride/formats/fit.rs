//! Garmin FIT: speed and cadence of a head unit, by times of day. Format: "FIT Protocol", Garmin, 2023; message `record`.

use rustyfit::profile::typedef::MesgNum;
use rustyfit::proto::{Message, Value};
use rustyfit::{Decoder, DecoderEvent, StreamingIterator};

use crate::channels::glimpse::Glimpse;
use crate::channels::table::Table;
use crate::error::{Problem, ReadError};
use crate::formats::header::Offered;
use crate::options::{ReadOptions, most_numbers};

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
    let Records { stamps, values } = records(bytes, options)?;
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
        warnings: recognised.warnings,
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
}

fn records(bytes: &[u8], options: &ReadOptions) -> Result<Records, Problem> {
    let most = (options.limits.rows).min(most_numbers(bytes.len()) / NAMES.len());
    let mut decoder = Decoder::builder().expand_components(false).build();
    let mut events = decoder.stream(bytes);
    let mut out = Records::default();
    while let Some(event) = events.next() {
        let event = event.map_err(|error| Problem::Corrupt {
            format: "FIT",
            cause: error.to_string(),
        })?;
        if let DecoderEvent::Message(message) = event
            && message.num == MesgNum::RECORD
        {
            out.add(message);
            if out.stamps.len() > most {
                return Err(Problem::TooMany {
                    what: "rows",
                    limit: most,
                });
            }
        }
    }
    Ok(out)
}

impl Records {
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
pub mod tests {
    #![allow(clippy::unwrap_used)]
    use proptest::prelude::*;

    use super::*;

    /// FIT's checksum (the protocol's chapter on CRC).
    fn crc(bytes: &[u8]) -> u16 {
        let step = |crc: u16, bit: u8| {
            (crc >> 1)
                ^ if (crc as u8 ^ bit) & 1 == 1 {
                    0xa001
                } else {
                    0
                }
        };
        let byte = |crc, byte: &u8| (0..8).fold(crc, |crc, i| step(crc, byte >> i));
        bytes.iter().fold(0, byte)
    }

    fn closed(messages: &[u8]) -> Vec<u8> {
        let mut file = vec![12, 0x20, 0x54, 0x08];
        file.extend((messages.len() as u32).to_le_bytes());
        file.extend(b".FIT");
        file.extend(messages);
        file.extend(crc(&file).to_le_bytes());
        file
    }

    /// Records of a stamp, a speed (mm/s) and a cadence.
    pub fn file(records: &[(u32, u16, u8)]) -> Vec<u8> {
        let mut messages = vec![0x40, 0, 0, 20, 0, 3, 253, 4, 0x86, 6, 2, 0x84, 4, 1, 0x02];
        for (stamp, speed, cadence) in records {
            messages.push(0);
            messages.extend(stamp.to_le_bytes());
            messages.extend(speed.to_le_bytes());
            messages.push(*cadence);
        }
        closed(&messages)
    }

    #[test]
    fn speed_and_cadence_are_read_by_times_of_day() {
        let start = 1_000_000_000;
        let bytes = file(&[
            (start, 5000, 80),
            (start + 1, 0xffff, 81),
            (start + 1, 5250, 0xff),
            (start + 3, 5500, 82),
        ]);
        assert!(is_fit(&bytes));
        let table = read(&bytes, &ReadOptions::default()).unwrap();
        assert_eq!(table.epoch_s, Some(EPOCH_S + f64::from(start)));
        let column = |i: usize| (table.columns[i].0.channel.name(), &table.columns[i].1[..]);
        assert_eq!(column(0), ("t", &[0.0, 1.0, 3.0][..]));
        assert_eq!(column(1), ("v", &[5.0, 5.25, 5.5][..]));
        assert_eq!(column(2), ("cadence", &[80.0, 81.0, 82.0][..]));
        let rows = ReadOptions {
            rows: Some((1, 2)),
            ..ReadOptions::default()
        };
        assert_eq!(read(&bytes, &rows).unwrap().columns[1].1, [5.25]);
        let early = read(&file(&[(50, 5000, 80)]), &ReadOptions::default()).unwrap();
        assert_eq!(early.epoch_s, None);
    }

    #[test]
    fn damage_is_refused() {
        let bytes = file(&[(1_000_000_000, 5000, 80), (1_000_000_001, 5000, 80)]);
        let kind = |bytes: &[u8]| read(bytes, &ReadOptions::default()).unwrap_err().kind();
        assert_eq!(kind(&bytes[..bytes.len() - 3]), "corrupt-file");
        let mut other = bytes.clone();
        other[30] ^= 1;
        assert_eq!(kind(&other), "corrupt-file");
        let no_record = [0x40, 0, 0, 0, 0, 1, 0, 1, 0, 0, 4];
        assert_eq!(kind(&closed(&no_record)), "header-only");
        assert_eq!(kind(&bytes[..12]), "corrupt-file");
    }

    proptest! {
        #[test]
        fn no_messages_do_harm(messages in prop::collection::vec(any::<u8>(), 0..600), begun in any::<bool>()) {
            let record = [0x40, 0, 0, 20, 0, 1, 253, 4, 0x86];
            let messages = match begun {
                true => [&record[..], &messages].concat(),
                false => messages,
            };
            let _ = read(&closed(&messages), &ReadOptions::default());
        }
    }
}
