//! The process dies at every labelled point of `server/crash.rs`, and is started anew on the same
//! data: what was acknowledged ends once and well, and nothing ran twice.

use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use futures_util::StreamExt;
use futures_util::stream::iter;

use crate::harness::{Server, has_points};
use crate::oracle::{Undisturbed, Upload, jobs_are, nothing_is_left, nothing_ran_twice};
use crate::ride::LONG;

/// Swarms so large that a row of River holds two of them.
const TWO_A_ROW: [(&str, &str); 2] = [("iterations", "200"), ("particles", "200")];

/// Points that an upload or a stage passes, with the passages at which the process dies. A job of three
/// trials, two to a row, computes and publishes four times: observe, two rows of trials, conclude.
const IN_PASSING: [(&str, &[u32]); 9] = [
    // The file lies in its place; the database knows nothing of it.
    ("after_file", &[1]),
    // The same, with a transaction that ends with the process.
    ("before_commit", &[1]),
    // The job is queued; whoever sent it has heard nothing.
    ("after_commit", &[1]),
    // The job is `running`, its River row too; nothing is computed.
    ("in_observe", &[1]),
    // A stage has leave to compute.
    ("computing", &[1, 3, 4]),
    // A swarm is under way.
    ("in_trial", &[1, 450]),
    // A stage has its result in memory.
    ("before_result", &[1, 2, 3, 4]),
    // The River row is completed and the result is not stored, in one open transaction.
    ("between_completion_and_result", &[1, 2, 3, 4]),
    // The result is stored and what comes next is queued, or the job is at its end.
    ("after_result", &[1, 2, 3, 4]),
];

/// The same points once more, in a diagnosis.
const IN_DIAGNOSIS: [&str; 4] = [
    "computing:5",
    "before_result:5",
    "between_completion_and_result:5",
    "after_result:5",
];

/// Points that only a diagnosis, a cancel, a second start, a stop, a failure or a deletion passes; a test for each
/// is below, or where it says.
const APART: [&str; 11] = [
    "in_diagnose",
    "in_end",
    "after_cancel",
    "in_retry",
    "in_takeover",
    "in_stop",
    // tests/deletion.rs
    "in_delete",
    "after_delete",
    "in_erase",
    "after_erase",
    "in_removal",
];

#[test]
fn every_point_has_its_death() {
    let mut found = Vec::new();
    labels(Path::new(env!("CARGO_MANIFEST_DIR")), &mut found);
    let mut tested: Vec<String> = IN_PASSING
        .iter()
        .map(|(label, _)| (*label).to_owned())
        .collect();
    tested.extend(APART.map(str::to_owned));
    found.sort();
    tested.sort();
    assert_eq!(found, tested);
}

/// The labels in the sources below a folder.
fn labels(folder: &Path, found: &mut Vec<String>) {
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            labels(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = std::fs::read_to_string(&path).unwrap();
            let calls = text.split("crash::point(\"").skip(1);
            found.extend(calls.map(|rest| rest.split('"').next().unwrap().to_owned()));
        }
    }
}

/// A server that dies where it is told to.
fn doomed(args: &[&str], point: &str) -> Option<Server> {
    if !has_points() {
        return None;
    }
    Some(Server::with_env(args, &[("VELOID_CRASH_AT", point)]))
}

/// Servers at a time: on PostgreSQL most of a case is waiting for the lease to end, but each takes up to
/// 13 of its 100 connections.
fn at_a_time() -> usize {
    match crate::built::postgres() {
        Some(_) => 5,
        None => 3,
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn an_upload_survives_a_death_at_every_point_on_its_way() {
    let passages = |(label, passages): &'static (&str, &[u32])| {
        passages.iter().map(move |n| format!("{label}:{n}"))
    };
    let points = IN_PASSING.iter().flat_map(passages).collect();
    die_at(points, &Upload::new("key", &TWO_A_ROW)).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_diagnosis_survives_a_death_at_every_point_on_its_way() {
    let upload = Upload::new("key", &[&TWO_A_ROW[..], &[("diagnosis", "true")]].concat());
    die_at(IN_DIAGNOSIS.map(str::to_owned).into(), &upload).await;
}

async fn die_at(points: Vec<String>, upload: &Upload) {
    let expected = &upload.undisturbed().await;
    let deaths = iter(points).map(|point| dies_in_passing(point, upload, expected));
    deaths.buffer_unordered(at_a_time()).collect::<()>().await;
}

async fn dies_in_passing(point: String, upload: &Upload, expected: &Undisturbed) {
    let Some(mut server) = doomed(&["--workers", "1"], &point) else {
        return;
    };
    let acknowledged = upload.send(&server).await;
    server.dies().await;
    server.restart_with_env(&[]);
    eprintln!("died {point}");
    let job = upload.send_again(&server, acknowledged.as_deref()).await;
    upload.succeeded_once(&server, &job, expected).await;
    jobs_are(&server, 1).await;
    nothing_ran_twice(&server).await;
}

/// What was sent, and is sent again where nobody heard the answer, succeeds once.
async fn ends_well(server: &Server, upload: &Upload, acknowledged: Option<&str>) {
    let job = upload.send_again(server, acknowledged).await;
    let expected = upload.undisturbed().await;
    upload.succeeded_once(server, &job, &expected).await;
    nothing_ran_twice(server).await;
}

/// In the transaction of a cancel: it is undone, and asked for again. After it: it holds.
#[tokio::test]
async fn a_cancel_holds_once_it_is_committed() {
    for (point, state) in [("in_end", "running"), ("after_cancel", "cancelled")] {
        let Some(mut server) = doomed(&["--workers", "1"], point) else {
            return;
        };
        let upload = Upload::new("key", &LONG);
        let job = upload.send(&server).await.unwrap();
        while server.json(&job).await["stage"] != "trial" {}
        assert!(
            server.cancel(&job).await.is_err(),
            "it dies before it answers"
        );
        server.dies().await;
        server.restart_with_env(&[]);
        assert_eq!(server.json(&job).await["state"], state, "{point}");
        assert_eq!(server.cancel(&job).await.unwrap().status(), 200);
        upload.cancelled_once(&server, &job).await;
        nothing_is_left(&server).await;
    }
}

/// In the transaction that gives a job up because its computation broke down: it is undone.
#[tokio::test]
async fn a_failure_holds_once_it_is_committed() {
    let here = ["--workers", "1", "--isolate", "off"];
    let Some(mut server) = doomed(&here, "in_end") else {
        return;
    };
    server.kill();
    server.restart_with_env(&[
        ("VELOID_CRASH_AT", "in_end"),
        ("VELOID_PANIC_AT", "computing"),
    ]);
    let upload = Upload::new("key", &[]);
    let acknowledged = upload.send(&server).await;
    server.dies().await;
    server.restart_with_env(&[]);
    ends_well(&server, &upload, acknowledged.as_deref()).await;
}

/// In the transaction that begins a cancelled job anew: it stays cancelled until that is asked again.
#[tokio::test]
async fn a_job_is_begun_anew_as_a_whole() {
    let Some(mut server) = doomed(&["--workers", "1"], "in_retry") else {
        return;
    };
    let upload = Upload::new("key", &[("iterations", "500")]);
    let job = upload.send(&server).await.unwrap();
    server.cancel(&job).await.unwrap();
    let again = |server: &Server| {
        server
            .client
            .post(server.address(&format!("{job}/retry")))
            .send()
    };
    assert!(again(&server).await.is_err(), "it dies before it answers");
    server.dies().await;
    server.restart_with_env(&[]);
    upload.cancelled_once(&server, &job).await;
    assert_eq!(again(&server).await.unwrap().status(), 202);
    upload
        .succeeded_once(&server, &job, &upload.undisturbed().await)
        .await;
    nothing_is_left(&server).await;
}

/// In the transaction that takes work over: it is undone, and the next process takes it over.
#[tokio::test]
async fn who_takes_over_may_die_of_it() {
    let Some(mut server) = doomed(&["--workers", "1"], "in_trial:9") else {
        return;
    };
    let upload = Upload::new("key", &[]);
    let acknowledged = upload.send(&server).await;
    server.dies().await;
    let mut heir = server.beside(&["serve", "--listen", "127.0.0.1:0", "--workers", "1"]);
    heir.env("VELOID_CRASH_AT", "in_takeover")
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let died = tokio::task::spawn_blocking(move || heir.status().unwrap())
        .await
        .unwrap();
    assert!(died.signal().is_some(), "{died}");
    server.restart_with_env(&[]);
    ends_well(&server, &upload, acknowledged.as_deref()).await;
}

/// Asked to stop, it has handed its work back, and dies before it has said that it leaves.
#[tokio::test]
async fn who_stops_may_die_of_it() {
    let Some(mut server) = doomed(&["--workers", "1"], "in_stop") else {
        return;
    };
    let upload = Upload::new("key", &[]);
    let job = upload.send(&server).await.unwrap();
    assert_eq!(server.terminate(), None, "killed by a signal");
    server.restart_with_env(&[]);
    ends_well(&server, &upload, Some(&job)).await;
}

/// Whether another process on the same data dies too, before a job is given up.
async fn dies_again(server: &Server) -> bool {
    let mut heir = server.beside(&["serve", "--listen", "127.0.0.1:0", "--workers", "2"]);
    heir.stdout(Stdio::null()).stderr(Stdio::null());
    let mut heir = heir.spawn().unwrap();
    loop {
        if let Some(died) = heir.try_wait().unwrap() {
            assert!(died.signal().is_some(), "{died}");
            return true;
        }
        if server
            .count("SELECT COUNT(*) FROM job WHERE state = 'failed'")
            .await
            == 1
        {
            heir.kill().unwrap();
            heir.wait().unwrap();
            return false;
        }
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
}

/// A job that ends each process that works on it: five, in the last three of which nothing runs beside it.
/// Those that waited meanwhile are none the worse for it.
#[tokio::test]
async fn a_job_that_kills_its_process_each_time_is_found_out() {
    let Some(mut server) = doomed(&["--workers", "2"], "in_diagnose") else {
        return;
    };
    let mut others = Vec::new();
    for seed in ["1", "2"] {
        let upload = Upload::new(
            seed,
            &[("seed", seed), ("iterations", "300"), ("trials", "8")],
        );
        let expected = upload.undisturbed().await;
        let job = upload.send(&server).await.unwrap();
        others.push((upload, job, expected));
    }
    let poison = Upload::new("poison", &[("diagnosis", "true")]);
    let job = poison.send(&server).await.unwrap();
    server.dies().await;
    let mut deaths = 1;
    while dies_again(&server).await {
        deaths += 1;
    }
    assert_eq!(deaths, 5);
    server.restart_with_env(&[]);
    let view = server.finished(&job).await;
    assert_eq!(view["state"], "failed");
    assert_eq!(view["failure"]["kind"], "crash");
    for (upload, job, expected) in &others {
        upload.succeeded_once(&server, job, expected).await;
    }
    nothing_ran_twice(&server).await;
}
