//! The clock of a laser over many rides, for docs/latent-road.md:
//!
//!     SEEDS=20 cargo test --workspace --test blackbox clocks -- --ignored --nocapture

use serde_json::Value;

use crate::harness::{self, Folder, veloid};

const OFFSETS_MS: [&str; 3] = ["5", "20", "-1000"];
const DRIFTS_PPM: [&str; 3] = ["0", "50", "200"];
/// As `veloid simulate` makes them.
const TRUE: [(&str, f64); 2] = [("k_n_m", 110e3), ("b_n_s_m", 1150.0)];

/// Errors of one kind over many rides, and how many of them two standard errors hold.
#[derive(Default)]
struct Errors {
    sizes: Vec<f64>,
    held: usize,
}

impl Errors {
    fn add(&mut self, off: f64, std_error: Option<f64>) {
        self.sizes.push(off.abs());
        self.held += usize::from(std_error.is_some_and(|std| off.abs() < 1.96 * std));
    }

    /// Median, largest, and how many in a hundred intervals hold.
    fn reported(mut self) -> String {
        self.sizes.sort_by(f64::total_cmp);
        let (middle, last) = (self.sizes.len() / 2, self.sizes.len() - 1);
        let held = 100 * self.held / self.sizes.len();
        format!("{:.2}, {:.2}; {held}", self.sizes[middle], self.sizes[last])
    }
}

/// The rear axle's report on a ride of the paper's bench, with both accelerometers.
fn identified(road: &str, speed: &str, clock: &str, seed: &str) -> Value {
    let folder = Folder::new();
    let [ride, bike] =
        ["ride.csv", "bike.json"].map(|name| folder.0.join(name).to_str().unwrap().to_owned());
    let laser = format!("rear:2e-4:{clock}");
    let written = ["simulate", &ride, "--bike", &bike, "--seed", seed];
    let road = ["--road", road, "--speed", speed];
    let sensors = ["--accelerometers", "0.03", "--laser", &laser];
    let done = veloid(&[&written[..], &road, &sensors].concat());
    assert!(done.status.success(), "{done:?}");
    let quick = ["--trials", "1", "--iterations", "1"];
    harness::identify(ride.as_ref(), bike.as_ref(), &quick).0
}

/// Errors of the offset (ms), the drift (ppm), k and B (%) by output error and by the latent road, and the rides with a verdict.
fn line(road: &str, speed: &str, drift: &str, seeds: u64) -> String {
    let mut errors: [Errors; 6] = Default::default();
    let (mut rides, mut reported) = (0, 0);
    for offset in OFFSETS_MS {
        for seed in 1..=seeds {
            let report = identified(road, speed, &format!("{offset}:{drift}"), &seed.to_string());
            let found = &report["ride"]["clocks"][0]["found"];
            let value = |of: &Value, key: &str| of[key].as_f64().unwrap();
            let at_s = value(found, "at_s");
            let [offset_s, rate]: [f64; 2] = [offset, drift].map(|x| x.parse().unwrap());
            let true_ms = offset_s + 1e-3 * rate * at_s;
            let (late, fast) = (1e3 * value(found, "offset_s"), value(found, "drift_ppm"));
            errors[0].add(late - true_ms, Some(1e3 * value(found, "offset_std_s")));
            errors[1].add(fast - rate, Some(value(found, "drift_std_ppm")));
            for (m, method) in ["output_error", "latent_road"].into_iter().enumerate() {
                let e = &report[method]["rear"];
                for (q, (key, truth)) in TRUE.into_iter().enumerate() {
                    let std = e[key.replace("_n", "_std_n")].as_f64();
                    let percent = |x: f64| 100.0 * x / truth;
                    errors[2 + 2 * m + q].add(percent(value(e, key) - truth), std.map(percent));
                }
            }
            rides += 1;
            reported += usize::from(report["diagnosis"]["verdict"] != "cannot_tell");
        }
    }
    let errors = errors.map(Errors::reported).join(" | ");
    format!("| {road}, {speed} m/s, {drift} ppm | {errors} | {reported} of {rides} |")
}

#[test]
#[ignore = "takes minutes; prints a table of docs/latent-road.md"]
fn errors_and_coverage_of_clocks() {
    let seeds = std::env::var("SEEDS").ok();
    let seeds = seeds.and_then(|s| s.parse().ok()).unwrap_or(20);
    println!(
        "| ride | offset (ms) | drift (ppm) | k, output error (%) | B | k, latent road (%) | B | with a verdict |\n\
         |---|---|---|---|---|---|---|---|"
    );
    for road in ["A", "C"] {
        for speed in ["3", "6"] {
            for drift in DRIFTS_PPM {
                println!("{}", line(road, speed, drift, seeds));
            }
        }
    }
}
