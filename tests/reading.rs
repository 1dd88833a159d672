//! Whatever a file does to the process that reads it, the server lives, answers in a line and takes no memory for it.

use std::path::Path;
use std::time::Instant;

use bytes::Bytes;
use reqwest::{Response, StatusCode};
use serde_json::Value;

use crate::built::has;
use crate::harness::{Server, has_points};
use crate::skips::not_applicable;
use crate::{ride, workbook};

/// Most that the server's own memory may grow (kB) by files that others send, whatever they hold: the pieces in which they come,
/// what is told of them, and what an allocator keeps.
const GROWTH: u64 = 48 << 10;

/// The most memory that the server itself had (kB).
fn peak(server: &Server) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", server.id())).unwrap();
    let mark = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    mark.unwrap()
        .trim()
        .trim_end_matches(" kB")
        .parse()
        .unwrap()
}

fn has_no_proc() -> bool {
    let absent = !Path::new("/proc/self/status").exists();
    if absent {
        not_applicable("no /proc to read the memory of a process from");
    }
    absent
}

async fn send(server: &Server, path: &str, file: impl Into<reqwest::Body>) -> Response {
    let request = server.client.post(server.address(path));
    request.body(file).send().await.unwrap()
}

/// Status, and the problem's detail.
async fn refused(response: Response) -> (StatusCode, String) {
    let status = response.status();
    let problem: Value = response.json().await.unwrap();
    (
        status,
        problem["detail"].as_str().unwrap_or_default().to_owned(),
    )
}

/// Once 60 kB took 290 MB of the server, 3 kB of fonts 3.5 GB, and a count of strings in 1 kB ended it.
#[tokio::test]
async fn a_spreadsheet_with_a_huge_text_takes_no_memory_of_the_server() {
    if has_no_proc() || !has("spreadsheets") {
        return;
    }
    let mut server = Server::with(&["--workers", "0"]);
    let sound = workbook::of_table(&ride::table(200, 200.0));
    assert_eq!(
        send(&server, "/v1/rides/preview", sound).await.status(),
        200
    );
    let before = peak(&server);
    let files = [
        (workbook::one_text(60_000_000), "32767 characters"),
        (
            workbook::promised_strings(10_000_000_000_000),
            "shared strings",
        ),
        (workbook::long_fonts(60_000), "no row of numbers"),
    ];
    for (file, why) in files {
        let preview = send(&server, "/v1/rides/preview", file.clone()).await;
        let upload = server.upload(file, ride::BIKE, &[]).await;
        let (status, detail) = refused(upload).await;
        assert_eq!(status, 422, "{detail}");
        assert!(detail.contains(why), "{detail}");
        // A sheet that is a table of text is shown with what is in the way.
        let text = preview.text().await.unwrap();
        assert!(text.contains(why), "{text}");
    }
    let grown = peak(&server) - before;
    eprintln!("from {before} kB by {grown} kB");
    assert!(grown < GROWTH, "{grown} kB");
    assert!(server.is_there());
}

/// Once a workbook of 40 million numbers kept a reader for 40 s.
#[tokio::test]
async fn a_workbook_of_too_many_cells_is_refused_before_the_rest_is_read() {
    if !has("spreadsheets") {
        return;
    }
    let server = Server::with(&["--workers", "0"]);
    let cases = [
        (1_000_000, "is damaged"),
        (3_000_000, "cells in the workbook"),
    ];
    for (cells, why) in cases {
        let file = workbook::malformed_after(cells);
        let (status, detail) = refused(send(&server, "/v1/rides/preview", file).await).await;
        assert_eq!(status, 422, "{detail}");
        assert!(detail.contains(why), "{cells} cells: {detail}");
    }
}

/// Once four previews of 144 MB took a server from 56 to 504 MB.
#[tokio::test]
async fn large_files_take_no_memory_of_the_server() {
    if has_no_proc() {
        return;
    }
    let server = Server::with(&["--workers", "0"]);
    // More than is kept at hand of an upload.
    let table = ride::table(600_000, 200.0);
    let file = Bytes::from(table);
    let small = Bytes::from(ride::table(200, 200.0));
    assert_eq!(
        send(&server, "/v1/rides/preview", small).await.status(),
        200
    );
    let before = peak(&server);
    let preview = || send(&server, "/v1/rides/preview", file.clone());
    let all = futures_util::future::join_all([preview(), preview(), preview(), preview()]).await;
    for response in all {
        let preview: Value = response.json().await.unwrap();
        assert_eq!(preview["rows"], 600_000, "{preview:#}");
    }
    let upload = server.upload(file.to_vec(), ride::BIKE, &ride::QUICK).await;
    assert_eq!(upload.status(), 202);
    let grown = peak(&server) - before;
    eprintln!(
        "five of {} MB: from {before} kB by {grown} kB",
        file.len() / 1_000_000
    );
    assert!(grown < GROWTH, "{grown} kB");
}

/// What reading does, of which it is asked, and the answer.
const POISON: [(&str, &str, u64, u16, &str); 6] = [
    ("abort", "read", 107, 422, "SIGABRT"),
    ("memory", "read", 108, 413, "more memory than the 0.2 GB"),
    ("kill", "read", 109, 503, "from outside"),
    ("stack", "preview", 110, 422, "stack overflow"),
    ("loop", "preview", 111, 422, "longer than the 5 s allowed"),
    ("abort", "series", 112, 422, "SIGABRT"),
];

#[tokio::test]
async fn a_reader_that_breaks_down_takes_nobody_with_it() {
    if !has_points() {
        return;
    }
    let orders = POISON.map(|(kind, stage, seed, ..)| format!("{kind}:{stage}:{seed}"));
    let args = ["--read-timeout", "5", "--memory-budget", "200000000"];
    let mut server = Server::with_env(&args, &[("VELOID_POISON", &orders.join(","))]);
    let before = server.submit(&[("seed", "1")]).await;
    for (kind, stage, seed, expected, why) in POISON {
        let seed = seed.to_string();
        let parts = [&ride::QUICK[..], &[("seed", &seed)]].concat();
        let answer = match stage {
            "read" => server.upload(ride::example(), ride::BIKE, &parts).await,
            "preview" => {
                let path = format!("/v1/rides/preview?seed={seed}");
                send(&server, &path, ride::example()).await
            }
            _ => {
                let job = server.submit(&parts).await;
                server.succeeded(&job).await;
                server.get(&format!("{job}/series")).await
            }
        };
        let again = answer.headers().contains_key("retry-after");
        let (status, detail) = refused(answer).await;
        assert_eq!(status, expected, "{kind} {stage}: {detail}");
        assert!(detail.contains(why), "{kind} {stage}: {detail}");
        assert_eq!(again, status == 503, "{kind} {stage}");
    }
    assert!(server.is_there());
    server.succeeded(&before).await;
    assert_eq!(server.get(&format!("{before}/series")).await.status(), 200);
    let after = server.submit(&[("seed", "2")]).await;
    server.succeeded(&after).await;
    let arriving = server.folder.0.join("incoming").read_dir().unwrap();
    assert_eq!(arriving.count(), 0, "what is refused is not kept");
}

/// What a small upload costs beside one that is read in the server itself; printed, not judged: a machine that tests share
/// measures nothing. `cargo test --workspace --test blackbox reading::what -- --ignored --nocapture`
#[tokio::test]
#[ignore = "a measurement"]
async fn what_a_child_costs_a_preview() {
    let servers = [&["--isolate", "off"][..], &[]].map(|args| {
        let args = [&["--workers", "0"], args].concat();
        Server::with(&args)
    });
    let file = Bytes::from(ride::example());
    let mut times = [Vec::new(), Vec::new()];
    for _ in 0..200 {
        for (server, times) in servers.iter().zip(&mut times) {
            let begun = Instant::now();
            let answer = send(server, "/v1/rides/preview", file.clone()).await;
            assert_eq!(answer.status(), 200);
            answer.bytes().await.unwrap();
            times.push(begun.elapsed().as_secs_f64() * 1e3);
        }
    }
    let [here, child] = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    });
    eprintln!(
        "a preview of {} kB: {here:.2} ms here, {child:.2} ms in a child, {:.2} times as long",
        file.len() / 1000,
        child / here
    );
}
