//! What `veloid simulate` writes, `veloid identify` finds again.

use serde_json::Value;

use crate::harness::{self, Folder, veloid};

/// Simulates with these arguments, identifies what was written, and gives report and truth.
fn there_and_back(simulate: &[&str], identify: &[&str]) -> (Value, Value) {
    let folder = Folder::new();
    let [ride, bike, truth] = files(&folder);
    let written = ["simulate", &ride, "--bike", &bike, "--truth", &truth];
    let simulated = veloid(&[&written, simulate].concat());
    assert!(simulated.status.success(), "{simulated:?}");
    let quick = ["--no-diagnosis", "--trials", "2", "--iterations", "12"];
    let quick = [&quick, identify].concat();
    let (report, _) = harness::identify(ride.as_ref(), bike.as_ref(), &quick);
    (report, read(&truth))
}

/// Paths of a ride, its bike and its truth.
fn files(folder: &Folder) -> [String; 3] {
    ["ride.csv", "bike.json", "truth.json"]
        .map(|name| folder.0.join(name).to_str().unwrap().to_owned())
}

fn read(path: &str) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

/// Largest error of k and of B by `method` (%).
fn errors(report: &Value, truth: &Value, method: &str, axles: &[&str]) -> [f64; 2] {
    ["k_n_m", "b_n_s_m"].map(|key| {
        let error = |axle: &&str| {
            let [found, true_one] = [&report[method][axle][key], &truth[axle][key]];
            100.0 * (found.as_f64().unwrap() / true_one.as_f64().unwrap() - 1.0).abs()
        };
        axles.iter().map(error).fold(0.0, f64::max)
    })
}

#[test]
fn a_road_without_noise_gives_the_bicycle_back() {
    let bumps = ["--bump", "100:0.5:0.02", "--bump", "200:0.4:-0.015"];
    let bicycle = ["--stiffness", "95000:120000", "--damping", "800:1300"];
    let more = ["--road", "c", "--speed", "6", "--seed", "3"];
    let (report, truth) = there_and_back(&[&bumps[..], &bicycle, &more].concat(), &[]);
    let axles = ["front", "rear"];
    let [k, b] = errors(&report, &truth, "output_error", &axles);
    assert!(k < 0.1 && b < 0.5, "{k} % {b} %");
    let [k, b] = errors(&report, &truth, "swarm", &axles);
    assert!(k < 0.5 && b < 2.0, "swarm: {k} % {b} %");
    assert_eq!(report["ride"]["samples"], 6001);
}

/// A bicycle's release is over in a third of a second, long before the part of the record that is held out begins.
#[test]
fn a_release_that_is_over_early_shows_no_missing_physics() {
    for seed in ["1", "2", "4"] {
        let folder = Folder::new();
        let [ride, bike, _] = files(&folder);
        let release = ["--release", "0.01", "--duration", "5", "--rate", "200"];
        let noise = ["--noise", "5e-5", "--seed", seed];
        let written = ["simulate", &ride, "--bike", &bike];
        let simulated = veloid(&[&written[..], &release, &noise].concat());
        assert!(simulated.status.success(), "{simulated:?}");
        let quick = ["--trials", "1", "--iterations", "2"];
        let (report, _) = harness::identify(ride.as_ref(), bike.as_ref(), &quick);
        let diagnosis = &report["diagnosis"];
        assert_eq!(
            diagnosis["verdict"], "nothing_missing",
            "{}",
            diagnosis["sentence"]
        );
        let k = &report["result"]["front"]["k"];
        let [low, high] = [0, 1].map(|end| k["interval"][end].as_f64().unwrap());
        assert!(low < 110e3 && 110e3 < high, "{k}");
    }
}

#[test]
fn noise_of_half_a_tenth_of_a_millimetre_does_little() {
    let (report, truth) = there_and_back(&["--noise", "5e-5"], &[]);
    let [k, b] = errors(&report, &truth, "output_error", &["front", "rear"]);
    assert!(k < 0.5 && b < 2.0, "{k} % {b} %");
    assert_eq!(truth["noise_displacement_m"], 5e-5);
}

#[test]
fn a_shaker_and_a_release_give_one_axle_back() {
    let (report, truth) = there_and_back(
        &[
            "--shaker",
            "60:0.5:18",
            "--only",
            "front",
            "--noise",
            "5e-6",
        ],
        &[],
    );
    let [k, b] = errors(&report, &truth, "output_error", &["front"]);
    assert!(k < 0.5 && b < 2.0, "shaker: {k} % {b} %");
    assert!(report["output_error"]["rear"].is_null());
    let decay = ["--release", "0.02", "--only", "rear", "--duration", "8"];
    let (report, truth) = there_and_back(&[&decay[..], &["--damping", "300"]].concat(), &[]);
    let [k, b] = errors(&report, &truth, "output_error", &["rear"]);
    assert!(k < 0.1 && b < 0.5, "release: {k} % {b} %");
}

#[test]
fn the_seed_makes_the_ride() {
    let text = |args: &[&str]| {
        let output = veloid(&[&["simulate", "-", "--duration", "2"], args].concat());
        assert!(output.status.success(), "{output:?}");
        output.stdout
    };
    assert_eq!(text(&["--noise", "1e-4"]), text(&["--noise", "1e-4"]));
    assert_ne!(text(&[]), text(&["--seed", "2"]));
    assert!(text(&[]).starts_with(b"t,u_f,z_f,u_r,z_r,v\n0.0,"));
}

#[test]
fn what_cannot_be_simulated_is_refused() {
    for args in [
        &["--duration", "1e9"][..],
        &["--rate", "0"],
        &["--mass", "0:63"],
        &["--speed", "-1"],
        &["--shaker", "60:1:80"],
        &["--bump", "1:2"],
        &["--noise", "NaN"],
        &["--road", "J"],
        &["--speed-change", "0.4"],
        &["--speed-change", "1.2:20"],
        &["--cadence", "-3"],
    ] {
        let output = veloid(&[&["simulate", "-"], args].concat());
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        assert!(output.stdout.is_empty() && !output.stderr.is_empty());
    }
}

#[test]
fn effects_that_cannot_act_are_refused_in_one_line() {
    for (effect, problem) in [
        (
            "square_wheel:front:side=1",
            "square_wheel: no such effect, expected one of cubic_stiffness, ",
        ),
        (
            "pitch_coupling:rear:pitch_inertia=9",
            "the axle can be both here",
        ),
        (
            "sensor_gain:front:gian=1.1",
            "no parameter 'gian', only gain",
        ),
        (
            "bump_stop:front:gap=0.005,side=compression",
            "stop_stiffness is missing",
        ),
        (
            "sensor_delay:rear:delay=3",
            "delay = 3 is outside its range",
        ),
        ("load_transfer:both:cog_height=1", "the speed hardly varies"),
        (
            "pedalling_force:rear:amplitude=30,phase=0",
            "no cadence channel",
        ),
    ] {
        let output = veloid(&["simulate", "-", "--duration", "5", "--effect", effect]);
        assert_eq!(output.status.code(), Some(2), "{effect}");
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains(problem), "{effect}: {message}");
        assert!(
            output.stdout.is_empty() && message.lines().count() == 1,
            "{message}"
        );
    }
    for effect in [
        "sensor_gain:front",
        "sensor_gain:top:gain=1",
        "sensor_gain:rear:gain",
    ] {
        let output = veloid(&["simulate", "-", "--effect", effect]);
        assert_eq!(output.status.code(), Some(2), "{effect}");
    }
}

#[test]
fn effects_are_in_the_ride_and_in_the_truth_and_are_named() {
    let folder = Folder::new();
    let [ride, bike, truth] = files(&folder);
    let written = ["simulate", &ride, "--bike", &bike, "--truth", &truth];
    // At a steady speed a late rear sensor is a wheelbase that is off.
    let noise = ["--noise", "1e-5", "--damping", "500"];
    let simulated_ride = ["--duration", "30", "--speed-change", "0.3:11"];
    let effects = [
        "--effect",
        "cubic_stiffness:front:k3=8e9",
        "--effect",
        "sensor_delay:rear:delay=0.008",
    ];
    let simulated = veloid(&[&written[..], &simulated_ride, &noise, &effects].concat());
    assert!(simulated.status.success(), "{simulated:?}");
    let quick = ["--trials", "1", "--iterations", "2"];
    let (report, _) = harness::identify(ride.as_ref(), bike.as_ref(), &quick);
    let truth = read(&truth);
    let found = &report["diagnosis"]["effects"];
    assert_eq!(
        found.as_array().unwrap().len(),
        2,
        "{}",
        report["diagnosis"]["sentence"]
    );
    for effect in truth["effects"].as_array().unwrap() {
        let same = |f: &&Value| f["id"] == effect["id"] && f["axle"] == effect["axle"];
        let found = found.as_array().unwrap().iter().find(same).unwrap();
        for (name, value) in effect["parameters"].as_object().unwrap() {
            let ratio =
                found["parameters"][name]["value"].as_f64().unwrap() / value.as_f64().unwrap();
            assert!((ratio - 1.0).abs() < 0.02, "{name}: {ratio}");
        }
    }
}

/// A drive: a force on a mass with a damper and no spring. The k that is found lies around zero.
#[test]
fn no_spring_is_no_fault() {
    let drive = [
        "--shaker",
        "60:0.5:18",
        "--stiffness",
        "0",
        "--noise",
        "1e-6",
    ];
    let (report, truth) = there_and_back(&[&drive[..], &["--only", "front"]].concat(), &[]);
    let fit = &report["output_error"]["front"];
    assert!(fit["k_n_m"].as_f64().unwrap().abs() < 4.0 * fit["k_std_n_m"].as_f64().unwrap());
    let [_, b] = errors(&report, &truth, "output_error", &["front"]);
    assert!(b < 0.1, "{b} %");
}

/// The paper's own bench: a laser to the road at 30 Hz, an accelerometer at 100 Hz, no road sensor.
#[test]
fn a_ride_of_the_papers_bench_is_identified() {
    let folder = Folder::new();
    let bike = folder.0.join("bike.json");
    let bike = bike.to_str().unwrap();
    let simulated = veloid(&[
        "simulate", "-", "--bike", bike, "--rate", "600", "--only", "rear",
    ]);
    let table: Vec<Vec<f64>> = String::from_utf8(simulated.stdout)
        .unwrap()
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
        .collect();
    let mut csv = "t,d_r,a_r\n".to_owned();
    for i in 1..table.len() - 1 {
        let [u, z] = [1, 2].map(|column| table[i][column]);
        let bend = table[i + 1][2] - 2.0 * z + table[i - 1][2];
        let cell = |every: usize, x: f64| match i % every {
            0 => format!("{x:?}"),
            _ => String::new(),
        };
        let (d, a) = (cell(20, u - z + 0.35), cell(6, bend * 600.0 * 600.0));
        if !(d.is_empty() && a.is_empty()) {
            csv += &format!("{},{d},{a}\n", table[i][0]);
        }
    }
    let ride = folder.write("ride.csv", csv);
    let (report, _) = harness::identify(&ride, bike.as_ref(), &["--no-diagnosis"]);
    let truth = serde_json::json!({"rear": {"k_n_m": 110e3, "b_n_s_m": 1150.0}});
    let [k, b] = errors(&report, &truth, "output_error", &["rear"]);
    assert!(k < 1.0 && b < 5.0, "{k} % {b} %");
    let warnings = report["ride"]["warnings"].to_string();
    assert!(
        warnings.contains("u_r was computed from a_r and d_r"),
        "{warnings}"
    );
}

/// Simulates each ride of `rides` (arguments of `veloid simulate`) and diagnoses it with a swarm that is as small as it gets.
fn diagnosed(rides: &[Vec<&str>]) -> Vec<Value> {
    let diagnosed = |simulate: &Vec<&str>| {
        let folder = Folder::new();
        let [ride, bike, truth] = files(&folder);
        let written = ["simulate", &ride, "--bike", &bike, "--truth", &truth];
        let simulated = veloid(&[&written[..], simulate].concat());
        assert!(simulated.status.success(), "{simulated:?}");
        let mut declared = read(&bike);
        declared["noise_displacement_m"] = read(&truth)["noise_displacement_m"].clone();
        std::fs::write(&bike, declared.to_string()).unwrap();
        let quick = ["--trials", "1", "--particles", "8", "--iterations", "4"];
        harness::identify(ride.as_ref(), bike.as_ref(), &quick).0
    };
    rides.iter().map(diagnosed).collect()
}

const AXLES: [&str; 2] = ["front", "rear"];

/// At walking pace nothing is faster than some hertz, so that the engine thins the record.
#[test]
fn clean_rides_at_walking_pace_leave_the_noise_of_their_sensors() {
    let ride = |speed| vec!["--speed", speed, "--noise", "3e-5", "--seed", "1"];
    for report in diagnosed(&["0.8", "1.0", "1.2", "1.5"].map(ride)) {
        let diagnosis = &report["diagnosis"];
        assert_eq!(
            diagnosis["verdict"], "nothing_missing",
            "{}",
            diagnosis["sentence"]
        );
        for axle in AXLES {
            let held = &diagnosis["held_out"][axle];
            let [left, floor] =
                ["plain_rms_m", "noise_floor_m"].map(|key| held[key].as_f64().unwrap());
            assert!(
                (0.9..1.1).contains(&(left / floor)),
                "{axle}: {left} {floor}"
            );
            assert!(floor < 0.75 * 3e-5, "not thinned: {floor}");
        }
    }
}

#[test]
fn effects_at_walking_pace_are_named() {
    for (effect, id) in [
        ("coulomb_friction:front:friction=20", "coulomb_friction"),
        ("cubic_stiffness:front:k3=8e9", "cubic_stiffness"),
    ] {
        let ride = vec![
            "--speed", "1.5", "--road", "E", "--noise", "3e-5", "--seed", "1", "--effect", effect,
        ];
        let diagnosis = &diagnosed(&[ride])[0]["diagnosis"];
        assert_eq!(diagnosis["verdict"], "named", "{}", diagnosis["sentence"]);
        assert_eq!(diagnosis["effects"][0]["id"], id);
    }
}

/// Uniform p values are above 0.9 on a tenth of the axles, and on half of fourteen once in 3000 times.
#[test]
fn p_values_of_clean_rides_do_not_gather_at_one() {
    let seeds = ["1", "2", "3", "4", "5", "6", "7"];
    let ride = |seed| vec!["--road", "C", "--noise", "2e-5", "--seed", seed];
    let reports = diagnosed(&seeds.map(ride));
    let p_values: Vec<f64> = (reports.iter())
        .flat_map(|report| AXLES.map(|axle| &report["diagnosis"]["where"][axle]["p_value"]))
        .map(|p| p.as_f64().unwrap())
        .collect();
    let high = p_values.iter().filter(|p| **p > 0.9).count();
    assert!(high < p_values.len() / 2, "{p_values:?}");
}

/// A second mode on the front axle, which no effect of the library explains.
#[test]
#[ignore = "slow"]
fn a_mismatch_has_a_small_p_value_or_none() {
    let folder = Folder::new();
    let [ride, bike, _] = files(&folder);
    let simulated = veloid(&["simulate", &ride, "--bike", &bike, "--noise", "3e-5"]);
    assert!(simulated.status.success(), "{simulated:?}");
    let text = std::fs::read_to_string(&ride).unwrap();
    let mut lines = text.lines();
    let mut shaken = format!("{}\n", lines.next().unwrap());
    let (mut z, mut v, mut state) = (0.0, 0.0, 1_u64);
    for line in lines {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        let force = (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
        // 7 Hz, damping ratio 0.15, some 0.1 mm.
        v += 0.01 * (0.76 * force - 1934.0 * z - 13.2 * v);
        z += 0.01 * v;
        let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
        cells[2] = (cells[2].parse::<f64>().unwrap() + z).to_string();
        shaken += &format!("{}\n", cells.join(","));
    }
    std::fs::write(&ride, shaken).unwrap();
    let quick = ["--trials", "1", "--particles", "8", "--iterations", "4"];
    let (report, _) = harness::identify(ride.as_ref(), bike.as_ref(), &quick);
    let front = &report["diagnosis"]["where"]["front"];
    assert_eq!(front["mismatch"], true, "{front}");
    assert!(
        front["p_value"].as_f64().is_none_or(|p| p <= 0.01),
        "{front}"
    );
}
