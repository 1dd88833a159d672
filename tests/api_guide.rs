//! docs/api.md does what it says.

use std::process::Command;

use serde_json::Value;

use crate::harness::{Server, VELOID, veloid};
use crate::skips::skip;

/// The first block of a language.
fn block(language: &str) -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/api.md");
    let guide = std::fs::read_to_string(path).unwrap();
    let begin = format!("```{language}\n");
    let block = guide
        .split_once(&begin)
        .unwrap()
        .1
        .split_once("```")
        .unwrap()
        .0;
    block.to_owned()
}

/// A server with the ride and the bike that the guide expects.
fn ready() -> Server {
    let server = Server::start();
    let path = |name: &str| server.folder.0.join(name).display().to_string();
    let ride = [
        "simulate",
        &path("ride.csv"),
        "--bike",
        &path("bike.json"),
        "--duration",
        "20",
    ];
    assert!(veloid(&ride).status.success());
    server
}

fn run(server: &Server, program: &str, script: &str) -> String {
    let mut command = Command::new(program);
    command
        .args(["-c", script])
        .current_dir(&server.folder.0)
        .env("SERVER", &server.url);
    let out = command.output().unwrap();
    assert!(
        out.status.success(),
        "{}",
        String::from_utf8_lossy(&out.stderr)
    );
    String::from_utf8(out.stdout).unwrap()
}

#[test]
fn the_example_with_curl_works() {
    if Command::new("curl").arg("--version").output().is_err() {
        return skip("no curl");
    }
    let server = ready();
    run(&server, "bash", &format!("set -e\n{}", block("bash")));
    let read = |name: &str| -> Value {
        serde_json::from_str(&std::fs::read_to_string(server.folder.0.join(name)).unwrap()).unwrap()
    };
    assert_eq!(read("job.json")["state"], "succeeded");
    assert!(read("report.json")["diagnosis"]["sentence"].is_string());
    assert_eq!(read("series.json")["unit"], "m/s");
    let csv = std::fs::read_to_string(server.folder.0.join("parameters.csv")).unwrap();
    // k, B, natural frequency and damping ratio of each axle below the header.
    assert_eq!(csv.lines().count(), 9, "{csv}");
    assert_eq!(read("ride.json")["facts"]["stem_mm"], 90.0);
    assert_eq!(read("wet.json")["items"].as_array().unwrap().len(), 1);
    assert!(read("deleted.json")["deleted_at"].is_string());
    assert!(read("restored.json")["deleted_at"].is_null());
}

#[test]
fn the_example_in_python_works() {
    let requests = Command::new("python3")
        .args(["-c", "import requests"])
        .output();
    if !requests.is_ok_and(|out| out.status.success()) {
        return skip("no python3 with requests");
    }
    let server = ready();
    let said = run(&server, "python3", &block("python"));
    assert!(
        said.contains("front: k = 1") && said.contains("N/m"),
        "{said}"
    );
}

/// python/examples/season.py fills a fleet through the API, with nothing beside Python.
#[tokio::test]
async fn the_example_of_a_season_sends_rides_with_what_is_known_of_them() {
    if Command::new("python3").arg("--version").output().is_err() {
        return skip("no python3");
    }
    let server = Server::with(&["--workers", "0"]);
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../python/examples/season.py");
    let mut command = Command::new("python3");
    command.args([script, "--server", &server.url, "--veloid", &VELOID]);
    command.args(["--bikes", "2", "--rides", "4", "--duration", "5"]);
    let out = command.output().unwrap();
    assert!(out.status.success(), "{out:?}");
    let bikes = server.json("/v1/bikes").await;
    assert_eq!(bikes["items"].as_array().unwrap().len(), 2);
    let jobs = server.json("/v1/jobs?bike=season-1").await;
    let known = |job: &Value, fact: &str| job["ride"]["facts"][fact].as_f64().unwrap();
    let jobs = jobs["items"].as_array().unwrap();
    // Newest first.
    let pressures: Vec<f64> = jobs
        .iter()
        .map(|job| known(job, "pressure_front_bar"))
        .collect();
    assert_eq!(pressures.len(), 4);
    assert!(pressures.is_sorted(), "it leaks: {pressures:?}");
    assert!(jobs.iter().all(|job| known(job, "temperature_c") < 60.0));
}
