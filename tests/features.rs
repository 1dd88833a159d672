//! What a program says that is asked for something which it was built without.

use std::path::Path;
use std::time::Duration;

use reqwest::Response;
use serde_json::{Value, json};
use sqlx::SqliteConnection;

use crate::built::{is_built_with, veloid};
use crate::harness::{Folder, Server};
use crate::skips::not_applicable;
use crate::{altered, ride, workbook};

const FEATURES: [&str; 5] = ["parquet", "postgres", "s3", "spreadsheets", "webhooks"];

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

#[test]
fn hosts_of_webhooks_are_refused_at_the_start() {
    if lacks("webhooks") {
        for command in ["serve", "worker"] {
            is_refused(&[command, "--webhook-allow", "example.org"], "webhooks");
            is_refused(&[command, "--webhook-private"], "webhooks");
        }
    }
}

/// Webhooks of a program that sends are listed and deleted, and their messages wait for it.
#[tokio::test]
async fn webhooks_are_refused_and_their_messages_wait() {
    if !lacks("webhooks") {
        return;
    }
    const WAITING: &str = "SELECT state, attempt FROM river_job WHERE kind = 'deliver'";
    const WEBHOOK: &str = "\
        INSERT INTO webhook (id, group_name, url, events, secret, created_at) \
        VALUES (x'00112233445566778899aabbccddeeff', 'default', 'http://127.0.0.1:9/', 'job.succeeded', 'whsec_', 0)";
    let server = Server::on_sqlite(&[]);
    let url = json!({"url": "https://example.org/"});
    let id = "00112233-4455-6677-8899-aabbccddeeff";
    for path in ["/v1/webhooks".to_owned(), format!("/v1/webhooks/{id}/test")] {
        let request = server.client.post(server.address(&path)).json(&url);
        is_not_built(request.send().await.unwrap(), "webhooks").await;
    }
    let mut database = altered::open(&server.folder).await;
    sqlx::query(WEBHOOK).execute(&mut database).await.unwrap();
    assert_eq!(server.json("/v1/webhooks").await[0]["id"], id);
    let job = server.submit(&ride::QUICK).await;
    server.succeeded(&job).await;
    let waiting = async |database: &mut SqliteConnection| -> Vec<(String, i64)> {
        let rows = sqlx::query_as(WAITING).fetch_all(database).await;
        rows.unwrap()
    };
    while waiting(&mut database).await.is_empty() {
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    tokio::time::sleep(Duration::from_secs(2)).await;
    assert_eq!(
        waiting(&mut database).await,
        [("available".to_owned(), 0)],
        "nobody has tried"
    );
    let path = server.address(&format!("/v1/webhooks/{id}"));
    let deleted = server.client.delete(path).send().await.unwrap();
    assert_eq!(deleted.status(), 204);
}
