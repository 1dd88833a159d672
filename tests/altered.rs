//! Rows that were altered or lost without anyone's doing: `veloid check` names them, and a report that cannot be read is a
//! problem at its own address alone.

use std::fs;
use std::path::Path;
use std::time::Duration;

use serde_json::{Value, json};
use sqlx::sqlite::SqliteConnectOptions;
use sqlx::{ConnectOptions, Connection, SqliteConnection};

use crate::built::is_built_with;
use crate::harness::{Folder, Server, form, key_of, veloid};
use crate::ride::{self, LONG};
use crate::several;

/// The data folder of a server that was killed: every table that anything is kept in for long has a row.
struct Data {
    folder: Folder,
}

impl Data {
    /// A job that succeeded, one whose trials are under way, and one of three files that waits.
    async fn new() -> Self {
        let webhooks: &[&str] = match is_built_with("webhooks") {
            true => &["--webhook-allow", "127.0.0.1", "--webhook-private"],
            false => &[],
        };
        let mut server = Server::on_sqlite(&[&["--workers", "1"], webhooks].concat());
        let mut create = server.beside(&["key", "create", "--scope", "admin"]);
        let key = key_of(&create.output().unwrap());
        server.kill();
        server.restart_with_env(&[("VELOID_KEYS", "true")]);
        server.as_seen_by(&key);
        let parts = [&ride::QUICK[..], &[("tags", "wet")]].concat();
        let request = server.client.post(server.address("/v1/rides"));
        let request = request.header("Idempotency-Key", "once");
        let sent = request.multipart(form(ride::example(), ride::BIKE, &parts));
        let sent = sent.send().await.unwrap();
        assert_eq!(sent.status(), 202);
        server
            .succeeded(sent.headers()["location"].to_str().unwrap())
            .await;
        let webhook = json!({"url": "http://127.0.0.1:9/", "events": ["job.failed"]});
        let event = json!({"date": "2026-05-01", "text": "new tyre"});
        let mut created = vec![("/v1/bikes/lab-7/events", event)];
        if is_built_with("webhooks") {
            created.push(("/v1/webhooks", webhook));
        }
        for (path, body) in created {
            let request = server.client.post(server.address(path)).json(&body);
            assert_eq!(request.send().await.unwrap().status(), 201, "{path}");
        }
        let long = server.submit(&LONG).await;
        while server.json(&long).await["stage"] != "trial" {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
        server.kill();
        let folder = std::mem::replace(&mut server.folder, Folder::new());
        // Nothing begins what comes now.
        let mut server = Server::in_folder(folder, &["--workers", "0"]);
        let files = Folder::new();
        several::simulated(&files, "0", "0", "1");
        let form = several::form(&files, &several::NAMES);
        let sent = several::send(&server, "/v1/rides", form).await;
        assert_eq!(sent.status(), 202);
        server.kill();
        let folder = std::mem::replace(&mut server.folder, Folder::new());
        let mut database = open(&folder).await;
        let checkpoint = sqlx::query("PRAGMA wal_checkpoint(TRUNCATE)");
        checkpoint.execute(&mut database).await.unwrap();
        database.close().await.unwrap();
        Self { folder }
    }

    fn copy(&self) -> Folder {
        let copy = Folder::new();
        for (from, to) in [
            (&self.folder.0, &copy.0),
            (&self.folder.0.join("rides"), &copy.0.join("rides")),
        ] {
            fs::create_dir_all(to).unwrap();
            for entry in fs::read_dir(from).unwrap() {
                let path = entry.unwrap().path();
                if path.is_file() {
                    fs::copy(&path, to.join(path.file_name().unwrap())).unwrap();
                }
            }
        }
        copy
    }

    /// What `veloid check` says once a statement was run on a copy.
    async fn check_after(&self, sql: &'static str) -> (i32, String) {
        let copy = self.copy();
        let mut database = open(&copy).await;
        let done = sqlx::query(sql).execute(&mut database).await.unwrap();
        assert!(done.rows_affected() > 0, "{sql}");
        database.close().await.unwrap();
        check(&copy)
    }
}

pub async fn open(folder: &Folder) -> SqliteConnection {
    let options = SqliteConnectOptions::new().filename(folder.0.join("veloid.db"));
    options.foreign_keys(false).connect().await.unwrap()
}

fn check(folder: &Folder) -> (i32, String) {
    let output = veloid(&["check", "--data", folder.0.to_str().unwrap()]);
    let text = [output.stdout, output.stderr].concat();
    (
        output.status.code().unwrap(),
        String::from_utf8(text).unwrap(),
    )
}

/// Statements that alter a value, and what is said of it.
const ALTERED: [(&str, &str); 31] = [
    (
        "UPDATE result SET document = replace(document, '0.1.0', '0.1.1') WHERE name = 'report'",
        "the stored report was altered",
    ),
    (
        "UPDATE result SET document = substr(document, 2) WHERE name = 'report'",
        "the stored report was altered",
    ),
    (
        "UPDATE result SET document = CAST(x'ff' || CAST(document AS BLOB) AS TEXT) WHERE name = 'report'",
        "the stored report was altered",
    ),
    (
        "UPDATE result SET document = substr(document, 2), sha256 = NULL WHERE name = 'report'",
        "the stored report is malformed",
    ),
    (
        "UPDATE result SET sha256 = '~' || substr(sha256, 2) WHERE name = 'report'",
        "the stored report was altered",
    ),
    (
        "UPDATE result SET document = replace(document, '1', '2') WHERE name = 'observed'",
        "the stored observed was altered",
    ),
    (
        "UPDATE trial SET seed = seed + 1 WHERE trial_index = 1 AND result IS NOT NULL",
        "trial 1 has another seed",
    ),
    (
        "UPDATE trial SET result = replace(result, '\"best_cost\":[', '\"best_cost\":[1') WHERE trial_index = 2",
        "trial 2 and its report's differ",
    ),
    (
        "UPDATE trial SET result = substr(result, 2) WHERE result IS NOT NULL",
        "a trial: ",
    ),
    (
        "UPDATE parameter SET value = value + 1 WHERE method = 'result' AND axle = 'front' AND name = 'k_n_m'",
        "parameter front k_n_m by result is ",
    ),
    (
        "UPDATE parameter SET std_error = 2 * std_error WHERE method = 'result' AND axle = 'rear' AND name = 'b_n_s_m'",
        "parameter rear b_n_s_m by result is ",
    ),
    (
        "UPDATE parameter SET unit = 'N/n' WHERE unit = 'N/m'",
        "parameter front k_n_m by swarm is ",
    ),
    (
        "UPDATE parameter SET version = '0.1.1'",
        "is kept for another bike, group, verdict or version",
    ),
    (
        "UPDATE parameter SET bike = 'lab-8'",
        "is kept for another bike",
    ),
    (
        "UPDATE job SET request = replace(request, '23.0', '28.0') WHERE state = 'succeeded'",
        "its bike file and its report's differ",
    ),
    (
        "UPDATE job SET request = replace(request, '\"iterations\":8', '\"iterations\":9') WHERE state = 'succeeded'",
        "its settings and its report's differ",
    ),
    (
        "UPDATE job SET request = substr(request, 2) WHERE state = 'queued'",
        "request",
    ),
    (
        "UPDATE job SET least_squares = '{' WHERE state = 'succeeded'",
        "least_squares",
    ),
    (
        "UPDATE job SET summary = replace(summary, '4000', '4001') WHERE state = 'succeeded'",
        "its ride summary and its report's differ",
    ),
    (
        "UPDATE job SET verdict = 'named' WHERE state = 'succeeded'",
        "its verdict and its report's differ",
    ),
    (
        "UPDATE job SET trials_total = 4 WHERE state = 'succeeded'",
        "3 trials were asked for, it states 4",
    ),
    (
        "UPDATE job SET trials_done = 2 WHERE state = 'succeeded'",
        "3 trials have a result, 2 were counted",
    ),
    (
        "UPDATE job SET stage = 'observe' WHERE state = 'succeeded'",
        "3 of 0 trials are there",
    ),
    (
        "UPDATE job SET river_id = NULL WHERE state = 'queued'",
        "the queue has no work of it",
    ),
    (
        "UPDATE job SET bike = 'lab-8' WHERE state = 'succeeded'",
        "missing row of bike",
    ),
    (
        "UPDATE ride SET sha256 = '~' || substr(sha256, 2) WHERE name = 'ride.csv'",
        "its ride is another one",
    ),
    (
        "UPDATE ride SET facts = '{' WHERE facts IS NOT NULL",
        "facts",
    ),
    (
        "UPDATE ride_file SET bytes = bytes + 1 WHERE number = 0",
        "its files are not those",
    ),
    (
        "UPDATE ride_tag SET tag = 'wed'",
        "its tags are not those of its facts",
    ),
    (
        "UPDATE bike SET document = substr(document, 2)",
        "bike lab-7 of group default: ",
    ),
    (
        "UPDATE idempotency_key SET fingerprint = 'f'",
        "idempotency key once",
    ),
];

#[tokio::test]
async fn altered_values_are_named() {
    let data = Data::new().await;
    let (status, said) = check(&data.copy());
    assert_eq!((status, said.as_str()), (0, "no problems found\n"));
    for (sql, expected) in ALTERED {
        let (status, said) = data.check_after(sql).await;
        assert!(
            status > 0 && said.contains(expected),
            "{sql}: {status} {said}"
        );
    }
}

/// Statements that take rows away, and what is said of it.
const LOST: [(&str, &str); 16] = [
    (
        "DELETE FROM job WHERE state = 'succeeded'",
        "missing row of job",
    ),
    ("DELETE FROM job WHERE state = 'queued'", "it has no job"),
    (
        "DELETE FROM ride WHERE name = 'ride.csv'",
        "missing row of ride",
    ),
    ("DELETE FROM bike", "missing row of bike"),
    (
        "DELETE FROM trial WHERE trial_index = 1 AND result IS NOT NULL",
        "2 of 3 trials are there",
    ),
    (
        "DELETE FROM trial WHERE result IS NULL AND trial_index = 0",
        "2 of 3 trials are there",
    ),
    (
        "DELETE FROM result WHERE name = 'report'",
        "it succeeded and has no report",
    ),
    (
        "DELETE FROM result WHERE name = 'observed'",
        "`observed` of an earlier stage is missing",
    ),
    (
        "DELETE FROM parameter WHERE method = 'swarm' AND axle = 'rear' AND name = 'k_n_m'",
        "parameter rear k_n_m by swarm is missing",
    ),
    (
        "DELETE FROM ride_file WHERE number = 1",
        "its files are not those",
    ),
    ("DELETE FROM ride_file", "is missing"),
    (
        "DELETE FROM ride_tag",
        "its tags are not those of its facts",
    ),
    ("DELETE FROM api_key", "missing row of api_key"),
    ("DELETE FROM webhook", "webhook "),
    ("DELETE FROM bike_event", "event "),
    (
        "DELETE FROM river_job WHERE kind = 'observe' AND state = 'available'",
        "the queue has no work of it",
    ),
];

#[tokio::test]
async fn lost_rows_are_named() {
    let data = Data::new().await;
    let without = |sql: &str| sql.contains("webhook") && !is_built_with("webhooks");
    for (sql, expected) in LOST.into_iter().filter(|(sql, _)| !without(sql)) {
        let (status, said) = data.check_after(sql).await;
        assert!(
            status > 0 && said.contains(expected),
            "{sql}: {status} {said}"
        );
    }
}

/// A row that is gone from its page, whichever table it is of, is missing from where the file has it.
#[tokio::test]
async fn rows_that_are_gone_from_their_page_are_named() {
    let data = Data::new().await;
    let mut database = open(&data.folder).await;
    let tables: Vec<(String, i64)> =
        sqlx::query_as("SELECT name, rootpage FROM sqlite_schema WHERE type = 'table'")
            .fetch_all(&mut database)
            .await
            .unwrap();
    database.close().await.unwrap();
    let mut damaged = 0;
    for (table, root) in tables {
        let copy = data.copy();
        if !lose_a_cell(&copy.0.join("veloid.db"), root as usize) {
            continue;
        }
        damaged += 1;
        let (status, said) = check(&copy);
        assert!(
            status > 0 && said.contains("atabase"),
            "{table}: {status} {said}"
        );
    }
    assert!(damaged > 14, "{damaged} tables had rows");
}

/// Takes the last row off the first leaf of a table, as the SQLite file format has it; false where it has none.
fn lose_a_cell(database: &Path, root: usize) -> bool {
    let mut bytes = fs::read(database).unwrap();
    let number = |bytes: &[u8], at: usize, length: usize| {
        let digits = bytes[at..][..length].iter();
        digits.fold(0, |sum, byte| (sum << 8) | usize::from(*byte))
    };
    let mut page = root;
    loop {
        let begin = 4096 * (page - 1);
        let head = begin + if page == 1 { 100 } else { 0 };
        if [0x0a, 0x0d].contains(&bytes[head]) {
            let cells = number(&bytes, head + 3, 2);
            if cells == 0 {
                return false;
            }
            bytes[head + 3..][..2].copy_from_slice(&(cells as u16 - 1).to_be_bytes());
            fs::write(database, &bytes).unwrap();
            return true;
        }
        let cell = begin + number(&bytes, head + 12, 2);
        page = number(&bytes, cell, 4);
    }
}

/// Ways in which a report is altered; the last one is as earlier versions stored it.
const UNREADABLE: [&str; 4] = [
    "UPDATE result SET document = replace(document, '0.1.0', '0.1.1') WHERE job_id = (SELECT MIN(id) FROM job)",
    "UPDATE result SET document = substr(document, 2) WHERE job_id = (SELECT MIN(id) FROM job)",
    "UPDATE result SET document = CAST(x'ff' || CAST(document AS BLOB) AS TEXT) WHERE job_id = (SELECT MIN(id) FROM job)",
    "UPDATE result SET sha256 = NULL WHERE job_id = (SELECT MIN(id) FROM job)",
];

#[tokio::test]
async fn a_report_that_cannot_be_read_is_a_problem_at_its_own_address_alone() {
    let server = Server::on_sqlite(&["--workers", "1"]);
    let mut jobs = Vec::new();
    for seed in ["1", "2"] {
        let job = server.submit(&[("seed", seed)]).await;
        server.succeeded(&job).await;
        jobs.push(job);
    }
    let [lost, other] = [&jobs[0], &jobs[1]].map(|job| job.rsplit('/').next().unwrap());
    let view = server.json(&jobs[0]).await;
    let ride = view["ride"]["id"].as_str().unwrap();
    let whole = [
        format!("/v1/jobs/{lost}"),
        format!("/v1/jobs/{lost}/trials"),
        format!("/v1/jobs/{other}/report"),
        format!("/v1/jobs/{other}/model"),
        format!("/v1/jobs/{other}/series"),
        format!("/v1/rides/{ride}"),
        format!("/v1/parameters?job={lost}"),
        format!("/jobs/{lost}"),
        format!("/jobs/{other}"),
        format!("/compare?job={lost}&job={other}"),
    ];
    let lists = [
        "/v1/jobs",
        "/v1/parameters",
        "/v1/parameters?format=csv",
        "/v1/fleet",
        "/v1/bikes",
        "/v1/bikes/lab-7",
        "/v1/bikes/lab-7/course",
        "/v1/bikes/lab-7/history",
        "/",
        "/jobs",
        "/jobs.atom",
        "/bikes",
        "/bikes/lab-7",
        "/parameters",
        "/metrics",
        "/readyz",
    ];
    for sql in UNREADABLE {
        server.execute(sql).await;
        for path in ["report", "model", "series"] {
            let path = format!("/v1/jobs/{lost}/{path}");
            let response = server.get(&path).await;
            assert_eq!(response.status(), 500, "{path} after {sql}");
            let problem: Value = response.json().await.unwrap();
            assert_eq!(
                problem["type"], "urn:veloid:problem:report-unreadable",
                "{path}: {problem}"
            );
            let detail = problem["detail"].as_str().unwrap();
            assert!(detail.starts_with("the stored report "), "{path}: {detail}");
        }
        for path in whole.iter().map(String::as_str).chain(lists) {
            assert_eq!(server.get(path).await.status(), 200, "{path} after {sql}");
        }
        for path in [
            format!("/jobs/{lost}"),
            format!("/compare?job={lost}&job={other}"),
        ] {
            let page = server.get(&path).await.text().await.unwrap();
            assert!(page.contains("report cannot be read"), "{path}: {page}");
        }
        let (status, said) = check(&server.folder);
        assert!(
            status == 1 && said.contains(&format!("job {lost}: the stored report")),
            "{status} {said}"
        );
    }
}
