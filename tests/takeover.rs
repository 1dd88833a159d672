//! Workers on PostgreSQL that stand still or die in the middle of a trial: another one takes over, and
//! what comes late is refused.

use std::net::TcpListener;
use std::time::{Duration, Instant};

use crate::harness::{Server, Worker};
use crate::oracle::{Upload, jobs_are, nothing_ran_twice};
use crate::skips::not_applicable;

/// Swarms of some seconds each.
const SECONDS: [(&str, &str); 3] = [("trials", "6"), ("iterations", "5000"), ("particles", "60")];

const WORKING: &str = "SELECT COUNT(DISTINCT attempted_by[array_upper(attempted_by, 1)]) \
                       FROM river_job WHERE kind = 'trial' AND state = 'running'";
const TAKEOVERS: &str = "SELECT CAST(SUM(takeovers) AS BIGINT) FROM job";

async fn until(what: &str, mut holds: impl AsyncFnMut() -> bool) {
    for _ in 0..1200 {
        if holds().await {
            return;
        }
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    panic!("in vain: {what}");
}

async fn becomes(server: &Server, sql: &'static str, least: i64) {
    until(sql, async || server.count(sql).await >= least).await;
}

/// The time until another worker takes over from one that is hit now.
async fn taken_over(server: &Server, hit: impl FnOnce()) -> f64 {
    let before = server.count(TAKEOVERS).await;
    hit();
    let begin = Instant::now();
    becomes(server, TAKEOVERS, before + 1).await;
    begin.elapsed().as_secs_f64()
}

/// A worker that stands still with the result of its second stage in hand, its first trials, and where
/// it answers.
fn stopping(server: &Server) -> (Worker, String) {
    let free = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = free.local_addr().unwrap().to_string();
    drop(free);
    let stop = ("VELOID_STOP_AT", "before_result:2");
    (
        server.worker_with_env(&["--listen", &address], &[stop]),
        format!("http://{address}/metrics"),
    )
}

/// `VELOID_TEST_OLD` names an older build: its server and then its workers are replaced while rides are
/// computed.
#[tokio::test]
async fn rides_outlive_a_change_of_version() {
    let Ok(old) = std::env::var("VELOID_TEST_OLD") else {
        return not_applicable("VELOID_TEST_OLD names no older build");
    };
    // On SQLite one process works, so that the server's own threads have to.
    let threads = if crate::built::postgres().is_some() {
        "0"
    } else {
        "2"
    };
    let mut server = Server::of_build(&old, &["--workers", threads]);
    let worker = |server: &Server| server.database().map(|_| server.worker(&[]));
    let workers = [worker(&server), worker(&server)];
    let mut jobs = Vec::new();
    for key in 0..6 {
        let seed = key.to_string();
        let parts = [&SECONDS[..], &[("seed", &seed)]].concat();
        jobs.push(Upload::new(key, &parts).send(&server).await.unwrap());
    }
    let begun = "SELECT COUNT(*) FROM trial WHERE result IS NOT NULL";
    becomes(&server, begun, 3).await;
    server.becomes_new();
    let mut new = Vec::new();
    for old in workers.into_iter().flatten() {
        new.push(worker(&server));
        becomes(&server, "SELECT COUNT(*) FROM worker", 2).await;
        old.send("-TERM");
        becomes(&server, begun, server.count(begun).await + 3).await;
    }
    for job in &jobs {
        server.succeeded(job).await;
    }
    jobs_are(&server, 6).await;
    nothing_ran_twice(&server).await;
    assert_eq!(server.count(TAKEOVERS).await, 0, "all left in order");
}

#[tokio::test]
async fn a_worker_that_stands_still_or_dies_loses_its_work_to_another() {
    let server = Server::with(&["--workers", "0"]);
    if server.database().is_none() {
        return not_applicable("on SQLite one process works");
    }
    let upload = Upload::new("still", &SECONDS);
    let expected = upload.undisturbed().await;
    let (still, metrics) = stopping(&server);
    let job = upload.send(&server).await.unwrap();
    becomes(&server, WORKING, 1).await;
    let _other = server.worker(&[]);
    becomes(&server, TAKEOVERS, 1).await;
    upload.succeeded_once(&server, &job, &expected).await;
    still.send("-CONT");
    until("its late result is refused", async || {
        let response = server.client.get(&metrics).send().await.unwrap();
        let text = response.text().await.unwrap();
        text.contains("veloid_stale_completions_total 1")
    })
    .await;
    upload.succeeded_once(&server, &job, &expected).await;
    becomes(&server, "SELECT COUNT(*) FROM worker", 2).await;

    let upload = Upload::new("dead", &[&SECONDS[..], &[("again", "true")]].concat());
    let job = upload.send(&server).await.unwrap();
    becomes(&server, WORKING, 2).await;
    let after = taken_over(&server, || still.send("-KILL")).await;
    eprintln!("taken over {after:.1} s after SIGKILL");
    upload.succeeded_once(&server, &job, &expected).await;
    jobs_are(&server, 2).await;
    nothing_ran_twice(&server).await;
}
