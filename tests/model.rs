use std::collections::{BTreeMap, BTreeSet};
use std::process::{Command, Output};

use serde_json::{Value, json};

use crate::harness::{Folder, Server, VELOID, veloid};
use crate::ride;

#[tokio::test]
async fn the_model_comes_as_json_and_as_a_script_that_simulates_it() {
    let server = Server::start();
    let job = server.submit(&[]).await;
    server.succeeded(&job).await;
    let report = server.json(&format!("{job}/report")).await;
    let model = server.json(&format!("{job}/model")).await;
    assert_eq!(model["plain"], report["output_error"]);
    assert!(model["extended"].is_null(), "no diagnosis was asked for");

    let response = server.get(&format!("{job}/model?format=matlab")).await;
    assert_eq!(
        response.headers()["content-type"],
        "text/x-matlab; charset=utf-8"
    );
    let script = response.text().await.unwrap();
    assert!(script.contains("{'u_r', 'u_r', 1.0};"), "{script}");
    server.folder.write("ride.csv", ride::example());
    let series = server.json(&format!("{job}/series?points=100000")).await;
    if let Some((_, simulated)) = octave(&server, script) {
        for (column, axle) in ["front", "rear"].into_iter().enumerate() {
            let cells = simulated.lines().map(|line| line.split(',').nth(column));
            let own: Vec<f64> = cells.map(|cell| cell.unwrap().parse().unwrap()).collect();
            is_plain(&own, &series, axle);
        }
    }
    let Some(output) = python(&server, &job).await else {
        return;
    };
    assert!(output.status.success(), "{output:?}");
    let call = "import json, veloid_model as m; t, z = m.main('ride.csv'); \
                json.dump({axle: list(z[axle]) for axle in z}, open('z.json', 'w'))";
    let mut python = Command::new("python3");
    python.args(["-c", call]).current_dir(&server.folder.0);
    let output = python.output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let simulated = std::fs::read(server.folder.0.join("z.json")).unwrap();
    let simulated: BTreeMap<String, Vec<f64>> = serde_json::from_slice(&simulated).unwrap();
    for axle in ["front", "rear"] {
        is_plain(&simulated[axle], &series, axle);
    }
}

/// Whether this is the plain model's curve of the series.
fn is_plain(own: &[f64], series: &Value, axle: &str) {
    let plain = series["axles"][axle]["plain"].as_array().unwrap();
    assert_eq!(own.len(), plain.len());
    let far = |(own, plain): &(&f64, &Value)| (*own - plain.as_f64().unwrap()).abs() > 1e-9;
    assert_eq!(own.iter().zip(plain).filter(far).count(), 0, "{axle}");
}

/// Rides with the effects that they are simulated with, two on most of them.
const RIDES: [&[&str]; 5] = [
    &[
        "--effect",
        "coulomb_friction:front:friction=40",
        "--effect",
        "quadratic_damping:rear:c2=4000",
    ],
    &[
        "--effect",
        "cubic_stiffness:front:k3=8e9",
        "--effect",
        "viscoelastic_tyre:rear:branch_stiffness=60000,relaxation_time=0.03",
    ],
    &[
        "--effect",
        "hysteresis:front:stiffness=60000,yield_force=30",
        "--effect",
        "sensor_delay:rear:delay=0.012",
    ],
    &[
        "--effect",
        "tyre_enveloping:front:patch_length=0.2",
        "--effect",
        "sprung_mass:rear:mass_fraction=0.3,natural_frequency=4,damping_ratio=0.2",
    ],
    &["--effect", "pitch_coupling:both:pitch_inertia=14"],
];

#[tokio::test]
async fn scripts_leave_the_error_that_the_report_holds() {
    let server = Server::start();
    let mut jobs = Vec::new();
    for effects in RIDES {
        jobs.push(upload(&server, effects, &[]).await);
    }
    let mut acting = BTreeSet::new();
    for (job, ride) in jobs {
        server.succeeded(&job).await;
        server.folder.write("ride.csv", ride);
        acting.extend(reproduced(&server, &job).await);
    }
    assert!(acting.len() >= 6, "{acting:?}");
}

#[tokio::test]
async fn a_law_of_ones_own_is_in_the_scripts() {
    let server = Server::start();
    let law = "id = \"stiffening\"\naxle = \"front\"\nforce = \"lambda * d^2 * d\"\n\
               [parameters.lambda]\nunit = \"N/m^3\"\nstart = 1e9\nrange = [-1e9, 1e12]\n";
    let effect = ["--effect", "cubic_stiffness:front:k3=8e9"];
    let (job, ride) = upload(&server, &effect, &[("law", law)]).await;
    server.succeeded(&job).await;
    server.folder.write("ride.csv", ride);
    reproduced(&server, &job).await;
}

#[tokio::test]
async fn a_ride_that_was_thinned_comes_as_a_table_for_the_scripts() {
    let server = Server::start();
    let often = [
        "--rate",
        "1000",
        "--effect",
        "coulomb_friction:front:friction=40",
    ];
    let (job, ride) = upload(&server, &often, &[]).await;
    server.succeeded(&job).await;
    let model = server.json(&format!("{job}/model")).await;
    let rows = String::from_utf8_lossy(&ride).lines().count() - 1;
    let is_thinned = model["simulation"]["samples"] != rows;
    server.folder.write("ride.csv", ride);
    if let Some(output) = python(&server, &job).await {
        assert!(output.status.success(), "{output:?}");
        let said = String::from_utf8_lossy(&output.stdout);
        assert_eq!(
            said.contains("from a start that is fitted to"),
            is_thinned,
            "{said}"
        );
    }
    let table = server.get(&format!("{job}/model?format=csv")).await;
    assert_eq!(table.headers()["content-type"], "text/csv; charset=utf-8");
    server
        .folder
        .write("ride.csv", table.bytes().await.unwrap());
    reproduced(&server, &job).await;
}

#[test]
fn the_command_line_writes_the_model_as_its_file_is_called() {
    let folder = Folder::new();
    let [ride, bike] = [
        ("ride.csv", ride::example()),
        ("bike.json", ride::BIKE.into()),
    ]
    .map(|(name, bytes)| folder.write(name, bytes).display().to_string());
    let file = |name: &str| folder.0.join(name).display().to_string();
    let names = ["m.py", "m.m", "m.json", "m.csv"];
    let mut arguments = vec!["identify", &ride, "--bike", &bike, "--no-diagnosis"];
    arguments.extend(["--trials", "1", "--iterations", "2"]);
    let files = names.map(file);
    arguments.extend(files.iter().flat_map(|file| ["--model", file]));
    let output = veloid(&arguments);
    assert!(output.status.success(), "{output:?}");
    let begins = [
        "# The identified plain model",
        "function [t, z] = veloid_model",
        "{",
        "t,u_f",
    ];
    for (file, begin) in files.iter().zip(begins) {
        let text = std::fs::read_to_string(file).unwrap();
        assert!(text.starts_with(begin), "{file}: {}", &text[..40]);
    }
    let other = veloid(&["identify", &ride, "--bike", &bike, "--model", "m.txt"]);
    assert_eq!(other.status.code(), Some(2), "{other:?}");
}

#[tokio::test]
async fn a_rigs_deflection_is_read_without_its_mean() {
    let server = Server::start();
    let mut ride = "t,d_f,force_f\n".to_owned();
    for i in 0..4000 {
        let t = f64::from(i) * 0.005;
        let waves = [(0.004, 0.7), (0.003, 1.9), (0.002, 4.3)]
            .map(|(a, hz)| (a, std::f64::consts::TAU * hz));
        let d: f64 = waves.iter().map(|(a, w)| a * (w * t).sin()).sum();
        let rate: f64 = waves.iter().map(|(a, w)| a * w * (w * t).cos()).sum();
        let force =
            3000.0 * d + 200.0 * rate + 30.0 * rate.signum() + 2.0 * (f64::from(i) * 2.4).sin();
        ride += &format!("{t:.3},{:.9},{force:.6}\n", d + 0.05);
    }
    let parts = [("trials", "1"), ("iterations", "2")];
    let response = server.upload(ride.clone().into(), "{}", &parts).await;
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    server.succeeded(&job).await;
    server.folder.write("ride.csv", ride);
    let acting = reproduced(&server, &job).await;
    assert!(acting.contains("coulomb_friction"), "{acting:?}");
}

/// Runs both scripts on ride.csv and holds what they say against the report; the effects in the model.
async fn reproduced(server: &Server, job: &str) -> BTreeSet<String> {
    let report = server.json(&format!("{job}/report")).await;
    let held_out = &report["diagnosis"]["held_out"];
    let model = server.json(&format!("{job}/model")).await;
    assert_eq!(model["not_in_script"], json!([]));
    if let Some(output) = python(server, job).await {
        agrees(&output, held_out);
    }
    let script = server.get(&format!("{job}/model?format=matlab")).await;
    if let Some((output, _)) = octave(server, script.text().await.unwrap()) {
        agrees(&output, held_out);
    }
    let axles = model["simulation"]["axles"].as_object().unwrap();
    let effects = axles.values().filter_map(|axle| axle["effects"].as_array());
    let ids = effects
        .flatten()
        .map(|e| e["id"].as_str().unwrap().to_owned());
    ids.collect()
}

/// Whether a script says of every axle what the report does, to 1 %.
fn agrees(output: &Output, held_out: &Value) {
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{output:?}");
    let recorded = held_out.as_object().unwrap().iter();
    for (axle, held) in recorded.filter(|(_, held)| !held.is_null()) {
        let begin = format!("{axle}: held-out error ");
        let line = said.lines().find_map(|line| line.strip_prefix(&begin));
        let line = line.unwrap_or_else(|| panic!("{axle}: {output:?}"));
        let error: f64 = line.split(' ').next().unwrap().parse().unwrap();
        let reported = held["extended_rms_m"].as_f64().unwrap();
        let unit = held["predicted"]
            .as_str()
            .map_or("m", |of| if of == "force" { "N" } else { "m" });
        assert!(
            line.ends_with(&format!("in the report {reported:?} {unit}")),
            "{line}"
        );
        let off = error / reported - 1.0;
        eprintln!("{axle}: {line}, {:.4} % off", 100.0 * off);
        assert!(off.abs() < 0.01, "{axle}: {line}");
    }
}

/// Simulates a ride, and sends it.
async fn upload(server: &Server, arguments: &[&str], parts: &[(&str, &str)]) -> (String, Vec<u8>) {
    let [ride, bike] = ["simulated.csv", "bike.json"].map(|name| server.folder.0.join(name));
    let mut simulate = Command::new(&*VELOID);
    simulate.arg("simulate").arg(&ride).arg("--bike").arg(&bike);
    let simulated = simulate
        .args(["--duration", "30", "--noise", "2e-5"])
        .args(arguments)
        .output();
    let simulated = simulated.unwrap();
    assert!(simulated.status.success(), "{simulated:?}");
    let [ride, bike] = [ride, bike].map(|path| std::fs::read(path).unwrap());
    let parts = [&[("trials", "1"), ("iterations", "2")], parts].concat();
    let bike = String::from_utf8(bike).unwrap();
    let response = server.upload(ride.clone(), &bike, &parts).await;
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    (job, ride)
}

/// What the Python script says of ride.csv, where there is a Python with NumPy and SciPy to run it.
async fn python(server: &Server, job: &str) -> Option<Output> {
    let has_scipy = Command::new("python3")
        .args(["-c", "import numpy, scipy"])
        .output();
    if !has_scipy.is_ok_and(|output| output.status.success()) {
        crate::skips::skip("no python3 with numpy and scipy to run the script");
        return None;
    }
    let response = server.get(&format!("{job}/model?format=python")).await;
    assert_eq!(
        response.headers()["content-type"],
        "text/x-python; charset=utf-8"
    );
    server
        .folder
        .write("veloid_model.py", response.text().await.unwrap());
    let mut python = Command::new("python3");
    python.args(["veloid_model.py", "ride.csv"]);
    Some(python.current_dir(&server.folder.0).output().unwrap())
}

/// What the script says and what it makes of ride.csv, where there is an Octave to run it.
fn octave(server: &Server, script: String) -> Option<(Output, String)> {
    if Command::new("octave").arg("--version").output().is_err() {
        crate::skips::skip("no octave to run the script");
        return None;
    }
    server.folder.write("veloid_model.m", script);
    let call = "[t, z] = veloid_model('ride.csv'); dlmwrite('z.csv', z, 'precision', 12);";
    let mut octave = Command::new("octave");
    octave.args(["--no-gui", "--quiet", "--eval", call]);
    let output = octave.current_dir(&server.folder.0).output().unwrap();
    let simulated = std::fs::read_to_string(server.folder.0.join("z.csv"));
    let simulated = simulated.unwrap_or_else(|error| panic!("{error}: {output:?}"));
    Some((output, simulated))
}
