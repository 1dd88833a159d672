//! What a program says that is asked for something which it was built without.

use std::path::Path;

use reqwest::Response;
use serde_json::Value;

use crate::built::{is_built_with, veloid};
use crate::harness::{Folder, Server};
use crate::skips::not_applicable;
use crate::{ride, workbook};

const FEATURES: [&str; 4] = ["parquet", "postgres", "s3", "spreadsheets"];

/// Whether the program is built without a feature; says so if not.
fn lacks(feature: &str) -> bool {
    let has = is_built_with(feature);
    if has {
        not_applicable(&format!(
            "the program under test is built with the feature `{feature}`"
        ));
    }
    !has
}

/// How a build with the feature is made.
fn command(feature: &str) -> String {
    format!("`cargo build --release --features {feature}`")
}

async fn is_not_built(answer: Response, feature: &str) {
    assert_eq!(answer.status(), 501);
    assert_eq!(answer.headers()["content-type"], "application/problem+json");
    let problem: Value = answer.json().await.unwrap();
    assert_eq!(problem["type"], "urn:veloid:problem:not-built");
    let detail = problem["detail"].as_str().unwrap();
    assert!(detail.contains(&format!("`{feature}`")), "{detail}");
}

/// The program ends with the feature and the command that builds it, and has made nothing.
fn is_refused(args: &[&str], feature: &str) {
    let folder = Folder::new();
    let data = folder.0.join("data");
    let at = ["--data", data.to_str().unwrap()];
    let ended = veloid(&[args, &at].concat());
    let said = String::from_utf8(ended.stderr).unwrap();
    assert_eq!(ended.status.code(), Some(1), "{said}");
    assert!(said.contains(&command(feature)), "{said}");
    assert!(!Path::new(&data).join("veloid.db").exists(), "{said}");
}

#[test]
fn the_program_says_what_it_is_built_with() {
    let said = String::from_utf8(veloid(&["--version"]).stdout).unwrap();
    let features = said
        .lines()
        .find_map(|line| line.strip_prefix("features: "));
    for feature in features.unwrap().split(", ") {
        assert!(FEATURES.contains(&feature) || feature == "none", "{said}");
    }
}

#[test]
fn a_postgresql_database_is_refused_at_the_start() {
    if lacks("postgres") {
        const URL: &str = "postgres://postgres@127.0.0.1:1/veloid";
        for command in ["serve", "worker", "migrate", "check"] {
            is_refused(&[command, "--database-url", URL], "postgres");
        }
        is_refused(&["key", "list", "--database-url", URL], "postgres");
    }
}

#[test]
fn object_storage_is_refused_at_the_start() {
    if lacks("s3") {
        for command in ["serve", "worker"] {
            is_refused(&[command, "--files", "s3://bucket/rides"], "s3");
        }
    }
}

#[tokio::test]
async fn parquet_is_refused_and_not_offered() {
    if !lacks("parquet") {
        return;
    }
    let server = Server::with(&["--workers", "0"]);
    let answer = server.get("/v1/parameters?format=parquet").await;
    is_not_built(answer, "parquet").await;
    server.submit(&[]).await;
    let bikes = server.json("/v1/bikes").await;
    let bike = bikes["items"][0]["name"].as_str().unwrap();
    let history = format!("/v1/bikes/{bike}/history?format=parquet");
    is_not_built(server.get(&history).await, "parquet").await;
    for page in ["/parameters".to_owned(), format!("/bikes/{bike}")] {
        let page = server.get(&page).await.text().await.unwrap();
        assert!(page.contains("format=csv") && !page.contains("parquet"));
    }
}

#[tokio::test]
async fn a_workbook_is_refused() {
    if !lacks("spreadsheets") {
        return;
    }
    let server = Server::with(&["--workers", "0"]);
    let workbook = workbook::of_table(&ride::table(200, 200.0));
    let preview = server.client.post(server.address("/v1/rides/preview"));
    let answer = preview.body(workbook.clone()).send().await.unwrap();
    is_not_built(answer, "spreadsheets").await;
    let answer = server.upload(workbook, ride::BIKE, &[]).await;
    is_not_built(answer, "spreadsheets").await;
}
