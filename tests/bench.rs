//! The figures themselves are this machine's; that they come is what is tested.

use serde_json::Value;

use crate::harness::{Folder, Server, veloid};

#[test]
#[ignore = "takes a minute; `.ci/long` runs it"]
fn figures_of_a_server_come_as_json() {
    let server = Server::start();
    let output = veloid(&[
        "bench",
        "--only",
        "service",
        "--runs",
        "1",
        "--server",
        &server.url,
        "--json",
        "-",
    ]);
    assert!(output.status.success(), "{output:?}");
    let measured: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(measured["machine"]["cores"].as_u64().unwrap() > 0);
    let figures = measured["figures"].as_array().unwrap();
    for name in ["least squares visible", "swarm finished"] {
        let figure = figures
            .iter()
            .find(|f| f["name"].as_str().unwrap().contains(name));
        assert!(figure.unwrap()["median"].as_f64().unwrap() > 0.0, "{name}");
    }
}

#[test]
fn the_swarm_is_timed_like_other_implementations() {
    let folder = Folder::new();
    let ride = folder.0.join("ride.csv");
    let ride = ride.to_str().unwrap();
    let simulate = ["simulate", ride, "--duration", "10", "--noise", "1e-4"];
    assert!(veloid(&simulate).status.success());
    let output = veloid(&["bench", "--swarm", ride]);
    let line: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(line["evals"], 6000);
    assert_eq!(line["thetas"].as_array().unwrap().len(), 10);
    assert!(line["inner_s"].as_f64().unwrap() > 0.0);
}
