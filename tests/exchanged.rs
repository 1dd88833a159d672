//! Database or store of raw files are exchanged under a running server: it refuses uploads, says why, goes on when they
//! are back, and every job that it acknowledged exists after a restart.

use std::fs;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use futures_util::StreamExt;
use futures_util::future::join_all;
use futures_util::stream::iter;
use reqwest::Response;
use serde_json::Value;
use sqlx::{Connection, SqliteConnection};

use crate::harness::{Folder, Server, form, has_points};
use crate::oracle::Upload;
use crate::ride;

const IDLE: [&str; 2] = ["--workers", "0"];
/// More than two beats.
const BEATS: Duration = Duration::from_secs(5);
const STORAGE: &str = "urn:veloid:problem:storage";

/// Uploads that were acknowledged.
#[derive(Default)]
struct Sent {
    count: usize,
    jobs: Vec<String>,
}

impl Sent {
    /// Sends a ride that no other has.
    async fn send(&mut self, server: &Server) -> Response {
        self.count += 1;
        let file = ride::table(500 + self.count, 200.0).into_bytes();
        let response = server.upload(file, ride::BIKE, &ride::QUICK).await;
        if response.status() == 202 {
            let job = response.headers()["location"].to_str().unwrap();
            self.jobs.push(job.to_owned());
        }
        response
    }

    /// Each of them exists, with its file.
    async fn exist(&self, server: &Server, after: &str) {
        assert!(!self.jobs.is_empty());
        for job in &self.jobs {
            let found = server.get(job).await;
            assert_eq!(found.status(), 200, "{after}: {job}");
            let view: Value = found.json().await.unwrap();
            let ride = view["ride"]["id"].as_str().unwrap();
            let file = server.get(&format!("/v1/rides/{ride}/file")).await;
            assert_eq!(file.status(), 200, "{after}: file of {job}");
        }
    }
}

/// An answer that says that the storage is not as it should be, and to come again.
async fn is_storage_fault(response: Response, when: &str) {
    let (status, headers) = (response.status(), response.headers().clone());
    let problem: Value = response.json().await.unwrap();
    assert_eq!(status, 503, "{when}: {problem:#}");
    assert_eq!(problem["type"], STORAGE, "{when}: {problem:#}");
    assert!(headers.contains_key("retry-after"), "{when}");
}

/// Waits until `/readyz` answers so; what it said.
async fn ready(server: &Server, status: u16, when: &str) -> String {
    for _ in 0..600 {
        let answer = server.get("/readyz").await;
        if answer.status() == status {
            return answer.text().await.unwrap();
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    panic!("{when}: /readyz is not {status} after a minute");
}

fn times_logged(server: &Server) -> usize {
    let log = fs::read_to_string(server.folder.0.join("log")).unwrap();
    log.matches("nothing is accepted").count()
}

/// What an administrator may do to a data folder, and how it is put right.
struct Exchange {
    name: &'static str,
    away: fn(&Path),
    back: fn(&Path),
}

fn rename(data: &Path, from: &str, to: &str) {
    fs::rename(data.join(from), data.join(to)).unwrap();
}

const EXCHANGES: [Exchange; 9] = [
    Exchange {
        name: "the database's file is renamed",
        away: |data| rename(data, "veloid.db", "kept"),
        back: |data| rename(data, "kept", "veloid.db"),
    },
    Exchange {
        name: "the database's file is deleted",
        away: |data| {
            fs::hard_link(data.join("veloid.db"), data.join("kept")).unwrap();
            fs::remove_file(data.join("veloid.db")).unwrap();
        },
        back: |data| rename(data, "kept", "veloid.db"),
    },
    Exchange {
        name: "an older database is renamed over it",
        away: |data| {
            fs::hard_link(data.join("veloid.db"), data.join("kept")).unwrap();
            fs::copy(data.join("older"), data.join("new")).unwrap();
            rename(data, "new", "veloid.db");
        },
        back: |data| rename(data, "kept", "veloid.db"),
    },
    Exchange {
        name: "the log is renamed",
        away: |data| rename(data, "veloid.db-wal", "kept"),
        back: |data| rename(data, "kept", "veloid.db-wal"),
    },
    Exchange {
        name: "the log's index is renamed",
        away: |data| rename(data, "veloid.db-shm", "kept"),
        back: |data| rename(data, "kept", "veloid.db-shm"),
    },
    Exchange {
        name: "the store is renamed",
        away: |data| rename(data, "rides", "kept"),
        back: |data| rename(data, "kept", "rides"),
    },
    Exchange {
        name: "the store is unmounted",
        away: |data| {
            rename(data, "rides", "kept");
            fs::create_dir(data.join("rides")).unwrap();
        },
        back: |data| {
            fs::remove_dir(data.join("rides")).unwrap();
            rename(data, "kept", "rides");
        },
    },
    Exchange {
        name: "the store is emptied",
        away: |data| {
            fs::create_dir(data.join("kept")).unwrap();
            move_all(&data.join("rides"), &data.join("kept"));
        },
        back: |data| {
            move_all(&data.join("kept"), &data.join("rides"));
            fs::remove_dir(data.join("kept")).unwrap();
        },
    },
    Exchange {
        name: "the store is another installation's",
        away: |data| {
            rename(data, "rides", "kept");
            fs::create_dir(data.join("rides")).unwrap();
            let id = "01936f00-0000-7000-8000-000000000000\n";
            fs::write(data.join("rides/installation"), id).unwrap();
        },
        back: |data| {
            fs::remove_dir_all(data.join("rides")).unwrap();
            rename(data, "kept", "rides");
        },
    },
];

fn move_all(from: &Path, to: &Path) {
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        fs::rename(entry.path(), to.join(entry.file_name())).unwrap();
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_exchanged_is_noticed_before_the_next_answer_and_loses_nothing() {
    let all = iter(EXCHANGES).map(is_noticed).buffer_unordered(3);
    all.collect::<()>().await;
}

async fn is_noticed(Exchange { name, away, back }: Exchange) {
    let mut server = Server::on_sqlite(&IDLE);
    let data = server.folder.0.clone();
    let mut sent = Sent::default();
    assert_eq!(sent.send(&server).await.status(), 202, "{name}");
    let backup = Folder::new();
    let to = backup.0.join("backup");
    let made = server.beside(&["backup", to.to_str().unwrap()]).output();
    assert!(made.unwrap().status.success(), "{name}");
    fs::copy(to.join("veloid.db"), data.join("older")).unwrap();
    assert_eq!(sent.send(&server).await.status(), 202, "{name}");

    away(&data);
    for _ in 0..3 {
        is_storage_fault(sent.send(&server).await, name).await;
    }
    let said = ready(&server, 503, name).await;
    assert!(said.contains("exchanged"), "{name}: {said}");
    tokio::time::sleep(BEATS).await;
    assert_eq!(times_logged(&server), 1, "{name}");
    // What only reads goes on.
    assert_eq!(server.get("/v1/jobs").await.status(), 200, "{name}");

    back(&data);
    ready(&server, 200, name).await;
    let copies = fs::read_dir(&data).unwrap().filter(|entry| {
        let name = entry.as_ref().unwrap().file_name();
        name.to_str().unwrap().contains("rescued")
    });
    assert_eq!(copies.count(), 0, "{name}");
    assert_eq!(sent.send(&server).await.status(), 202, "{name}");
    server.crash_and_restart();
    sent.exist(&server, name).await;
}

/// A server that computes nothing and has five rides, and its data folder.
async fn with_five_rides() -> (Server, PathBuf, Sent) {
    let server = Server::on_sqlite(&IDLE);
    let mut sent = Sent::default();
    for _ in 0..5 {
        assert_eq!(sent.send(&server).await.status(), 202);
    }
    let data = server.folder.0.clone();
    (server, data, sent)
}

/// It cannot be put back: what it had is moved into the database.
#[tokio::test]
async fn a_log_that_is_removed_loses_nothing() {
    let (mut server, data, mut sent) = with_five_rides().await;
    fs::remove_file(data.join("veloid.db-wal")).unwrap();
    is_storage_fault(sent.send(&server).await, "removed").await;
    said_of(&server, "what it had is in the database").await;
    server.crash_and_restart();
    sent.exist(&server, "removed").await;
    assert_eq!(sent.send(&server).await.status(), 202);
}

/// It cannot be put back either: a copy of what the process has open takes its place.
#[tokio::test]
async fn a_database_that_is_deleted_is_copied_and_loses_nothing() {
    let (mut server, data, mut sent) = with_five_rides().await;
    fs::remove_file(data.join("veloid.db")).unwrap();
    is_storage_fault(sent.send(&server).await, "deleted").await;
    let said = said_of(&server, "also in ").await;
    server.kill();
    let (_, copy) = said.split_once("also in ").unwrap();
    let copy = copy.split('"').next().unwrap();
    for suffix in ["-wal", "-shm"] {
        fs::remove_file(data.join(format!("veloid.db{suffix}"))).unwrap();
    }
    fs::rename(copy, data.join("veloid.db")).unwrap();
    server.restart();
    sent.exist(&server, "deleted").await;
    assert_eq!(sent.send(&server).await.status(), 202);
}

/// Waits until `/readyz` says this.
async fn said_of(server: &Server, what: &str) -> String {
    for _ in 0..600 {
        let said = ready(server, 503, what).await;
        if said.contains(what) {
            return said;
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    panic!("{what} is not said after a minute");
}

/// Uploads that are under way at the moment of the exchange.
#[tokio::test(flavor = "multi_thread")]
async fn nothing_is_acknowledged_into_a_database_that_was_exchanged_meanwhile() {
    let mut server = Server::on_sqlite(&["--workers", "1"]);
    let data = server.folder.0.clone();
    let mut acknowledged = Vec::new();
    for round in 0..4 {
        let uploads = (0..40).map(|i| {
            let file = ride::table(500 + 40 * round + i, 200.0).into_bytes();
            server.upload(file, ride::BIKE, &ride::QUICK)
        });
        let exchange = async {
            tokio::time::sleep(Duration::from_millis(150 * (round as u64 + 1))).await;
            fs::remove_file(data.join("veloid.db-wal")).unwrap();
        };
        let (answers, ()) = tokio::join!(join_all(uploads), exchange);
        for answer in answers {
            match answer.status().as_u16() {
                202 => {
                    acknowledged.push(answer.headers()["location"].to_str().unwrap().to_owned());
                }
                _ => is_storage_fault(answer, "in the flood").await,
            }
        }
        said_of(&server, "what it had is in the database").await;
        server.crash_and_restart();
        for job in &acknowledged {
            assert_eq!(server.get(job).await.status(), 200, "{job}");
        }
    }
    assert!(!acknowledged.is_empty());
}

/// A swarm of some seconds.
const SECONDS: [(&str, &str); 2] = [("iterations", "1000"), ("particles", "60")];

#[tokio::test]
async fn a_result_waits_until_its_database_is_back() {
    let server = Server::on_sqlite(&["--workers", "1"]);
    let data = server.folder.0.clone();
    let upload = Upload::new("key", &SECONDS);
    let job = upload.send(&server).await.unwrap();
    while server.json(&job).await["stage"] != "trial" {}
    rename(&data, "veloid.db", "kept");
    let before = server.json(&job).await;
    // Time for trials to end.
    tokio::time::sleep(2 * BEATS).await;
    let after = server.json(&job).await;
    assert_eq!(after["trials"]["done"], before["trials"]["done"]);
    assert!(after["finished_at"].is_null(), "{after:#}");
    rename(&data, "kept", "veloid.db");
    upload
        .succeeded_once(&server, &job, &upload.undisturbed().await)
        .await;
}

/// A ride whose file is not found because the store is away has not lost it.
#[tokio::test]
async fn no_job_fails_for_a_store_that_is_away() {
    if !has_points() {
        return;
    }
    let server = Server::on_sqlite(&IDLE);
    let data = server.folder.0.clone();
    let job = server.submit(&[]).await;
    let worker = server.worker_with_env(&[], &[("VELOID_STOP_AT", "in_observe")]);
    while server.json(&job).await["state"] != "running" {
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    rename(&data, "rides", "kept");
    let until = tokio::time::Instant::now() + 2 * BEATS;
    while tokio::time::Instant::now() < until {
        worker.send("-CONT");
        tokio::time::sleep(Duration::from_millis(500)).await;
    }
    let view = server.json(&job).await;
    assert!(view["finished_at"].is_null(), "{view:#}");
    rename(&data, "kept", "rides");
    server.succeeded(&job).await;
}

#[tokio::test]
async fn a_folder_that_is_missing_puts_uploads_off() {
    let server = Server::on_sqlite(&IDLE);
    let data = server.folder.0.clone();
    for folder in ["incoming", "rides"] {
        rename(&data, folder, "kept");
        let response = Sent::default().send(&server).await;
        assert_eq!(response.status(), 503, "{folder}");
        assert!(response.headers().contains_key("retry-after"), "{folder}");
        rename(&data, "kept", folder);
        ready(&server, 200, folder).await;
        assert_eq!(Sent::default().send(&server).await.status(), 202);
    }
}

/// The first statement that meets a damaged page ends all writing.
#[tokio::test]
async fn a_page_that_is_damaged_meanwhile_counts_at_once() {
    let mut server = Server::on_sqlite(&IDLE);
    let mut sent = Sent::default();
    assert_eq!(sent.send(&server).await.status(), 202);
    assert_eq!(server.terminate(), Some(0));
    let (database, page) = page_of(&server, "idempotency_key").await;
    server.restart();
    ready(&server, 200, "whole").await;
    assert_eq!(sent.send(&server).await.status(), 202);
    let mut file = fs::File::options().write(true).open(database).unwrap();
    file.seek(SeekFrom::Start(4096 * (page - 1))).unwrap();
    file.write_all(&[0x5a; 4096]).unwrap();
    let upload = async || {
        let file = ride::table(900, 200.0).into_bytes();
        let request = server.client.post(server.address("/v1/rides"));
        let request = request.header("Idempotency-Key", "key");
        let form = form(file, ride::BIKE, &ride::QUICK);
        request.multipart(form).send().await.unwrap()
    };
    is_storage_fault(upload().await, "on the damaged page").await;
    is_storage_fault(sent.send(&server).await, "on any other").await;
    let said = ready(&server, 503, "damaged").await;
    assert!(said.contains("the database is damaged"), "{said}");
}

/// The database of a server that has stopped, with an empty log, and the first page of a table.
async fn page_of(server: &Server, table: &str) -> (PathBuf, u64) {
    let mut connection = SqliteConnection::connect(&server.sqlite()).await.unwrap();
    let empty = sqlx::query("PRAGMA wal_checkpoint(TRUNCATE)");
    empty.execute(&mut connection).await.unwrap();
    let root = "SELECT rootpage FROM sqlite_schema WHERE name = $1";
    let page: i64 = sqlx::query_scalar(root)
        .bind(table)
        .fetch_one(&mut connection)
        .await
        .unwrap();
    connection.close().await.unwrap();
    (server.folder.0.join("veloid.db"), page.try_into().unwrap())
}
