//! Processes: their orderly end, their limits, and several of them on the same data.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

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

/// Their senders have no answer yet, and send them again; else they would hold the process up.
#[tokio::test]
async fn uploads_that_have_not_arrived_end_when_the_server_stops() {
    let mut server = Server::start();
    let address = server.url.trim_start_matches("http://").to_owned();
    let begun = |path: &str, kind: &str, sent: &str| {
        let mut stream = TcpStream::connect(&address).unwrap();
        write!(
            stream,
            "POST {path} HTTP/1.1\r\nHost: x\r\nContent-Type: {kind}\r\nContent-Length: 1000\r\n\r\n{sent}"
        )
        .unwrap();
        stream
    };
    let form = "--B\r\nContent-Disposition: form-data; name=\"file\"\r\n\r\nt,u_f\n";
    let mut streams = [
        begun("/v1/rides", "text/csv", "t,u_f\n"),
        begun("/v1/rides/preview", "text/csv", ""),
        begun("/v1/rides", "multipart/form-data; boundary=B", form),
        begun("/", "multipart/form-data; boundary=B", "--B"),
    ];
    let folder = server.folder.0.join("incoming");
    // The three that have sent something of a file hold one each.
    while std::fs::read_dir(&folder).unwrap().count() < 3 {
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    server.ask_to_stop();
    for stream in &mut streams {
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        assert!(answer.starts_with("HTTP/1.1 503"), "{answer}");
        assert!(answer.contains("the server is stopping"), "{answer}");
    }
    assert_eq!(server.terminate(), Some(0));
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 0);
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
    if crate::built::postgres().is_some() {
        return crate::skips::not_applicable("PostgreSQL lets many processes work");
    }
    let output = server.beside(&["worker"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(
        message.contains("another veloid uses this data"),
        "{message}"
    );
}

/// A process that hangs at its start does so in one of thousands: `VELOID_STARTS=4000` looks for it.
#[test]
fn every_start_of_many_comes_to_its_end() {
    let starts = std::env::var("VELOID_STARTS").ok();
    let starts = starts.and_then(|starts| starts.parse().ok()).unwrap_or(20);
    let server = Server::with(&["--workers", "0"]);
    for start in 1..=starts {
        let output = server.beside_for_a_minute(&["migrate"]).output().unwrap();
        assert!(output.status.success(), "start {start}: {output:?}");
    }
}
