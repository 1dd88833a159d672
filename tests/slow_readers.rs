//! Clients that ask for much and read little of it. Others get their long lists meanwhile, the slow ones are cut off, and
//! what breaks off never looks complete.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use crate::built::has;
use crate::harness::{Server, http};
use crate::season;

const LIST: &str = "/v1/parameters?limit=100000&format=csv";
/// Whoever waits for so long waits in vain.
const PATIENCE: Duration = Duration::from_secs(120);

/// An answer of which only the head was read.
pub struct Begun {
    pub status: u16,
    head: String,
    pub rest: BufReader<TcpStream>,
}

impl Begun {
    pub fn new(server: &Server, path: &str, key: &str) -> Self {
        let mut stream = TcpStream::connect(server.url.trim_start_matches("http://")).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        write!(
            stream,
            "GET {path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\nAuthorization: Bearer {key}\r\n\r\n"
        )
        .unwrap();
        let (mut rest, mut head) = (BufReader::with_capacity(1, stream), String::new());
        while !head.ends_with("\r\n\r\n") {
            assert!(rest.read_line(&mut head).unwrap() > 0, "{head}");
        }
        let status = head[9..12].parse().unwrap();
        Self { status, head, rest }
    }

    /// Reads a byte a second until it is told to stop; the answer as far as it came then.
    fn slowly(mut self, stop: &Arc<AtomicBool>) -> JoinHandle<Vec<u8>> {
        let stop = Arc::clone(stop);
        std::thread::spawn(move || {
            let (mut came, mut byte) = (Vec::new(), [0]);
            while !stop.load(Ordering::Relaxed) && matches!(self.rest.read(&mut byte), Ok(1)) {
                came.push(byte[0]);
                std::thread::sleep(Duration::from_secs(1));
            }
            // A connection that was cut off may end with a fault.
            let _ = self.rest.read_to_end(&mut came);
            came
        })
    }
}

/// The list as a client without a fault of its own gets it: status, and lines if it is complete.
async fn whole(server: &Server, key: &str) -> (u16, Option<usize>) {
    let client = http().timeout(PATIENCE).build().unwrap();
    let request = client.get(server.address(LIST)).bearer_auth(key);
    let answer = request.send().await.unwrap();
    let status = answer.status().as_u16();
    (status, answer.text().await.ok().map(|t| t.lines().count()))
}

#[tokio::test(flavor = "multi_thread")]
async fn two_slow_readers_keep_nobody_from_long_lists() {
    let (server, [slow, other]) = Server::with_keys([&[], &[]], &["--workers", "0"]);
    season::write(&server, 40, 2000).await;
    let rows = server.count("SELECT COUNT(*) FROM parameter").await as usize;
    assert!(rows > 10_000, "{rows}");
    let stop = Arc::new(AtomicBool::new(false));
    let mut readers: Vec<_> = (0..2).map(|_| Begun::new(&server, LIST, &slow)).collect();
    assert!(readers.iter().all(|reader| reader.status == 200));
    let complete = (200, Some(rows + 1));
    assert_eq!(whole(&server, &other).await, complete, "beside two");

    // Two more have a place beside them; who comes then is sent away, and told for how long.
    readers.extend((0..6).map(|_| Begun::new(&server, LIST, &slow)));
    let (taken, refused): (Vec<_>, Vec<_>) = readers.into_iter().partition(|r| r.status == 200);
    assert_eq!(taken.len(), 4);
    for reader in &refused {
        assert_eq!(reader.status, 429, "{}", reader.head);
        assert!(reader.head.contains("retry-after: "), "{}", reader.head);
    }
    let threads: Vec<_> = taken.into_iter().map(|r| r.slowly(&stop)).collect();
    assert_eq!(whole(&server, &other).await, complete, "beside eight");
    let short = server.address("/v1/parameters?limit=1000");
    let short = http().build().unwrap().get(short).bearer_auth(&slow);
    assert_eq!(short.send().await.unwrap().status(), 200, "short lists");

    stop.store(true, Ordering::Relaxed);
    for thread in threads {
        let came = String::from_utf8_lossy(&thread.join().unwrap()).into_owned();
        assert!(came.ends_with("\r\n0\r\n\r\n") || came.is_empty());
    }
    assert_eq!(
        whole(&server, &slow).await,
        complete,
        "their places are free"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn who_takes_too_little_of_an_answer_is_cut_off_and_who_only_listens_is_not() {
    let args = ["--workers", "0", "--answer-timeout", "1"];
    let server = Server::with(&args);
    season::write(&server, 40, 2000).await;
    let job = server.submit(&[]).await;
    let mut events = Begun::new(&server, &format!("{job}/events"), "");
    assert_eq!(events.status, 200);
    let stop = Arc::new(AtomicBool::new(false));
    let readers: Vec<_> = (0..2)
        .map(|_| Begun::new(&server, LIST, "").slowly(&stop))
        .collect();
    let held = server.json(&format!("{job}?wait=3")).await;
    assert_eq!(held["state"], "queued");
    while !server
        .get("/metrics")
        .await
        .text()
        .await
        .unwrap()
        .contains("veloid_answers_cut_total 2")
    {
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
    stop.store(true, Ordering::Relaxed);
    for reader in readers {
        let came = reader.join().unwrap();
        assert!(!came.ends_with(b"\r\n0\r\n\r\n"), "not complete");
    }
    // The job ends, and who listened all the time hears of it.
    assert_eq!(server.cancel(&job).await.unwrap().status(), 200);
    let mut reported = String::new();
    while !reported.contains("cancelled") {
        assert!(
            events.rest.read_line(&mut reported).unwrap() > 0,
            "{reported}"
        );
    }
}

/// The table is taken away while its list is being sent.
#[tokio::test(flavor = "multi_thread")]
async fn a_list_that_breaks_off_does_not_look_complete() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 40, 2000).await;
    let mut formats = vec!["json", "csv"];
    if has("parquet") {
        formats.push("parquet");
    }
    for format in formats {
        let address = server.address(&format!("/v1/parameters?limit=100000&format={format}"));
        for encoding in ["identity", "gzip"] {
            let client = http().timeout(PATIENCE).build().unwrap();
            let request = client.get(&address).header("Accept-Encoding", encoding);
            let answer = request.send().await.unwrap();
            assert_eq!(answer.status(), 200);
            server
                .execute("ALTER TABLE parameter RENAME TO taken_away")
                .await;
            let came = answer.bytes().await;
            assert!(
                came.is_err(),
                "{format}, {encoding}: {:?}",
                came.map(|b| b.len())
            );
            server
                .execute("ALTER TABLE taken_away RENAME TO parameter")
                .await;
        }
    }
}

/// What is streamed is what pages of a thousand say together.
#[tokio::test]
async fn a_long_list_is_one_document_and_goes_on_where_it_ends() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 40, 200).await;
    let all = server.json("/v1/parameters?limit=100000").await;
    assert!(all["next"].is_null());
    let all = all["items"].as_array().unwrap();
    assert!(all.len() > 3000, "{}", all.len());
    let (mut paged, mut path) = (Vec::new(), "/v1/parameters?limit=1500".to_owned());
    loop {
        let response = server.get(&path).await;
        let link = response.headers().get("link").cloned();
        let page: serde_json::Value = response.json().await.unwrap();
        let items = page["items"].as_array().unwrap();
        paged.extend(items.iter().cloned());
        assert_eq!(page["next"].is_string(), link.is_some());
        let Some(link) = link else { break };
        assert_eq!(items.len(), 1500);
        let link = link.to_str().unwrap();
        path = link[1..link.find('>').unwrap()].to_owned();
    }
    assert_eq!(&paged, all);
    let exact = format!("/v1/parameters?limit={}", all.len());
    assert!(server.json(&exact).await["next"].is_null());
}
