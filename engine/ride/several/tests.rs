//! Rides in several files: where they are placed, and what is refused.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::fmt::Write;

use super::*;
use crate::Ride;
use crate::formats::track;
#[cfg(feature = "spreadsheets")]
use crate::formats::{fit, xlsx};
use crate::options::FileOptions;
use crate::read::{preview, read, read_on_clocks};
use veloid_core::bicycle::Bike;

/// A column of waves at 100 Hz, time stamps written as reported.
fn csv(header: &str, rows: usize, stamp: impl Fn(usize) -> String) -> String {
    let mut text = format!("{header}\n");
    for i in 0..rows {
        let t = i as f64 * 0.01;
        let wave = 1e-3 * ((5.0 * t).sin() + (31.0 * t).sin());
        writeln!(text, "{},{wave:.9}", stamp(i)).unwrap();
    }
    text
}

fn seconds(from: f64) -> impl Fn(usize) -> String {
    move |i| format!("{:.2}", from + i as f64 * 0.01)
}

fn files<'a>(named: &[(&'a str, &'a [u8])]) -> Vec<RideFile<'a>> {
    named
        .iter()
        .map(|(name, bytes)| RideFile::new(name, bytes))
        .collect()
}

fn ride(named: &[(&str, &[u8])], options: &ReadOptions) -> Result<Ride, ReadError> {
    read_on_clocks(&files(named), &Bike::default(), options, &[])
}

fn with(file: &str, own: FileOptions) -> ReadOptions {
    ReadOptions {
        files: BTreeMap::from([(file.to_owned(), own)]),
        ..ReadOptions::default()
    }
}

fn mapped(pairs: &[(&str, &str)]) -> BTreeMap<String, String> {
    pairs
        .iter()
        .map(|(a, b)| ((*a).to_owned(), (*b).to_owned()))
        .collect()
}

fn span(ride: &Ride, file: usize) -> [f64; 2] {
    let file = &ride.summary.files[file];
    [file.from_s, file.to_s].map(|t| (1e6 * t).round() / 1e6)
}

#[test]
fn files_whose_stamps_begin_anywhere_begin_together() {
    let (z, u) = (
        csv("t,z_f", 2000, seconds(0.0)),
        csv("t,u_f", 2000, seconds(77.5)),
    );
    let both = ride(
        &[("z.csv", z.as_bytes()), ("u.csv", u.as_bytes())],
        &ReadOptions::default(),
    )
    .unwrap();
    let lines = z
        .lines()
        .zip(u.lines())
        .map(|(z, u)| format!("{z},{}\n", u.split(',').nth(1).unwrap()));
    let one: String = lines.collect();
    let one = read(
        one.as_bytes(),
        "one.csv",
        &Bike::default(),
        &ReadOptions::default(),
    )
    .unwrap();
    assert_eq!(both.axles, one.axles);
    assert_eq!(
        (both.start_s, both.samples, both.summary.rows),
        (0.0, 2000, 4000)
    );
    let summary = &both.summary;
    assert_eq!(summary.file_of("u_f"), Some("u.csv"));
    assert_eq!(summary.files[1].shift_s, -77.5);
    assert_eq!(summary.files[0].kept, None);
    let kept = summary.files[1].kept.as_ref().unwrap();
    assert!(kept.contains("aligned with z.csv"), "{kept}");
    assert!(
        summary
            .warnings
            .iter()
            .any(|w| w.starts_with("u.csv: ") && w.ends_with(kept))
    );

    let later = FileOptions {
        offset_s: Some(1.5),
        ..FileOptions::default()
    };
    let moved = ride(
        &[("z.csv", z.as_bytes()), ("u.csv", u.as_bytes())],
        &with("logs/u.csv", later),
    )
    .unwrap();
    assert_eq!(span(&moved, 1), [1.5, 21.49]);
    assert_eq!(moved.samples, 1850);
}

#[test]
fn stamps_that_are_dates_place_a_file() {
    let iso = csv("t,z_f", 2000, |i| {
        format!("2026-11-23T09:51:{:02}.{:02}0+01:00", i / 100, i % 100)
    });
    // A logger that writes milliseconds since 1970, switched on 2.5 s later, and one that knows no date.
    let start = 1_795_423_860_000.0 + 2500.0;
    let epoch = csv("t,u_f", 1500, |i| format!("{:.0}", start + 10.0 * i as f64));
    let loose = csv("t,v", 2000, seconds(5.0));
    let named = [
        ("z.csv", iso.as_bytes()),
        ("v.csv", loose.as_bytes()),
        ("u.csv", epoch.as_bytes()),
    ];
    let ride = ride(&named, &ReadOptions::default()).unwrap();
    assert_eq!(span(&ride, 0), [0.0, 19.99]);
    assert_eq!(span(&ride, 1), [0.0, 19.99]);
    let [from, to] = span(&ride, 2);
    assert!(
        (from - 2.5).abs() < 1e-6 && (to - 17.49).abs() < 1e-6,
        "{from} {to}"
    );
    let dated: Vec<bool> = ride.summary.files.iter().map(|f| f.dated).collect();
    assert_eq!(dated, [true, false, true]);
    assert!(
        ride.summary.files[2]
            .kept
            .as_ref()
            .unwrap()
            .contains("used as they are")
    );
    assert!(
        ride.summary
            .warnings
            .iter()
            .any(|w| w.contains("milliseconds since 1970"))
    );
}

#[cfg(feature = "spreadsheets")]
#[test]
fn a_workbook_and_a_head_unit_are_files_too() {
    let start = 1_000_000_000_u32;
    let records: Vec<(u32, u16, u8)> = (0..30).map(|i| (start + i, 5000 + i as u16, 80)).collect();
    let fit = fit::tests::file(&records);
    let epoch = 631_065_600.0 + f64::from(start) + 4.0;
    let text = csv("t,a_f", 2000, |i| format!("{:.2}", epoch + i as f64 * 0.01));
    let rows: Vec<Vec<String>> = text
        .lines()
        .map(|l| l.split(',').map(str::to_owned).collect())
        .collect();
    let xlsx = xlsx::tests::workbook(&rows);
    let named: [(&str, &[u8]); 2] = [("imu.xlsx", &xlsx), ("unit.fit", &fit)];
    let ride = ride(&named, &ReadOptions::default()).unwrap();
    let formats: Vec<&str> = ride
        .summary
        .files
        .iter()
        .map(|f| f.format.as_str())
        .collect();
    assert_eq!(formats, ["xlsx, first sheet", "Garmin FIT"]);
    let speed = ride.speed.unwrap();
    assert!(
        (speed[0] - 5.004).abs() < 1e-6 && (speed[1000] - 5.014).abs() < 1e-6,
        "{}",
        speed[0]
    );
    assert_eq!(ride.cadence.unwrap()[5], 80.0);
}

#[test]
fn a_track_gives_the_speed_by_its_times_of_day() {
    let speeds: Vec<f64> = (0..30).map(|i| 5.0 + 1e-3 * f64::from(i)).collect();
    let track = track::tests::gpx("2026-05-01T10:00", &speeds);
    let epoch = 1_777_629_604.0;
    let text = csv("t,a_f", 2000, |i| format!("{:.2}", epoch + i as f64 * 0.01));
    let named: [(&str, &[u8]); 2] = [("imu.csv", text.as_bytes()), ("ride.gpx", track.as_bytes())];
    let ride = ride(&named, &ReadOptions::default()).unwrap();
    assert_eq!(ride.summary.files[1].format, "GPX or TCX track");
    let speed = ride.speed.unwrap();
    assert!((speed[0] - 5.004).abs() < 1e-6, "{}", speed[0]);
    assert!((speed[1000] - 5.014).abs() < 1e-6, "{}", speed[1000]);
    assert_eq!(ride.cadence.unwrap()[5], 80.0);
}

#[test]
fn what_is_said_of_one_file_holds_for_it_alone() {
    let z = csv("time,height", 2000, seconds(0.0));
    let u = csv("x,ground", 2000, |_| "NA".to_owned());
    let own = FileOptions {
        rate_hz: Some(100.0),
        map: mapped(&[("u_f", "ground")]),
        ..FileOptions::default()
    };
    let options = ReadOptions {
        map: mapped(&[("t", "time"), ("z_f", "height")]),
        missing: vec!["NA".to_owned()],
        ..with("u.csv", own)
    };
    let named = [("z.csv", z.as_bytes()), ("u.csv", u.as_bytes())];
    assert_eq!(ride(&named, &options).unwrap().samples, 2000);
    let seen = preview(&files(&named), &options).unwrap();
    assert_eq!((seen.problem, seen.files.len(), seen.rows), (None, 2, 4000));
    assert_eq!(seen.format.matches("csv: text").count(), 2);
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let (z, u) = (
        csv("t,z_f", 200, seconds(0.0)),
        csv("t,u_f", 200, seconds(0.0)),
    );
    let named = [("z.csv", z.as_bytes()), ("u.csv", u.as_bytes())];
    let fault = |named: &[(&str, &[u8])], options: &ReadOptions| {
        let fault = ride(named, options).unwrap_err();
        (fault.kind(), fault.to_string())
    };
    let plain = ReadOptions::default();
    let twice = fault(&[named[0], ("z2.csv", z.as_bytes())], &plain);
    assert_eq!(twice.0, "channel-twice");
    assert!(
        twice
            .1
            .starts_with("z2.csv, column 2 (z_f): z_f is already in z.csv, column 2"),
        "{}",
        twice.1
    );
    assert_eq!(fault(&[named[0], named[0]], &plain).0, "same-name");
    let other = fault(&named, &with("x.csv", FileOptions::default()));
    assert!(
        other.0 == "unknown-file" && other.1.contains("'x.csv', expected one of z.csv, u.csv"),
        "{}",
        other.1
    );
    let column = FileOptions {
        map: mapped(&[("u_f", "z_f")]),
        ..FileOptions::default()
    };
    let column = fault(&named, &with("u.csv", column));
    assert!(
        column.0 == "missing-column" && column.1.starts_with("u.csv: "),
        "{}",
        column.1
    );
    let nowhere = ReadOptions {
        map: mapped(&[("v", "speed")]),
        ..ReadOptions::default()
    };
    assert_eq!(fault(&named, &nowhere).0, "missing-column");
    let rows = ReadOptions {
        rows: Some((0, 99)),
        ..ReadOptions::default()
    };
    assert_eq!(fault(&named, &rows).0, "bad-option");
    let none = fault(&[named[0], ("n.csv", b"t,x\n0,1\n1,2\n")], &plain);
    assert!(
        none.0 == "no-channel" && none.1.contains("found t, x"),
        "{}",
        none.1
    );
    let apart = FileOptions {
        offset_s: Some(3.0),
        ..FileOptions::default()
    };
    let apart = fault(&named, &with("u.csv", apart));
    assert!(
        apart.0 == "files-apart" && apart.1.contains("u.csv from 3.0 s to 5.0 s"),
        "{}",
        apart.1
    );
    assert_eq!(fault(&[], &plain).0, "file-count");
    let mixed = z.replace("\n0.0", "\n2026-11-23T09:51:10.0");
    assert_eq!(
        fault(&[("z.csv", mixed.as_bytes()), named[1]], &plain).0,
        "other-time"
    );
}
