//! Raw files that were altered or are gone: nobody is given them, and `veloid check` finds them.

use std::path::PathBuf;
use std::process::Output;
use std::time::Duration;

use serde_json::Value;
use sqlx::{Connection, SqliteConnection};

use crate::harness::{Server, key_of, raw_files};
use crate::ride;

/// The only raw file of a server.
fn stored(server: &Server) -> PathBuf {
    raw_files(&server.folder.0).remove(0)
}

fn check(server: &Server, args: &[&str]) -> Output {
    server.beside(&["check"]).args(args).output().unwrap()
}

fn found(output: &Output) -> (i32, String) {
    let text = String::from_utf8(output.stdout.clone()).unwrap();
    (output.status.code().unwrap(), text)
}

#[tokio::test]
async fn altered_and_missing_files_are_reported_and_never_served() {
    let server = Server::with(&["--workers", "0"]);
    let job = server.submit(&[]).await;
    let view = server.json(&job).await;
    let ride = format!("/v1/rides/{}", view["ride"]["id"].as_str().unwrap());
    let path = format!("{ride}/file");
    let whole = server.get(&path).await;
    let etag = whole.headers()["etag"].clone();
    assert_eq!(whole.bytes().await.unwrap(), ride::example());
    assert_eq!(
        found(&check(&server, &[])),
        (0, "no problems found\n".to_owned())
    );

    let file = stored(&server);
    let mut bytes = ride::example();
    bytes[100] ^= 1;
    std::fs::write(&file, &bytes).unwrap();
    is_lost(&server, &path, "altered").await;
    let (status, said) = found(&check(&server, &[]));
    assert!(
        status == 1 && said.contains("was altered"),
        "{status} {said}"
    );

    std::fs::remove_file(&file).unwrap();
    is_lost(&server, &path, "missing").await;
    let (status, said) = found(&check(&server, &["--repair"]));
    assert!(
        status == 1 && said.contains("is missing"),
        "{status} {said}"
    );

    // A process that has not read it before finds out too, and says so.
    let _worker = server.worker(&[]);
    let view = server.finished(&job).await;
    assert_eq!(view["failure"]["kind"], "file", "{view:#}");

    // The same bytes take its place.
    server.submit(&[("again", "true")]).await;
    let back = server.get(&path).await;
    assert_eq!(back.headers()["etag"], etag);
    assert_eq!(back.bytes().await.unwrap(), ride::example());
    assert_eq!(found(&check(&server, &[])).0, 0);
}

async fn is_lost(server: &Server, path: &str, why: &str) {
    let response = server.get(path).await;
    assert_eq!(response.status(), 410);
    assert!(!response.headers().contains_key("etag"));
    let problem: Value = response.json().await.unwrap();
    assert_eq!(problem["type"], "urn:veloid:problem:file-lost");
    assert!(
        problem["detail"].as_str().unwrap().contains(why),
        "{problem:#}"
    );
}

#[tokio::test]
async fn files_without_a_ride_are_found_and_removed() {
    let server = Server::with(&["--workers", "0"]);
    server.submit(&[]).await;
    let orphan = server.folder.0.join("rides").join("0".repeat(64));
    std::fs::write(&orphan, "left behind").unwrap();
    assert_eq!(found(&check(&server, &[])).0, 0, "it may just have arrived");
    let yesterday = std::time::SystemTime::now() - std::time::Duration::from_secs(86_400);
    let file = std::fs::File::options().append(true).open(&orphan).unwrap();
    file.set_modified(yesterday).unwrap();
    let (status, said) = found(&check(&server, &[]));
    assert!(
        status == 1 && said.contains("would erase raw file 0000"),
        "{said}"
    );
    assert!(orphan.exists());
    assert_eq!(found(&check(&server, &["--repair"])).0, 1);
    assert!(!orphan.exists());
    assert_eq!(found(&check(&server, &[])).0, 0);
}

/// Pages of the database that were overwritten.
#[tokio::test]
async fn a_damaged_database_is_found() {
    let mut server = Server::on_sqlite(&["--workers", "0"]);
    for seed in ["1", "2", "3"] {
        server.submit(&[("seed", seed)]).await;
    }
    assert_eq!(server.get("/readyz").await.status(), 200);
    assert_eq!(server.terminate(), Some(0));
    damage(&server).await;
    let (status, said) = found(&check(&server, &[]));
    assert!(status >= 1 && said.contains("database:"), "{status} {said}");
}

/// Writes over a page of the database of a server that has stopped.
async fn damage(server: &Server) {
    let database = server.folder.0.join("veloid.db");
    let url = format!("sqlite:{}", database.display());
    let mut connection = SqliteConnection::connect(&url).await.unwrap();
    let checkpoint = sqlx::query("PRAGMA wal_checkpoint(TRUNCATE)");
    checkpoint.execute(&mut connection).await.unwrap();
    let root = "SELECT rootpage FROM sqlite_schema WHERE name = 'idempotency_key'";
    let page: i64 = sqlx::query_scalar(root)
        .fetch_one(&mut connection)
        .await
        .unwrap();
    connection.close().await.unwrap();
    let mut bytes = std::fs::read(&database).unwrap();
    let from = 4096 * (page as usize - 1);
    bytes[from..][..4096].fill(0x5a);
    std::fs::write(&database, &bytes).unwrap();
}

#[tokio::test]
async fn strangers_hear_that_the_database_is_damaged_and_admins_where() {
    let mut server = Server::on_sqlite(&["--workers", "0"]);
    server.submit(&[]).await;
    let [admin, reader] = ["admin", "read"].map(|scope| {
        let mut create = server.beside(&["key", "create", "--scope", scope]);
        key_of(&create.output().unwrap())
    });
    assert_eq!(server.terminate(), Some(0));
    damage(&server).await;
    server.restart_with_env(&[("VELOID_KEYS", "true")]);
    // It is looked through soon after the start.
    while server.get("/readyz").await.status() != 503 {
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    let hears = async |key: &str| {
        let request = server.client.get(server.address("/readyz"));
        let answer = request.bearer_auth(key).send().await.unwrap();
        assert_eq!(answer.status(), 503);
        let problem: Value = answer.json().await.unwrap();
        problem["detail"].as_str().unwrap().to_owned()
    };
    for key in ["", "veloid_00", &reader] {
        assert_eq!(hears(key).await, "the database is damaged", "{key}");
    }
    let reported = hears(&admin).await;
    let detail = reported.strip_prefix("the database is damaged: ").unwrap();
    let detail = detail.lines().next().unwrap();
    let log = std::fs::read_to_string(server.folder.0.join("log")).unwrap();
    assert!(!detail.is_empty() && log.contains(detail), "{reported}");
}
