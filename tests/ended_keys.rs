//! Requests that are under way when their key ends. Nothing more comes of them.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use reqwest::RequestBuilder;
use serde_json::Value;

use crate::doors::{cookie, sign_in};
use crate::harness::{Server, http};
use crate::ride;
use crate::season;
use crate::slow_readers::Begun;

/// What goes on for so long goes on.
const PATIENCE: Duration = Duration::from_secs(60);

/// The first word of the line about a key or a session.
fn id(server: &Server, list: &str, name: &str) -> String {
    let list = server.beside(&["key", list]).output().unwrap();
    let list = String::from_utf8(list.stdout).unwrap();
    let line = list.lines().find(|line| line.contains(name)).unwrap();
    line.split(' ').next().unwrap().to_owned()
}

fn end(server: &Server, how: &str, id: &str) {
    let ended = server.beside(&["key", how, id]).status().unwrap();
    assert!(ended.success());
}

fn wait(server: &Server, job: &str) -> RequestBuilder {
    let client = http().build().unwrap();
    client.get(server.address(&format!("{job}?wait=60")))
}

/// Reads the rest of an answer at 2 MB/s, so that whatever is whole took its time; its length.
fn rest(mut answer: Begun) -> usize {
    let (mut came, mut piece) = (0, vec![0; 1 << 16]);
    loop {
        match answer.rest.get_mut().read(&mut piece) {
            Ok(0) | Err(_) => return came,
            Ok(read) => came += read,
        }
        std::thread::sleep(Duration::from_millis(30));
    }
}

#[tokio::test]
#[ignore = "slow"]
async fn compressed_answers_to_a_key_are_whole() {
    let (mut server, [owner]) = Server::with_keys([&[]], &["--workers", "0"]);
    server.as_seen_by(&owner);
    let job = server.upload(
        ride::table(20_000, 200.0).into_bytes(),
        ride::BIKE,
        &ride::QUICK,
    );
    let job = job.await.headers()["location"].to_str().unwrap().to_owned();
    let view = server.json(&job).await;
    let ride = view["ride"]["id"].as_str().unwrap();
    season::write(&server, 40, 2000).await;
    for path in [
        format!("/v1/rides/{ride}/file"),
        "/v1/parameters?limit=100000&format=csv".to_owned(),
    ] {
        for coding in ["identity", "gzip", "zstd"] {
            let request = http().build().unwrap().get(server.address(&path));
            let request = request
                .bearer_auth(&owner)
                .header("Accept-Encoding", coding);
            let answer = request.send().await.unwrap().bytes().await;
            assert!(
                answer.is_ok_and(|body| body.len() > 1000),
                "{path} {coding}"
            );
        }
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn all_that_waits_or_streams_ends_with_its_key() {
    let (mut server, [owner, listener]) =
        Server::with_keys([&[], &["--name", "listener"]], &["--workers", "0"]);
    server.as_seen_by(&owner);
    let long = ride::table(300_000, 200.0).into_bytes();
    let size = long.len();
    let job = server.upload(long, ride::BIKE, &ride::QUICK).await;
    let job = job.headers()["location"].to_str().unwrap().to_owned();
    let response = server.get(&job).await;
    let tag = response.headers()["etag"].clone();
    let view: Value = response.json().await.unwrap();
    let ride = view["ride"]["id"].as_str().unwrap();
    season::write(&server, 40, 2000).await;
    let list = "/v1/parameters?limit=100000&format=csv";
    let whole = server.get(list).await.text().await.unwrap().len();

    let streams = [
        (format!("{job}/events"), None),
        (format!("/v1/rides/{ride}/file"), Some(size)),
        (list.to_owned(), Some(whole)),
    ];
    let streams: Vec<_> = streams
        .into_iter()
        .map(|(path, whole)| (Begun::new(&server, &path, &listener), path, whole))
        .collect();
    let mut upload = TcpStream::connect(server.url.trim_start_matches("http://")).unwrap();
    upload.set_read_timeout(Some(PATIENCE)).unwrap();
    write!(
        upload,
        "POST /v1/rides?bike=lab-7 HTTP/1.1\r\nHost: x\r\nAuthorization: Bearer {listener}\r\n\
         Content-Type: text/csv\r\nContent-Length: 100000\r\n\r\nt,u_f,u_r,z_f,z_r\n"
    )
    .unwrap();
    let wait = wait(&server, &job).bearer_auth(&listener);
    let tagged = wait.try_clone().unwrap().header("If-None-Match", tag);
    let waits = [wait, tagged].map(|request| tokio::spawn(request.send()));
    tokio::time::sleep(Duration::from_millis(500)).await;
    end(&server, "revoke", &id(&server, "list", "listener"));

    for wait in waits {
        let answer = wait.await.unwrap().unwrap();
        assert_eq!(answer.status(), 401);
        let problem: Value = answer.json().await.unwrap();
        assert_eq!(problem["type"], "urn:veloid:problem:unauthorized");
    }
    let mut status = [0; 12];
    upload.read_exact(&mut status).unwrap();
    assert_eq!(&status, b"HTTP/1.1 401", "an upload");
    for (answer, path, whole) in streams {
        assert_eq!(answer.status, 200, "{path}");
        let came = tokio::task::spawn_blocking(|| rest(answer));
        let came = tokio::time::timeout(PATIENCE, came).await;
        let came = came.unwrap_or_else(|_| panic!("{path} goes on")).unwrap();
        assert!(
            whole.is_none_or(|whole| came < whole),
            "{path}: {came} bytes"
        );
    }
    assert_eq!(
        server.json(&job).await["state"],
        "queued",
        "it was not the job's end"
    );
}

#[tokio::test]
async fn a_wait_ends_when_the_key_expires_or_the_session_is_ended() {
    let keys: [&[&str]; 2] = [&[], &["--name", "short", "--days", "1"]];
    let (mut server, [owner, short]) = Server::with_keys(keys, &["--workers", "0"]);
    server.as_seen_by(&owner);
    let job = server.submit(&[]).await;
    let session = cookie(&sign_in(&server, &owner, &[("Origin", &server.url)]).await);
    let waits = [
        wait(&server, &job).bearer_auth(&short),
        wait(&server, &job).header("Cookie", session),
    ];
    let waits = waits.map(|request| tokio::spawn(request.send()));
    tokio::time::sleep(Duration::from_millis(500)).await;
    server
        .execute("UPDATE api_key SET expires_at = 1 WHERE name = 'short'")
        .await;
    let lines = server.beside(&["key", "sessions"]).output().unwrap();
    let lines = String::from_utf8(lines.stdout).unwrap();
    let row = lines.lines().nth(1).unwrap();
    end(&server, "end", row.split(' ').next().unwrap());
    for wait in waits {
        assert_eq!(wait.await.unwrap().unwrap().status(), 401);
    }
}
