//! What people get wrong with a file, each in the way they would, and what they hear of it.

use serde_json::Value;

use crate::harness::{Folder, Server, identify, veloid};

const QUICK: [&str; 6] = ["--trials", "1", "--iterations", "3", "--particles", "6"];

/// A ride of half a minute at a speed that varies, as rows of t, u_f, z_f, u_r, z_r, v.
struct Recorded {
    folder: Folder,
    rows: Vec<Vec<f64>>,
}

impl Recorded {
    fn new() -> Self {
        let folder = Folder::new();
        let [ride, bike] = ["ride.csv", "bike.json"].map(|name| folder.0.join(name));
        let paths = [&ride, &bike].map(|path| path.to_str().unwrap());
        let args = ["simulate", paths[0], "--bike", paths[1], "--duration", "30"];
        let more = ["--noise", "5e-5", "--speed-change", "0.2:20", "--seed", "5"];
        assert!(veloid(&[&args[..], &more].concat()).status.success());
        let text = std::fs::read_to_string(ride).unwrap();
        let numbers = |line: &str| line.split(',').map(|x| x.parse().unwrap()).collect();
        assert!(text.starts_with("t,u_f,z_f,u_r,z_r,v\n"));
        Self {
            rows: text.lines().skip(1).map(numbers).collect(),
            folder,
        }
    }

    /// The report of the ride with every row changed, on a bicycle with some text replaced.
    fn report(&self, change: impl Fn(&mut Vec<f64>), bike: (&str, &str)) -> Value {
        let mut csv = "t,u_f,z_f,u_r,z_r,v\n".to_owned();
        for row in &self.rows {
            let mut row = row.clone();
            change(&mut row);
            let cells: Vec<String> = row.iter().map(|x| format!("{x:e}")).collect();
            csv.push_str(&cells.join(","));
            csv.push('\n');
        }
        let ride = self.folder.write("changed.csv", csv);
        let text = std::fs::read_to_string(self.folder.0.join("bike.json")).unwrap();
        assert!(text.contains(bike.0), "{text}");
        let bike = self
            .folder
            .write("changed.json", text.replacen(bike.0, bike.1, 1));
        identify(&ride, &bike, &QUICK).0
    }
}

const AS_IT_IS: (&str, &str) = ("mass", "mass");

#[test]
fn each_mistake_is_said_with_its_mend_and_takes_the_verdict() {
    let recorded = Recorded::new();
    let said = |name: &str, words: &str, report: Value| {
        let sentence = report["diagnosis"]["sentence"].as_str().unwrap();
        assert_eq!(report["diagnosis"]["verdict"], "cannot_tell", "{name}");
        assert!(sentence.contains(words), "{name}: {sentence}");
        assert!(!report["mistakes"].as_array().unwrap().is_empty());
        for method in ["instrumental", "output_error", "least_squares"] {
            assert!(report[method]["front"]["k_std_n_m"].is_null(), "{name}");
        }
    };
    let scaled = |column: usize, by: f64| move |row: &mut Vec<f64>| row[column] *= by;
    let of_channel = [
        (2, -1.0, "opposite signs"),
        (3, -1.0, "opposite signs"),
        (
            2,
            1000.0,
            "z_f is about 1000 times too large relative to u_f: its unit seems to be mm",
        ),
        (3, 1000.0, "u_r is about 1000 times too large"),
        (4, 39.37, "its unit seems to be inch"),
        (4, -100.0, "its unit seems to be cm"),
        (5, 3.6, "the unit of v seems to be km/h"),
        (5, 2.23694, "the unit of v seems to be mph"),
    ];
    for (column, by, words) in of_channel {
        let report = recorded.report(scaled(column, by), AS_IT_IS);
        said(&format!("column {column} by {by}"), words, report);
    }
    let milliseconds = recorded.report(scaled(0, 1000.0), AS_IT_IS);
    said("t in ms", "the stamps are in ms", milliseconds);
    let swapped = recorded.report(|row| row.swap(2, 4), AS_IT_IS);
    said(
        "z swapped",
        "z_f and z_r, or u_f and u_r, are swapped",
        swapped,
    );
    let turned_round = |row: &mut Vec<f64>| {
        row.swap(1, 3);
        row.swap(2, 4);
    };
    let report = recorded.report(turned_round, AS_IT_IS);
    said("axles", "The rear wheel meets the road before", report);
    let doubled = ("\"mass_front_kg\": 23.0", "\"mass_front_kg\": 46.0");
    let report = recorded.report(|_| (), doubled);
    said("mass", "mass_front_kg seems to be twice", report);
}

#[test]
fn a_ride_without_mistakes_is_not_suspected() {
    let recorded = Recorded::new();
    let report = recorded.report(|_| (), AS_IT_IS);
    assert_eq!(report["mistakes"].as_array().unwrap().len(), 0);
    assert_eq!(report["diagnosis"]["verdict"], "nothing_missing");
    // All of it in millimetres: k and B do not feel it, and it is told from the size.
    let all = |row: &mut Vec<f64>| row[1..5].iter_mut().for_each(|x| *x *= 1000.0);
    let report = recorded.report(all, AS_IT_IS);
    assert_eq!(report["mistakes"].as_array().unwrap().len(), 0);
    let warnings = report["ride"]["warnings"].to_string();
    assert!(warnings.contains("is the unit (m) right"), "{warnings}");
}

/// A minute of the paper's bench: accelerometers on both axles, a laser, the speed.
fn bench(laser: &str) -> (Folder, String, String) {
    let folder = Folder::new();
    let [ride, bike] = ["ride.csv", "bike.json"].map(|name| folder.0.join(name));
    let paths = [&ride, &bike].map(|path| path.to_str().unwrap());
    let args = ["simulate", paths[0], "--bike", paths[1], "--road", "C"];
    let more = ["--accelerometers", "0.03", "--laser", laser];
    let speed = [
        "--speed-change",
        "0.2:20",
        "--stiffness",
        "110000:95000",
        "--damping",
        "1150:900",
    ];
    assert!(
        veloid(&[&args[..], &more, &speed].concat())
            .status
            .success()
    );
    let [ride, bike] = [ride, bike].map(|path| std::fs::read_to_string(path).unwrap());
    (folder, ride, bike)
}

/// The log with the numbers of a column changed, blanks left as they are.
fn changed(csv: &str, column: &str, change: impl Fn(usize, f64) -> Option<f64>) -> String {
    let mut lines = csv.lines();
    let header = lines.next().unwrap();
    let at = header.split(',').position(|name| name == column).unwrap();
    let mut out = format!("{header}\n");
    for (row, line) in lines.enumerate() {
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        if let Ok(x) = cells[at].parse::<f64>() {
            cells[at] = change(row, x).map_or(String::new(), |x| format!("{x:e}"));
        }
        out += &(cells.join(",") + "\n");
    }
    out
}

#[test]
fn val_accelerometers_and_lasers_that_are_misread_are_named_and_withhold_the_result() {
    let (folder, ride, bike) = bench("rear:1e-4:0:0");
    let swapped = ride.replacen("a_f,a_r", "a_r,a_f", 1);
    let scaled = |column: &str, by: f64| changed(&ride, column, |_, x| Some(by * x));
    for (name, csv, kind, words) in [
        (
            "a_f turned",
            scaled("a_f", -1.0),
            "turned_channel",
            "opposite signs",
        ),
        (
            "a_r in g",
            scaled("a_r", 1.0 / 9.806_65),
            "wrong_unit",
            "a_r [g]",
        ),
        ("d_r in mm", scaled("d_r", 1000.0), "wrong_unit", "d_r [mm]"),
        ("v in km/h", scaled("v", 3.6), "speed_unit", "km/h"),
        (
            "accelerometers swapped",
            swapped,
            "swapped_accelerometers",
            "a_f and a_r are swapped",
        ),
    ] {
        let bike = folder.write("b.json", &bike);
        let (report, _) = identify(&folder.write("r.csv", csv), &bike, &QUICK);
        let mistakes = report["mistakes"].to_string();
        assert!(
            mistakes.contains(kind) && mistakes.contains(words),
            "{name}: {mistakes}"
        );
        assert_eq!(report["diagnosis"]["verdict"], "cannot_tell", "{name}");
        for axle in ["front", "rear"] {
            assert!(
                report["result"][axle]["k"]["value"].is_null(),
                "{name}: {}",
                report["result"]
            );
        }
    }
}

/// What is put right or left out by itself is said, and k and B are those of the ride as it was.
#[test]
#[ignore = "slow"]
fn val_what_a_bench_loses_or_turns_is_put_right() {
    let (folder, ride, bike) = bench("rear:1e-4:0:0");
    let bike = folder.write("b.json", &bike);
    let distance = changed(&ride, "d_r", |_, x| Some(-x));
    let lost = changed(&ride, "d_r", |row, x| (row % 97 != 0).then_some(x));
    let frozen = {
        let held = std::cell::Cell::new(0.0);
        changed(&ride, "a_f", |row, x| match (2000..2400).contains(&row) {
            true => Some(held.get()),
            false => {
                held.set(x);
                Some(x)
            }
        })
    };
    for (name, csv, words) in [
        ("distance", distance, "distance to the road"),
        ("lost", lost, "missing"),
        ("frozen", frozen, "repeat the same value"),
    ] {
        let (report, _) = identify(&folder.write("r.csv", csv), &bike, &QUICK);
        let warnings = report["ride"]["warnings"].to_string();
        assert!(warnings.contains(words), "{name}: {warnings}");
        assert_eq!(report["mistakes"].as_array().unwrap().len(), 0, "{name}");
        let k = report["result"]["rear"]["k"]["value"].as_f64().unwrap();
        let b = report["result"]["rear"]["B"]["value"].as_f64().unwrap();
        assert!(
            (k / 95e3 - 1.0).abs() < 0.02 && (b / 900.0 - 1.0).abs() < 0.06,
            "{name}: {k} {b}"
        );
    }
}

/// Laser and accelerometer on one axle need no speed to find their clocks: a channel of zeros does not hide that one is late.
#[test]
fn val_a_dead_speed_sensor_does_not_hide_a_late_laser() {
    let (folder, ride, bike) = bench("rear:1e-4:20:0");
    let bike = folder.write("b.json", &bike);
    let dead = changed(&ride, "v", |_, _| Some(0.0));
    let (report, _) = identify(&folder.write("r.csv", dead), &bike, &QUICK);
    let clock = &report["ride"]["clocks"][0];
    let late = clock["found"]["middle_offset_s"].as_f64();
    assert!(late.is_some_and(|s| (s - 0.02).abs() < 2e-3), "{clock}");
    assert_eq!(clock["applied"], true);
    let k = report["output_error"]["rear"]["k_n_m"].as_f64().unwrap();
    assert!((k / 95e3 - 1.0).abs() < 0.03, "{k}");
}

#[test]
fn val_road_and_displacement_of_an_axle_in_each_others_place_are_named() {
    let recorded = Recorded::new();
    let report = recorded.report(|row| row.swap(1, 2), AS_IT_IS);
    assert!(
        report["mistakes"]
            .to_string()
            .contains("u_f and z_f are swapped"),
        "{}",
        report["mistakes"]
    );
}

/// Seconds under a header of milliseconds: a rate and a stiffness that no bicycle has.
#[test]
fn val_times_that_are_too_short_are_named() {
    let recorded = Recorded::new();
    let report = recorded.report(|row| row[0] /= 1000.0, AS_IT_IS);
    let mistakes = report["mistakes"].to_string();
    assert!(mistakes.contains("1000 times larger"), "{mistakes}");
    assert!(report["result"]["front"]["k"]["value"].is_null());
}

/// A ride of accelerometers alone, its bike, and the folder in which both were written.
fn sensed() -> (Folder, String, String) {
    let folder = Folder::new();
    let [ride, bike] = ["ride.csv", "bike.json"].map(|name| folder.0.join(name));
    let paths = [&ride, &bike].map(|path| path.to_str().unwrap());
    let args = ["simulate", paths[0], "--bike", paths[1]];
    let made = veloid(&[&args[..], &["--accelerometers", "0.03"]].concat());
    assert!(made.status.success(), "{made:?}");
    let [ride, bike] = [ride, bike].map(|path| std::fs::read_to_string(path).unwrap());
    (folder, ride, bike)
}

/// A bike file with another value of a field.
fn with(bike: &str, fields: &[(&str, Value)]) -> String {
    let mut bike: Value = serde_json::from_str(bike).unwrap();
    for (name, value) in fields {
        bike[name] = value.clone();
    }
    bike.to_string()
}

/// At the command line, in the report and on the page.
#[tokio::test]
async fn val_what_is_wrong_with_accelerometers_is_said_in_the_place_of_a_verdict() {
    let (folder, ride, bike) = sensed();
    let scaled = |column: &str, by: f64| changed(&ride, column, |_, x| Some(by * x));
    let late = {
        let past = std::cell::RefCell::new(std::collections::VecDeque::from([0.0; 4]));
        changed(&ride, "a_r", |_, x| {
            past.borrow_mut().push_back(x);
            past.borrow_mut().pop_front()
        })
    };
    let masses = [
        ("mass_front_kg", 63.0.into()),
        ("mass_rear_kg", 23.0.into()),
    ];
    let no_lengths = [("l_front_m", Value::Null), ("l_rear_m", Value::Null)];
    let server = Server::start();
    for (csv, bike, words) in [
        (
            scaled("a_r", 1.0 / 9.806_65),
            bike.clone(),
            "its unit seems to be g",
        ),
        (
            scaled("v", 3.6),
            bike.clone(),
            "the unit of v seems to be km/h",
        ),
        (
            scaled("a_r", -1.0),
            bike.clone(),
            "a_f and a_r have opposite signs",
        ),
        (late, bike.clone(), "ms late relative to a_f"),
        (
            ride.replacen("a_f,a_r", "a_r,a_f", 1),
            bike.clone(),
            "a_f and a_r are swapped",
        ),
        (
            ride.clone(),
            with(&bike, &masses),
            "or the two masses, seem to be swapped",
        ),
        (
            ride.clone(),
            with(&bike, &no_lengths),
            "No result: the wheelbase",
        ),
        (
            ride.replacen("a_r", "other", 1),
            bike.clone(),
            "No result: one accelerometer alone",
        ),
    ] {
        let paths = [folder.write("r.csv", &csv), folder.write("b.json", &bike)];
        let (report, text) = identify(&paths[0], &paths[1], &QUICK);
        let sentence = report["diagnosis"]["sentence"].as_str().unwrap();
        assert!(sentence.contains(words), "{sentence}");
        assert!(text.contains(words), "{text}");
        let answer = server.upload(csv.into_bytes(), &bike, &[]).await;
        let job = answer.headers()["location"].to_str().unwrap().to_owned();
        let view = server.succeeded(&job).await;
        let page = server.get(view["links"]["page"].as_str().unwrap()).await;
        let page = page.text().await.unwrap();
        let (_, lead) = page.split_once("id=\"sentence\"").unwrap();
        assert!(lead.contains(words), "{words}");
        assert!(page.contains("No result: fix this first"), "{words}");
    }
}

/// On a bench that only a force moves, a displacement that reads low and a mass that is too small in the bike file are alike.
#[test]
#[ignore = "slow"]
fn val_a_gain_that_a_mass_explains_as_well_has_no_stiffness() {
    let folder = Folder::new();
    let [ride, bike] = ["ride.csv", "bike.json"].map(|name| folder.0.join(name));
    let paths = [&ride, &bike].map(|path| path.to_str().unwrap());
    let args = ["simulate", paths[0], "--bike", paths[1], "--only", "front"];
    let bench = ["--mass", "25:63", "--shaker", "200:1:20", "--noise", "3e-5"];
    assert!(veloid(&[&args[..], &bench].concat()).status.success());
    let given = r#"{"bike": "bench", "mass_front_kg": 18.0, "static_load_front_n": 176.6}"#;
    let (report, text) = identify(&ride, &folder.write("given.json", given), &QUICK);
    let diagnosis = &report["diagnosis"];
    let gain = &diagnosis["effects"][0]["parameters"]["gain"]["value"];
    assert!(
        (gain.as_f64().unwrap() - 18.0 / 25.0).abs() < 0.01,
        "{gain}"
    );
    let sentence = diagnosis["sentence"].as_str().unwrap();
    assert!(sentence.contains("a mass of 25.0 kg"), "{sentence}");
    let k = &report["result"]["front"]["k"];
    assert!(k["value"].is_null() && k["interval"].is_null(), "{k}");
    assert!(k["why"].as_str().unwrap().contains("weigh the axle"), "{k}");
    assert!(text.starts_with("front  k withheld"), "{text}");
    for method in ["least_squares", "instrumental", "output_error"] {
        assert!(report[method]["front"]["k_std_n_m"].is_null(), "{method}");
    }
}

/// A row of displacements beside roads that are so many rows later.
fn early(recorded: &Recorded, rows: usize) -> Value {
    let mut later: Vec<Vec<f64>> = recorded.rows[rows..].to_vec();
    let row = std::cell::RefCell::new(later.drain(..));
    recorded.report(
        |now| {
            if let Some(later) = row.borrow_mut().next() {
                now[2] = later[2];
                now[4] = later[4];
            }
        },
        AS_IT_IS,
    )
}

#[test]
fn val_displacements_that_are_both_early_are_named_together() {
    let recorded = Recorded::new();
    let tie = early(&recorded, 1);
    let effects = tie["diagnosis"].to_string();
    for id in ["front", "rear"] {
        let found = tie["diagnosis"]["effects"].as_array().unwrap();
        assert!(found.iter().any(|e| e["axle"] == id), "{effects}");
    }
    let lost = early(&recorded, 2);
    let sentence = lost["diagnosis"]["sentence"].as_str().unwrap();
    assert!(
        sentence.contains("z_f and z_r are both about 20 ms early"),
        "{sentence}"
    );
    assert!(
        sentence.contains("a wheelbase that is 0.10 m off"),
        "{sentence}"
    );
    for axle in ["front", "rear"] {
        let k = &lost["result"][axle]["k"];
        assert!(k["value"].is_null(), "{k}");
    }
}
