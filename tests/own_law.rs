//! A law of one's own at the command line and through the server.

use serde_json::Value;

use crate::harness::{Folder, Server, veloid};
use crate::ride;

const LAW: &str = r#"id = "fifth_power_spring"
force = "k5 * d^5"
parameters.k5 = { unit = "N/m^5", start = 1e13, range = [-1e16, 1e16] }
"#;

const SHORT: [(&str, &str); 3] = [("trials", "1"), ("particles", "4"), ("iterations", "2")];

#[tokio::test]
async fn a_law_is_uploaded_with_a_ride_and_stands_in_its_report() {
    let server = Server::start();
    let before = server.submit(&ride::QUICK).await;
    server.succeeded(&before).await;
    let parts = [&SHORT[..], &[("law", LAW)]].concat();
    let response = server.upload(ride::example(), ride::BIKE, &parts).await;
    assert_eq!(response.status(), 202);
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    server.succeeded(&job).await;
    let report = server.json(&format!("{job}/report")).await;
    assert_eq!(report["settings"]["law"], LAW.trim());
    let sizes = report["diagnosis"]["detectable"].as_array().unwrap();
    let own = |size: &&Value| size["id"] == "fifth_power_spring";
    assert!(sizes.iter().any(|size| own(&size)), "{sizes:?}");
    let tried = report["diagnosis"]["tried"].as_array().unwrap();
    let places: Vec<&Value> = (tried.iter())
        .filter(|t| t["effects"][0]["id"] == "fifth_power_spring" && t["why_not"].is_string())
        .map(|t| &t["effects"][0]["axle"])
        .collect();
    assert_eq!(places.len(), 2, "{tried:?}");
    // Nothing of that name is stored, since it does not act.
    let asked = server.get("/v1/parameters?effect=fifth_power_spring").await;
    assert_eq!(asked.status(), 400);
}

#[tokio::test]
async fn a_law_that_means_nothing_is_refused_with_its_column() {
    let wrong = LAW.replace("k5 * d^5", "k5 * dd^5");
    let said = "setting law: force, column 6: unknown name 'dd', expected one of d, w, z, z_dot";
    let server = Server::start();
    let parts = [&SHORT[..], &[("law", &wrong)]].concat();
    let response = server.upload(ride::example(), ride::BIKE, &parts).await;
    assert_eq!(response.status(), 422);
    let problem: Value = response.json().await.unwrap();
    assert!(
        problem["detail"].as_str().unwrap().contains(said),
        "{problem}"
    );

    let folder = Folder::new();
    let path = |name: &str| folder.0.join(name).to_str().unwrap().to_owned();
    for (name, text) in [
        ("law.toml", wrong.as_bytes()),
        ("bike.json", ride::BIKE.as_bytes()),
        ("ride.csv", &ride::example()),
    ] {
        std::fs::write(path(name), text).unwrap();
    }
    let output = veloid(&[
        "identify",
        &path("ride.csv"),
        "--bike",
        &path("bike.json"),
        "--law",
        &path("law.toml"),
    ]);
    assert_eq!(output.status.code(), Some(2));
    let reported = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(reported.contains(said), "{reported}");
}
