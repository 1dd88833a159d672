//! Receivers of webhooks that do not answer. The messages of others arrive meanwhile, and theirs wait for them.

use std::collections::HashSet;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;

use crate::built::has;
use crate::harness::Server;
use crate::webhooks::{Receiver, created};

const JOBS: usize = 30;
const ENDS: [&str; 3] = ["job.succeeded", "job.failed", "job.cancelled"];

/// What a host does with a connection.
#[derive(Clone, Copy, PartialEq)]
enum Manner {
    Silent,
    Closing,
    Answering,
}

/// A host that counts its connections.
#[derive(Clone)]
struct Host {
    url: String,
    manner: watch::Sender<Manner>,
    taken: Arc<Mutex<Vec<Instant>>>,
    open: Arc<AtomicUsize>,
    most: Arc<AtomicUsize>,
    /// Identifiers of messages that were answered.
    heard: Arc<Mutex<HashSet<String>>>,
}

impl Host {
    async fn new(address: &str, manner: Manner) -> Self {
        let listener = TcpListener::bind((address, 0)).await.unwrap();
        let port = listener.local_addr().unwrap().port();
        let host = Self {
            url: format!("http://{address}:{port}/hook"),
            manner: watch::Sender::new(manner),
            taken: Arc::default(),
            open: Arc::default(),
            most: Arc::default(),
            heard: Arc::default(),
        };
        let own = host.clone();
        tokio::spawn(async move {
            while let Ok((stream, _)) = listener.accept().await {
                own.taken.lock().unwrap().push(Instant::now());
                let open = own.open.fetch_add(1, Ordering::Relaxed) + 1;
                own.most.fetch_max(open, Ordering::Relaxed);
                let own = own.clone();
                tokio::spawn(own.hold(stream));
            }
        });
        host
    }

    async fn hold(self, mut stream: TcpStream) {
        let answered = self.message(&mut stream).await;
        self.open.fetch_sub(1, Ordering::Relaxed);
        if let Some(id) = answered {
            let answer = b"HTTP/1.1 204 No Content\r\nconnection: close\r\n\r\n";
            stream.write_all(answer).await.unwrap();
            self.heard.lock().unwrap().insert(id);
        }
    }

    /// The identifier of the message, once it may be answered; nothing if the connection ends before.
    async fn message(&self, stream: &mut TcpStream) -> Option<String> {
        let (mut manner, mut request) = (self.manner.subscribe(), Vec::new());
        if *manner.borrow() == Manner::Closing {
            return None;
        }
        let answers = manner.wait_for(|manner| *manner == Manner::Answering);
        tokio::pin!(answers);
        let mut is_answering = false;
        loop {
            if is_answering && let Some(id) = whole(&request) {
                return Some(id);
            }
            tokio::select! {
                _ = &mut answers, if !is_answering => is_answering = true,
                read = stream.read_buf(&mut request) => if !matches!(read, Ok(1..)) { return None },
            }
        }
    }

    fn taken(&self) -> usize {
        self.taken.lock().unwrap().len()
    }
}

/// The identifier of a message that has come whole.
fn whole(request: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(request).ok()?;
    let (head, body) = text.split_once("\r\n\r\n")?;
    let field = |name: &str| {
        let mut fields = head.lines().filter_map(|line| line.split_once(": "));
        fields
            .find(|(n, _)| n.eq_ignore_ascii_case(name))
            .map(|(_, value)| value)
    };
    let length: usize = field("content-length")?.parse().ok()?;
    (body.len() >= length).then(|| field("webhook-id").map(str::to_owned))?
}

/// Ends so many jobs.
async fn end_jobs(server: &Server, count: usize) {
    for seed in 0..count {
        let job = server.submit(&[("seed", &seed.to_string())]).await;
        server.cancel(&job).await.unwrap();
    }
}

async fn until(what: &str, mut holds: impl AsyncFnMut() -> bool) {
    let begun = Instant::now();
    while !holds().await {
        assert!(
            begun.elapsed() < Duration::from_secs(180),
            "{what}: not within 180 s"
        );
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

/// A server that two groups use: the keys of their administrators.
fn shared(addresses: &[String]) -> (Server, [String; 2]) {
    let allowed = [&["127.0.0.1".to_owned()], addresses].concat().join(",");
    let keys: [&[&str]; 2] = [
        &["--scope", "admin", "--group", "a"],
        &["--scope", "admin", "--group", "b"],
    ];
    Server::with_keys(keys, &["--webhook-allow", &allowed, "--webhook-private"])
}

/// Group a has messages for hosts that do not answer, then b's are sent; how many connections the hosts had got by then.
async fn others_hear(addresses: &[String]) {
    let (mut server, [a, b]) = shared(addresses);
    let mut hosts = Vec::new();
    server.as_seen_by(&a);
    for address in addresses {
        let host = Host::new(address, Manner::Silent).await;
        created(&server, &json!({"url": host.url, "events": ENDS})).await;
        hosts.push(host);
    }
    end_jobs(&server, JOBS).await;
    until("a host is sent to", async || {
        hosts.iter().any(|host| host.taken() > 0)
    })
    .await;

    server.as_seen_by(&b);
    let receiver = Receiver::answering(&[]).await;
    created(&server, &json!({"url": receiver.url(), "events": ENDS})).await;
    end_jobs(&server, 5).await;
    receiver.heard(5).await;
    let taken: usize = hosts.iter().map(Host::taken).sum();
    // Each may have been tried again.
    assert!(
        taken <= 2 * hosts.len(),
        "{taken} connections to {} hosts",
        hosts.len()
    );

    let most: Vec<usize> = hosts
        .iter()
        .map(|host| host.most.load(Ordering::Relaxed))
        .collect();
    assert!(
        most.iter().all(|most| *most <= 1),
        "{most:?} connections at a time"
    );
    let all = JOBS * hosts.len();
    until("all messages wait", async || {
        let kept = server.count(
            "SELECT COUNT(*) FROM river_job WHERE kind = 'deliver' AND state <> 'completed'",
        );
        kept.await as usize == all
    })
    .await;
    let used = server.count("SELECT CAST(COALESCE(SUM(attempt), 0) AS BIGINT) FROM river_job WHERE kind = 'deliver' AND state IN ('available', 'retryable', 'scheduled')");
    let used = used.await as usize;
    let taken: usize = hosts.iter().map(Host::taken).sum();
    assert!(used <= taken, "{used} attempts for {taken} connections");

    // What waits outlives the process, and arrives once it is answered.
    server.crash_and_restart();
    for host in &hosts {
        host.manner.send_replace(Manner::Answering);
    }
    for host in &hosts {
        until("all messages are heard", async || {
            host.heard.lock().unwrap().len() == JOBS
        })
        .await;
        assert_eq!(host.most.load(Ordering::Relaxed), 1);
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_host_that_does_not_answer_keeps_nobody_elses_messages() {
    if !has("webhooks") {
        return;
    }
    others_hear(&["127.0.0.2".to_owned()]).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn nor_those_to_another_port_of_it() {
    if !has("webhooks") {
        return;
    }
    others_hear(&["127.0.0.1".to_owned()]).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn nor_do_many_hosts_that_do_not_answer() {
    if !has("webhooks") {
        return;
    }
    let addresses: Vec<String> = (2..14).map(|n| format!("127.0.0.{n}")).collect();
    others_hear(&addresses).await;
}

/// A connection that is closed is no answer; with each the host has more time.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_host_that_closes_its_connections_is_sent_to_less_and_less() {
    if !has("webhooks") {
        return;
    }
    let addresses = ["127.0.0.2".to_owned()];
    let (mut server, [a, _]) = shared(&addresses);
    server.as_seen_by(&a);
    let host = Host::new(&addresses[0], Manner::Closing).await;
    created(&server, &json!({"url": host.url, "events": ENDS})).await;
    end_jobs(&server, JOBS).await;
    until("four connections", async || host.taken() >= 4).await;
    let taken = host.taken.lock().unwrap().clone();
    // 2, 4 and 8 s.
    let took = taken[3] - taken[0];
    assert!(
        took > Duration::from_secs(8),
        "four connections within {took:?}"
    );

    host.manner.send_replace(Manner::Answering);
    // A message that was tried twice waits for 5 minutes.
    until("the others are heard", async || {
        host.heard.lock().unwrap().len() >= JOBS - 4
    })
    .await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_message_is_given_up_after_days_however_few_attempts_were_made() {
    if !has("webhooks") {
        return;
    }
    let addresses = ["127.0.0.2".to_owned()];
    let (mut server, [a, _]) = shared(&addresses);
    server.as_seen_by(&a);
    let host = Host::new(&addresses[0], Manner::Closing).await;
    created(&server, &json!({"url": host.url, "events": ENDS})).await;
    end_jobs(&server, 1).await;
    until("an attempt", async || {
        server.json("/v1/webhooks").await[0]["outcome"].is_string()
    })
    .await;
    server
        .execute(
            "UPDATE river_job SET created_at = '2020-01-01 00:00:00.000' WHERE kind = 'deliver'",
        )
        .await;
    until("it is given up", async || {
        let outcome = &server.json("/v1/webhooks").await[0]["outcome"];
        outcome == "a message was given up after 4 days"
    })
    .await;
    assert!(host.taken() < 10, "not after all attempts");
}
