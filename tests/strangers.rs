//! What strangers may do to a server without asking for anything sensible: hold connections open, send slowly,
//! send forms that are no forms. Others are served meanwhile, and memory stays where it was.

use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;

use serde_json::Value;

use crate::harness::{Server, nothing_is_kept, raw_files};
use crate::ride;

/// Whoever waits for an answer for so long gets none.
const PATIENCE: Duration = Duration::from_secs(60);

fn address(server: &Server) -> SocketAddr {
    let address = server.url.trim_start_matches("http://");
    address.parse().unwrap()
}

fn connect(server: &Server) -> TcpStream {
    let stream = TcpStream::connect(address(server)).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream
}

/// What comes until the other side closes.
fn rest(mut stream: TcpStream) -> String {
    let mut bytes = Vec::new();
    match stream.read_to_end(&mut bytes) {
        Ok(_) => {}
        Err(error) if error.kind() == ErrorKind::ConnectionReset => {}
        Err(error) => panic!("{error}"),
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[tokio::test]
async fn half_open_requests_keep_nobody_out() {
    let server = Server::with(&["--connections", "100", "--header-timeout", "600"]);
    for sent in [
        "",
        "GET /healthz HT",
        "GET /healthz HTTP/1.1\r\nHost: x\r\nX-A: ",
    ] {
        let mut held: Vec<_> = (0..150).map(|_| connect(&server)).collect();
        for stream in &mut held {
            // Those that made room may be gone.
            let _ = stream.write_all(sent.as_bytes());
        }
        // A client of its own has no connection yet.
        let client = crate::harness::http().timeout(PATIENCE).build().unwrap();
        let answer = client.get(server.address("/healthz")).send().await;
        assert_eq!(answer.unwrap().status(), 200, "beside 150 times '{sent}'");
        // Half of all is for one address; who has to go takes a moment.
        let open = || held.iter().filter(|stream| is_open(stream)).count();
        while open() > 50 {
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        assert!(open() >= 40, "{}: only as many went as had to", open());
    }
}

fn is_open(mut stream: &TcpStream) -> bool {
    stream.set_nonblocking(true).unwrap();
    match stream.read(&mut [0]) {
        Err(error) => error.kind() == ErrorKind::WouldBlock,
        Ok(read) => read > 0,
    }
}

#[tokio::test]
async fn requests_that_do_not_come_end() {
    let server = Server::with(&["--header-timeout", "1", "--body-timeout", "1"]);
    for sent in ["", "GET /healthz HTTP/1.1\r\nHost: x\r\n"] {
        let mut stream = connect(&server);
        stream.write_all(sent.as_bytes()).unwrap();
        assert_eq!(rest(stream), "", "after '{sent}'");
    }
    for path in ["/v1/rides", "/v1/rides/preview"] {
        let mut stream = connect(&server);
        write!(
            stream,
            "POST {path} HTTP/1.1\r\nHost: x\r\nContent-Length: 1000\r\n\r\nt,u_f"
        )
        .unwrap();
        let answer = rest(stream);
        assert!(answer.starts_with("HTTP/1.1 408"), "{path}: {answer}");
        assert!(answer.contains("urn:veloid:problem:too-slow"), "{answer}");
        assert!(
            answer.contains("no more of the request arrived for 1 s"),
            "{answer}"
        );
    }
    let mut stream = connect(&server);
    write!(
        stream,
        "POST /v1/rides HTTP/1.1\r\nHost: x\r\nContent-Length: 100000\r\n\r\n"
    )
    .unwrap();
    // Always something, never enough.
    while stream.write_all(b"1").is_ok() {
        std::thread::sleep(Duration::from_millis(100));
        stream.set_nonblocking(true).unwrap();
        let mut answer = [0; 12];
        if stream.peek(&mut answer).is_ok_and(|bytes| bytes == 12) {
            assert_eq!(&answer, b"HTTP/1.1 408");
            break;
        }
        stream.set_nonblocking(false).unwrap();
    }
    nothing_is_kept(&server);
}

#[tokio::test]
async fn a_slow_upload_of_an_honest_client_is_taken() {
    let server = Server::with(&["--body-timeout", "3", "--body-rate", "100"]);
    let file = ride::example();
    let pieces: Vec<Vec<u8>> = file.chunks(file.len() / 20).map(<[u8]>::to_vec).collect();
    // Four seconds.
    let slow = futures_util::StreamExt::then(futures_util::stream::iter(pieces), async |piece| {
        tokio::time::sleep(Duration::from_millis(200)).await;
        Ok::<_, std::io::Error>(piece)
    });
    let body = reqwest::Body::wrap_stream(Box::pin(slow));
    let request = server.client.post(server.address("/v1/rides"));
    let request = request
        .header("Veloid-Bike", ride::BIKE.replace('\n', ""))
        .body(body);
    let response = request.send().await.unwrap();
    assert_eq!(response.status(), 202, "{}", response.text().await.unwrap());
}

/// Most memory that the process ever had (kB).
fn peak_kb(server: &Server) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", server.id())).unwrap();
    let line = status
        .lines()
        .find(|line| line.starts_with("VmHWM"))
        .unwrap();
    line.split_whitespace().nth(1).unwrap().parse().unwrap()
}

const PART: &str = "--B\r\nContent-Disposition: form-data; name=\"";

/// Forms that go on for ever: how they begin, what is repeated, status and what the problem says.
fn endless() -> [(String, String, u16, &'static str); 6] {
    let block = "x".repeat(1 << 16);
    [
        (
            String::new(),
            block.clone(),
            400,
            "65536 bytes without a part",
        ),
        (
            format!("{PART}file\"\r\nX: "),
            block.clone(),
            400,
            "65536 bytes without a part",
        ),
        (
            format!("{PART}zzz\"\r\n\r\n"),
            block.clone(),
            422,
            "unknown part `zzz`, expected `file`, `bike`",
        ),
        (
            format!("{PART}bike\"\r\n\r\n"),
            block.clone(),
            413,
            "part `bike` is larger than 65536 bytes",
        ),
        (
            String::new(),
            format!("{PART}map\"\r\n\r\nz_f=1\r\n"),
            413,
            "more than 128 parts",
        ),
        (
            format!("{PART}{block}{block}\"\r\n\r\n"),
            block,
            400,
            "65536 bytes without a part",
        ),
    ]
}

#[tokio::test]
async fn forms_that_never_end_take_no_memory() {
    const SIZE: usize = 200 << 20;
    let server = Server::start();
    server.get("/").await;
    let before = peak_kb(&server);
    for path in ["/v1/rides", "/v1/rides/preview"] {
        for (head, block, status, says) in endless() {
            let mut stream = connect(&server);
            write!(
                stream,
                "POST {path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\nContent-Length: {SIZE}\r\n\
                 Content-Type: multipart/form-data; boundary=B\r\n\r\n{head}"
            )
            .unwrap();
            let block = block.repeat((1 << 20) / block.len());
            let mut left = SIZE - head.len();
            while left > 0 {
                let piece = &block.as_bytes()[..block.len().min(left)];
                // Whoever goes on after the answer may be cut off.
                if stream.write_all(piece).is_err() {
                    break;
                }
                left -= piece.len();
            }
            let answer = rest(stream);
            let expected = format!("HTTP/1.1 {status}");
            assert!(answer.starts_with(&expected), "{path}, {says}: {answer}");
            assert!(answer.contains(says), "{path}, {says}: {answer}");
        }
    }
    let grown = peak_kb(&server).saturating_sub(before) >> 10;
    eprintln!("forms of 200 MiB without an end took {grown} MiB");
    assert!(grown < 64, "{grown} MiB");
    nothing_is_kept(&server);
}

#[tokio::test]
async fn an_upload_that_finds_the_queue_full_leaves_no_file() {
    let server = Server::with(&["--queue", "1", "--workers", "0"]);
    let first = server.upload(ride::example(), ride::BIKE, &[]).await;
    assert_eq!(first.status(), 202);
    let other = || ride::table(400, 200.0).into_bytes();
    for _ in 0..3 {
        let refused = server.upload(other(), ride::BIKE, &[]).await;
        assert_eq!(refused.status(), 503);
        let problem: Value = refused.json().await.unwrap();
        assert_eq!(problem["type"], "urn:veloid:problem:unavailable");
    }
    let again = server.upload(ride::example(), ride::BIKE, &[]).await;
    assert_eq!(again.status(), 202, "what is queued already needs no place");
    assert_eq!(raw_files(&server.folder.0).len(), 1);
    let incoming = std::fs::read_dir(server.folder.0.join("incoming")).unwrap();
    assert_eq!(incoming.count(), 0);
}

/// What a request gets, to the end of the connection.
fn answer(server: &Server, request: &str) -> String {
    let mut stream = connect(server);
    stream.write_all(request.as_bytes()).unwrap();
    rest(stream)
}

#[tokio::test]
async fn a_request_names_one_server() {
    let server = Server::with(&["--workers", "0"]);
    let (one, two) = ("Host: x\r\n", "Host: x\r\nHost: x\r\n");
    for (version, hosts, status) in [
        ("1.1", "", 400),
        ("1.1", two, 400),
        ("1.0", two, 400),
        ("1.1", one, 200),
        ("1.0", "", 200),
    ] {
        let head = format!("{hosts}Accept: text/html\r\nConnection: close\r\n\r\n");
        let said = answer(&server, &format!("GET /healthz HTTP/{version}\r\n{head}"));
        assert!(said.contains(&format!(" {status} ")), "{hosts}: {said}");
        assert_eq!(status == 400, said.contains("application/problem+json"));
    }
}

/// Streams of events take every connection that an address has.
#[tokio::test]
async fn an_address_that_waits_for_answers_still_learns_whether_the_server_lives() {
    let server = Server::with(&["--workers", "0", "--connections-per-address", "4"]);
    let job = server.submit(&[]).await;
    let events: Vec<_> = (0..4)
        .map(|_| {
            let mut stream = connect(&server);
            write!(stream, "GET {job}/events HTTP/1.1\r\nHost: x\r\n\r\n").unwrap();
            assert!(stream.read(&mut [0; 12]).unwrap() > 0);
            stream
        })
        .collect();
    let get = |path| {
        let request = format!("GET {path} HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
        answer(&server, &request)
    };
    for _ in 0..10 {
        for path in ["/healthz", "/readyz"] {
            assert!(get(path).starts_with("HTTP/1.1 200"), "{path}");
        }
        let refused = get("/v1/jobs");
        assert!(refused.starts_with("HTTP/1.1 503"), "{refused}");
        assert!(refused.contains("retry-after: "), "{refused}");
    }
    assert!(events.iter().all(is_open), "nobody had to go");
    drop(events);
    while !get("/v1/jobs").starts_with("HTTP/1.1 200") {}
}
