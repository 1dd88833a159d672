//! A process that was given the wrong database or the wrong store of raw files: it refuses with what to do, and no file
//! is lost.

use std::fs;
use std::path::Path;
use std::process::Output;
use std::time::{Duration, SystemTime};

use reqwest::Method;
use serde_json::Value;

use crate::harness::{Folder, Server, has_points, raw_files, veloid};
use crate::ride;

const IDLE: [&str; 2] = ["--workers", "0"];

/// Uploads a ride that no other upload has; its address.
async fn sent(server: &Server, samples: usize) -> String {
    let file = ride::table(samples, 200.0).into_bytes();
    let response = server.upload(file, ride::BIKE, &ride::QUICK).await;
    assert_eq!(response.status(), 202);
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    let id = server.json(&job).await["ride"]["id"].clone();
    format!("/v1/rides/{}", id.as_str().unwrap())
}

/// Server with so many rides, whose files are older than any that may be arriving.
async fn with_rides(count: usize) -> Server {
    let server = Server::on_sqlite(&IDLE);
    for samples in 500..500 + count {
        sent(&server, samples).await;
    }
    age(&server.folder.0);
    server
}

/// Makes the raw files two hours old.
fn age(data: &Path) {
    let hours_ago = SystemTime::now() - Duration::from_secs(2 * 3600);
    for path in raw_files(data) {
        let file = fs::File::options().append(true).open(path).unwrap();
        file.set_modified(hours_ago).unwrap();
    }
}

fn remove_database(data: &Path) {
    for name in ["veloid.db", "veloid.db-wal", "veloid.db-shm"] {
        let _ = fs::remove_file(data.join(name));
    }
}

fn said(output: &Output) -> String {
    let texts = [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text));
    texts.concat()
}

/// Every command that works on raw files refuses, and says this.
fn is_refused(server: &Server, env: &[(&str, &str)], why: &str) {
    let files = raw_files(&server.folder.0).len();
    let listen = ["serve", "--listen", "127.0.0.1:0", "--workers", "0"];
    for command in [
        &listen[..],
        &["worker"],
        &["migrate"],
        &["prune"],
        &["check", "--repair"],
    ] {
        let mut limited = std::process::Command::new("timeout");
        let beside = server.beside(command);
        limited
            .arg("60")
            .arg(beside.get_program())
            .args(beside.get_args());
        limited.env_remove("DATABASE_URL").envs(env.iter().copied());
        let output = limited.output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{command:?}: {output:?}");
        let said = said(&output);
        assert!(said.contains(why), "{command:?}: {said}");
        assert_eq!(raw_files(&server.folder.0).len(), files, "{command:?}");
    }
}

fn succeeds(server: &Server, args: &[&str]) -> String {
    let output = server.beside(args).output().unwrap();
    assert!(output.status.success(), "{args:?}: {output:?}");
    said(&output)
}

#[tokio::test]
async fn a_server_whose_database_is_lost_leaves_its_files() {
    let mut server = with_rides(5).await;
    server.kill();
    remove_database(&server.folder.0);
    for command in [&["prune"][..], &["check"], &["key", "list"]] {
        let output = server.beside(command).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{command:?}: {output:?}");
        assert!(said(&output).contains("there is no such database"));
        assert!(!server.folder.0.join("veloid.db").exists(), "{command:?}");
    }
    for command in [
        &["serve", "--listen", "127.0.0.1:0"][..],
        &["worker"],
        &["migrate"],
    ] {
        let output = server.beside(command).output().unwrap();
        assert!(
            said(&output).contains("the database has no rides"),
            "{output:?}"
        );
        assert!(!server.folder.0.join("veloid.db").exists(), "{command:?}");
    }
    assert_eq!(raw_files(&server.folder.0).len(), 5);

    // Where it is said to be lost, a new one takes its place and the files are found.
    succeeds(&server, &["adopt"]);
    server.restart();
    let check = server.beside(&["check"]).output().unwrap();
    assert_eq!(check.status.code(), Some(5));
    assert!(
        said(&check).contains("5 of 5 raw files (100.0 %)"),
        "{check:?}"
    );
    assert_eq!(raw_files(&server.folder.0).len(), 5);
}

#[tokio::test]
async fn another_installations_database_is_refused() {
    let mut server = with_rides(2).await;
    let other = with_rides(3).await;
    server.kill();
    let url = format!("sqlite:{}", other.folder.0.join("veloid.db").display());
    is_refused(
        &server,
        &[("DATABASE_URL", &url)],
        "the database belongs to installation",
    );
    server.restart();
    assert_eq!(
        server.json("/v1/jobs").await["items"]
            .as_array()
            .unwrap()
            .len(),
        2
    );
}

#[tokio::test]
async fn a_second_installation_on_the_same_store_is_refused() {
    let first = with_rides(2).await;
    let second = Server::on_sqlite(&IDLE);
    let files = format!("file://{}", first.folder.0.display());
    let mut serve = std::process::Command::new("timeout");
    let beside = second.beside(&["prune"]);
    serve
        .arg("60")
        .arg(beside.get_program())
        .args(beside.get_args());
    let output = serve.env("VELOID_FILES", &files).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(
        said(&output).contains("belongs to installation"),
        "{output:?}"
    );

    let empty = Folder::new();
    let data = empty.0.to_str().unwrap();
    let output = veloid(&["migrate", "--data", data, "--files", &files]);
    assert!(
        said(&output).contains("the database has no rides"),
        "{output:?}"
    );
    for job in first.json("/v1/jobs").await["items"].as_array().unwrap() {
        let file = format!("/v1/rides/{}/file", job["ride"]["id"].as_str().unwrap());
        assert_eq!(first.get(&file).await.status(), 200);
    }
}

/// A dump from before the last uploads: their files are listed, and removed by nothing but the word for it.
#[tokio::test]
async fn an_older_database_loses_no_file_of_later_rides() {
    let mut server = with_rides(1).await;
    let data = server.folder.0.clone();
    let kept = Folder::new();
    let backup = kept.0.join("backup");
    succeeds(&server, &["backup", backup.to_str().unwrap()]);
    for samples in 600..603 {
        sent(&server, samples).await;
    }
    age(&data);
    server.kill();
    remove_database(&data);
    fs::copy(backup.join("veloid.db"), data.join("veloid.db")).unwrap();
    server.restart();
    assert!(succeeds(&server, &["prune", "--grace-days", "0"]).contains(" 0 raw files"));
    server.crash_and_restart();
    let check = server.beside(&["check"]).output().unwrap();
    assert_eq!(check.status.code(), Some(3), "{check:?}");
    assert!(
        said(&check).contains("3 of 4 raw files (75.0 %) belong to no ride"),
        "{check:?}"
    );
    assert_eq!(raw_files(&data).len(), 4);
    // What comes again finds its place.
    sent(&server, 600).await;
    let repair = server.beside(&["check", "--repair"]).output().unwrap();
    assert_eq!(repair.status.code(), Some(2), "{repair:?}");
    assert_eq!(raw_files(&data).len(), 2);
}

/// An installation of before there were ids: adopted where files and rides match.
#[tokio::test]
async fn an_upgrade_is_adopted_where_its_files_match() {
    let mut server = with_rides(2).await;
    let data = server.folder.0.clone();
    let forget = async |server: &Server| {
        assert_eq!(
            server
                .count("DELETE FROM installation RETURNING single")
                .await,
            1
        );
        fs::remove_file(server.folder.0.join("rides/installation")).unwrap();
    };
    forget(&server).await;
    server.crash_and_restart();
    assert!(data.join("rides/installation").exists());

    forget(&server).await;
    server.kill();
    let foreign = data.join("rides").join("0".repeat(64));
    fs::write(&foreign, "another installation's").unwrap();
    server.restart();
    forget(&server).await;
    server.kill();
    age(&data);
    is_refused(&server, &[], "1 of 3 raw files");
    succeeds(&server, &["adopt"]);
    server.restart();
    assert!(foreign.exists());
}

#[tokio::test]
async fn an_unmounted_store_is_refused() {
    let mut server = with_rides(2).await;
    server.kill();
    let (rides, away) = (server.folder.0.join("rides"), server.folder.0.join("away"));
    fs::rename(&rides, &away).unwrap();
    fs::create_dir(&rides).unwrap();
    is_refused(&server, &[], "the database has 2 rides");
    fs::remove_dir(&rides).unwrap();
    fs::rename(&away, &rides).unwrap();
    server.restart();
    assert_eq!(
        server.json("/v1/jobs").await["items"]
            .as_array()
            .unwrap()
            .len(),
        2
    );
}

/// A store that is exchanged under a running server loses nothing: what was deleted waits until the store is back.
#[tokio::test]
async fn a_store_that_is_exchanged_meanwhile_loses_nothing() {
    if !has_points() {
        return;
    }
    let server = Server::on_sqlite(&IDLE);
    let ride = sent(&server, 500).await;
    let delete = server.client.request(Method::DELETE, server.address(&ride));
    assert_eq!(delete.send().await.unwrap().status(), 200);
    let (rides, away) = (server.folder.0.join("rides"), server.folder.0.join("away"));
    // The id is asked for once more when files are to be removed.
    let mut prune = server.beside(&["prune", "--grace-days", "0"]);
    let died = prune
        .env("VELOID_CRASH_AT", "after_erase")
        .output()
        .unwrap();
    assert_eq!(died.status.code(), None, "{died:?}");
    fs::rename(&rides, &away).unwrap();
    fs::create_dir(&rides).unwrap();
    fs::write(
        rides.join("installation"),
        "01936f00-0000-7000-8000-000000000000\n",
    )
    .unwrap();
    let output = server
        .beside(&["prune", "--grace-days", "0"])
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    fs::remove_dir_all(&rides).unwrap();
    fs::rename(&away, &rides).unwrap();
    assert!(succeeds(&server, &["prune", "--grace-days", "0"]).contains(" 1 raw files"));
    assert!(raw_files(&server.folder.0).is_empty());
}

/// A restored backup is the same installation; a copy that lives beside the original is made another.
#[tokio::test]
async fn a_copy_becomes_an_installation_of_its_own() {
    let server = with_rides(2).await;
    let kept = Folder::new();
    let (backup, data) = (kept.0.join("backup"), kept.0.join("data"));
    succeeds(&server, &["backup", backup.to_str().unwrap()]);
    let [backup, data] = [&backup, &data].map(|path| path.to_str().unwrap());
    let run = |args: &[&str]| {
        let output = veloid(args);
        (output.status.code(), said(&output))
    };
    assert_eq!(run(&["restore", backup, "--data", data]).0, Some(0));
    let marker = |folder: &Path| fs::read_to_string(folder.join("rides/installation")).unwrap();
    assert_eq!(marker(data.as_ref()), marker(&server.folder.0));
    assert_eq!(run(&["migrate", "--data", data]).0, Some(0));

    let (status, printed) = run(&["adopt", "--new", "--data", data]);
    assert_eq!(status, Some(0), "{printed}");
    assert_ne!(marker(data.as_ref()), marker(&server.folder.0));
    let production = format!("file://{}", server.folder.0.display());
    let (status, printed) = run(&["check", "--data", data, "--files", &production]);
    assert!(
        status == Some(1) && printed.contains("belongs to installation"),
        "{printed}"
    );
    assert_eq!(
        run(&["check", "--data", data]),
        (Some(0), "no problems found\n".to_owned())
    );
    let jobs: Value = server.json("/v1/jobs").await;
    assert_eq!(jobs["items"].as_array().unwrap().len(), 2);
}
