//! SIGKILL at random moments: of a server at work, of one that starts, of uploads on their way.
//! `VELOID_KILLS` says how often, `VELOID_SEED` when.

use std::env;
use std::process::Stdio;
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::harness::Server;
use crate::oracle::{Upload, jobs_are, nothing_ran_twice};

/// Kills between two looks at what has come of all uploads.
const ROUND: usize = 3;
/// Different uploads; what comes of each is known beforehand.
const SEEDS: u32 = 4;

/// Swarms so large that each of the three trials is a row of River by itself, so that a ride may be hit between two.
const ONE_A_ROW: [(&str, &str); 2] = [("iterations", "200"), ("particles", "500")];
const TRIALS: u32 = 3;
/// Rows of River are gone after an hour; what they were remains.
const TRIAL_ROWS: &str = "SELECT COUNT(DISTINCT river_id) FROM trial";

fn from_env(name: &str, otherwise: u32) -> u32 {
    env::var(name).map_or(otherwise, |text| text.parse().expect("a number"))
}

#[tokio::test]
#[ignore = "takes a minute; `.ci/long` runs it"]
async fn random_kills_lose_nothing_and_do_nothing_twice() {
    // On PostgreSQL a process has to live for a lease before it takes anything over.
    let few = crate::built::postgres().map_or(50, |_| 6);
    let (kills, seed) = (from_env("VELOID_KILLS", few), from_env("VELOID_SEED", 1));
    let mut random = ChaCha8Rng::seed_from_u64(seed.into());
    let mut expected = Vec::new();
    for seed in 0..SEEDS {
        expected.push(upload(0, seed).undisturbed().await);
    }
    let most = expected[0].took.mul_f64(1.5);
    let begin = Instant::now();
    let mut acknowledged_before = 0;
    let mut server = Server::with(&["--workers", "2"]);
    let mut sent = Vec::new();
    for kill in 0..kills {
        let seed = kill % SEEDS;
        let upload = upload(kill, seed);
        let moment = Instant::now() + most.mul_f64(random.random());
        let acknowledged = tokio::time::timeout_at(moment.into(), upload.send(&server)).await;
        let acknowledged = acknowledged.ok().flatten();
        tokio::time::sleep_until(moment.into()).await;
        server.kill();
        if random.random_bool(0.2) {
            killed_at_its_start(&server, most.mul_f64(0.3 * random.random::<f64>()));
        }
        server.restart();
        acknowledged_before += u32::from(acknowledged.is_some());
        let job = upload.send_again(&server, acknowledged.as_deref()).await;
        sent.push((upload, job, seed));
        if sent.len() == ROUND || kill + 1 == kills {
            for (upload, job, seed) in sent.drain(..) {
                let expected = &expected[seed as usize];
                upload.succeeded_once(&server, &job, expected).await;
            }
            jobs_are(&server, i64::from(kill + 1)).await;
            let rows = server.count(TRIAL_ROWS).await;
            assert!(rows >= i64::from(TRIALS * (kill + 1)), "{rows} rows");
            nothing_ran_twice(&server).await;
        }
    }
    eprintln!(
        "{kills} kills in {:.0} s, seed {seed}: all succeeded, {acknowledged_before} of them acknowledged before",
        begin.elapsed().as_secs_f64()
    );
}

fn upload(key: u32, seed: u32) -> Upload {
    let seed = seed.to_string();
    let parts = [("seed", seed.as_str()), ("again", "true")];
    Upload::new(key, &[&parts[..], &ONE_A_ROW].concat())
}

/// A process that is killed while it starts: it migrates, or takes over from the one before.
fn killed_at_its_start(server: &Server, after: Duration) {
    let mut command = server.beside(&["serve", "--listen", "127.0.0.1:0", "--workers", "2"]);
    let mut child = command
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(after);
    child.kill().unwrap();
    child.wait().unwrap();
}

/// Processes that are killed as soon as they have done anything, with many rides waiting or at work: none
/// is to blame for it.
#[tokio::test]
#[ignore = "takes a minute; `.ci/long` runs it"]
async fn quick_kills_fail_no_ride() {
    const DONE: &str = "SELECT COUNT(*) FROM river_job WHERE state = 'completed'";
    const LEFT: &str = "SELECT COUNT(*) FROM job WHERE finished_at IS NULL";
    const LOSSES: &str = "SELECT CAST(SUM(takeovers) AS BIGINT) FROM job";
    let few = crate::built::postgres().map_or(16, |_| 3);
    let kills = from_env("VELOID_QUICK_KILLS", few);
    // Swarms large enough that a kill finds most of what was fetched still to be done.
    let upload = |key: u32, seed: u32| {
        let seed = seed.to_string();
        let large = [
            ("iterations", "2000"),
            ("particles", "100"),
            ("again", "true"),
        ];
        Upload::new(key, &[&large[..], &[("seed", &seed)]].concat())
    };
    let expected = [
        upload(0, 0).undisturbed().await,
        upload(0, 1).undisturbed().await,
    ];
    let mut server = Server::with(&["--workers", "2"]);
    let mut sent = Vec::new();
    for key in 0..24 {
        let upload = upload(key, key % 2);
        let job = upload.send(&server).await.unwrap();
        sent.push((upload, job, &expected[(key % 2) as usize]));
    }
    let mut killed = 0;
    while killed < kills && server.count(LEFT).await > 0 {
        let done = server.count(DONE).await;
        while server.count(DONE).await == done && server.count(LEFT).await > 0 {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        server.crash_and_restart();
        killed += 1;
    }
    for (upload, job, expected) in &sent {
        upload.succeeded_once(&server, job, expected).await;
    }
    let losses = server.count(LOSSES).await;
    eprintln!("{killed} quick kills, {losses} times a job lost the process that had its work");
    assert!(
        losses > i64::from(killed) / 2,
        "the kills found nothing at work"
    );
    jobs_are(&server, 24).await;
    nothing_ran_twice(&server).await;
}

/// Kills from outside that come faster than a stage ends are not held against a job that computes in a child process.
#[tokio::test]
async fn kills_from_outside_fail_no_job_that_computes_in_a_child() {
    const RUNNING: &str =
        "SELECT COUNT(*) FROM river_job WHERE kind = 'trial' AND state = 'running'";
    const FAILED: &str = "SELECT COUNT(*) FROM job WHERE state = 'failed'";
    let mut server = Server::on_sqlite(&["--workers", "1"]);
    let long = [
        ("trials", "1"),
        ("particles", "100"),
        ("iterations", "5000"),
    ];
    let job = server.submit(&long).await;
    for kill in 0..8 {
        while server.count(RUNNING).await == 0 {
            assert_eq!(server.count(FAILED).await, 0, "after {kill} kills");
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
        // It begins to compute.
        tokio::time::sleep(Duration::from_millis(150)).await;
        server.crash_and_restart();
    }
    server.succeeded(&job).await;
}
