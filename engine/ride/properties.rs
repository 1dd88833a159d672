//! Properties of reading: every dialect says the same, and no bytes do harm.
#![allow(clippy::unwrap_used)]

use std::io::Write as _;

use proptest::prelude::*;

use super::*;
use veloid_core::bicycle::Bike;

/// A way to write a table.
#[derive(Clone, Debug)]
struct Style {
    separator: char,
    comma: bool,
    quoted: bool,
    crlf: bool,
    trailing: bool,
    comments: bool,
    units_row: bool,
    /// Number format: fixed decimals or scientific.
    scientific: bool,
    mark: bool,
    packing: u8,
    last_line_end: bool,
    /// Lines of other text above the header.
    preamble: usize,
    /// A row of sources below the units.
    sources: bool,
    minus: bool,
    stamps: Stamps,
}

/// How times are written.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Stamps {
    Seconds,
    OfDay,
    Iso,
    American,
    German,
}

impl Stamps {
    const ALL: [Self; 5] = [
        Self::Seconds,
        Self::OfDay,
        Self::Iso,
        Self::American,
        Self::German,
    ];

    /// `second`: since ten o'clock on 21 May 2026.
    fn write(self, second: f64) -> String {
        let micros = (second * 1e6).round() as i64 + 36_000_000_000;
        let (seconds, rest) = (micros.div_euclid(1_000_000), micros.rem_euclid(1_000_000));
        let (hour, minute) = (seconds / 3600, seconds / 60 % 60);
        let of_day = |hour: i64| format!("{hour:02}:{minute:02}:{:02}.{rest:06}", seconds % 60);
        match self {
            Self::Seconds => format!("{second:.12}"),
            Self::OfDay => of_day(hour),
            Self::Iso => format!("2026-05-21T{}Z", of_day(hour)),
            Self::American => format!("05/21/2026 {} AM", of_day(hour)),
            Self::German => format!("21.05.2026 {}", of_day(hour)),
        }
    }
}

fn styles() -> impl Strategy<Value = Style> {
    let flags = prop::array::uniform8(any::<bool>());
    (
        prop::sample::select(vec![',', ';', '\t', '|', ' ']),
        flags,
        prop::array::uniform3(any::<bool>()),
        0u8..5,
        0usize..4,
        prop::sample::select(Stamps::ALL.to_vec()),
    )
        .prop_map(
            |(separator, [a, b, c, d, e, f, g, h], [i, j, k], packing, preamble, stamps)| Style {
                separator,
                comma: a && (separator != ',' || b),
                quoted: b && separator != ' ',
                crlf: c,
                trailing: d && separator != ' ',
                comments: e,
                units_row: f,
                scientific: g,
                mark: h,
                packing,
                last_line_end: i,
                preamble,
                sources: j && f && separator != ' ',
                minus: k,
                stamps: if separator == ' ' {
                    Stamps::Seconds
                } else {
                    stamps
                },
            },
        )
}

impl Style {
    fn write(&self, names: &[&str], units: &[&str], columns: &[Vec<f64>]) -> Vec<u8> {
        let end = if self.crlf { "\r\n" } else { "\n" };
        let mut text = String::new();
        let mut row = |cells: Vec<String>| {
            let quote = |c: &String| {
                if self.quoted {
                    format!("\"{c}\"")
                } else {
                    c.clone()
                }
            };
            let cells: Vec<String> = cells.iter().map(quote).collect();
            text.push_str(&cells.join(&self.separator.to_string()));
            if self.trailing {
                text.push(self.separator);
            }
            text.push_str(end);
        };
        for line in 0..self.preamble {
            row(vec![format!("Logger-{line}"), "made by hand".to_owned()]);
        }
        if self.units_row {
            row(names.iter().map(|n| (*n).to_owned()).collect());
            row(units.iter().map(|n| (*n).to_owned()).collect());
            if self.sources {
                row(vec![
                    "clock".to_owned(),
                    "laser 1".to_owned(),
                    "laser 2".to_owned(),
                ]);
            }
        } else {
            let both = names.iter().zip(units);
            row(both
                .map(|(n, u)| {
                    if self.separator == ' ' {
                        format!("{n}[{u}]")
                    } else {
                        format!("{n} [{u}]")
                    }
                })
                .collect());
        }
        for i in 0..columns[0].len() {
            let number = |(index, c): (usize, &Vec<f64>)| {
                let mut n = if index == 0 && self.stamps != Stamps::Seconds {
                    return self.stamps.write(c[i]);
                } else if self.scientific {
                    format!("{:.12e}", c[i])
                } else {
                    format!("{:.12}", c[i])
                };
                if self.minus {
                    n = n.replace('-', "\u{2212}");
                }
                if self.comma { n.replace('.', ",") } else { n }
            };
            row(columns.iter().enumerate().map(number).collect());
        }
        if self.comments {
            text = format!("# a comment; with, separators{end}{end}{text}");
            let half = text.floor_char_boundary(text.len() / 2);
            let at = text[half..].find('\n').unwrap() + half + 1;
            text.insert_str(at, "# paused\n\n");
        }
        if !self.last_line_end {
            text.truncate(text.trim_end_matches(['\r', '\n']).len());
        }
        self.pack(&text)
    }

    fn pack(&self, text: &str) -> Vec<u8> {
        let marked = if self.mark {
            format!("\u{feff}{text}")
        } else {
            text.to_owned()
        };
        match self.packing {
            1 => gzip(marked.as_bytes()),
            2 => crate::formats::zstd::tests::packed(marked.as_bytes()),
            3 => format!("\u{feff}{text}")
                .encode_utf16()
                .flat_map(u16::to_le_bytes)
                .collect(),
            4 => gzip(
                &format!("\u{feff}{text}")
                    .encode_utf16()
                    .flat_map(u16::to_be_bytes)
                    .collect::<Vec<_>>(),
            ),
            _ => marked.into_bytes(),
        }
    }
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut e = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    e.write_all(bytes).unwrap();
    e.finish().unwrap()
}

/// A level 5 .mat file with one vector per column, unpacked.
fn mat(names: &[&str], columns: &[Vec<f64>]) -> Vec<u8> {
    let element = |kind: u32, data: &[u8]| -> Vec<u8> {
        let mut out = [kind.to_le_bytes(), (data.len() as u32).to_le_bytes()].concat();
        out.extend_from_slice(data);
        out.resize(out.len().next_multiple_of(8), 0);
        out
    };
    let mut out = b"MATLAB 5.0 MAT-file".to_vec();
    out.resize(124, b' ');
    out.extend_from_slice(b"\x00\x01IM");
    for (name, values) in names.iter().zip(columns) {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let shape = [(values.len() as u32).to_le_bytes(), 1u32.to_le_bytes()].concat();
        let body = [
            element(6, &[6, 0, 0, 0, 0, 0, 0, 0]),
            element(5, &shape),
            element(1, name.as_bytes()),
            element(9, &bytes),
        ];
        out.extend(element(14, &body.concat()));
    }
    out
}

/// Times, a road and a displacement (mm) with 12 decimals at most.
fn records() -> impl Strategy<Value = Vec<Vec<f64>>> {
    (60usize..150, 0.001f64..0.1, -1e3f64..1e3, any::<u64>()).prop_map(|(n, step, start, seed)| {
        let mut state = seed | 1;
        let mut noise = || {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            ((state >> 24) as f64 / (1u64 << 40) as f64 - 0.5) * 8.0
        };
        let round = |v: f64| (v * 1e6).round() / 1e6;
        let t = (0..n).map(|i| round(start + i as f64 * step)).collect();
        let u = (0..n).map(|_| round(noise())).collect();
        let z = (0..n).map(|_| round(noise())).collect();
        vec![t, u, z]
    })
}

const NAMES: [&str; 3] = ["t", "u_f", "z_f"];

fn all_ways(bytes: &[u8], options: &ReadOptions) {
    let bike = Bike::default();
    if let Err(e) = read(bytes, "x", &bike, options) {
        assert!(e.to_string().starts_with('x') && !e.kind().is_empty());
    }
    let _ = preview(&[RideFile::new("x", bytes)], options);
}

fn some_options() -> impl Strategy<Value = ReadOptions> {
    (
        prop::option::of(0.5f64..5e3),
        prop::option::of(0usize..200),
        any::<bool>(),
    )
        .prop_map(|(rate_hz, from, mapped)| {
            let mut options = ReadOptions {
                rate_hz,
                rows: from.map(|from| (from, from + 100)),
                ..ReadOptions::default()
            };
            if mapped {
                options.map.insert("z_f".into(), "1".into());
                options.map.insert("a_r".into(), "2".into());
            }
            options
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(192))]

    #[test]
    fn every_dialect_reads_back_the_same(columns in records(), style in styles()) {
        let bytes = style.write(&NAMES, &["s", "m", "mm"], &columns);
        let ride = read(&bytes, "x", &Bike::default(), &ReadOptions::default());
        let ride = ride.map_err(|e| TestCaseError::fail(format!("{e}\n{}", String::from_utf8_lossy(&bytes[..bytes.len().min(200)]))))?;
        let front = ride.axles.front.unwrap();
        prop_assert_eq!(ride.samples, columns[0].len());
        for i in 0..ride.samples {
            prop_assert!((front.road[i] - columns[1][i]).abs() < 1e-11);
            prop_assert!((front.displacement[i] - 1e-3 * columns[2][i]).abs() < 1e-13);
        }
        let start = if style.stamps == Stamps::Seconds { columns[0][0] } else { 0.0 };
        prop_assert!((ride.start_s - start).abs() < 1e-6);
    }

    /// The layout that a preview shows, sent as an option, gives the same ride.
    #[test]
    fn a_layout_that_is_confirmed_changes_nothing(columns in records(), style in styles()) {
        let bytes = style.write(&NAMES, &["s", "m", "mm"], &columns);
        let options = ReadOptions::default();
        let found = preview(&[RideFile::new("x", &bytes)], &options).unwrap();
        let layout = found.tables[0].layout.clone();
        let said = ReadOptions { layout, ..ReadOptions::default() };
        let own = read(&bytes, "x", &Bike::default(), &options).unwrap();
        let confirmed = read(&bytes, "x", &Bike::default(), &said).unwrap();
        prop_assert_eq!(own.axles, confirmed.axles);
        prop_assert_eq!(own.step_s, confirmed.step_s);
    }

    #[test]
    fn mat_and_csv_are_the_same_ride(columns in records()) {
        let text: String = (0..columns[0].len())
            .map(|i| format!("{},{},{}\n", columns[0][i], columns[1][i], columns[2][i]))
            .collect();
        let (bike, options) = (Bike::default(), ReadOptions::default());
        let a = read(&mat(&NAMES, &columns), "x", &bike, &options).unwrap();
        let b = read(format!("t,u_f,z_f\n{text}").as_bytes(), "x", &bike, &options).unwrap();
        prop_assert_eq!(a.axles, b.axles);
        prop_assert_eq!(a.step_s, b.step_s);
    }

    #[test]
    fn random_bytes_do_no_harm(bytes in prop::collection::vec(any::<u8>(), 0..3000), options in some_options()) {
        all_ways(&bytes, &options);
        all_ways(&gzip(&bytes), &options);
        all_ways(&[b"\x28\xb5\x2f\xfd", &bytes[..]].concat(), &options);
        let mut file = mat(&[], &[]);
        file.extend(&bytes);
        all_ways(&file, &options);
    }

    #[test]
    fn random_text_does_no_harm(text in "[0-9tuzafrdv_.,;:\\- \t\n\"e#%\\[\\]]{0,2000}", options in some_options()) {
        all_ways(text.as_bytes(), &options);
        all_ways(format!("t,z_f,d_f,a_f,u_f,v\n{text}").as_bytes(), &options);
    }

    /// Well-formed rows of anything: blanks, repeats, pauses, clipping, every channel.
    #[test]
    fn random_tables_do_no_harm(
        names in prop::collection::vec(prop::sample::select(vec![
            "u_f", "z_f", "d_f", "a_f", "force_f", "z_r", "d_r", "a_r", "v", "cadence",
        ]), 1..5),
        steps in prop::collection::vec(prop::sample::select(vec![1u32, 1, 1, 1, 2, 3, 7, 500]), 60..200),
        cells in prop::collection::vec(prop::option::weighted(0.8, -3i32..4), 800),
    ) {
        let mut text = format!("t,{}\n", names.join(","));
        let (mut t, mut cells) = (0, cells.iter().cycle());
        for step in steps {
            t += step;
            text.push_str(&format!("{}", f64::from(t) * 0.01));
            for _ in &names {
                let cell = cells.next().unwrap().map(|v| v.to_string());
                text.push_str(&format!(",{}", cell.unwrap_or_default()));
            }
            text.push('\n');
        }
        let bike = Bike { l_front_m: Some(0.5), l_rear_m: Some(0.5), ..Bike::default() };
        if let Ok(ride) = read(text.as_bytes(), "x", &bike, &ReadOptions::default()) {
            for (_, axle) in ride.axles.iter() {
                let lengths = [axle.road.len(), axle.displacement.len(), axle.valid.len()];
                prop_assert_eq!(lengths, [ride.samples; 3]);
                prop_assert!(axle.road.iter().chain(&axle.displacement).all(|v| v.is_finite()));
            }
            for sensor in &ride.sensors {
                prop_assert_eq!([sensor.values.len(), sensor.valid.len()], [ride.samples; 2]);
                prop_assert!(sensor.values.iter().all(|v| v.is_finite()));
            }
            for channel in [&ride.speed, &ride.cadence].into_iter().flatten() {
                prop_assert_eq!(channel.len(), ride.samples);
                prop_assert!(channel.iter().all(|v| v.is_finite()));
            }
        }
    }

    #[test]
    fn damaged_files_do_no_harm(
        columns in records(),
        style in styles(),
        as_mat in any::<bool>(),
        hits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
    ) {
        let mut bytes = if as_mat {
            mat(&NAMES, &columns)
        } else {
            style.write(&NAMES, &["s", "m", "mm"], &columns)
        };
        for (at, byte) in hits {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        all_ways(&bytes, &ReadOptions::default());
        all_ways(&bytes[..cut.index(bytes.len())], &ReadOptions::default());
    }
}
