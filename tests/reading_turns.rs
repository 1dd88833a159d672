//! One group's requests to read files do not delay another group's.

use std::time::Duration;

use reqwest::{Client, RequestBuilder, Response, StatusCode};
use tokio::task::JoinSet;
use tokio::time::timeout;

use crate::harness::{Server, has_points};
use crate::ride;

/// Previews and curves with this seed never end.
const ENDLESS: &str = "7";
const POISON: &str = "loop:preview:7,loop:series:7";
/// Requests of a group that wait beside those that are read (server/jobs/seats.rs).
const WAITING: usize = 128;
const READ: usize = 2;
/// Far longer than any answer takes that does not wait for the flood.
const MINUTE: Duration = Duration::from_secs(60);
/// Longer than a preview of a small ride takes: one without an answer waits.
const MOMENT: Duration = Duration::from_secs(3);

/// A server, and clients with a key of the group `many`, with one of it that only reads, and with a key of the group `one`.
fn server() -> (Server, [Client; 3]) {
    let keys: [&[&str]; 3] = [
        &["--group", "many"],
        &["--group", "many", "--scope", "read"],
        &["--group", "one"],
    ];
    let (mut server, keys) = Server::with_keys(keys, &["--workers", "1"]);
    server.kill();
    server.restart_with_env(&[("VELOID_POISON", POISON)]);
    let clients = keys.map(|key| {
        server.as_seen_by(&key);
        server.client.clone()
    });
    (server, clients)
}

fn preview(server: &Server, client: &Client, seed: &str) -> RequestBuilder {
    let path = format!("/v1/rides/preview?seed={seed}");
    client.post(server.address(&path)).body(ride::example())
}

/// Requests under way; dropped, they are abandoned.
fn flood(count: usize, request: impl Fn() -> RequestBuilder) -> JoinSet<Response> {
    let send = |request: RequestBuilder| async { request.send().await.unwrap() };
    (0..count).map(|_| send(request())).collect()
}

/// Returns once the readers are busy with the flood: another preview of its group has no answer.
async fn is_under_way(server: &Server, client: &Client) {
    let probe = || timeout(MOMENT, preview(server, client, "1").send());
    while probe().await.is_ok() {}
}

/// Uploads a small ride of the group `one`, and looks whether the flood goes on.
async fn is_answered_at_once(server: &mut Server, one: &Client, flood: &mut JoinSet<Response>) {
    server.client = one.clone();
    let upload = timeout(MINUTE, server.submit(&[]));
    upload.await.expect("the upload waits for the flood");
    assert!(flood.try_join_next().is_none(), "the flood is over");
}

/// Once 12 large previews delayed another group's upload by 12 to 42 s.
#[tokio::test]
async fn previews_of_one_group_do_not_delay_the_upload_of_another() {
    if !has_points() {
        return;
    }
    let (mut server, [many, _, one]) = server();
    let mut flood = flood(12, || preview(&server, &many, ENDLESS));
    is_under_way(&server, &many).await;
    is_answered_at_once(&mut server, &one, &mut flood).await;
}

/// Once 60 requests of a key that may only read did the same.
#[tokio::test]
async fn curves_of_one_group_do_not_delay_the_upload_of_another() {
    if !has_points() {
        return;
    }
    let (mut server, [many, reading, one]) = server();
    server.client = many.clone();
    let job = server.submit(&[("seed", ENDLESS)]).await;
    server.succeeded(&job).await;
    let series = server.address(&format!("{job}/series"));
    let mut flood = flood(60, || reading.get(&series));
    is_under_way(&server, &many).await;
    is_answered_at_once(&mut server, &one, &mut flood).await;
}

#[tokio::test]
async fn a_group_has_so_many_waiting_requests_and_abandoned_ones_leave() {
    if !has_points() {
        return;
    }
    let (server, [many, _, one]) = server();
    let beyond = 4;
    let count = READ + WAITING + beyond;
    let mut flood = flood(count, || preview(&server, &many, ENDLESS));
    for _ in 0..beyond {
        let refused = timeout(MINUTE, flood.join_next()).await;
        let refused = refused.expect("all of them wait").unwrap().unwrap();
        assert_eq!(refused.status(), StatusCode::SERVICE_UNAVAILABLE);
        assert_eq!(refused.headers()["retry-after"], "10");
        let detail = refused.text().await.unwrap();
        assert!(
            detail.contains(&format!("{WAITING} requests that wait")),
            "{detail}"
        );
    }
    let other = timeout(MINUTE, preview(&server, &one, "1").send()).await;
    assert_eq!(other.unwrap().unwrap().status(), 200);
    assert!(flood.try_join_next().is_none(), "no more are refused");
    drop(flood);
    let own = async {
        while preview(&server, &many, "1").send().await.unwrap().status() != 200 {
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
    };
    timeout(MINUTE, own)
        .await
        .expect("abandoned requests still wait");
}
