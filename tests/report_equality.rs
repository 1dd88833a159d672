use serde_json::Value;

use crate::harness::{Folder, Server, veloid};
use crate::ride;

#[tokio::test]
async fn the_server_and_the_command_line_report_the_same_numbers() {
    let server = Server::with(&["--workers", "2"]);
    let job = server.submit(&[("seed", "7")]).await;
    server.succeeded(&job).await;
    let served = server
        .get(&format!("{job}/report"))
        .await
        .text()
        .await
        .unwrap();

    let folder = Folder::new();
    let ride = folder.write("ride.csv", ride::example());
    let bike = folder.write("bike.json", ride::BIKE);
    let json = folder.0.join("report.json");
    let [ride, bike, json] = [&ride, &bike, &json].map(|path| path.to_str().unwrap());
    let output = veloid(&[
        "identify",
        ride,
        "--bike",
        bike,
        "--json",
        json,
        "--seed",
        "7",
        "--trials",
        "3",
        "--particles",
        "12",
        "--iterations",
        "8",
        "--no-diagnosis",
    ]);
    assert!(output.status.success(), "{output:?}");
    let summary = String::from_utf8(output.stdout).unwrap();
    assert!(summary.contains("output error"), "{summary}");
    let written = std::fs::read_to_string(json).unwrap();

    // Texts of the numbers, not their values: not even the last bit may differ.
    let [served, written] =
        [served, written].map(|text| serde_json::from_str::<Value>(&text).unwrap());
    assert_eq!(served.to_string(), written.to_string());
}
