//! Rides and bicycles are deleted, brought back and erased.

use std::process::Output;
use std::time::Duration;

use reqwest::{Method, StatusCode};
use serde_json::Value;

use crate::harness::{Folder, Server, form, has_points, veloid};
use crate::ride::{self, LONG};

/// An upload, by its addresses.
pub struct Sent {
    pub job: String,
    pub ride: String,
    pub sha256: String,
}

/// Uploads a ride of so many samples and waits for its result.
pub async fn sent(server: &Server, samples: usize, parts: &[(&str, &str)]) -> Sent {
    let parts = [&ride::QUICK, parts].concat();
    let file = ride::table(samples, 200.0).into_bytes();
    let response = server.upload(file, ride::BIKE, &parts).await;
    assert_eq!(response.status(), 202);
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    let view = server.succeeded(&job).await;
    let ride = format!("/v1/rides/{}", view["ride"]["id"].as_str().unwrap());
    let sha256 = server.json(&ride).await["sha256"]
        .as_str()
        .unwrap()
        .to_owned();
    Sent { job, ride, sha256 }
}

async fn ask(server: &Server, method: Method, path: &str) -> StatusCode {
    let request = server.client.request(method, server.address(path));
    request.send().await.unwrap().status()
}

async fn delete(server: &Server, path: &str) -> StatusCode {
    ask(server, Method::DELETE, path).await
}

async fn restore(server: &Server, path: &str) -> StatusCode {
    ask(server, Method::POST, &format!("{path}/restore")).await
}

fn prune(server: &Server, args: &[&str]) -> String {
    let output = server
        .beside(&[&["prune"], args].concat())
        .output()
        .unwrap();
    said(&output)
}

fn said(output: &Output) -> String {
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn is_kept(server: &Server, sent: &Sent) -> bool {
    server.folder.0.join("rides").join(&sent.sha256).exists()
}

/// Number of rides that the front stiffness is pooled over.
async fn pooled(server: &Server) -> Value {
    let course = server.json("/v1/bikes/lab-7/course").await;
    course["courses"][0]["pooled"]["rides"].clone()
}

async fn jobs(server: &Server, query: &str) -> Vec<String> {
    let page = server.json(&format!("/v1/jobs?{query}")).await;
    let jobs = page["items"].as_array().unwrap().iter();
    jobs.map(|job| job["links"]["job"].as_str().unwrap().to_owned())
        .collect()
}

async fn parameters(server: &Server, sent: &Sent) -> usize {
    let id = sent.job.rsplit('/').next().unwrap();
    let page = server.json(&format!("/v1/parameters?job={id}")).await;
    page["items"].as_array().unwrap().len()
}

#[tokio::test]
async fn a_deleted_ride_counts_nowhere_until_it_is_brought_back() {
    let server = Server::start();
    let (stays, goes) = (
        sent(&server, 1000, &[]).await,
        sent(&server, 1001, &[]).await,
    );
    let report = server.json(&format!("{}/report", goes.job)).await;
    assert_eq!(pooled(&server).await, 2);

    assert_eq!(delete(&server, &goes.ride).await, 200);
    assert_eq!(jobs(&server, "").await, [stays.job.as_str()]);
    assert_eq!(jobs(&server, "deleted=true").await, [goes.job.as_str()]);
    assert_eq!(pooled(&server).await, 1);
    assert_eq!(parameters(&server, &goes).await, 0);
    assert_eq!(server.json("/v1/bikes/lab-7").await["jobs"], 1);
    for of_job in ["", "/report", "/series", "/trials", "/model", "/events"] {
        let address = format!("{}{of_job}", goes.job);
        assert_eq!(server.get(&address).await.status(), 404, "{address}");
    }
    assert_eq!(
        server.get(&format!("{}/file", goes.ride)).await.status(),
        404
    );
    assert_eq!(
        ask(&server, Method::POST, &format!("{}/retry", goes.job)).await,
        404
    );
    let view = server.json(&goes.ride).await;
    let deleted_at = view["deleted_at"].as_str().unwrap();
    assert!(Some(deleted_at) < view["erased_after"].as_str(), "{view:#}");
    assert_eq!(view["jobs"][0]["deleted_at"], deleted_at);
    assert_eq!(delete(&server, &goes.ride).await, 200);
    assert_eq!(
        server.json(&goes.ride).await["deleted_at"],
        deleted_at,
        "the first time counts"
    );
    assert!(prune(&server, &[]).ends_with("erased: 0 rides, 0 jobs, 0 bikes, 0 raw files\n"));

    assert_eq!(restore(&server, &goes.ride).await, 200);
    assert_eq!(restore(&server, &goes.ride).await, 409);
    assert_eq!(pooled(&server).await, 2);
    assert_eq!(server.json(&format!("{}/report", goes.job)).await, report);
    assert!(is_kept(&server, &goes) && server.json(&goes.ride).await["deleted_at"].is_null());
}

/// Sends the example ride under the same idempotency key; the address of its job.
async fn sent_with_a_key(server: &Server) -> String {
    let form = form(ride::example(), ride::BIKE, &ride::QUICK);
    let request = server.client.post(server.address("/v1/rides"));
    let request = request.header("Idempotency-Key", "key").multipart(form);
    let response = request.send().await.unwrap();
    assert_eq!(response.status(), 202);
    response.headers()["location"].to_str().unwrap().to_owned()
}

#[tokio::test]
async fn what_is_sent_again_after_its_deletion_is_new() {
    let server = Server::start();
    let upload = || sent_with_a_key(&server);
    let first = upload().await;
    let ride = server.succeeded(&first).await["ride"]["id"]
        .as_str()
        .unwrap()
        .to_owned();
    let ride = format!("/v1/rides/{ride}");
    assert_eq!(upload().await, first);
    assert_eq!(delete(&server, &ride).await, 200);
    let second = upload().await;
    assert_ne!(second, first);
    assert_eq!(upload().await, second);
    server.succeeded(&second).await;
    prune(&server, &["--grace-days", "0"]);
    assert_eq!(
        server.json(&ride).await["jobs"].as_array().unwrap().len(),
        1
    );
    assert_eq!(server.get(&format!("{ride}/file")).await.status(), 200);
}

#[tokio::test]
async fn what_is_erased_leaves_nothing() {
    let server = Server::start();
    let one = sent(&server, 1000, &[]).await;
    let same_bytes = sent(&server, 1000, &[("name", "other.csv"), ("again", "true")]).await;
    let other_bytes = sent(&server, 1001, &[]).await;
    assert_ne!(one.ride, same_bytes.ride);
    for sent in [&one, &other_bytes] {
        assert_eq!(delete(&server, &sent.ride).await, 200);
    }
    let rows = "SELECT (SELECT COUNT(*) FROM job) + (SELECT COUNT(*) FROM ride) + (SELECT COUNT(*) FROM result) \
                + (SELECT COUNT(*) FROM trial) + (SELECT COUNT(*) FROM parameter)";
    let before = server.count(rows).await;
    let foreseen = prune(&server, &["--grace-days", "0", "--dry-run"]);
    assert!(
        foreseen.contains(&format!("would erase raw file {}", other_bytes.sha256)),
        "{foreseen}"
    );
    assert!(
        foreseen.ends_with("would be erased: 2 rides, 2 jobs, 0 bikes, 1 raw files\n"),
        "{foreseen}"
    );
    assert_eq!(server.count(rows).await, before);
    assert!(is_kept(&server, &other_bytes));

    let done = prune(&server, &["--grace-days", "0"]);
    assert_eq!(
        done,
        foreseen
            .replace("would be ", "")
            .replace("would erase", "erased")
    );
    assert_eq!(
        server.count(rows).await * 3,
        before,
        "two of three are gone"
    );
    assert!(is_kept(&server, &one), "another ride has the same bytes");
    assert!(!is_kept(&server, &other_bytes));
    for sent in [&one, &other_bytes] {
        assert_eq!(server.get(&sent.ride).await.status(), 404);
        assert_eq!(restore(&server, &sent.ride).await, 404);
    }
    let file = server.get(&format!("{}/file", same_bytes.ride)).await;
    assert_eq!(file.bytes().await.unwrap(), ride::table(1000, 200.0));
    assert_eq!(delete(&server, &same_bytes.ride).await, 200);
    prune(&server, &["--grace-days", "0"]);
    assert!(!is_kept(&server, &one));
    assert_eq!(server.count(rows).await, 0);
    assert_eq!(
        server
            .count("SELECT COUNT(*) FROM audit WHERE action = 'erase'")
            .await,
        3
    );
}

/// A job whose trials are computed, and its ride.
async fn computing(server: &Server) -> (String, String) {
    let job = server.submit(&LONG).await;
    while server.json(&job).await["stage"] != "trial" {}
    let ride = server.json(&job).await["ride"]["id"]
        .as_str()
        .unwrap()
        .to_owned();
    (job, format!("/v1/rides/{ride}"))
}

#[tokio::test]
async fn a_job_that_runs_is_cancelled_with_its_ride() {
    let server = Server::with(&["--workers", "1"]);
    let (job, ride) = computing(&server).await;
    assert_eq!(delete(&server, &ride).await, 200);
    assert_eq!(server.json(&ride).await["jobs"][0]["state"], "cancelled");
    crate::oracle::nothing_is_left(&server).await;
    assert_eq!(restore(&server, &ride).await, 200);
    assert_eq!(server.json(&job).await["state"], "cancelled");
}

#[tokio::test]
async fn a_bicycle_goes_with_its_rides_and_comes_back_with_them() {
    let server = Server::start();
    let (first, second) = (
        sent(&server, 1000, &[]).await,
        sent(&server, 1001, &[]).await,
    );
    // The first was of another bicycle too.
    let other = ride::BIKE.replace("lab-7", "lab/8");
    let file = ride::table(1000, 200.0).into_bytes();
    let response = server.upload(file, &other, &ride::QUICK).await;
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    server.succeeded(&job).await;
    assert_eq!(delete(&server, &second.ride).await, 200);

    assert_eq!(delete(&server, "/v1/bikes/lab-7").await, 204);
    assert_eq!(delete(&server, "/v1/bikes/lab-7").await, 404);
    for gone in [
        "/v1/bikes/lab-7",
        "/v1/bikes/lab-7/course",
        "/bikes/lab-7",
        &first.job,
    ] {
        assert_eq!(server.get(gone).await.status(), 404, "{gone}");
    }
    let fleet = server.json("/v1/fleet").await;
    assert_eq!(fleet["bikes"].as_array().unwrap().len(), 1, "{fleet:#}");
    let named = server.upload(ride::example(), "lab-7", &ride::QUICK).await;
    assert_eq!(named.status(), 422, "it is no bike of the fleet");
    assert_eq!(jobs(&server, "").await, [job.as_str()]);

    assert_eq!(restore(&server, "/v1/bikes/lab-7").await, 200);
    assert_eq!(
        jobs(&server, "bike=lab-7").await,
        [first.job.as_str()],
        "not what was deleted before"
    );
    assert_eq!(delete(&server, "/v1/bikes/lab-7").await, 204);
    // A ride brings its bicycle back.
    assert_eq!(restore(&server, &second.ride).await, 200);
    assert_eq!(server.json("/v1/bikes/lab-7").await["jobs"], 1);
    assert_eq!(delete(&server, "/v1/bikes/lab-7").await, 204);
    let done = prune(&server, &["--grace-days", "0"]);
    assert!(
        done.contains("erased: 1 rides, 2 jobs, 1 bikes, 1 raw files"),
        "{done}"
    );
    assert_eq!(restore(&server, "/v1/bikes/lab-7").await, 404);
    assert_eq!(jobs(&server, "").await, [job.as_str()]);
    assert!(is_kept(&server, &first), "it is the other's too");
}

#[tokio::test]
async fn groups_delete_only_what_is_theirs_and_admins_see_by_whom() {
    let (mut server, [ours, theirs, admin]) = Server::with_keys(
        [
            &["--group", "a"],
            &["--group", "b"],
            &["--group", "a", "--scope", "admin"],
        ],
        &[],
    );
    server.as_seen_by(&theirs);
    let other = sent(&server, 1000, &[]).await;
    server.as_seen_by(&ours);
    let own = sent(&server, 1000, &[]).await;
    assert_eq!(own.sha256, other.sha256);
    assert_eq!(delete(&server, &other.ride).await, 404);
    assert_eq!(restore(&server, &other.ride).await, 404);
    assert_eq!(delete(&server, &own.ride).await, 200);
    assert_eq!(delete(&server, "/v1/bikes/lab-7").await, 204);
    assert_eq!(server.get("/v1/audit").await.status(), 403);
    prune(&server, &["--grace-days", "0"]);

    server.as_seen_by(&theirs);
    assert_eq!(pooled(&server).await, 1);
    assert_eq!(
        server.get(&format!("{}/file", other.ride)).await.status(),
        200
    );
    assert!(jobs(&server, "deleted=true").await.is_empty());
    server.as_seen_by(&admin);
    let trail = server.json("/v1/audit").await;
    let reported: Vec<_> = trail["items"]
        .as_array()
        .unwrap()
        .iter()
        .map(|deed| {
            let subject = deed["subject"].as_str().unwrap();
            [
                deed["actor"].as_str().unwrap(),
                deed["action"].as_str().unwrap(),
                &subject[..4],
            ]
        })
        .collect();
    let by_key = |action, subject| ["key", action, subject];
    let expected = [
        ["command", "erase", "bike"],
        ["command", "erase", "ride"],
        by_key("delete", "bike"),
        by_key("delete", "ride"),
    ];
    assert_eq!(reported, expected);
    let list = server.beside(&["key", "list"]).output().unwrap();
    let key = trail["items"][3]["key"].as_str().unwrap().to_owned();
    assert!(said(&list).contains(&key));
}

#[tokio::test]
async fn results_are_kept_for_as_long_as_their_group_says() {
    let server = Server::start();
    let (old, older) = (
        sent(&server, 1000, &[]).await,
        sent(&server, 1001, &[]).await,
    );
    let new = sent(&server, 1002, &[]).await;
    let by_hand = "UPDATE job SET created_at = created_at - 9 * 86400000 \
                   WHERE ride_id IN (SELECT id FROM ride ORDER BY id LIMIT 2) RETURNING created_at";
    assert!(server.count(by_hand).await > 0);
    prune(&server, &["--retain-days", "30"]);
    assert_eq!(jobs(&server, "").await.len(), 3);
    prune(
        &server,
        &["--retain-days", "3", "--retain-group", "default=30,other=1"],
    );
    assert_eq!(jobs(&server, "").await.len(), 3);
    let reported = prune(&server, &["--retain-group", "default=3"]);
    assert!(
        reported.contains("deleted 2 jobs older than 3 days of group default"),
        "{reported}"
    );
    assert_eq!(jobs(&server, "").await, [new.job.as_str()]);
    assert_eq!(restore(&server, &old.ride).await, 200);
    prune(&server, &["--retain-days", "3", "--grace-days", "0"]);
    assert!(!is_kept(&server, &old) && !is_kept(&server, &older) && is_kept(&server, &new));
}

#[tokio::test]
async fn a_server_erases_by_itself() {
    let mut server = Server::start();
    let sent = sent(&server, 1000, &[]).await;
    assert_eq!(delete(&server, &sent.ride).await, 200);
    server.crash_and_restart();
    assert_eq!(
        server.get(&sent.ride).await.status(),
        200,
        "within the days of grace"
    );
    server.kill();
    server.restart_with_env(&[("VELOID_GRACE_DAYS", "0")]);
    while is_kept(&server, &sent) {
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    assert_eq!(server.get(&sent.ride).await.status(), 404);
}

/// Dies in the transaction that erases: nothing is erased. After it: only the file is left, which the database names, and
/// the next one removes it, whenever that dies.
#[tokio::test]
async fn a_prune_that_dies_leaves_nothing_half_erased() {
    if !has_points() {
        return;
    }
    let server = Server::start();
    let sent = sent(&server, 1000, &[]).await;
    assert_eq!(delete(&server, &sent.ride).await, 200);
    let dies = |point: &str| {
        let mut command = server.beside(&["prune", "--grace-days", "0"]);
        let died = command.env("VELOID_CRASH_AT", point).output().unwrap();
        assert_eq!(died.status.code(), None, "{died:?}");
    };
    for (point, left) in [("in_erase", 1), ("after_erase", 0)] {
        dies(point);
        for table in [
            "SELECT COUNT(*) FROM job",
            "SELECT COUNT(*) FROM ride",
            "SELECT COUNT(*) FROM result",
        ] {
            assert_eq!(server.count(table).await, left, "{point}: {table}");
        }
        let named = server.count("SELECT COUNT(*) FROM erased_file").await;
        assert_eq!(named, 1 - left, "{point}");
        assert!(is_kept(&server, &sent), "{point}");
    }
    assert!(
        prune(&server, &[]).contains(" 0 raw files"),
        "the days of grace have not passed since it was erased"
    );
    server.folder.write("rides/README", "no raw file");
    dies("in_removal");
    assert!(!is_kept(&server, &sent));
    assert_eq!(server.count("SELECT COUNT(*) FROM erased_file").await, 1);
    assert!(prune(&server, &["--grace-days", "0"]).contains(" 0 raw files"));
    assert_eq!(server.count("SELECT COUNT(*) FROM erased_file").await, 0);
    assert!(server.folder.0.join("rides/README").exists());
}

/// A file that comes again after its ride was erased, and before it is removed, stays.
#[tokio::test]
async fn a_file_that_comes_again_is_not_removed() {
    let server = Server::start();
    let first = sent(&server, 1000, &[]).await;
    assert_eq!(delete(&server, &first.ride).await, 200);
    let by_hand = "UPDATE job SET deleted_at = deleted_at - 8 * 86400000 RETURNING deleted_at";
    assert!(server.count(by_hand).await > 0);
    assert!(prune(&server, &[]).contains("erased: 1 rides, 1 jobs, 0 bikes, 0 raw files"));
    let again = sent(&server, 1000, &[]).await;
    assert_eq!(again.sha256, first.sha256);
    assert!(prune(&server, &["--grace-days", "0"]).contains(" 0 raw files"));
    assert!(is_kept(&server, &again));
    assert_eq!(server.count("SELECT COUNT(*) FROM erased_file").await, 0);
    assert_eq!(delete(&server, &again.ride).await, 200);
    assert!(prune(&server, &["--grace-days", "0"]).contains(" 1 raw files"));
    assert!(!is_kept(&server, &again));
}

#[tokio::test]
async fn a_deletion_holds_once_it_is_committed() {
    if !has_points() {
        return;
    }
    for (point, deleted) in [("in_delete", false), ("after_delete", true)] {
        let mut server = Server::with_env(&["--workers", "1"], &[("VELOID_CRASH_AT", point)]);
        let (_, ride) = computing(&server).await;
        let answer = server.client.delete(server.address(&ride)).send().await;
        assert!(answer.is_err(), "it dies before it answers");
        server.dies().await;
        server.restart_with_env(&[]);
        assert_eq!(
            server.json(&ride).await["deleted_at"].is_string(),
            deleted,
            "{point}"
        );
        assert_eq!(delete(&server, &ride).await, 200);
        assert_eq!(server.json(&ride).await["jobs"][0]["state"], "cancelled");
        crate::oracle::nothing_is_left(&server).await;
    }
}

/// The same bytes come and go all the time: who hears 202 has a ride with its file.
#[tokio::test(flavor = "multi_thread")]
async fn an_acknowledged_ride_keeps_its_file_while_others_are_erased() {
    let server = Server::with(&["--workers", "0"]);
    let file = ride::table(500, 200.0).into_bytes();
    let erasing = async {
        for _ in 0..12 {
            let mut command = server.beside(&["prune", "--grace-days", "0"]);
            let output = tokio::task::spawn_blocking(move || command.output().unwrap()).await;
            said(&output.unwrap());
        }
    };
    let uploading = async {
        let mut safe = 0;
        for _ in 0..150 {
            let response = server.upload(file.clone(), ride::BIKE, &ride::QUICK).await;
            if response.status() == 503 {
                continue;
            }
            assert_eq!(response.status(), 202);
            let job: Value = response.json().await.unwrap();
            let ride = format!("/v1/rides/{}", job["ride"]["id"].as_str().unwrap());
            let kept = server.get(&format!("{ride}/file")).await;
            assert_eq!(kept.status(), 200);
            assert_eq!(kept.bytes().await.unwrap(), file);
            assert_eq!(delete(&server, &ride).await, 200);
            safe += 1;
        }
        safe
    };
    let (safe, ()) = tokio::join!(uploading, erasing);
    assert!(safe > 100, "{safe} of 150 were taken");
}

/// Uploads are answered with their job while others delete the same ride.
#[tokio::test(flavor = "multi_thread")]
#[ignore = "slow"]
async fn an_upload_that_meets_a_deletion_is_answered() {
    let server = Server::with(&["--workers", "0", "--queue", "1000000"]);
    let first = server.submit(&[]).await;
    let ride = server.json(&first).await["ride"]["id"].clone();
    let address = server.address(&format!("/v1/rides/{}", ride.as_str().unwrap()));
    let sending = std::sync::atomic::AtomicBool::new(true);
    let deleting = async || {
        let mut deletions = 0;
        while sending.load(std::sync::atomic::Ordering::Relaxed) {
            let deleted = server.client.delete(&address).send().await.unwrap();
            assert_eq!(deleted.status(), 200);
            deletions += 1;
        }
        deletions
    };
    // One makes a new job each time, one finds that of the same fingerprint, one that of its key.
    let uploading = async |again: &str, key: Option<&str>| {
        for _ in 0..100 {
            let parts = [&ride::QUICK[..], &[("again", again)]].concat();
            let form = form(ride::example(), ride::BIKE, &parts);
            let mut request = server.client.post(server.address("/v1/rides"));
            if let Some(key) = key {
                request = request.header("Idempotency-Key", key);
            }
            let response = request.multipart(form).send().await.unwrap();
            let (status, body) = (response.status(), response.text().await.unwrap());
            assert_eq!(status, 202, "{body}");
        }
    };
    let uploads = async {
        tokio::join!(
            uploading("true", None),
            uploading("false", None),
            uploading("false", Some("key")),
        );
        sending.store(false, std::sync::atomic::Ordering::Relaxed);
    };
    let (deletions, others, ()) = tokio::join!(deleting(), deleting(), uploads);
    eprintln!("300 uploads beside {} deletions", deletions + others);
    assert!(deletions + others > 10);
}

/// An idempotency key whose job was deleted by retention can be used again.
#[tokio::test]
async fn a_key_of_an_expired_result_is_free() {
    let server = Server::start();
    let upload = || sent_with_a_key(&server);
    let first = upload().await;
    server.succeeded(&first).await;
    let by_hand = "UPDATE job SET created_at = created_at - 9 * 86400000 RETURNING created_at";
    assert!(server.count(by_hand).await > 0);
    prune(&server, &["--retain-days", "3"]);
    let second = upload().await;
    assert_ne!(second, first);
    assert_eq!(upload().await, second);
}

#[tokio::test]
async fn a_backup_holds_what_can_be_brought_back() {
    let server = Server::on_sqlite(&[]);
    let sent = sent(&server, 1000, &[]).await;
    assert_eq!(delete(&server, &sent.ride).await, 200);
    let folder = Folder::new();
    let path = |name: &str| folder.0.join(name).to_str().unwrap().to_owned();
    let output = server
        .beside(&["backup", &path("backup")])
        .output()
        .unwrap();
    said(&output);
    prune(&server, &["--grace-days", "0"]);
    assert!(!is_kept(&server, &sent));
    let data = Folder::new();
    let restored = [
        "restore",
        &path("backup"),
        "--data",
        data.0.to_str().unwrap(),
    ];
    said(&veloid(&restored));
    let server = Server::in_folder(data, &[]);
    assert!(server.json(&sent.ride).await["deleted_at"].is_string());
    assert_eq!(restore(&server, &sent.ride).await, 200);
    assert_eq!(
        server.get(&format!("{}/file", sent.ride)).await.status(),
        200
    );
}

#[tokio::test]
async fn buttons_delete_and_bring_back_but_not_from_elsewhere() {
    let server = Server::start();
    let sent = sent(&server, 1000, &[]).await;
    let page = async |path: &str| server.get(path).await.text().await.unwrap();
    let (job, ride) = (
        sent.job.trim_start_matches("/v1"),
        sent.ride.trim_start_matches("/v1"),
    );
    let button = format!("action=\"{ride}/delete\"");
    assert!(page(job).await.contains(&button));
    assert!(
        page("/bikes/lab-7")
            .await
            .contains("action=\"/bikes/lab-7/delete\"")
    );
    let press = async |path: String, site: &str| {
        let request = server.client.post(server.address(&path));
        let response = request.header("Sec-Fetch-Site", site).send().await.unwrap();
        (response.status().as_u16(), response.text().await.unwrap())
    };
    assert_eq!(press(format!("{ride}/delete"), "cross-site").await.0, 403);
    let (status, deleted) = press(format!("{ride}/delete"), "same-origin").await;
    assert!(status == 200 && deleted.contains("Bring back"), "{deleted}");
    assert!(!page("/jobs").await.contains("ride.csv"));
    let (status, jobs) = press(format!("{ride}/restore"), "same-origin").await;
    assert!(status == 200 && jobs.contains(job), "{jobs}");
    let (status, deleted) = press("/bikes/lab-7/delete".to_owned(), "same-origin").await;
    assert!(status == 200 && deleted.contains("Bring lab-7 back"));
    let (status, bike) = press("/bikes/lab-7/restore".to_owned(), "same-origin").await;
    assert!(status == 200 && bike.contains("Rides together"), "{bike}");
}
