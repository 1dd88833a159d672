//! The identified model from inside: what it swings like, and how it stands beside its record.

use std::f64::consts::TAU;
use std::path::Path;

use serde_json::{Value, json};

use crate::harness::{Folder, identify, veloid};
use crate::ride::BIKE;

const QUICK: [&str; 6] = ["--trials", "1", "--iterations", "3", "--particles", "6"];
/// Stiffness (N/m), damping (N s/m) and masses (kg) of simulated rides.
const K: f64 = 110e3;
const B: f64 = 1150.0;
const MASSES: [(&str, f64); 2] = [("front", 23.0), ("rear", 63.0)];
/// Largest `validation` of an axle (bytes).
const MOST: usize = 30_000;

/// The report of a simulated ride of a bike.
fn report(folder: &Folder, bike: &str, simulated: &[&str], identified: &[&str]) -> Value {
    let ride = folder.0.join("ride.csv");
    let path = ride.to_str().unwrap();
    let make = ["simulate", path, "--duration", "30", "--noise", "2e-5"];
    assert!(veloid(&[&make, simulated].concat()).status.success());
    let bike = folder.write("bike.json", bike);
    identify(Path::new(path), &bike, &[&QUICK, identified].concat()).0
}

fn numbers(values: &Value) -> Vec<f64> {
    let values = values.as_array().unwrap().iter();
    values.map(|x| x.as_f64().unwrap()).collect()
}

#[test]
fn a_road_shows_what_an_axle_swings_like_whatever_its_mass() {
    let folder = Folder::new();
    let plain = ["--no-diagnosis"];
    let unsure = BIKE.replace("63.0", "63.0, \"mass_front_std_kg\": 1.0");
    let [exact, unsure] = [BIKE, &unsure].map(|bike| report(&folder, bike, &[], &plain));
    for (axle, m) in MASSES {
        for (name, truth) in [
            ("natural_frequency", (K / m).sqrt() / TAU),
            ("damping_ratio", B / (2.0 * (K * m).sqrt())),
        ] {
            let [found, beside] = [&exact, &unsure].map(|report| &report["result"][axle][name]);
            let [value, error] = ["value", "std_error"].map(|key| found[key].as_f64().unwrap());
            assert!(
                (value - truth).abs() < 4.0 * error && error < 0.01 * truth,
                "{axle} {found}"
            );
            assert_eq!(found["value"], beside["value"]);
            let ratio = beside["std_error"].as_f64().unwrap() / error;
            assert!((ratio - 1.0).abs() < 0.05, "{axle} {name} {ratio}");
        }
        let dynamics = &exact["dynamics"][axle];
        let pole = &dynamics["poles"][0];
        let half = B / (2.0 * m);
        assert!((pole["re_1_s"].as_f64().unwrap() / -half - 1.0).abs() < 0.02);
        let turns = (K / m - half * half).sqrt();
        assert!((pole["im_rad_s"].as_f64().unwrap() / turns - 1.0).abs() < 0.02);
        assert_eq!(dynamics["parameters"]["names"], json!(["k", "B"]));
        assert!(numbers(&dynamics["step_response"]["displacement_m"]).len() <= 100);
    }
    let wide = |report: &Value| {
        report["result"]["front"]["k"]["std_error"]
            .as_f64()
            .unwrap()
    };
    assert!(
        wide(&unsure) > 5.0 * wide(&exact),
        "k itself is as unsure as the mass"
    );
}

#[test]
fn a_plain_ride_leaves_noise_and_answers_as_its_transfer_function() {
    let folder = Folder::new();
    let report = report(&folder, BIKE, &[], &["--no-diagnosis"]);
    for (axle, m) in MASSES {
        let validation = &report["validation"][axle];
        assert!(validation.to_string().len() < MOST);
        assert_eq!(validation["why"], json!([]));
        let residual = &validation["residual"];
        assert_eq!(residual["input"], "road_slope");
        for test in ["autocorrelation", "cross_correlation"] {
            assert!(
                residual[test]["outside"].as_u64().unwrap() < 5,
                "{axle}: {}",
                residual[test]
            );
        }
        let response = &validation["response"];
        assert_eq!(response["of"], "z/u");
        let hz = numbers(&response["frequency_hz"]);
        let [seen, coherence, plain] = [
            &response["magnitude"],
            &response["coherence"],
            &response["plain"]["magnitude"],
        ]
        .map(numbers);
        for i in (0..hz.len()).filter(|i| coherence[*i] > 0.99 && hz[*i] > 1.0) {
            let w = TAU * hz[i];
            let expected = K.hypot(B * w) / (K - m * w * w).hypot(B * w);
            assert!(
                (seen[i] / expected - 1.0).abs() < 0.1,
                "{axle} {} Hz",
                hz[i]
            );
            assert!(
                (plain[i] / expected - 1.0).abs() < 0.01,
                "{axle} {} Hz",
                hz[i]
            );
        }
        assert!(response["distortion"].is_null() && response["distortion_why"].is_string());
    }
}

#[test]
fn friction_bends_the_force_over_the_rate_and_the_model_with_it_follows() {
    let folder = Folder::new();
    let friction = ["--effect", "coulomb_friction:front:friction=40"];
    let report = report(&folder, BIKE, &friction, &[]);
    assert_eq!(report["diagnosis"]["verdict"], "named");
    assert!(report["diagnosis"].get("validation").is_none());
    let front = &report["validation"]["front"];
    assert!(front.to_string().len() < MOST);
    assert_eq!(front["residual"]["model"], "extended");
    assert!(front["response"]["extended"].is_object());
    assert_eq!(report["dynamics"]["front"]["linear_part"], true);
    let curve = &front["restoring"]["over_rate"];
    let [rate, seen, plain] = [&curve["at"], &curve["measured_n"], &curve["plain_n"]].map(numbers);
    let extended = curve["extended_n"].as_array().unwrap();
    let off = |model: &dyn Fn(usize) -> f64| {
        let squares = (0..rate.len()).map(|i| (seen[i] - model(i)).powi(2));
        (squares.sum::<f64>() / rate.len() as f64).sqrt()
    };
    let [plain, extended] = [
        off(&|i| plain[i]),
        off(&|i| extended[i].as_f64().unwrap_or(seen[i])),
    ];
    assert!(
        extended < 0.5 * plain && extended < 8.0,
        "{extended} N, {plain} N"
    );
    let rear = &report["validation"]["rear"];
    assert_eq!(rear["residual"]["model"], "output_error");
    assert!(rear["response"]["extended"].is_null());
}

#[test]
fn a_shaker_shows_the_receptance_and_a_release_has_its_reasons() {
    let folder = Folder::new();
    let plain = ["--no-diagnosis"];
    let shaken = report(&folder, BIKE, &["--shaker", "100:1:20"], &plain);
    let response = &shaken["validation"]["front"]["response"];
    assert_eq!(
        (&response["of"], &response["unit"]),
        (&json!("z/F"), &json!("m/N"))
    );
    assert_eq!(shaken["validation"]["front"]["residual"]["input"], "force");
    assert_eq!(
        shaken["dynamics"]["front"]["step_response"]["input"],
        "force"
    );
    let released = report(&folder, BIKE, &["--release", "0.01"], &plain);
    let front = &released["validation"]["front"];
    assert!(front["response"].is_null(), "{front}");
    assert!(
        front["why"].to_string().contains("decays freely"),
        "{front}"
    );
}
