use serde_json::Value;

use crate::harness::{Server, time};
use crate::ride;

#[tokio::test]
async fn a_form_is_queued_followed_and_succeeds() {
    let server = Server::start();
    let response = server
        .upload(ride::example(), ride::BIKE, &ride::QUICK)
        .await;
    assert_eq!(response.status(), 202);
    assert_eq!(response.headers()["retry-after"], "1");
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    let view = server.succeeded(&job).await;
    assert_eq!(view["bike"], "lab-7");
    assert_eq!(view["trials"]["done"], 3);
    assert_eq!(view["progress"], 1.0);
    let [observed, finished] = ["observed_at", "finished_at"].map(|at| time(&view[at]));
    assert!(observed.is_some() && observed < finished);
    let k = view["least_squares"]["front"]["k_n_m"].as_f64().unwrap();
    assert!((k / 110e3 - 1.0).abs() < 0.2, "k = {k} N/m");
    let report = server.json(&format!("{job}/report")).await;
    let k = report["output_error"]["front"]["k_n_m"].as_f64().unwrap();
    assert!((k / 110e3 - 1.0).abs() < 1e-3, "k = {k} N/m");
    let trials = server.json(&format!("{job}/trials")).await;
    assert_eq!(trials["items"].as_array().unwrap().len(), 3);
    assert_eq!(trials["items"][2]["seed"], 3);
    assert_eq!(trials["items"][0]["result"], report["swarm"]["trials"][0]);

    let series = server
        .json(&format!("{job}/series?t0=5&t1=6&quantity=velocity"))
        .await;
    assert_eq!(series["unit"], "m/s");
    assert_eq!(series["t_s"].as_array().unwrap().len(), 201);
    for (axle, curve) in [("front", "measured"), ("rear", "plain"), ("rear", "swarm")] {
        assert!(series["axles"][axle][curve][100].is_f64(), "{axle} {curve}");
    }
    let residual = series["axles"]["front"]["residual"][100].as_f64().unwrap();
    assert!(residual.abs() < 1e-4, "{residual} m/s");
    let thin = server.json(&format!("{job}/series?points=100")).await;
    assert_eq!(thin["thinned"], true);
    assert!(thin["t_s"].as_array().unwrap().len() <= 102);
}

#[tokio::test]
async fn a_raw_body_with_a_known_bike_is_the_same_ride() {
    let server = Server::start();
    let job = server.submit(&[]).await;
    let view = server.json(&job).await;
    let query = "bike=lab-7&name=ride.csv&trials=3&particles=12&iterations=8&diagnosis=false";
    let response = server
        .client
        .post(server.address(&format!("/v1/rides?{query}")))
        .body(ride::example())
        .send()
        .await
        .unwrap();
    assert_eq!(response.status(), 202);
    let body: Value = response.json().await.unwrap();
    assert_eq!(
        body["id"], view["id"],
        "same bytes, bike and options: same job"
    );
    server.succeeded(&job).await;
}

#[tokio::test]
async fn the_bytes_come_back_as_they_went() {
    let server = Server::start();
    let job = server.submit(&[]).await;
    let id = server.json(&job).await["ride"]["id"]
        .as_str()
        .unwrap()
        .to_owned();
    let ride = server.json(&format!("/v1/rides/{id}")).await;
    assert_eq!(ride["name"], "ride.csv");
    assert_eq!(ride["bytes"], ride::example().len());
    assert_eq!(ride["jobs"][0]["links"]["job"], job);
    let file = server.get(ride["file"].as_str().unwrap()).await;
    let disposition = file.headers()["content-disposition"].to_str().unwrap();
    assert!(disposition.starts_with("attachment"), "{disposition}");
    assert_eq!(file.bytes().await.unwrap(), ride::example());
}

#[tokio::test]
async fn again_identifies_anew_and_a_key_does_not() {
    let server = Server::start();
    let first = server.submit(&[]).await;
    assert_eq!(server.submit(&[]).await, first);
    assert_ne!(server.submit(&[("again", "true")]).await, first);

    let send = async |seed: &str| {
        let query = format!("bike=lab-7&trials=1&diagnosis=false&seed={seed}");
        server
            .client
            .post(server.address(&format!("/v1/rides?{query}")))
            .header("Idempotency-Key", "\"k-1\"")
            .body(ride::example())
            .send()
            .await
            .unwrap()
    };
    let once = send("5").await.headers()["location"].clone();
    assert_eq!(send("5").await.headers()["location"], once);
    let other = send("6").await;
    assert_eq!(other.status(), 422);
    let problem: Value = other.json().await.unwrap();
    assert_eq!(problem["type"], "urn:veloid:problem:idempotency-key-reused");
}

#[tokio::test]
async fn an_acknowledged_ride_survives_a_crash() {
    let mut server = Server::with(&["--workers", "1"]);
    let mut jobs = Vec::new();
    for seed in ["1", "2", "3", "4"] {
        jobs.push(server.submit(&[("seed", seed), ("iterations", "60")]).await);
    }
    server.crash_and_restart();
    for job in jobs {
        let view = server.succeeded(&job).await;
        assert_eq!(view["trials"]["done"], 3);
    }
}
