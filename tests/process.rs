//! Processes: their orderly end, their limits, and several of them on the same data.

use std::time::Instant;

use crate::harness::Server;
use crate::ride::{self, LONG};

#[tokio::test]
async fn a_stopped_server_hands_its_work_back_and_takes_it_up_again() {
    let mut server = Server::with(&["--workers", "1"]);
    // No machine ends a trial of this within the time that a stop allows.
    let endless = [
        ("trials", "1"),
        ("iterations", "10000"),
        ("particles", "200"),
        ("objective", "gradient"),
    ];
    let long = ride::table(60_000, 200.0).into_bytes();
    let parts = [&ride::QUICK[..], &endless].concat();
    let response = server.upload(long, ride::BIKE, &parts).await;
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    while server.json(&job).await["stage"] != "trial" {}
    let asked = Instant::now();
    server.ask_to_stop();
    while server
        .client
        .get(server.address("/healthz"))
        .send()
        .await
        .is_ok()
    {}
    assert!(server.is_there(), "it takes nothing on while its work ends");
    assert_eq!(server.terminate(), Some(0));
    eprintln!(
        "stopped {:.1} s after SIGTERM",
        asked.elapsed().as_secs_f64()
    );
    let begun = "SELECT COUNT(*) FROM river_job WHERE kind = 'trial' AND (attempt > 0 OR state <> 'available')";
    assert_eq!(server.count(begun).await, 0, "no attempt is burnt");
    server.restart();
    let view = server.json(&job).await;
    assert_eq!(view["state"], "running");
    assert_eq!(view["stage"], "trial");
    server.cancel(&job).await.unwrap();
    let short = server.submit(&[("seed", "2")]).await;
    server.succeeded(&short).await;
    let metrics = server.get("/metrics").await.text().await.unwrap();
    assert!(
        !metrics.contains("veloid_job_rescues_total"),
        "nothing was taken over"
    );
}

#[tokio::test]
async fn a_stage_that_takes_too_long_fails_its_job_and_frees_its_core() {
    let server = Server::with(&["--workers", "1", "--stage-timeout", "1"]);
    let job = server.submit(&LONG).await;
    let view = server.finished(&job).await;
    assert_eq!(view["state"], "failed");
    assert_eq!(view["failure"]["kind"], "deadline", "{view:#}");
    let short = server.submit(&[]).await;
    server.succeeded(&short).await;
}

#[tokio::test]
async fn a_worker_beside_the_server_does_the_work() {
    let server = Server::with(&["--workers", "0"]);
    let job = server.submit(&[]).await;
    assert_eq!(server.json(&job).await["state"], "queued");
    let _worker = server.worker(&[]);
    let view = server.succeeded(&job).await;
    assert_eq!(view["trials"]["done"], 3);
}

#[tokio::test]
async fn on_sqlite_only_one_process_works() {
    let server = Server::start();
    if std::env::var_os("VELOID_TEST_POSTGRES").is_some() {
        return crate::skips::not_applicable("PostgreSQL lets many processes work");
    }
    let output = server.beside(&["worker"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(message.contains("another veloid works"), "{message}");
}
