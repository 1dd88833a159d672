//! What people get wrong with a file, each in the way they would, and what they hear of it.

use serde_json::Value;

use crate::harness::{Folder, identify, veloid};

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
            "z_f is about 1000 times too large beside u_f: its unit seems to be mm",
        ),
        (3, 1000.0, "u_r is about 1000 times too large"),
        (4, 39.37, "its unit seems to be inch"),
        (4, -100.0, "its unit seems to be cm"),
        (5, 3.6, "its unit seems to be km/h"),
        (5, 2.23694, "its unit seems to be mph"),
    ];
    for (column, by, words) in of_channel {
        let report = recorded.report(scaled(column, by), AS_IT_IS);
        said(&format!("column {column} by {by}"), words, report);
    }
    let milliseconds = recorded.report(scaled(0, 1000.0), AS_IT_IS);
    said("t in ms", "its times seem to be in ms", milliseconds);
    let swapped = recorded.report(|row| row.swap(2, 4), AS_IT_IS);
    said(
        "z swapped",
        "z_f and z_r stand in each other's place",
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
