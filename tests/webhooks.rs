//! Others are told when jobs end and bicycles change.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use axum::Router;
use axum::body::Bytes;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use axum::routing::{get, post};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use hmac::{Hmac, KeyInit, Mac};
use reqwest::Response;
use serde_json::{Value, json};
use sha2::Sha256;

use crate::built::has;
use crate::harness::Server;
use crate::season;

/// Headers of interest and body.
#[derive(Clone)]
pub struct Heard {
    id: String,
    timestamp: String,
    signature: String,
    body: String,
}

/// A receiver on this machine that answers with the statuses that it is given, then with 204.
#[derive(Clone)]
pub struct Receiver {
    heard: Arc<Mutex<Vec<Heard>>>,
    answers: Arc<Mutex<Vec<StatusCode>>>,
    /// Requests to where a redirect leads.
    elsewhere: Arc<Mutex<usize>>,
    port: u16,
}

impl Receiver {
    pub async fn answering(answers: &[StatusCode]) -> Self {
        let listener = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
        let receiver = Self {
            heard: Arc::default(),
            answers: Arc::new(Mutex::new(answers.to_vec())),
            elsewhere: Arc::default(),
            port: listener.local_addr().unwrap().port(),
        };
        let router = Router::new()
            .route("/hook", post(hear))
            .route("/elsewhere", get(stray).post(stray))
            .with_state(receiver.clone());
        tokio::spawn(async move { axum::serve(listener, router).await });
        receiver
    }

    pub fn url(&self) -> String {
        format!("http://127.0.0.1:{}/hook", self.port)
    }

    /// The messages of a type.
    fn all_of(&self, kind: &str) -> Vec<Value> {
        let heard = self.heard.lock().unwrap();
        let reported = heard
            .iter()
            .map(|heard| serde_json::from_str::<Value>(&heard.body).unwrap());
        reported
            .filter(|reported| reported["type"] == kind)
            .collect()
    }

    /// Waits until so many messages of a type were heard.
    async fn heard_of(&self, kind: &str, count: usize) -> Vec<Value> {
        for _ in 0..600 {
            let reported = self.all_of(kind);
            if reported.len() >= count {
                return reported;
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
        panic!("{} of {count} {kind} in 30 s", self.all_of(kind).len());
    }

    /// Waits until so many messages were heard.
    pub async fn heard(&self, count: usize) -> Vec<Heard> {
        for _ in 0..600 {
            let heard = self.heard.lock().unwrap().clone();
            if heard.len() >= count {
                return heard;
            }
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
        panic!(
            "{} of {count} messages in 30 s",
            self.heard.lock().unwrap().len()
        );
    }
}

async fn hear(
    State(receiver): State<Receiver>,
    headers: HeaderMap,
    body: Bytes,
) -> (StatusCode, [(&'static str, &'static str); 1]) {
    let text = |name: &str| headers[name].to_str().unwrap().to_owned();
    receiver.heard.lock().unwrap().push(Heard {
        id: text("webhook-id"),
        timestamp: text("webhook-timestamp"),
        signature: text("webhook-signature"),
        body: String::from_utf8(body.to_vec()).unwrap(),
    });
    let mut answers = receiver.answers.lock().unwrap();
    let status = if answers.is_empty() {
        StatusCode::NO_CONTENT
    } else {
        answers.remove(0)
    };
    (status, [("location", "/elsewhere")])
}

async fn stray(State(receiver): State<Receiver>) {
    *receiver.elsewhere.lock().unwrap() += 1;
}

/// As a receiver checks it.
fn is_signed(heard: &Heard, secret: &str) -> bool {
    let key = STANDARD
        .decode(secret.strip_prefix("whsec_").unwrap())
        .unwrap();
    let mut mac = Hmac::<Sha256>::new_from_slice(&key).unwrap();
    mac.update(format!("{}.{}.{}", heard.id, heard.timestamp, heard.body).as_bytes());
    let given = STANDARD
        .decode(heard.signature.strip_prefix("v1,").unwrap())
        .unwrap();
    mac.verify_slice(&given).is_ok()
}

async fn create(server: &Server, body: &Value) -> Response {
    let request = server.client.post(server.address("/v1/webhooks"));
    request.json(body).send().await.unwrap()
}

pub async fn created(server: &Server, body: &Value) -> Value {
    let response = create(server, body).await;
    assert_eq!(response.status(), 201);
    response.json().await.unwrap()
}

const OPEN: [&str; 3] = ["--webhook-allow", "127.0.0.1", "--webhook-private"];

#[tokio::test]
async fn the_end_of_a_job_is_reported_signed_and_again_until_it_is_taken() {
    if !has("webhooks") {
        return;
    }
    let server = Server::with(&OPEN);
    let receiver = Receiver::answering(&[StatusCode::SERVICE_UNAVAILABLE, StatusCode::OK]).await;
    let made = created(
        &server,
        &json!({"url": receiver.url(), "events": ["job.succeeded", "job.cancelled"]}),
    )
    .await;
    let secret = made["secret"].as_str().unwrap();
    let job = server.submit(&[]).await;
    server.succeeded(&job).await;

    // The first attempt is refused, the second comes after 5 s.
    let heard = receiver.heard(2).await;
    assert!(heard.iter().all(|heard| is_signed(heard, secret)));
    assert!(!is_signed(
        &Heard {
            body: format!("{} ", heard[0].body),
            ..heard[0].clone()
        },
        secret
    ));
    assert_eq!(
        (&heard[0].id, &heard[0].body),
        (&heard[1].id, &heard[1].body)
    );
    let reported: Value = serde_json::from_str(&heard[0].body).unwrap();
    assert_eq!(
        (&reported["type"], &reported["data"]["links"]["job"]),
        (&json!("job.succeeded"), &json!(job))
    );
    assert_eq!(reported["data"]["bike"], "lab-7");
    assert!(reported["timestamp"].as_str().unwrap().ends_with('Z'));

    let view = &server.json("/v1/webhooks").await[0];
    assert_eq!((&view["id"], view.get("secret")), (&made["id"], None));
    let request = server
        .client
        .delete(server.address(&format!("/v1/webhooks/{}", made["id"].as_str().unwrap())));
    assert_eq!(request.send().await.unwrap().status(), 204);
    assert_eq!(server.json("/v1/webhooks").await, json!([]));
    let trail = server.json("/v1/audit").await;
    assert_eq!(trail["items"][0]["action"], "delete webhook");
}

#[tokio::test]
async fn a_bicycle_that_changes_is_reported_once() {
    if !has("webhooks") {
        return;
    }
    let server = Server::with(&OPEN);
    let receiver = Receiver::answering(&[]).await;
    season::write(&server, 2, 200).await;
    let events = json!(["bike.drifts", "job.succeeded"]);
    created(&server, &json!({"url": receiver.url(), "events": events})).await;
    // Any ride of the bicycle makes the server look at it again.
    let bike = r#"{"bike": "season-001", "mass_front_kg": 23.0, "mass_rear_kg": 63.0, "l_front_m": 0.808, "l_rear_m": 0.293}"#;
    for seed in ["1", "2"] {
        let parts = [&crate::ride::QUICK[..], &[("seed", seed)]].concat();
        let response = server.upload(crate::ride::example(), bike, &parts).await;
        assert_eq!(response.status(), 202);
        let job = response.headers()["location"].to_str().unwrap().to_owned();
        server.succeeded(&job).await;
    }
    let reported = receiver.heard_of("bike.drifts", 1).await.remove(0);
    let data = &reported["data"];
    assert_eq!(
        (
            &reported["type"],
            &data["bike"],
            &data["axle"],
            &data["name"]
        ),
        (
            &json!("bike.drifts"),
            &json!("season-001"),
            &json!("front"),
            &json!("k_n_m")
        )
    );
    assert_eq!(data["development"]["kind"], "drift");
    // The second ride is told of too, but the drift is not told again.
    receiver.heard_of("job.succeeded", 2).await;
    let drifts = receiver
        .all_of("bike.drifts")
        .into_iter()
        .filter(|reported| {
            reported["data"]["axle"] == "front" && reported["data"]["name"] == "k_n_m"
        });
    assert_eq!(drifts.count(), 1);
}

#[tokio::test]
async fn nothing_goes_where_the_operator_has_not_allowed_it() {
    if !has("webhooks") {
        return;
    }
    let receiver = Receiver::answering(&[]).await;
    for (args, url, said) in [
        (&[][..], receiver.url(), "is not encrypted"),
        (
            &[],
            "https://example.org/".to_owned(),
            "'example.org' is not allowed here",
        ),
        (
            &["--webhook-allow", "127.0.0.1"],
            "https://127.0.0.1:1/".to_owned(),
            "not a public address",
        ),
        (
            &["--webhook-allow", "example.org", "--webhook-private"],
            receiver.url(),
            "'127.0.0.1' is not allowed here",
        ),
    ] {
        let args = [&["--workers", "0"], args].concat();
        let server = Server::with(&args);
        let response = create(&server, &json!({"url": url})).await;
        assert_eq!(response.status(), 403, "{args:?} {url}");
        let problem: Value = response.json().await.unwrap();
        assert!(
            problem["detail"].as_str().unwrap().contains(said),
            "{problem}"
        );
    }
    // A name that is allowed and leads to this machine is refused when it is resolved.
    let server = Server::with(&["--workers", "0", "--webhook-allow", "localhost"]);
    let made = created(
        &server,
        &json!({"url": format!("https://localhost:{}/hook", receiver.port)}),
    )
    .await;
    let test = async |server: &Server, made: &Value| -> Value {
        let path = format!("/v1/webhooks/{}/test", made["id"].as_str().unwrap());
        let response = server
            .client
            .post(server.address(&path))
            .send()
            .await
            .unwrap();
        response.json().await.unwrap()
    };
    let tested = test(&server, &made).await;
    assert_eq!(tested["delivered"], false);
    assert!(
        tested["outcome"]
            .as_str()
            .unwrap()
            .contains("not a public address"),
        "{tested}"
    );
    assert!(receiver.heard.lock().unwrap().is_empty());

    // Where an answer leads is not followed, and its absence is told.
    let server = Server::with(&["--workers", "0", OPEN[0], OPEN[1], OPEN[2]]);
    let turning = Receiver::answering(&[StatusCode::TEMPORARY_REDIRECT, StatusCode::FOUND]).await;
    let made = created(&server, &json!({"url": turning.url()})).await;
    for status in ["307", "302", "204"] {
        let tested = test(&server, &made).await;
        assert_eq!(tested["delivered"], status == "204");
        assert!(
            tested["outcome"].as_str().unwrap().contains(status),
            "{tested}"
        );
    }
    assert_eq!(*turning.elsewhere.lock().unwrap(), 0);
    for (body, said) in [
        (
            json!({"url": turning.url(), "events": ["job.begun"]}),
            "events: 'job.begun', expected one of job.succeeded",
        ),
        (json!({"url": "nowhere"}), "expected an address"),
        (
            json!({"url": turning.url(), "secret": "mine"}),
            "unknown field `secret`",
        ),
        (json!([]), "the body: "),
    ] {
        let problem: Value = create(&server, &body).await.json().await.unwrap();
        assert!(
            problem["detail"].as_str().unwrap().contains(said),
            "{problem}"
        );
    }
    for _ in 1..20 {
        created(&server, &json!({"url": turning.url()})).await;
    }
    assert_eq!(
        create(&server, &json!({"url": turning.url()}))
            .await
            .status(),
        429
    );
}

#[tokio::test]
async fn webhooks_belong_to_a_groups_administrators() {
    if !has("webhooks") {
        return;
    }
    let receiver = Receiver::answering(&[]).await;
    let keys: [&[&str]; 3] = [
        &["--scope", "admin"],
        &["--scope", "read", "--scope", "upload"],
        &["--scope", "admin", "--group", "other"],
    ];
    let (mut server, [admin, user, other]) = Server::with_keys(keys, &OPEN);
    server.as_seen_by(&user);
    assert_eq!(server.get("/v1/webhooks").await.status(), 403);
    assert_eq!(
        create(&server, &json!({"url": receiver.url()}))
            .await
            .status(),
        403
    );
    server.as_seen_by(&admin);
    let made = created(&server, &json!({"url": receiver.url()})).await;
    server.as_seen_by(&other);
    assert_eq!(server.json("/v1/webhooks").await, json!([]));
    let path = format!("/v1/webhooks/{}", made["id"].as_str().unwrap());
    let foreign = server
        .client
        .delete(server.address(&path))
        .send()
        .await
        .unwrap();
    assert_eq!(foreign.status(), 404);
}

/// The feed is XML that tells the latest jobs, whatever a ride is called.
#[tokio::test]
async fn finished_jobs_are_a_feed() {
    let server = Server::start();
    let empty = server.get("/jobs.atom").await;
    assert_eq!(
        empty.headers()["content-type"],
        "application/atom+xml; charset=utf-8"
    );
    assert!(
        empty
            .text()
            .await
            .unwrap()
            .contains("<updated>1970-01-01T00:00:00Z</updated>")
    );
    let job = server.submit(&[]).await;
    let view = server.succeeded(&job).await;
    let feed = server.get("/jobs.atom").await.text().await.unwrap();
    for said in [
        format!("<id>urn:uuid:{}</id>", view["id"].as_str().unwrap()),
        format!(
            "<updated>{}</updated>",
            view["finished_at"].as_str().unwrap()
        ),
        "<category term=\"lab-7\"/>".to_owned(),
        format!("href=\"{}\"", view["links"]["page"].as_str().unwrap()),
    ] {
        assert!(feed.contains(&said), "{said}: {feed}");
    }
    let page = server.get("/jobs").await.text().await.unwrap();
    assert!(page.contains("type=\"application/atom+xml\""));
}
