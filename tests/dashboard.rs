use std::collections::BTreeSet;

use serde_json::Value;

use crate::harness::Server;

/// Every metric that the dashboard asks for is one that the server has.
#[tokio::test]
async fn the_dashboard_asks_for_metrics_that_are_there() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docker/grafana/veloid.json");
    let text = std::fs::read_to_string(path).unwrap();
    let dashboard: Value = serde_json::from_str(&text).unwrap();
    let panels = dashboard["panels"].as_array().unwrap();
    let expressions = panels
        .iter()
        .flat_map(|panel| panel["targets"].as_array().unwrap())
        .map(|target| target["expr"].as_str().unwrap());
    let asked: BTreeSet<&str> = expressions
        .flat_map(|expression| expression.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')))
        .filter(|word| word.starts_with("veloid_"))
        .collect();
    assert!(asked.len() >= 6, "{asked:?}");

    let server = Server::start();
    let job = server.submit(&[]).await;
    server.succeeded(&job).await;
    let metrics = server.get("/metrics").await.text().await.unwrap();
    for name in asked {
        let mut lines = metrics.lines();
        let named = lines.any(|line| {
            line.strip_prefix(name)
                .is_some_and(|rest| rest.starts_with(['{', ' ']))
        });
        assert!(named, "{name} is missing in\n{metrics}");
    }
}
