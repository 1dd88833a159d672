//! How far it scales: prints the table of docs/scale.md. Not for CI:
//! `VELOID_TEST_POSTGRES=... cargo test --workspace --test blackbox scale:: -- --ignored --nocapture --test-threads 1`

use std::process::{Command, Stdio};
use std::time::Duration;

use crate::harness::{Server, Worker};
use crate::measured::{self, row};
use crate::ride;

/// As little computing as there can be: what is left is the queue.
const NOTHING: [(&str, &str); 4] = [
    ("trials", "1"),
    ("particles", "2"),
    ("iterations", "1"),
    ("again", "true"),
];
const RIDES: usize = 600;
/// Diagnosed rides for two workers: the last ones keep only one of them busy.
const DIAGNOSED: usize = 24;
/// Time between two looks at what is open, each of which costs PostgreSQL a process.
const LOOK: Duration = Duration::from_secs(1);
/// Connections to PostgreSQL that a process takes at most.
const CONNECTIONS: usize = 13;

/// What one row of River does to the database, without River and without us: claimed, then completed
/// while its job is locked.
const FLOOR: &str = "\
BEGIN;
UPDATE q SET state = 'running', at = now() WHERE id = (
    SELECT id FROM q WHERE state = 'available' ORDER BY priority, id FOR UPDATE SKIP LOCKED LIMIT 1)
    RETURNING id, job \\gset
COMMIT;
BEGIN;
SELECT id FROM job WHERE id = :job FOR UPDATE;
UPDATE q SET state = 'completed', at = now() WHERE id = :id;
UPDATE trial SET result = repeat('x', 300) WHERE id = :id;
UPDATE job SET done = done + 1 WHERE id = :job;
COMMIT;
";

const FLOOR_TABLES: &str = "\
CREATE SCHEMA floor; SET search_path = floor;
CREATE TABLE job (id INT PRIMARY KEY, done INT NOT NULL);
INSERT INTO job SELECT i, 0 FROM generate_series(0, 3999) i;
CREATE TABLE q (id INT PRIMARY KEY, job INT, state TEXT, priority INT, at TIMESTAMPTZ);
INSERT INTO q SELECT i, i / 50, 'available', 2, now() FROM generate_series(0, 199999) i;
CREATE INDEX ON q (state, priority, id);
CREATE TABLE trial (id INT PRIMARY KEY, result TEXT);
INSERT INTO trial SELECT i FROM generate_series(0, 199999) i;
ANALYZE;";

/// A server without workers on PostgreSQL, or none and a word about it.
fn server() -> Option<Server> {
    if crate::built::postgres().is_none() {
        crate::skips::skip("VELOID_TEST_POSTGRES names no PostgreSQL");
        return None;
    }
    Some(Server::with(&["--workers", "0"]))
}

fn sql(server: &Server, sql: &str) -> String {
    let mut psql = Command::new("psql");
    let output = psql
        .args([server.database().unwrap(), "-qAtc", sql])
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout).unwrap().trim().to_owned()
}

async fn submit_many(server: &Server, count: usize, parts: &[(&str, &str)]) {
    for _ in 0..count {
        server.submit(parts).await;
    }
}

/// Rides of two seconds with next to nothing to compute.
async fn submit_nothing(server: &Server) {
    for _ in 0..RIDES {
        let parts = [&ride::QUICK[..], &NOTHING].concat();
        let short = ride::table(400, 200.0).into_bytes();
        let response = server.upload(short, ride::BIKE, &parts).await;
        assert_eq!(response.status(), 202);
    }
}

async fn until_done(server: &Server) {
    while sql(server, "SELECT count(*) FROM job WHERE finished_at IS NULL") != "0" {
        tokio::time::sleep(LOOK).await;
    }
}

/// Rows of River per second between the first that ended and the last, once all are done: for each ride
/// one of observe, trial and conclude.
async fn rows_per_second(server: &Server) -> f64 {
    until_done(server).await;
    let rate = "SELECT (count(*) - 1) / extract(epoch FROM max(finalized_at) - min(finalized_at)) \
                FROM river_job WHERE state = 'completed'";
    let found = sql(server, rate).parse().unwrap();
    sql(server, "DELETE FROM river_job WHERE state = 'completed'");
    found
}

/// Claims and completions per second that this PostgreSQL gives so many clients.
fn floor(server: &Server, clients: usize) -> f64 {
    let script = server.folder.write("floor.sql", FLOOR);
    sql(
        server,
        &format!("DROP SCHEMA IF EXISTS floor CASCADE; {FLOOR_TABLES}"),
    );
    let mut pgbench = Command::new("pgbench");
    pgbench.args([
        "-n",
        "-M",
        "prepared",
        "-T",
        "8",
        "-c",
        &clients.to_string(),
        "-f",
    ]);
    pgbench.arg(script).arg(server.database().unwrap());
    let output = pgbench
        .env("PGOPTIONS", "-c search_path=floor")
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let line = text.lines().find_map(|line| line.strip_prefix("tps = "));
    line.unwrap_or_else(|| panic!("{text}"))
        .split(' ')
        .next()
        .unwrap()
        .parse()
        .unwrap()
}

async fn working(server: &Server, count: usize) -> Vec<Worker> {
    let workers: Vec<_> = (0..count).map(|_| server.worker_with(4)).collect();
    while sql(server, "SELECT count(*) FROM worker") != count.to_string() {
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
    workers
}

#[tokio::test]
#[ignore = "measures"]
async fn jobs_per_second_beside_the_floor_of_the_database() {
    measured::head();
    for count in [1, 2, 4, 8] {
        let Some(server) = server() else { return };
        let room: usize = sql(&server, "SHOW max_connections").parse().unwrap();
        if room < CONNECTIONS * (count + 1) {
            eprintln!("{count} workers: not with max_connections = {room}");
            continue;
        }
        submit_nothing(&server).await;
        let workers = working(&server, count).await;
        let rate = rows_per_second(&server).await;
        drop(workers);
        let floor = floor(&server, count * 4);
        row(
            &format!("rows of River a second, {count} workers of four threads"),
            format!(
                "{rate:.0}, pgbench {floor:.0}: {:.1} times less",
                floor / rate
            ),
            "3 times less",
        );
    }
}

#[tokio::test]
#[ignore = "measures"]
async fn reads_that_last_do_not_hold_the_queue_back() {
    let Some(server) = server() else { return };
    measured::head();
    for long in [false, true, false, true] {
        submit_nothing(&server).await;
        let mut reader = long.then(|| {
            let look = "BEGIN ISOLATION LEVEL REPEATABLE READ; SELECT count(*) FROM river_job; \
                        SELECT pg_sleep(300)";
            let mut psql = Command::new("psql");
            psql.args([server.database().unwrap(), "-qAtc", look])
                .stdout(Stdio::null());
            psql.spawn().unwrap()
        });
        let workers = working(&server, 2).await;
        let rate = rows_per_second(&server).await;
        drop(workers);
        let beside = match long {
            true => "beside a transaction that stays open",
            false => "without one",
        };
        row(
            &format!("the same, 2 workers, {beside}"),
            format!("{rate:.0}"),
            "",
        );
        if let Some(reader) = &mut reader {
            reader.kill().unwrap();
            reader.wait().unwrap();
        }
        sql(&server, "DELETE FROM worker");
    }
}

#[tokio::test]
#[ignore = "measures"]
async fn an_idle_worker_picks_a_ride_up_at_once() {
    let Some(server) = server() else { return };
    measured::head();
    let _worker = working(&server, 1).await;
    for _ in 0..300 {
        let job = server
            .submit(&[("trials", "1"), ("particles", "2"), ("again", "true")])
            .await;
        server.succeeded(&job).await;
    }
    let latency = |quantile: f64| {
        let sql_text = format!(
            "SELECT percentile_disc({quantile}) WITHIN GROUP (ORDER BY started_at - created_at) FROM job"
        );
        sql(&server, &sql_text)
    };
    let [median, p99, most] = [0.5, 0.99, 1.0].map(latency);
    row(
        "an idle worker begins a ride: median, p99, most",
        format!("{median}, {p99}, {most} ms"),
        "p99 100 ms",
    );
}

#[tokio::test]
#[ignore = "measures"]
async fn two_pinned_workers_do_almost_twice_the_rides_of_one() {
    let Some(server) = server() else { return };
    measured::head();
    let parts = [
        ("trials", "10"),
        ("particles", "60"),
        ("iterations", "300"),
        ("diagnosis", "true"),
        ("again", "true"),
    ];
    let mut seconds = Vec::new();
    for cores in [&["0"][..], &["0", "1"], &["0"], &["0", "1"]] {
        submit_many(&server, DIAGNOSED, &parts).await;
        let workers: Vec<_> = cores
            .iter()
            .map(|core| server.pinned_worker(core))
            .collect();
        until_done(&server).await;
        let taken = format!(
            "SELECT (max(finished_at) - min(started_at)) / 1000.0 FROM
             (SELECT * FROM job ORDER BY created_at DESC LIMIT {DIAGNOSED}) AS last"
        );
        seconds.push(sql(&server, &taken).parse::<f64>().unwrap());
        let took = seconds[seconds.len() - 1];
        let what = format!(
            "{DIAGNOSED} diagnosed rides, {} pinned workers",
            cores.len()
        );
        row(&what, format!("{took:.1} s"), "");
        drop(workers);
        sql(&server, "DELETE FROM worker");
    }
    row(
        "two against one",
        format!(
            "{:.2} times",
            (seconds[0] + seconds[2]) / (seconds[1] + seconds[3])
        ),
        "1.8 times",
    );
}
