//! SIGKILL at random moments: of a server at work, of one that starts, of uploads on their way.
//! `VELOID_KILLS` says how often, `VELOID_SEED` when.

use std::env;
use std::process::Stdio;
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::harness::Server;
use crate::oracle::{Undisturbed, Upload, jobs_are, nothing_ran_twice};

/// Kills between two looks at what has come of all uploads. A job that dies with its process four times
/// is given up, so there are fewer.
const ROUND: usize = 2;
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
async fn random_kills_lose_nothing_and_do_nothing_twice() {
    // On PostgreSQL a process has to live for a lease before it takes anything over.
    let few = env::var_os("VELOID_TEST_POSTGRES").map_or(50, |_| 6);
    let (kills, seed) = (from_env("VELOID_KILLS", few), from_env("VELOID_SEED", 1));
    let mut random = ChaCha8Rng::seed_from_u64(seed.into());
    let mut expected = Vec::new();
    for seed in 0..SEEDS {
        expected.push(upload(0, seed).undisturbed().await);
    }
    let most = expected[0].took.mul_f64(1.5);
    let begin = Instant::now();
    let mut tally = Tally::default();
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
        tally.acknowledged += u32::from(acknowledged.is_some());
        let job = upload.send_again(&server, acknowledged.as_deref()).await;
        sent.push((upload, job, seed));
        if sent.len() == ROUND || kill + 1 == kills {
            for (upload, job, seed) in sent.drain(..) {
                tally
                    .ended(&server, &upload, &job, &expected[seed as usize])
                    .await;
            }
            jobs_are(&server, i64::from(kill + 1)).await;
            let rows = server.count(TRIAL_ROWS).await;
            assert!(rows >= i64::from(TRIALS * tally.succeeded), "{rows} rows");
            nothing_ran_twice(&server).await;
        }
    }
    eprintln!(
        "{kills} kills in {:.0} s, seed {seed}: {tally:?}",
        begin.elapsed().as_secs_f64()
    );
    assert_eq!(tally.succeeded + tally.given_up, kills);
    assert!(tally.succeeded * 10 >= kills * 9, "too many were given up");
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

/// What came of the uploads.
#[derive(Debug, Default)]
struct Tally {
    /// Answered by 202 before the kill.
    acknowledged: u32,
    succeeded: u32,
    /// Failed because the process died four times while it worked on them.
    given_up: u32,
}

impl Tally {
    async fn ended(&mut self, server: &Server, upload: &Upload, job: &str, expected: &Undisturbed) {
        let view = server.finished(job).await;
        if view["state"] == "failed" {
            assert_eq!(view["failure"]["kind"], "crash", "{view:#}");
            self.given_up += 1;
        } else {
            upload.succeeded_once(server, job, expected).await;
            self.succeeded += 1;
        }
    }
}
