use std::collections::HashSet;

use futures_util::StreamExt;
use serde_json::Value;
use tokio::sync::Notify;

use crate::harness::Server;
use crate::ride::LONG;

#[derive(Debug)]
struct Event {
    id: String,
    name: String,
    data: Value,
}

/// Reads the stream to its end.
async fn listen(server: &Server, job: &str, last: Option<&str>) -> Vec<Event> {
    listen_until(server, job, last, |_| false).await
}

/// Reads the stream until an event is enough.
async fn listen_until(
    server: &Server,
    job: &str,
    last: Option<&str>,
    enough: impl Fn(&Event) -> bool,
) -> Vec<Event> {
    let mut request = server.client.get(server.address(&format!("{job}/events")));
    if let Some(last) = last {
        request = request.header("Last-Event-ID", last);
    }
    let response = request.send().await.unwrap();
    assert_eq!(response.headers()["content-type"], "text/event-stream");
    let mut text = String::new();
    let mut chunks = response.bytes_stream();
    while let Some(chunk) = chunks.next().await {
        text.push_str(std::str::from_utf8(&chunk.unwrap()).unwrap());
        if text
            .split("\n\n")
            .filter_map(parse)
            .any(|event| enough(&event))
        {
            break;
        }
    }
    text.split("\n\n").filter_map(parse).collect()
}

fn parse(block: &str) -> Option<Event> {
    let field = |name: &str| {
        let start = format!("{name}: ");
        let line = block.lines().find(|line| line.starts_with(&start))?;
        Some(line[start.len()..].to_owned())
    };
    Some(Event {
        id: field("id")?,
        name: field("event")?,
        data: serde_json::from_str(&field("data")?).ok()?,
    })
}

/// All events of a job, which waits for the one beside it until somebody listens.
async fn heard_whole(server: &Server, job: &str, beside: &str) -> Vec<Event> {
    let heard = Notify::new();
    let hears = |_: &Event| {
        heard.notify_one();
        false
    };
    let (events, _) = tokio::join!(listen_until(server, job, None, hears), async {
        heard.notified().await;
        server.cancel(beside).await.unwrap()
    });
    events
}

#[tokio::test]
async fn a_stream_begins_with_a_snapshot_and_ends_with_done() {
    // The only worker is kept busy by another job until somebody listens.
    let server = Server::with(&["--workers", "1"]);
    let other = server.submit(&LONG).await;
    listen_until(&server, &other, None, |event| event.name == "iteration").await;
    let job = server.submit(&[("iterations", "40")]).await;
    let events = heard_whole(&server, &job, &other).await;
    assert_eq!(events[0].name, "snapshot");
    assert_eq!(events[0].data["job"]["links"]["job"], job);
    let last = events.last().unwrap();
    assert_eq!(last.name, "done");
    assert_eq!(last.data["state"], "succeeded");
    let of = |name: &str| events.iter().filter(|e| e.name == name).count();
    let is_late = events[0].data["job"]["state"] == "succeeded";
    assert!(is_late || of("stage") >= 1, "{events:#?}");
    assert_eq!(of("done"), 1, "{events:#?}");
    // An iteration may stand in the snapshot and come as an event too, when both happen at once.
    let trials = events[0].data["trials"].as_array().unwrap();
    let reported = trials.iter().flat_map(|trial| {
        let length = trial["best_cost"].as_array().unwrap().len() as u64;
        (0..length).map(|i| (trial["trial"].as_u64(), Some(i)))
    });
    let heard = events.iter().filter(|e| e.name == "iteration");
    let heard = heard.map(|e| (e.data["trial"].as_u64(), e.data["iteration"].as_u64()));
    assert_eq!(reported.chain(heard).collect::<HashSet<_>>().len(), 3 * 40);
    // Costs of one trial never rise.
    let costs: Vec<f64> = events
        .iter()
        .filter(|e| e.name == "iteration" && e.data["trial"] == 0)
        .map(|e| e.data["best_cost"].as_f64().unwrap())
        .collect();
    assert!(costs.is_sorted_by(|a, b| a >= b), "{costs:?}");
}

#[tokio::test]
async fn a_search_for_missing_physics_tells_how_far_it_is() {
    for isolate in ["on", "off"] {
        let server = Server::with(&["--workers", "1", "--isolate", isolate]);
        // Kept busy until somebody listens.
        let other = server.submit(&LONG).await;
        let parts = [("iterations", "2"), ("diagnosis", "true")];
        let job = server.submit(&parts).await;
        let events = heard_whole(&server, &job, &other).await;
        let searched = events.iter().filter(|e| e.name == "searched");
        let steps: Vec<u64> = searched
            .map(|e| {
                assert!(e.data["budget"].as_u64().unwrap() > 0);
                e.data["steps"].as_u64().unwrap()
            })
            .collect();
        assert!(
            !steps.is_empty() && steps.is_sorted(),
            "{isolate}: {steps:?}"
        );
    }
}

fn snapshot_iterations(snapshot: &Value) -> usize {
    let trials = snapshot["trials"].as_array().unwrap();
    let length = |trial: &Value| trial["best_cost"].as_array().unwrap().len();
    trials.iter().map(length).sum()
}

#[tokio::test]
async fn who_comes_late_gets_everything_in_the_snapshot() {
    let server = Server::start();
    let job = server.submit(&[]).await;
    server.succeeded(&job).await;
    let events = listen(&server, &job, Some("7-3")).await;
    let names: Vec<&str> = events.iter().map(|e| e.name.as_str()).collect();
    assert_eq!(names, ["snapshot", "done"]);
    assert_eq!(snapshot_iterations(&events[0].data), 3 * 8);
    assert!(!events[0].id.is_empty());
}

#[tokio::test]
async fn who_comes_back_goes_on_where_the_connection_broke() {
    let server = Server::with(&["--workers", "1"]);
    let job = server.submit(&LONG).await;
    let at = |number: u64| {
        move |event: &Event| {
            event.name == "iteration" && event.data["iteration"].as_u64() >= Some(number)
        }
    };
    let first = listen_until(&server, &job, None, at(3)).await;
    let last = first.last().unwrap();
    let second = listen_until(&server, &job, Some(&last.id), at(40)).await;
    let iterations: Vec<u64> = [&first, &second]
        .into_iter()
        .flatten()
        .filter(|event| event.name == "iteration")
        .map(|event| event.data["iteration"].as_u64().unwrap())
        .collect();
    assert!(second.iter().all(|event| event.name != "snapshot"));
    let from = iterations[0];
    let gapless: Vec<u64> = (from..from + iterations.len() as u64).collect();
    assert_eq!(iterations, gapless);
    server.cancel(&job).await.unwrap();
}
