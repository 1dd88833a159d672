//! Jobs that do harm to the process that computes them end alone, each with its cause.

use std::time::Instant;

use serde_json::Value;

use crate::harness::{Server, has_points, nothing_is_kept};
use crate::oracle::nothing_ran_twice;
use crate::ride;

const JOBS: u64 = 64;
/// What the poisoned ones do, in which stage, and what their failure says.
const POISON: [(&str, &str, u64, [&str; 2]); 8] = [
    ("abort", "observe", 100, ["crash", "SIGABRT"]),
    ("abort", "trial", 109, ["crash", "SIGABRT"]),
    ("loop", "trial", 118, ["deadline", "longer than 5 s"]),
    ("loop", "conclude", 127, ["deadline", "longer than 5 s"]),
    ("memory", "observe", 136, ["crash", "memory allocation of"]),
    ("memory", "trial", 145, ["crash", "memory allocation of"]),
    ("stack", "trial", 154, ["crash", "stack overflow"]),
    ("stack", "conclude", 163, ["crash", "stack overflow"]),
];

/// A server in whose children jobs with these seeds do harm.
fn poisoned(poison: &str, args: &[&str]) -> Option<Server> {
    if !has_points() {
        return None;
    }
    let args = [&["--memory-budget", "200000000"], args].concat();
    Some(Server::with_env(&args, &[("VELOID_POISON", poison)]))
}

fn fails_with(view: &Value, [kind, why]: [&str; 2]) {
    assert_eq!(view["state"], "failed", "{view:#}");
    assert_eq!(view["failure"]["kind"], kind, "{view:#}");
    let detail = view["failure"]["detail"].as_str().unwrap();
    assert!(detail.contains(why), "{view:#}");
}

/// Uploads so many rides, each with a seed of its own; the addresses of their jobs.
async fn upload(server: &Server, seeds: std::ops::Range<u64>) -> Vec<(u64, String)> {
    let mut jobs = Vec::new();
    for seed in seeds {
        let job = server.submit(&[("seed", &seed.to_string())]).await;
        jobs.push((seed, job));
    }
    jobs
}

#[tokio::test]
async fn poisoned_jobs_fail_alone_with_their_causes() {
    let orders = POISON.map(|(kind, stage, seed, _)| format!("{kind}:{stage}:{seed}"));
    let Some(server) = poisoned(&orders.join(","), &["--stage-timeout", "5"]) else {
        return;
    };
    let begun = Instant::now();
    for (seed, job) in upload(&server, 100..100 + JOBS).await {
        let view = server.finished(&job).await;
        match POISON.iter().find(|poison| poison.2 == seed) {
            Some((.., failure)) => fails_with(&view, *failure),
            None => assert_eq!(view["state"], "succeeded", "{view:#}"),
        }
    }
    eprintln!(
        "{JOBS} jobs, {} poisoned: {:.1} s",
        POISON.len(),
        begun.elapsed().as_secs_f64()
    );
    let charged =
        "SELECT COUNT(*) FROM job WHERE state = 'succeeded' AND (lost > 0 OR takeovers > 0)";
    assert_eq!(
        server.count(charged).await,
        0,
        "who was beside them is not charged"
    );
    let again = "SELECT COUNT(*) FROM river_job WHERE attempt > 1";
    assert_eq!(server.count(again).await, 0, "whose fault it was is plain");
    nothing_ran_twice(&server).await;
}

#[tokio::test]
async fn a_ride_beyond_the_budget_is_refused_with_what_it_needs() {
    let server = Server::with(&["--workers", "0", "--memory-budget", "20000000"]);
    let response = server
        .upload(ride::example(), ride::BIKE, &ride::QUICK)
        .await;
    assert_eq!(response.status(), 413);
    let problem: Value = response.json().await.unwrap();
    let detail = problem["detail"].as_str().unwrap();
    assert!(
        detail.contains("needs about") && detail.contains("allowed"),
        "{detail}"
    );
    nothing_is_kept(&server);
}

/// Whose child is killed from outside has one more try, alone.
#[tokio::test]
async fn a_job_whose_process_is_killed_is_tried_once_more() {
    let Some(server) = poisoned("kill:trial:7", &[]) else {
        return;
    };
    let jobs = upload(&server, 5..9).await;
    for (seed, job) in jobs {
        let view = server.finished(&job).await;
        match seed {
            7 => fails_with(&view, ["crash", "twice, the second time alone"]),
            _ => assert_eq!(view["state"], "succeeded", "{view:#}"),
        }
    }
    let tries = "SELECT COUNT(*) FROM river_job WHERE attempt = 2";
    assert_eq!(server.count(tries).await, 1);
}

/// The only core is free for the next job at once.
#[tokio::test]
async fn a_cancel_ends_work_that_hears_nothing() {
    let Some(server) = poisoned("loop:trial:7", &["--workers", "1"]) else {
        return;
    };
    let deaf = server.submit(&[("seed", "7")]).await;
    while server.json(&deaf).await["stage"] != "trial" {}
    let next = server.submit(&[("seed", "8")]).await;
    server
        .cancel(&deaf)
        .await
        .unwrap()
        .error_for_status()
        .unwrap();
    assert_eq!(server.finished(&deaf).await["state"], "cancelled");
    server.succeeded(&next).await;
}
