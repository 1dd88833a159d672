//! Whole files: what is read from them, what is said about them, what is refused.
#![allow(clippy::unwrap_used)]

use std::f64::consts::TAU;
use std::fmt::Write as _;

use super::*;
use veloid_core::bicycle::Bike;

fn bike() -> Bike {
    Bike {
        l_front_m: Some(0.808),
        l_rear_m: Some(0.293),
        ..Bike::default()
    }
}

fn options(map: &[(&str, &str)]) -> ReadOptions {
    ReadOptions {
        map: map
            .iter()
            .map(|(a, b)| ((*a).into(), (*b).into()))
            .collect(),
        ..ReadOptions::default()
    }
}

fn x(bytes: &[u8]) -> RideFile<'_> {
    RideFile::new("x.csv", bytes)
}

fn read_text(text: &str) -> Result<Ride, ReadError> {
    read(
        text.as_bytes(),
        "ride.csv",
        &bike(),
        &ReadOptions::default(),
    )
}

fn warned(ride: &Ride, words: &str) -> bool {
    ride.summary.warnings.iter().any(|w| w.contains(words))
}

/// Roads of sines and the exact answer of one axle, k/m = 4 800 1/s^2 (11 Hz), B/m = 50 1/s.
struct Waves;

impl Waves {
    const LINES: [(f64, f64, f64); 5] = [
        (0.9, 4e-3, 0.3),
        (2.3, 3e-3, 1.1),
        (5.2, 2e-3, 2.0),
        (8.6, 1e-3, 4.0),
        (10.9, 8e-4, 5.0),
    ];

    fn u(t: f64) -> f64 {
        Self::LINES
            .iter()
            .map(|(f, a, p)| a * (TAU * f * t + p).sin())
            .sum()
    }

    /// z (derivative 0) or z'' (derivative 2).
    fn z(t: f64, derivative: i32) -> f64 {
        let line = |(f, a, p): &(f64, f64, f64)| {
            let (w, k, b) = (TAU * f, 4800.0, 50.0);
            let (re, im) = (k - w * w, b * w);
            let size = (k * k + im * im).sqrt() / (re * re + im * im).sqrt();
            let phase = (b * w).atan2(k) - im.atan2(re);
            let sign = if derivative == 2 { -w * w } else { 1.0 };
            sign * a * size * (w * t + p + phase).sin()
        };
        Self::LINES.iter().map(line).sum()
    }

    fn csv(n: usize, rate: f64) -> String {
        let mut text = "t,u_f,z_f\n".to_owned();
        for i in 0..n {
            let t = i as f64 / rate;
            writeln!(text, "{t:.4},{:.7},{:.7}", Self::u(t), Self::z(t, 0)).unwrap();
        }
        text
    }
}

fn worst(a: &[f64], b: impl Fn(usize) -> f64, range: std::ops::Range<usize>) -> f64 {
    range.map(|i| (a[i] - b(i)).abs()).fold(0.0, f64::max)
}

#[test]
fn a_plain_file_is_taken_as_it_is() {
    let ride = read_text(&Waves::csv(1000, 100.0)).unwrap();
    let front = ride.axles.front.as_ref().unwrap();
    assert_eq!(
        (ride.samples, ride.axles.rear.is_none(), ride.start_s),
        (1000, true, 0.0)
    );
    assert!((ride.step_s - 0.01).abs() < 1e-12);
    assert!(worst(&front.road, |i| Waves::u(i as f64 * 0.01), 0..1000) < 1e-7);
    assert!(front.valid.iter().all(|v| *v));
    assert_eq!(ride.summary.warnings, [""; 0]);
    assert_eq!(ride.summary.columns.len(), 3);
    assert_eq!(ride.summary.sha256.len(), 64);
}

#[test]
fn a_year_old_loggers_oddities_are_met_with_warnings() {
    let text = Waves::csv(3000, 100.0);
    let mut lines: Vec<&str> = text.lines().collect();
    lines.drain(1001..1101);
    lines.insert(500, lines[500]);
    let mut text = lines.join("\n");
    text.truncate(text.len() - 9);
    let ride = read_text(&text).unwrap();
    let twice = |said: &String| said.starts_with("1 row(s) repeat the one before");
    assert!(
        ride.summary.reading.iter().any(twice),
        "{:?}",
        ride.summary.reading
    );
    assert!(warned(
        &ride,
        "100 sample(s) missing from 9.990 s to 11.000 s"
    ));
    assert!(warned(&ride, "the last, is incomplete"));
    assert_eq!(ride.samples, 2999);
    let front = ride.axles.front.as_ref().unwrap();
    let distrusted: Vec<usize> = (0..2999).filter(|i| !front.valid[*i]).collect();
    assert_eq!(
        (distrusted[0], distrusted[distrusted.len() - 1]),
        (1000, 1149)
    );
    let known = |i: usize| Waves::z(i as f64 * 0.01, 0);
    assert!(worst(&front.displacement, known, 0..1000) < 1e-7);
    assert!(worst(&front.displacement, known, 1100..2999) < 1e-7);
}

#[test]
fn a_german_logger_with_times_of_day_is_read() {
    let header = "Uhrzeit;Fahrbahn vorne;Weg vorne;Bemerkung";
    let mut text = format!("\u{feff}Messung 12;3\r\n\r\n{header}\r\nhh:mm:ss;mm;mm;\r\n");
    let cell = |value: f64| format!("{value:.4}").replace('.', ",");
    for i in 0..400 {
        let t = f64::from(i) / 100.0;
        let (u, z) = ((9.0 * t).sin() + (23.0 * t).cos(), (9.0 * t - 0.1).sin());
        let z = if i == 200 { "---".to_owned() } else { cell(z) };
        // It passes midnight.
        let (clock, second) = if t < 2.0 {
            ("23:59:", 58.0 + t)
        } else {
            ("00:00:", t - 2.0)
        };
        let second = format!("{second:06.3}").replace('.', ",");
        text += &format!("{clock}{second};{};{z};\r\n", cell(u));
        if i == 300 {
            text += &format!("{header}\r\n");
        }
    }
    let ride = read_text(&text).unwrap();
    let front = ride.axles.front.as_ref().unwrap();
    assert!((1.0 / ride.step_s - 100.0).abs() < 1e-6 && ride.samples == 400);
    assert!((front.road[100] - 1e-3 * (9.0_f64.sin() + 23.0_f64.cos())).abs() < 1e-7);
    let said = ride.summary.reading.join("; ");
    for words in [
        "the units stand in line 4",
        "header is repeated",
        "---: 1 cell(s)",
        "Weg vorne is read as z_f (mm)",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn clipped_stretches_are_masked() {
    let mut text = "t,u_f,z_f [mm]\n".to_owned();
    for i in 0..2000 {
        let t = i as f64 * 0.01;
        let z = (1e3 * Waves::z(t, 0)).min(4.0);
        writeln!(text, "{t:.2},{:.7},{z:.4}", Waves::u(t)).unwrap();
    }
    let ride = read_text(&text).unwrap();
    let front = ride.axles.front.as_ref().unwrap();
    assert!(
        warned(&ride, "z_f is clipped at 4.0000 mm for"),
        "{:?}",
        ride.summary.warnings
    );
    for i in 1..1999 {
        let flat = |i: usize| front.displacement[i] == 4e-3;
        if flat(i - 1) && flat(i) && flat(i + 1) {
            assert!(!front.valid[i]);
        } else if !flat(i) {
            assert!(front.valid[i]);
        }
    }
}

/// u at 250 Hz, z at 100 Hz, speed at 1 Hz, each on its own rows.
#[test]
fn channels_of_different_rates_share_a_file() {
    let mut rows: Vec<(f64, String)> = Vec::new();
    let at = |i: usize, rate: f64, offset: f64| offset + i as f64 / rate;
    for i in 0..5000 {
        let t = at(i, 250.0, 0.0);
        let alias = 1e-3 * (TAU * 89.0 * t).sin();
        rows.push((t, format!("{t:.5},{:.8},,", Waves::u(t) + alias)));
    }
    for i in 0..2000 {
        let t = at(i, 100.0, 0.00123);
        rows.push((t, format!("{t:.5},,{:.8},", Waves::z(t, 0))));
    }
    for i in 0..20 {
        let t = at(i, 1.0, 0.0002);
        rows.push((t, format!("{t:.5},,,{}", 3.0 + 0.1 * t)));
    }
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let rows: Vec<String> = rows.into_iter().map(|(_, row)| row).collect();
    let ride = read_text(&format!("t,u_f,z_f,v\n{}\n", rows.join("\n"))).unwrap();
    let front = ride.axles.front.as_ref().unwrap();
    assert!((ride.step_s - 0.01).abs() < 1e-9);
    assert!(
        warned(&ride, "u_f: low-passed from 250 Hz"),
        "{:?}",
        ride.summary.warnings
    );
    let t = |i: usize| ride.time_s(i);
    let n = ride.samples;
    assert!(n > 1990);
    assert!(worst(&front.displacement, |i| Waves::z(t(i), 0), 0..n) < 1e-8);
    assert!(worst(&front.road, |i| Waves::u(t(i)), 50..n - 50) < 2e-6);
    assert!(
        worst(
            ride.speed.as_ref().unwrap(),
            |i| 3.0 + 0.1 * t(i),
            10..n - 100
        ) < 1e-6
    );
}

/// As the paper's own bench logs: laser distance at 30 Hz, acceleration at 100 Hz, no road sensor.
#[test]
fn laser_and_accelerometer_make_road_and_displacement() {
    let mut rows: Vec<(f64, String)> = Vec::new();
    for i in 0..6000 {
        let t = i as f64 / 100.0;
        rows.push((t, format!("{t:.5},{:.6},", Waves::z(t, 2) + 9.81)));
    }
    for i in 0..1800 {
        let t = 0.0021 + i as f64 / 30.0;
        let laser = 0.85 - (Waves::u(t) - Waves::z(t, 0));
        rows.push((t, format!("{t:.5},,{laser:.8}")));
    }
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let rows: Vec<String> = rows.into_iter().map(|(_, row)| row).collect();
    let text = format!("t,a_f,d_f\n{}\n", rows.join("\n"));
    let mut options = ReadOptions {
        deflection_sign: -1.0,
        ..ReadOptions::default()
    };
    let ride = read(text.as_bytes(), "x", &bike(), &options).unwrap();
    let front = ride.axles.front.as_ref().unwrap();
    let n = ride.samples;
    assert!(n > 5990 && (ride.step_s - 0.01).abs() < 1e-9);
    assert!(
        warned(&ride, "z_f was computed from a_f"),
        "{:?}",
        ride.summary.warnings
    );
    assert!(warned(&ride, "2.7 samples per cycle") && !warned(&ride, "sign"));
    // Both are the truth seen through one filter, so the model's equation holds between them.
    let band = crate::band::Band {
        low_hz: Some(0.5),
        high_hz: Some(0.42 * 30.0),
    };
    let through = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
        let long: Vec<f64> = (0..n + 4000).map(|i| f(ride.time_s(i) - 20.0)).collect();
        band.keep(&long, 100.0)[2000..2000 + n].to_vec()
    };
    let (z, u) = (through(&|t| Waves::z(t, 0)), through(&|t| Waves::u(t)));
    assert!(worst(&front.displacement, |i| z[i], 500..n - 500) < 2e-6);
    assert!(worst(&front.road, |i| u[i], 500..n - 500) < 2e-5);
    let first = front.valid.iter().position(|v| *v).unwrap();
    assert!(worst(&front.displacement, |i| z[i], first..n - first) < 3e-4);
    options.deflection_sign = 1.0;
    let wrong = read(text.as_bytes(), "x", &bike(), &options).unwrap();
    assert!(
        warned(&wrong, "is its sign right"),
        "{:?}",
        wrong.summary.warnings
    );
}

#[test]
fn deflection_completes_road_or_displacement() {
    for (header, from_z) in [("t,z_f,d_f", true), ("t,u_f,d_f", false)] {
        let row = |i: usize| {
            let t = i as f64 * 0.01;
            let (u, z) = (Waves::u(t), Waves::z(t, 0));
            format!(
                "{t:.2},{:.9},{:.9}\n",
                if from_z { z } else { u },
                u - z + 0.7
            )
        };
        let text: String = (0..2000).map(row).collect();
        let ride = read_text(&format!("{header}\n{text}")).unwrap();
        let front = ride.axles.front.as_ref().unwrap();
        assert!(
            warned(&ride, "was computed from"),
            "{:?}",
            ride.summary.warnings
        );
        assert!(front.valid.iter().all(|v| *v));
        let made = if from_z {
            &front.road
        } else {
            &front.displacement
        };
        let truth = |i: usize| {
            let t = i as f64 * 0.01;
            if from_z { Waves::u(t) } else { Waves::z(t, 0) }
        };
        let constant = made[0] - truth(0);
        assert!(worst(made, |i| truth(i) + constant, 0..2000) < 1e-8);
    }
}

#[test]
fn the_rear_road_is_the_front_road_later() {
    let mut text = "t,u_f,z_f,z_r,v [km/h]\n".to_owned();
    for i in 0..1000 {
        let t = i as f64 * 0.01;
        let (u, z) = (Waves::u(t), Waves::z(t, 0));
        writeln!(text, "{t:.2},{u:.8},{z:.8},{:.8},18", 0.9 * z).unwrap();
    }
    let ride = read_text(&text).unwrap();
    let rear = ride.axles.rear.as_ref().unwrap();
    let late = 1.101 / 5.0;
    assert!(worst(&rear.road, |i| Waves::u(i as f64 * 0.01 - late), 30..1000) < 1e-5);
    assert!(!rear.valid[60] && rear.valid[80] && ride.axles.front.unwrap().valid[0]);
    let no_speed = text.replace("v [km/h]", "speedo");
    assert_eq!(
        read_text(&no_speed).unwrap_err().kind(),
        "rear-road-missing"
    );
    let e = read(
        text.as_bytes(),
        "x",
        &Bike::default(),
        &ReadOptions::default(),
    )
    .unwrap_err();
    assert!(e.to_string().contains("wheelbase"), "{e}");
}

/// True sampling instants jitter by 1.2 ms rms, or only their stamps do.
#[test]
fn jitter_is_undone_whichever_way_it_arose() {
    for sampled in [true, false] {
        let mut text = "t,u_f,z_f\n".to_owned();
        for i in 0..4000u64 {
            let even = i as f64 * 0.01;
            let random = (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f64 / (1u64 << 24) as f64;
            let stamp = even + 0.004 * (random - 0.5);
            let t = if sampled { stamp } else { even };
            writeln!(text, "{stamp:.6},{:.8},{:.8}", Waves::u(t), Waves::z(t, 0)).unwrap();
        }
        let ride = read_text(&text).unwrap();
        let front = ride.axles.front.as_ref().unwrap();
        let words = if sampled {
            "by a cubic spline"
        } else {
            "equal steps better"
        };
        assert!(warned(&ride, words), "{:?}", ride.summary.warnings);
        let n = ride.samples;
        let off = worst(
            &front.displacement,
            |i| Waves::z(ride.time_s(i), 0),
            3..n - 3,
        );
        assert!(off < 2e-5, "{sampled}: {off}");
    }
}

/// Stamps of a burst are dropped as repeats are: a few with a warning, many not at all.
#[test]
fn bursts_of_stamps_are_dropped_or_refused() {
    let text = Waves::csv(2000, 100.0);
    for apart in [1e-9, 1e-6, 1e-4, 1e-3] {
        for (rows, refused) in [(8, false), (300, true)] {
            let mut long = text.clone();
            for i in 1..=rows {
                let t = 19.99 + apart * f64::from(i);
                writeln!(long, "{t:.10},0.001,0.002").unwrap();
            }
            if refused {
                assert_eq!(refusal(&long, &[]).0, "time-not-increasing", "{apart}");
                continue;
            }
            let ride = read_text(&long).unwrap();
            assert!(
                warned(&ride, "repeat, or nearly repeat, the previous one"),
                "{apart}"
            );
            let front = ride.axles.front.as_ref().unwrap();
            let off = worst(
                &front.displacement,
                |i| Waves::z(i as f64 * 0.01, 0),
                0..2000,
            );
            assert!(off < 1e-6, "{apart}: {off}");
        }
    }
}

/// A ride of `columns` of Waves at 100 Hz, with some values of one column replaced.
fn spoiled(columns: &str, column: usize, spikes: &[(usize, f64)]) -> String {
    let mut text = format!("t,{columns}\n");
    for i in 0..2000 {
        let t = i as f64 * 0.01;
        let (u, z) = (Waves::u(t), Waves::z(t, 0));
        let mut row: Vec<f64> = (columns.split(','))
            .map(|c| match c {
                "u_f" => u,
                "d_f" => u - z,
                _ => z,
            })
            .collect();
        if let Some((_, value)) = spikes.iter().find(|(at, _)| *at == i) {
            row[column] = *value;
        }
        writeln!(text, "{t:.2},{:.9},{:.9}", row[0], row[1]).unwrap();
    }
    text
}

#[test]
fn wild_samples_are_taken_as_missing() {
    for (columns, column, sizes) in [
        ("u_f,z_f", 1, [0.2, 1.0, 10.0, -1e3, 999_999.0]),
        ("u_f,z_f", 0, [0.5, 1.0, 10.0, -1e3, 999_999.0]),
        ("u_f,d_f", 1, [0.5, 1.0, 10.0, -1e3, 999_999.0]),
        ("z_f,d_f", 1, [0.5, 1.0, 10.0, -1e3, 999_999.0]),
    ] {
        let clean = read_text(&spoiled(columns, column, &[])).unwrap();
        let clean = clean.axles.front.unwrap();
        assert!(clean.valid.iter().all(|v| *v));
        for size in sizes {
            let spikes = [(500, size), (900, size), (901, -size), (902, size)];
            let ride = read_text(&spoiled(columns, column, &spikes)).unwrap();
            assert!(
                warned(&ride, "4 sample(s) far outside the range of all others"),
                "{columns} {size}: {:?}",
                ride.summary.warnings
            );
            let front = ride.axles.front.as_ref().unwrap();
            let distrusted: Vec<usize> = (0..2000).filter(|i| !front.valid[*i]).collect();
            assert_eq!(distrusted, [500, 900, 901, 902], "{columns} {size}");
            let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
            for (now, before) in [
                (&front.displacement, &clean.displacement),
                (&front.road, &clean.road),
            ] {
                let (a, b) = (mean(now), mean(before));
                let off = worst(now, |i| before[i] - b + a, 0..2000);
                assert!(off < 2e-3, "{columns} {size}: {off}");
            }
        }
        // A fifth of a span outside is the axle's own.
        let range = clean.displacement.iter().copied().fold(0.0, f64::max);
        let near = read_text(&spoiled(columns, column, &[(500, 1.2 * range)])).unwrap();
        assert!(!warned(&near, "far outside"), "{columns}");
        let many: Vec<(usize, f64)> = (0..30).map(|i| (100 + 20 * i, 1e3)).collect();
        let e = read_text(&spoiled(columns, column, &many)).unwrap_err();
        assert_eq!((e.kind(), e.line()), ("wild-samples", Some(102)), "{e}");
    }
}

/// A bump of 40 mm that is one to five samples long on a flat road, and what the axle makes of it.
#[test]
fn a_short_bump_on_a_flat_road_is_no_spike() {
    for (rate, noise) in [(50.0, 0.0), (100.0, 0.0), (100.0, 5e-5), (250.0, 5e-5)] {
        for long in 1..=5 {
            let (mut z, mut w) = (0.0, 0.0);
            let mut text = "t,u_f,z_f\n".to_owned();
            for i in 0..2000u64 {
                let hit = (600..600 + long).contains(&i);
                let u = if hit { 0.04 } else { 0.0 };
                for _ in 0..100 {
                    let step = 0.01 / rate;
                    w += step * (4800.0 * (u - z) - 50.0 * w);
                    z += step * w;
                }
                let random =
                    |k: u64| ((i * 2 + k).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f64;
                let error = |k| noise * (random(k) / f64::from(1 << 23) - 1.0);
                let t = i as f64 / rate;
                writeln!(text, "{t:.3},{:.9},{:.9}", u + error(0), z + error(1)).unwrap();
            }
            let ride = read_text(&text).unwrap();
            assert!(
                !warned(&ride, "far outside"),
                "{rate} {noise} {long}: {:?}",
                ride.summary.warnings
            );
        }
    }
}

#[test]
fn free_decay_loads_and_noise_at_rest_does_not() {
    let row = |i: usize, z: f64| format!("{:.2},{z:.6}\n", i as f64 * 0.01);
    let noise = |i: usize| {
        let r = (i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 33;
        1e-4 * ((r % 1000) as f64 / 500.0 - 1.0)
    };
    let decay = |i: usize| 0.01 * (-(i as f64) / 300.0).exp() * (i as f64 * 0.2).cos();
    let text = |f: &dyn Fn(usize) -> f64| -> String {
        "t,z_f\n".to_owned() + &(0..1500).map(|i| row(i, f(i))).collect::<String>()
    };
    let ride = read_text(&text(&|i| decay(i) + noise(i))).unwrap();
    assert!(!ride.axles.front.unwrap().has_road());
    let e = read_text(&text(&noise)).unwrap_err();
    assert_eq!((e.kind(), e.column()), ("not-excited", Some((2, "z_f"))));
    assert_eq!(read_text(&text(&|_| 0.5)).unwrap_err().kind(), "constant");
}

#[test]
fn files_without_time_or_header_load_by_number_and_rate() {
    let plain = Waves::csv(500, 100.0);
    let bare: String = plain.lines().skip(1).map(|l| format!("{l}\n")).collect();
    let mapped = options(&[("t", "1"), ("u_f", "2"), ("z_f", "3")]);
    let a = read(bare.as_bytes(), "x", &bike(), &mapped).unwrap();
    let b = read_text(&plain).unwrap();
    assert_eq!(a.axles, b.axles);
    let mut timeless = options(&[("u_f", "2"), ("z_f", "3")]);
    assert_eq!(
        read(bare.as_bytes(), "x", &bike(), &timeless)
            .unwrap_err()
            .kind(),
        "time-missing"
    );
    timeless.rate_hz = Some(100.0);
    timeless.rows = Some((100, 300));
    let c = read(bare.as_bytes(), "x", &bike(), &timeless).unwrap();
    assert_eq!((c.samples, c.start_s), (200, 0.0));
    assert_eq!(
        c.axles.front.unwrap().road[..],
        b.axles.front.unwrap().road[100..300]
    );
}

/// Kind, line and column of the refusal.
fn refusal(text: &str, map: &[(&str, &str)]) -> (&'static str, Option<usize>, Option<usize>) {
    let e = read(text.as_bytes(), "ride.csv", &bike(), &options(map)).unwrap_err();
    assert!(e.to_string().starts_with("ride.csv"), "{e}");
    (e.kind(), e.line(), e.column().map(|(n, _)| n))
}

/// `n` rows of numbers from `from` (s) on.
fn rows(from: usize, n: usize) -> String {
    (from..from + n)
        .map(|i| format!("{}.5,0.{},0.{}\n", i, i % 7, i % 5))
        .collect()
}

fn good(n: usize) -> String {
    format!("t,u_f,z_f\n{}", rows(0, n))
}

/// Text, kind of problem, line and column.
type Refused<'a> = (String, &'a str, Option<usize>, Option<usize>);

fn are_refused(cases: &[Refused]) {
    for (text, kind, line, column) in cases {
        let head: String = text.chars().take(40).collect();
        assert_eq!(refusal(text, &[]), (*kind, *line, *column), "{head:?}");
    }
}

#[test]
fn refusals_name_the_place() {
    are_refused(&[
        (String::new(), "empty-file", None, None),
        ("\n \n".into(), "empty-file", None, None),
        ("\u{1}\u{2}\u{3}\0".into(), "binary-file", None, None),
        ("t,u_f,z_f\n".into(), "header-only", None, None),
        ("# only\n# comments\n".into(), "header-only", None, None),
        (rows(0, 60), "no-header", Some(1), None),
        (good(49), "too-short", None, None),
        (
            "t,u_f\n".to_owned() + &"1,2\n".repeat(3),
            "axle-missing",
            None,
            None,
        ),
        (
            good(60).replace("z_f", "z_f [furlong]"),
            "unknown-unit",
            Some(1),
            Some(3),
        ),
        (
            good(60).replace("z_f", "z_f_kg"),
            "unknown-unit",
            Some(1),
            Some(3),
        ),
        (
            good(60).replace("u_f", "z_f"),
            "duplicate-column",
            Some(1),
            Some(3),
        ),
        (good(60).replace("t,", "clock,"), "time-missing", None, None),
        (
            format!("t,z_f{}\n", ",x".repeat(600)),
            "too-many",
            Some(1),
            None,
        ),
        (
            "t,z_f\n".to_owned() + &"1,2\n".repeat(100),
            "time-not-increasing",
            Some(3),
            None,
        ),
    ]);
    assert_eq!(refusal(&good(60), &[("z_r", "nope")]).0, "missing-column");
    assert_eq!(refusal(&good(60), &[("wheel", "1")]).0, "unknown-channel");
    let mut late = options(&[]);
    late.rows = Some((100, 200));
    let e = read(good(60).as_bytes(), "x", &bike(), &late).unwrap_err();
    assert_eq!(e.kind(), "bad-rows");
    late.rows = Some((5, 5));
    assert_eq!(
        read(good(60).as_bytes(), "x", &bike(), &late)
            .unwrap_err()
            .kind(),
        "bad-option"
    );
}

#[test]
fn refusals_of_a_row_name_its_line() {
    let with = |bad: &str| format!("{}{bad}\n{}", good(40), rows(60, 40));
    are_refused(&[
        (with("45.5,0.1,-Infinity"), "not-finite", Some(42), Some(3)),
        (with("45.5,0.1,1e999"), "not-finite", Some(42), Some(3)),
        (with("45.5,0.1,1e30"), "out-of-range", Some(42), Some(3)),
        (with("45.5,0.1,wheel"), "not-a-number", Some(42), Some(3)),
        (with("45.5,0.1,0.1.2"), "not-a-number", Some(42), Some(3)),
        (with("45.5,0.1"), "ragged-row", Some(42), None),
        (with("45.5,0.1,0.2,0.3"), "ragged-row", Some(42), None),
        (with(",0.1,0.2"), "time-blank", Some(42), Some(1)),
        (
            with(&format!("45.5,0.1,{}", "0".repeat(70))),
            "cell-too-long",
            Some(42),
            Some(3),
        ),
    ]);
}

#[test]
fn large_numbers_are_reported_shortly() {
    let huge = |z: &str| format!("t,z_f\n{}", format!("0,{z}\n").repeat(60));
    let e = read_text(&huge("1e300")).unwrap_err().to_string();
    assert!(e.contains("1e300 is beyond 1e15"), "{e}");
    let rate = ReadOptions {
        rate_hz: Some(1e300),
        ..ReadOptions::default()
    };
    let e = read(b"z_f\n1\n", "x", &bike(), &rate)
        .unwrap_err()
        .to_string();
    assert!(e.contains("rate_hz: 1e300 Hz"), "{e}");
    let row = |i: usize| format!("{},{}\n", i as f64 / 100.0, 5e5 * (i as f64 * 0.3).cos());
    let large: String = (0..300).map(row).collect();
    let ride = read_text(&format!("t,z_f\n{large}")).unwrap();
    assert!(warned(&ride, "moves by ±"), "{:?}", ride.summary.warnings);
    let e = read_text("t,z_f\n1,2\n1\n1,2\n").unwrap_err().to_string();
    assert!(e.contains("1 cell, expected 2"), "{e}");
}

#[test]
fn long_pauses_are_refused() {
    let text: String = (0..400)
        .map(|i| if i < 200 { i } else { i + 300 })
        .map(|i| format!("{},{},{}\n", i, i % 7, i % 5))
        .collect();
    assert_eq!(
        refusal(&format!("t,u_f,z_f\n{text}"), &[]).0,
        "gap-too-long"
    );
}

#[test]
fn unusual_sizes_are_reported_not_refused() {
    let text = Waves::csv(500, 100.0)
        .replace("z_f", "z_f [ft]")
        .replace("u_f", "u_f [V]");
    let ride = read_text(&text).unwrap();
    assert!(
        warned(&ride, "volts are read as m of u_f"),
        "{:?}",
        ride.summary.warnings
    );
    let large: String = (0..300)
        .map(|i| {
            format!(
                "{:.3},{:.3}\n",
                i as f64 / 30.0,
                102.0 * (i as f64 * 0.3).cos()
            )
        })
        .collect();
    let ride = read_text(&format!("t,z_f\n{large}")).unwrap();
    assert!(
        warned(&ride, "is the unit (m) right?"),
        "{:?}",
        ride.summary.warnings
    );
}

#[test]
fn a_preview_needs_no_bike_and_says_what_lacks() {
    let text = Waves::csv(3000, 100.0);
    let mut lines: Vec<&str> = text.lines().collect();
    lines.drain(1001..1101);
    let text = lines.join("\n").replace("z_f", "z_f [mm]") + "\n";
    let p = preview(&[x(text.as_bytes())], &ReadOptions::default()).unwrap();
    assert_eq!(p.format, "text, separated by comma, decimal point");
    assert_eq!(
        (p.columns[2].channel.as_str(), p.columns[2].scale),
        ("z_f", 1e-3)
    );
    assert_eq!((p.gaps.len(), p.gaps[0].missing, p.problem), (1, 100, None));
    assert!((p.rate_hz.unwrap() - 100.0).abs() < 1e-6);
    let unknown = text.replace("z_f", "V2");
    let p = preview(&[x(unknown.as_bytes())], &ReadOptions::default()).unwrap();
    assert!(p.problem.unwrap().contains("no axle has a displacement"));
    assert_eq!(p.ignored, ["V2 [mm]"]);
    let seen: Vec<_> = (p.tables[0].columns.iter())
        .map(|c| {
            (
                c.number,
                c.header.as_str(),
                c.channel.as_deref(),
                c.first.len(),
            )
        })
        .collect();
    assert_eq!(
        seen,
        [
            (1, "t", Some("t"), 3),
            (2, "u_f", Some("u_f"), 3),
            (3, "V2 [mm]", None, 3)
        ]
    );
    assert_eq!(p.tables[0].columns[0].unit.as_deref(), Some("s"));
    let p = preview(&[x(b"a;b\n1;2\n")], &ReadOptions::default()).unwrap();
    assert!(p.problem.unwrap().contains("there is no time"));
    assert_eq!(
        preview(&[x(b"")], &ReadOptions::default())
            .unwrap_err()
            .kind(),
        "empty-file"
    );
}

fn laid_out(map: &[(&str, &str)], layout: &str) -> ReadOptions {
    ReadOptions {
        layout: serde_json::from_str(layout).unwrap(),
        ..options(map)
    }
}

#[test]
fn what_keeps_a_table_from_being_read_is_shown_beside_it() {
    let text = good(200).replace("u_f", "z_f");
    let p = preview(&[x(text.as_bytes())], &ReadOptions::default()).unwrap();
    assert!(p.problem.unwrap().contains("z_f"));
    let headers: Vec<&str> = (p.tables[0].columns.iter())
        .map(|c| c.header.as_str())
        .collect();
    assert_eq!(headers, ["t", "z_f", "z_f"]);
    assert_eq!(p.tables[0].lines[0].cells, ["t", "z_f", "z_f"]);
    let words = preview(&[x(b"a;b\nx;y\nx;y\n")], &ReadOptions::default()).unwrap();
    assert_eq!(words.tables[0].lines[2].cells, ["x", "y"]);
    let png = preview(&[x(b"\x89PNG....")], &ReadOptions::default());
    assert_eq!(png.unwrap_err().kind(), "binary-file");
    let line = preview(&[x(b"[null, null]")], &ReadOptions::default());
    assert_eq!(line.unwrap_err().kind(), "header-only");
    let own = preview(&[x(text.as_bytes())], &laid_out(&[], r#"{"decimal": "x"}"#));
    assert_eq!(own.unwrap_err().kind(), "bad-option");
}

#[test]
fn the_user_may_say_how_a_file_is_laid_out() {
    let rows = |row: &dyn Fn(f64, f64) -> String| -> String {
        (0..200)
            .map(|i| row(0.01 * f64::from(i), (0.3 * f64::from(i)).sin()))
            .collect()
    };
    let ride = |text: &str, layout: &str| {
        let options = laid_out(&[("t", "Zeit"), ("z_f", "Weg"), ("u_f", "1")], layout);
        read(text.as_bytes(), "x", &bike(), &options)
    };
    let numbers = rows(&|t, z| format!("{z:.4},{t:.2},{z:.4}\n"));
    let text = format!("1,2,3\nStrasse,Zeit,Weg\n7,8,9\nmm,s,mm\n{numbers}");
    let read = ride(
        &text,
        r#"{"header_row": 2, "units_row": 4, "first_row": 7}"#,
    );
    let columns = read.unwrap().summary.columns;
    let travel = columns.iter().find(|c| c.channel == "z_f").unwrap();
    assert_eq!((travel.scale, travel.samples), (1e-3, 198));
    let packed = rows(&|t, z| format!("{z:.4}:{t:.2}:{z:.4}\n"));
    let read = ride(
        &format!("Strasse:Zeit:Weg\n{packed}"),
        r#"{"separator": ":"}"#,
    );
    assert!((read.unwrap().step_s - 0.01).abs() < 1e-9);
    let read = ride(
        &rows(&|t, z| format!("{z:.4};2026 21 05 10h00m{t:05.2};{z:.4}\n")).replacen(
            "",
            "Strasse;Zeit;Weg\n",
            1,
        ),
        r#"{"time_format": "%Y %d %m %Hh%Mm%S%.f", "separator": ";"}"#,
    );
    assert!((read.unwrap().step_s - 0.01).abs() < 1e-9);
    for layout in [
        r#"{"header_row": 3000}"#,
        r#"{"header_row": 4, "first_row": 3}"#,
        r#"{"units_row": 2, "header_row": 2}"#,
    ] {
        assert_eq!(
            ride(&text, layout).unwrap_err().kind(),
            "bad-option",
            "{layout}"
        );
    }
}

#[test]
fn dates_and_times_of_day_may_stand_in_two_columns() {
    let of = |header: &str, separator: &str| {
        let rows: String = (0..200)
            .map(|i| {
                let (second, z) = (0.25 * f64::from(i) + 59_970.0, (0.3 * f64::from(i)).sin());
                let minute = (second / 60.0) as i32 - 999;
                let cells = [
                    "21.05.2026".to_owned(),
                    format!("10:{minute:02}:{:05.2}", second % 60.0),
                    format!("{z:.4}"),
                    format!("{z:.4}"),
                ];
                format!("{}\n", cells.join(separator))
            })
            .collect();
        let table = crate::formats::csv::read(
            format!("{header}\n{rows}").as_bytes(),
            &ReadOptions::default(),
        );
        let table = table.unwrap();
        (table.epoch_s, table.columns[0].1[199])
    };
    let expected = (Some(1_779_357_630.0), 49.75);
    assert_eq!(of("Date;Time;u_f;z_f", ";"), expected);
    assert_eq!(of("Date,Time,u_f,z_f", ","), expected);
    assert_eq!(of("Time u_f z_f", " "), expected);
}

#[test]
fn known_loggers_and_those_of_a_lab_are_read() {
    let rows: String = (0..300)
        .map(|i| {
            let second = 0.25 * f64::from(i);
            let (minute, rest) = ((second / 60.0) as i32, second % 60.0);
            let z = (0.3 * f64::from(i)).sin();
            format!("008 10{minute:02}{rest:05.2} 36.00 {z:.4} {z:.4}\n")
        })
        .collect();
    let head =
        "File created on 21/05/2026\n\n[header]\nsatellites\ntime\n\n[comments]\nby hand\n\n";
    let vbox = format!("{head}[column names]\nsats time velocity z_f u_f\n\n[data]\n{rows}");
    let ride = read_text(&vbox).unwrap();
    assert_eq!(ride.step_s, 0.25);
    assert!((ride.speed.unwrap()[9] - 10.0).abs() < 1e-9);
    let said = |ride: &RideSummary, words: &str| ride.reading.iter().any(|s| s.contains(words));
    assert!(said(&ride.summary, "VBOX"));
    let own = "name = 'Trailer'\nrecognise = ['clk,ADC7']\ncolumns = { clk = 't [ms]', ADC7 = 'z_f [cm]', ADC8 = 'u_f [cm]' }\nnote = 'hi'";
    let text = good(200).replace("t,u_f,z_f", "clk,ADC7,ADC8");
    assert_eq!(read_text(&text).unwrap_err().kind(), "time-missing");
    let options = ReadOptions {
        loggers: [parse_logger(own).unwrap()].into(),
        ..ReadOptions::default()
    };
    let ride = read(text.as_bytes(), "x", &bike(), &options).unwrap();
    let scales = ride
        .summary
        .columns
        .iter()
        .map(|c| (c.channel.as_str(), c.scale));
    let scales: Vec<_> = scales.collect();
    assert_eq!(scales, [("t", 1e-3), ("z_f", 1e-2), ("u_f", 1e-2)]);
    assert!(said(&ride.summary, "Trailer") && said(&ride.summary, "hi"));
    // What the user says comes first.
    let swapped = [("z_f", "ADC8"), ("u_f", "ADC7")];
    let said = ReadOptions {
        map: swapped
            .map(|(channel, column)| (channel.to_owned(), column.to_owned()))
            .into(),
        ..options
    };
    let ride = read(text.as_bytes(), "x", &bike(), &said).unwrap();
    assert_eq!(ride.summary.columns[1].scale, 1.0);
}

#[test]
fn options_come_as_json() {
    let json = r#"{"map": {"z_f": "V2"}, "rate_hz": 610.35, "rows": [40650, 127400]}"#;
    let o: ReadOptions = serde_json::from_str(json).unwrap();
    assert_eq!((o.rows, o.deflection_sign), (Some((40650, 127400)), 1.0));
    assert!(serde_json::from_str::<ReadOptions>(r#"{"limits": {}}"#).is_err());
}

/// Recordings by other people; they lie beside the project and not in it.
fn real(name: &str) -> Option<Vec<u8>> {
    Some(std::fs::read(crate::skips::recording(name)?).unwrap())
}

#[test]
fn val_silverbox() {
    let Some(bytes) = real("silverbox/SNLS80mV.csv") else {
        return;
    };
    let mut options = options(&[("force_f", "V1"), ("z_f", "V2")]);
    options.rate_hz = Some(610.35);
    options.rows = Some((40_650, 127_400));
    let ride = read(&bytes, "SNLS80mV.csv", &Bike::default(), &options).unwrap();
    let front = ride.axles.front.unwrap();
    assert_eq!((ride.samples, front.has_road()), (86_750, false));
    assert!(front.valid.iter().all(|v| *v));
    assert_eq!(ride.summary.warnings, [""; 0]);
    options.rows = None;
    let whole = read(&bytes, "SNLS80mV.csv", &Bike::default(), &options).unwrap();
    assert_eq!(whole.samples, 131_072);
    let front = whole.axles.front.unwrap();
    assert_eq!(
        (front.force.unwrap()[0], front.displacement[1]),
        (0.0057756, 0.012971)
    );
}

#[test]
fn val_spring_mass() {
    let Some(bytes) = real("spring_mass/real_linear_h_1.txt") else {
        return;
    };
    let options = options(&[("t", "2"), ("z_f", "3")]);
    let ride = read(&bytes, "real_linear_h_1.txt", &Bike::default(), &options).unwrap();
    let front = ride.axles.front.as_ref().unwrap();
    assert_eq!((ride.samples, front.displacement[0]), (870, -102.0));
    assert!((1.0 / ride.step_s - 29.97).abs() < 0.01, "{}", ride.step_s);
    assert!(front.valid.iter().all(|v| *v));
    assert!(warned(&ride, "is the unit (m) right?") && ride.summary.warnings.len() == 1);
}

/// Rows of noise under these headers, at 100 Hz.
fn table(headers: &[&str]) -> String {
    let mut text = format!("t,{}\n", headers.join(","));
    for i in 0..1200_u64 {
        write!(text, "{:.2}", i as f64 * 0.01).unwrap();
        for (k, header) in headers.iter().enumerate() {
            let mixed = (i * 2_654_435_761 + 97 * k as u64) % 1009;
            let value = if *header == "v" {
                5.0
            } else {
                mixed as f64 / 1009.0 - 0.5
            };
            write!(text, ",{value}").unwrap();
        }
        text.push('\n');
    }
    text
}

#[test]
fn accelerometers_and_a_speed_are_a_ride() {
    let ride = read_text(&table(&["a_f", "a_r", "v"])).unwrap();
    assert!(ride.has_no_road() && warned(&ride, "the road was not measured"));
    assert!(!warned(&ride, "not used"));
    let names: Vec<&str> = (ride.sensors.iter())
        .map(|s| channel_name(s.kind, s.axle))
        .collect();
    assert_eq!(names, ["a_f", "a_r"]);
    for sensor in &ride.sensors {
        assert_eq!((sensor.values.len(), sensor.rate_hz.round()), (1200, 100.0));
        assert!(sensor.valid.iter().all(|v| *v));
    }
    let refused = read_text(&table(&["a_f", "a_r"])).unwrap_err();
    assert_eq!(refused.kind(), "axle-missing");
    assert!(refused.to_string().contains("a_f, a_r and v"), "{refused}");
}

#[test]
fn a_laser_beside_the_accelerometers_is_a_sensor_too() {
    let ride = read_text(&table(&["a_f", "a_r", "d_r", "v"])).unwrap();
    assert!(ride.axles.rear.is_some() && ride.axles.front.is_none());
    assert_eq!(ride.sensors.len(), 3);
    assert!(!warned(&ride, "not used"));
    for known in ["u_r", "z_r", "force_r"] {
        let ride = read_text(&table(&["a_f", "a_r", "d_r", "v", known])).unwrap();
        assert!(ride.sensors.is_empty(), "{known}");
    }
}

#[test]
fn gaps_of_a_sensor_are_not_trusted() {
    let text = table(&["a_f", "a_r", "v"]);
    let lines: Vec<&str> = text.lines().collect();
    let whole = [&lines[..200], &lines[230..]].concat().join("\n");
    let ride = read_text(&whole).unwrap();
    assert!(!ride.sensors[0].valid[210] && ride.sensors[0].valid[150]);
}

#[test]
fn a_mass_is_needed_for_every_accelerometer() {
    let ride = read_text(&table(&["a_f", "a_r", "v"])).unwrap();
    let half = Bike {
        mass_front_kg: Some(23.0),
        ..bike()
    };
    assert!(
        ride.fits(&half)
            .unwrap_err()
            .to_string()
            .contains("mass_rear_kg")
    );
}
