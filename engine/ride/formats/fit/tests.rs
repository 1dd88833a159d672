#![allow(clippy::unwrap_used)]
use proptest::prelude::*;

use super::*;

fn closed(messages: &[u8]) -> Vec<u8> {
    let mut file = vec![12, 0x20, 0x54, 0x08];
    file.extend((messages.len() as u32).to_le_bytes());
    file.extend(b".FIT");
    file.extend(messages);
    file.extend(checksum(&file).to_le_bytes());
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

/// The stamps that are read, as seconds from the first, and the warning.
fn rescued(bytes: &[u8]) -> (Vec<f64>, String) {
    let table = read(bytes, &ReadOptions::default()).unwrap();
    (table.columns[0].1.clone(), table.warnings.join("; "))
}

const START: u32 = 1_000_000_000;

#[test]
fn damaged_files_are_read_as_far_as_they_are_intact() {
    let bytes = file(&[(START, 5000, 80), (START + 1, 5000, 80)]);
    let end = bytes.len() - 2;
    assert_eq!(rescued(&bytes), (vec![0.0, 1.0], String::new()));
    let warned = |bytes: &[u8], stamps: &[f64], word: &str| {
        let (read, warning) = rescued(bytes);
        assert_eq!(read, stamps);
        assert!(warning.contains(word), "{warning}");
    };
    warned(&bytes[..end], &[0.0, 1.0], "the checksum is missing");
    warned(&bytes[..end + 1], &[0.0, 1.0], "the checksum is missing");
    warned(&bytes[..end - 1], &[0.0], "cut: 30 of 31 bytes");
    warned(
        &[&bytes[..end], &[0, 0]].concat(),
        &[0.0, 1.0],
        "the checksum is zero",
    );
    warned(
        &[&bytes[..end], &[1, 2]].concat(),
        &[0.0, 1.0],
        "is 0x0201, expected",
    );
    warned(
        &[&bytes[..], &[7; 40]].concat(),
        &[0.0, 1.0],
        "40 bytes after the checksum",
    );
    let mut unfinished = bytes.clone();
    unfinished[4..8].fill(0);
    warned(&unfinished[..end], &[0.0, 1.0], "a size of 0 bytes");
}

#[test]
fn chained_files_are_all_read() {
    let (first, second) = (file(&[(START, 5000, 80)]), file(&[(START + 1, 5000, 80)]));
    let (stamps, warning) = rescued(&[&first[..], &second].concat());
    assert_eq!((stamps.len(), warning.as_str()), (2, ""));
    let cut = [&first[..], &second[..second.len() - 3]].concat();
    let error = read(&cut, &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("no record is intact"), "{error}");
}

#[test]
fn records_out_of_step_are_left_out() {
    let far = START + 900_000_000;
    let mut bytes = file(&[(START, 5000, 80), (START + 1, 5000, 80), (far, 5000, 80)]);
    assert_eq!(rescued(&bytes).0.len(), 3);
    bytes.truncate(bytes.len() - 2);
    assert_eq!(rescued(&bytes).0, [0.0, 1.0]);
}

#[test]
fn damage_beyond_repair_is_refused() {
    let bytes = file(&[(START, 5000, 80), (START + 1, 5000, 80)]);
    let kind = |bytes: &[u8]| read(bytes, &ReadOptions::default()).unwrap_err().kind();
    assert_eq!(kind(&bytes[..bytes.len() - 12]), "corrupt-file");
    let no_record = [0x40, 0, 0, 0, 0, 1, 0, 1, 0, 0, 4];
    assert_eq!(kind(&closed(&no_record)), "header-only");
    assert_eq!(kind(&bytes[..12]), "corrupt-file");
    let undefined = [0, 1, 2, 3];
    assert_eq!(kind(&closed(&undefined)), "corrupt-file");
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

    #[test]
    fn cut_files_give_the_records_before_the_cut(records in 2u32..30, cut in 0usize..200) {
        let whole: Vec<_> = (0..records).map(|second| (START + second, 5000, 80)).collect();
        let bytes = file(&whole);
        let cut = cut.min(8 * records as usize - 8);
        let read = read(&bytes[..bytes.len() - 2 - cut], &ReadOptions::default()).unwrap();
        prop_assert_eq!(read.rows, records as usize - cut.div_ceil(8));
    }
}
