use std::time::Duration;

use serde_json::Value;

use crate::harness::Server;
use crate::ride::{self, LONG};

#[tokio::test]
async fn a_running_job_is_cancelled_and_begins_anew() {
    let server = Server::start();
    let job = server.submit(&LONG).await;
    while server.json(&job).await["stage"] != "trial" {}
    assert_eq!(server.cancel(&job).await.unwrap().status(), 200);
    let view = server.json(&job).await;
    assert_eq!(view["state"], "cancelled");
    assert!(!view["least_squares"].is_null(), "what was found stays");
    let report = server.get(&format!("{job}/report")).await;
    assert_eq!(report.status(), 409);

    let retry = server.client.post(server.address(&format!("{job}/retry")));
    let view: Value = retry.send().await.unwrap().json().await.unwrap();
    // A worker may have begun it before the answer was made.
    assert!(["queued", "running"].contains(&view["state"].as_str().unwrap()));
    assert!(view["least_squares"].is_null());
    let again = server.client.post(server.address(&format!("{job}/retry")));
    assert_eq!(again.send().await.unwrap().status(), 409);
    server.cancel(&job).await.unwrap();
}

#[tokio::test]
async fn cancelling_at_any_moment_is_answered() {
    let server = Server::start();
    for delay_ms in (0..24).map(|step| step * 8) {
        let seed = delay_ms.to_string();
        let trials = [
            ("seed", seed.as_str()),
            ("iterations", "1"),
            ("trials", "40"),
        ];
        let job = server.submit(&trials).await;
        tokio::time::sleep(Duration::from_millis(delay_ms)).await;
        let (one, other) = tokio::join!(server.cancel(&job), server.cancel(&job));
        for response in [one.unwrap(), other.unwrap()] {
            let status = response.status();
            assert!(
                status == 200 || status == 409,
                "after {delay_ms} ms: {status}"
            );
        }
    }
}

#[tokio::test]
async fn a_cancelled_swarm_frees_its_core() {
    let server = Server::with(&["--workers", "1"]);
    let long = server.submit(&LONG).await;
    while server.json(&long).await["stage"] != "trial" {}
    let short = server.submit(&[("seed", "2")]).await;
    server.cancel(&long).await.unwrap();
    server.succeeded(&short).await;
}

/// One key sends 30 rides, another then one; how many of the 30 end while that one waits and is computed.
async fn ended_before_another(options: &[(&str, &str)]) -> i64 {
    let (mut server, [many, one]) = Server::with_keys([&[], &[]], &["--workers", "1"]);
    server.as_seen_by(&many);
    let send = async |server: &Server, seed: usize| {
        let seed = seed.to_string();
        let parts = [options, &[("seed", &*seed)]].concat();
        let response = server.upload(ride::example(), ride::BIKE, &parts).await;
        let view: Value = response.json().await.unwrap();
        view["links"]["job"].as_str().unwrap().to_owned()
    };
    for seed in 0..30 {
        send(&server, seed).await;
    }
    server.as_seen_by(&one);
    let job = send(&server, 30).await;
    let ended = "SELECT count(*) FROM job WHERE finished_at IS NOT NULL";
    let before = server.count(ended).await;
    assert!(before < 15, "there is no queue");
    server.succeeded(&job).await;
    server.count(ended).await - 1 - before
}

/// With one long stage at a time, two may end before each of the newcomer's two (jobs/run.rs), and the
/// quick stages are done four at a time.
#[tokio::test]
async fn an_uploader_of_many_rides_does_not_delay_an_uploader_of_one() {
    let swarm = [
        ("trials", "3"),
        ("iterations", "3000"),
        ("diagnosis", "false"),
    ];
    let diagnosis = [
        ("trials", "1"),
        ("particles", "4"),
        ("iterations", "1"),
        ("diagnosis", "true"),
    ];
    for (options, stage) in [(&swarm[..], "trial"), (&diagnosis, "diagnose")] {
        let ended = ended_before_another(options).await;
        assert!(ended <= 10, "{stage}: {ended} ended before");
    }
}

#[tokio::test]
async fn least_squares_are_there_before_the_swarm_has_finished() {
    let server = Server::with(&["--workers", "1"]);
    let busy = server.submit(&LONG).await;
    while server.json(&busy).await["stage"] != "trial" {}
    let waiting = server.submit(&[("seed", "2")]).await;
    while server.json(&waiting).await["stage"] != "trial" {}
    let view = server.json(&waiting).await;
    assert_eq!(view["state"], "running");
    assert_eq!(view["trials"]["done"], 0);
    assert!(view["least_squares"]["rear"]["k_n_m"].as_f64().unwrap() > 0.0);
    server.cancel(&busy).await.unwrap();
    server.succeeded(&waiting).await;
}

#[tokio::test]
async fn polls_are_answered_by_304_until_something_changes() {
    let server = Server::start();
    let job = server.submit(&[]).await;
    server.succeeded(&job).await;
    let first = server.get(&job).await;
    let etag = first.headers()["etag"].to_str().unwrap().to_owned();
    for path in [job.clone(), format!("{job}/report")] {
        let request = server.client.get(server.address(&path));
        let response = request.header("If-None-Match", &etag).send().await.unwrap();
        assert_eq!(response.status(), 304, "{path}");
        assert_eq!(response.headers()["etag"], etag.as_str());
    }
}

#[tokio::test]
async fn lists_are_paged_and_filtered() {
    let server = Server::start();
    let other = ride::BIKE.replace("lab-7", "lab-8");
    let mut ids = Vec::new();
    for (seed, bike) in [("1", ride::BIKE), ("2", &other), ("3", ride::BIKE)] {
        let parts = [&ride::QUICK[..], &[("seed", seed)]].concat();
        let response = server.upload(ride::example(), bike, &parts).await;
        let view: Value = response.json().await.unwrap();
        ids.push(view["id"].clone());
        server
            .succeeded(view["links"]["job"].as_str().unwrap())
            .await;
    }
    let ids_of = |page: &Value| -> Vec<Value> {
        let items = page["items"].as_array().unwrap();
        items.iter().map(|item| item["id"].clone()).collect()
    };
    let first = server.get("/v1/jobs?state=succeeded&limit=2").await;
    let link = first.headers()["link"].to_str().unwrap().to_owned();
    let first: Value = first.json().await.unwrap();
    assert_eq!(ids_of(&first), [ids[2].clone(), ids[1].clone()]);
    let next = link.split_once('<').unwrap().1.split_once('>').unwrap().0;
    let second = server.json(next).await;
    assert_eq!(ids_of(&second), [ids[0].clone()]);
    assert!(second["next"].is_null());
    let of_bike = server.json("/v1/jobs?bike=lab-8").await;
    assert_eq!(ids_of(&of_bike), [ids[1].clone()]);
    assert_eq!(
        ids_of(&server.json("/v1/jobs?state=failed").await),
        [] as [Value; 0]
    );
}

#[tokio::test]
async fn metrics_count_jobs_and_requests() {
    let server = Server::start();
    let job = server.submit(&[]).await;
    server.succeeded(&job).await;
    let text = server.get("/metrics").await.text().await.unwrap();
    for line in [
        "veloid_jobs{state=\"succeeded\"} 1",
        "veloid_uploads_total{outcome=\"accepted\"} 1",
        "veloid_workers 1",
        "route=\"/v1/jobs/{id}\"",
    ] {
        assert!(text.contains(line), "{line} is missing in\n{text}");
    }
}
