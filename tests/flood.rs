//! Floods of made-up methods, paths, hosts, keys, headers and bodies, short and long: memory, log and `/metrics` do not grow.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use crate::harness::Server;

/// Requests of each kind: long ones of 60 to 100 kB, and short ones.
const LONG: usize = 300;
const SHORT: usize = 1000;
/// Longest line of the log (bytes).
const LINE: u64 = 800;
/// Allowed growth of memory (kB); 300 texts of 60 kB would be 18 MB.
const GROWTH_KB: u64 = 12 << 10;

/// Made-up requests: head and body, in which a text takes the place of `{}`.
const KINDS: [(&str, &str, &str); 15] = [
    ("method", "{} /healthz", ""),
    ("method of a route", "{} /v1/jobs", ""),
    ("path", "GET /{}", ""),
    ("id", "GET /v1/jobs/{}/events", ""),
    ("bicycle", "GET /v1/bikes/{}", ""),
    ("query", "GET /v1/jobs?{}=1", ""),
    ("host", "GET /healthz|Host: {}.example", ""),
    ("user agent", "GET /healthz|User-Agent: {}", ""),
    (
        "key of a group",
        "GET /v1/jobs?group={}|Authorization: Bearer veloid_{}",
        "",
    ),
    ("session", "GET /jobs|Cookie: veloid_session={}", ""),
    (
        "sign-in",
        "POST /sign-in|Content-Type: application/x-www-form-urlencoded",
        "key=veloid_{}",
    ),
    ("origin", "POST /v1/rides|Origin: http://{}", ""),
    ("idempotency key", "POST /v1/rides|Idempotency-Key: {}", ""),
    ("ride", "POST /v1/rides?name={}|Veloid-Bike: {}", "t,u_f"),
    (
        "webhook",
        "POST /v1/webhooks|Content-Type: application/json",
        "{\"url\": \"https://{}.example\"}",
    ),
];

/// A request with a text.
fn request(head: &str, body: &str, text: &str) -> String {
    let (line, headers) = head.split_once('|').unwrap_or((head, ""));
    let host = if headers.contains("Host: ") {
        ""
    } else {
        "Host: x\r\n"
    };
    let end = if headers.is_empty() { "" } else { "\r\n" };
    let body = body.replace("{}", text);
    let (line, headers, bytes) = (
        line.replace("{}", text),
        headers.replace("{}", text),
        body.len(),
    );
    format!("{line} HTTP/1.1\r\n{host}{headers}{end}Content-Length: {bytes}\r\n\r\n{body}")
}

/// Sends requests on one connection; how many were answered.
fn flood(server: &Server, requests: impl Iterator<Item = String>) -> usize {
    let mut stream = TcpStream::connect(server.url.trim_start_matches("http://")).unwrap();
    let patience = Some(Duration::from_secs(60));
    stream.set_read_timeout(patience).unwrap();
    let mut reader = stream.try_clone().unwrap();
    let answers = std::thread::spawn(move || {
        let mut bytes = Vec::new();
        reader.read_to_end(&mut bytes).unwrap();
        String::from_utf8_lossy(&bytes).matches("HTTP/1.1 ").count()
    });
    for request in requests {
        stream.write_all(request.as_bytes()).unwrap();
    }
    let last = "GET /healthz HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n";
    stream.write_all(last.as_bytes()).unwrap();
    answers.join().unwrap() - 1
}

fn resident_kb(server: &Server) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", server.id())).unwrap();
    let line = status
        .lines()
        .find(|line| line.starts_with("VmRSS"))
        .unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

fn log_bytes(server: &Server) -> u64 {
    std::fs::metadata(server.folder.0.join("log"))
        .unwrap()
        .len()
}

/// Texts that differ, of some more bytes.
fn texts(count: usize, bytes: usize) -> impl Iterator<Item = String> {
    (0..count).map(move |i| format!("{i}{}", "x".repeat(bytes)))
}

async fn nothing_grows(server: &Server, admin: Option<&str>) {
    let metrics = async || {
        let request = server.client.get(server.address("/metrics"));
        let request = match admin {
            Some(key) => request.bearer_auth(key),
            None => request,
        };
        request.send().await.unwrap().text().await.unwrap()
    };
    // A long body that no key lets in is not read, and ends its connection.
    let kinds = || {
        KINDS
            .into_iter()
            .filter(|kind| admin.is_none() || kind.0 != "webhook")
    };
    // What a connection and its buffers need is there afterwards.
    for (_, head, body) in kinds() {
        let text = "y".repeat(60_000);
        flood(server, (0..100).map(|_| request(head, body, &text)));
    }
    let mut found = Vec::new();
    for (what, head, body) in kinds() {
        let of = |text: String| request(head, body, &text);
        let bytes = if what.starts_with("method") {
            100_000
        } else {
            60_000
        };
        let (memory, log) = (resident_kb(server), log_bytes(server));
        let long = flood(server, texts(LONG, bytes).map(of));
        let short = flood(server, texts(SHORT, 12).map(of));
        assert_eq!((long, short), (LONG, SHORT), "{what}: all were answered");
        let logged = (log_bytes(server) - log) / (LONG + SHORT) as u64;
        let mut grown = u64::MAX;
        for _ in 0..50 {
            grown = grown.min(resident_kb(server).saturating_sub(memory));
            if grown < GROWTH_KB {
                break;
            }
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
        eprintln!("{what}: {grown} kB of memory, {logged} bytes of log per request");
        if grown >= GROWTH_KB || logged >= LINE {
            found.push(what);
        }
    }
    let figures = metrics().await;
    eprintln!("/metrics has {} bytes", figures.len());
    assert!(found.is_empty(), "memory or log grow with {found:?}");
    assert!(figures.contains("method=\"other\""), "{figures}");
    assert!(!figures.contains("xxx"), "a text of a stranger");
    assert!(figures.len() < 300_000, "{} bytes", figures.len());
    let log = std::fs::read(server.folder.0.join("log")).unwrap();
    let longest = log.split(|byte| *byte == b'\n').map(<[u8]>::len).max();
    assert!(longest < Some(LINE as usize), "a line of {longest:?} bytes");
}

#[tokio::test]
#[ignore = "slow"]
async fn made_up_requests_grow_neither_memory_nor_log_nor_metrics() {
    let (server, [admin]) = Server::with_keys([&["--scope", "admin"]], &["--workers", "0"]);
    nothing_grows(&server, Some(&admin)).await;
}

/// Here the requests reach their handlers.
#[tokio::test]
#[ignore = "slow"]
async fn without_keys_made_up_requests_grow_neither_memory_nor_log_nor_metrics() {
    let server = Server::with(&["--workers", "0", "--log-json"]);
    nothing_grows(&server, None).await;
}
