//! What browsers are let do, and how they sign in.

use reqwest::{Client, Response, StatusCode, redirect};

use crate::harness::{Server, http};
use crate::ride;
use crate::season;

fn browser() -> Client {
    http().redirect(redirect::Policy::none()).build().unwrap()
}

/// The server's own origin, as a browser on plain HTTP says it.
fn own(server: &Server) -> String {
    server.url.clone()
}

pub async fn sign_in(server: &Server, key: &str, headers: &[(&str, &str)]) -> Response {
    let request = browser().post(server.address("/sign-in"));
    let request = request.header("Content-Type", "application/x-www-form-urlencoded");
    let request = headers
        .iter()
        .fold(request, |r, (name, value)| r.header(*name, *value));
    request.body(format!("key={key}")).send().await.unwrap()
}

pub fn cookie(response: &Response) -> String {
    let cookie = response.headers()["set-cookie"].to_str().unwrap();
    cookie.split(';').next().unwrap().to_owned()
}

async fn jobs(server: &Server, cookie: &str) -> StatusCode {
    let request = browser()
        .get(server.address("/v1/jobs"))
        .header("Cookie", cookie);
    request.send().await.unwrap().status()
}

/// On plain HTTP to an address of the LAN browsers send `Origin` and no `Sec-Fetch-Site`.
#[tokio::test]
async fn forms_of_other_sites_are_refused_by_their_origin() {
    let (server, [key]) = Server::with_keys([&[]], &[]);
    let own = own(&server);
    for origin in ["http://evil.example", "null", "http://127.0.0.1:1"] {
        let refused = sign_in(&server, &key, &[("Origin", origin)]).await;
        assert_eq!(refused.status(), 403, "sign-in by a page of {origin}");
        assert!(!refused.headers().contains_key("set-cookie"));
    }
    let cookie = cookie(&sign_in(&server, &key, &[("Origin", &own)]).await);
    let post = async |origin: Option<&str>| {
        let request = browser()
            .post(server.address("/v1/rides"))
            .header("Cookie", &cookie);
        let request = match origin {
            Some(origin) => request.header("Origin", origin),
            None => request,
        };
        request.body("t").send().await.unwrap().status()
    };
    assert_eq!(post(Some("http://evil.example")).await, 403);
    assert_eq!(post(None).await, 403, "no browser leaves out both");
    assert_eq!(post(Some(&own)).await, 422, "no ride, but heard");
}

/// Only `same-origin` and `none` are accepted as `Sec-Fetch-Site`, whatever `Origin` says.
#[tokio::test]
async fn forms_of_other_sites_are_refused_by_what_browsers_say_of_them() {
    let (server, [key]) = Server::with_keys([&[]], &[]);
    let own = own(&server);
    let cookie = cookie(&sign_in(&server, &key, &[("Origin", &own)]).await);
    let post = async |site: &str| {
        let request = browser().post(server.address("/v1/rides"));
        let request = request.header("Cookie", &cookie).header("Origin", &own);
        let request = request.header("Sec-Fetch-Site", site).body("t");
        request.send().await.unwrap().status()
    };
    for site in ["same-origin", "none"] {
        assert_eq!(post(site).await, 422, "{site}: no ride, but heard");
    }
    for site in [
        "cross-site",
        "same-site",
        "",
        "null",
        "other",
        "Cross-Site",
        "same-origin, cross-site",
        "cross-origin",
        "same-origin;x",
    ] {
        assert_eq!(post(site).await, 403, "{site}");
    }
}

/// A cookie is no key: it ends at sign-out, at the next sign-in, by the operator and with its key.
#[tokio::test]
async fn sessions_are_apart_from_keys_and_end() {
    let (server, [key, other]) = Server::with_keys([&[], &[]], &[]);
    let own = own(&server);
    let begin = async |key: &str, before: &str| {
        let headers = [("Origin", own.as_str()), ("Cookie", before)];
        cookie(&sign_in(&server, key, &headers).await)
    };
    let first = begin(&key, "").await;
    assert!(!first.contains(&key));
    assert_eq!(jobs(&server, &first).await, 200);
    let as_key = first.split_once('=').unwrap().1;
    let request = browser()
        .get(server.address("/v1/jobs"))
        .bearer_auth(as_key);
    assert_eq!(
        request.send().await.unwrap().status(),
        401,
        "nor is a session a key"
    );

    let second = begin(&key, &first).await;
    assert_eq!(jobs(&server, &first).await, 401, "rotated at sign-in");
    let out = browser()
        .post(server.address("/sign-out"))
        .header("Cookie", &second);
    out.header("Origin", &own).send().await.unwrap();
    assert_eq!(jobs(&server, &second).await, 401, "signed out");

    let (third, fourth) = (begin(&key, "").await, begin(&other, "").await);
    let run = |args: &[&str]| {
        let output = server.beside(args).output().unwrap();
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let listed = run(&["key", "sessions"]);
    let rows: Vec<Vec<&str>> = listed
        .lines()
        .skip(1)
        .map(|l| l.split_whitespace().collect())
        .collect();
    assert_eq!(rows.len(), 2, "{listed}");
    run(&["key", "end", rows[0][0]]);
    assert_eq!(jobs(&server, &third).await, 401, "ended by the operator");
    assert_eq!(jobs(&server, &fourth).await, 200);
    run(&["key", "revoke", rows[1][1]]);
    assert_eq!(jobs(&server, &fourth).await, 401, "ended with its key");
}

#[tokio::test]
async fn who_guesses_keys_has_to_wait() {
    let (server, [key]) = Server::with_keys([&[]], &[]);
    let mut refused = Vec::new();
    // Ten may come at once, then one a second.
    for _ in 0..30 {
        refused.push(sign_in(&server, "veloid_00", &[]).await.status().as_u16());
    }
    assert_eq!(refused[0], 401);
    assert!(refused.contains(&429), "{refused:?}");
    let program = browser().get(server.address("/v1/jobs")).bearer_auth(&key);
    assert_eq!(
        program.send().await.unwrap().status(),
        200,
        "keys are heard"
    );
}

#[tokio::test]
async fn an_idempotency_key_is_taken_as_it_is_or_refused() {
    let server = Server::with(&["--workers", "0"]);
    let send = async |key: &[u8]| {
        let form = crate::harness::form(ride::example(), ride::BIKE, &ride::QUICK);
        let request = server
            .client
            .post(server.address("/v1/rides"))
            .multipart(form);
        request
            .header("Idempotency-Key", key)
            .send()
            .await
            .unwrap()
            .status()
    };
    assert_eq!(send("schlüssel".as_bytes()).await, 400);
    assert_eq!(send(&[b'k'; 201]).await, 400);
    assert_eq!(send(b"\"\"").await, 400);
    assert_eq!(send(&[b'k'; 200]).await, 202);
    assert_eq!(server.count("SELECT COUNT(*) FROM job").await, 1);
}

/// The port of a process that says it listens somewhere else is not told; so it is given one.
fn free_port() -> u16 {
    let listener = std::net::TcpListener::bind("0.0.0.0:0").unwrap();
    listener.local_addr().unwrap().port()
}

#[tokio::test]
async fn a_workers_figures_need_a_key_off_loopback() {
    let (server, [admin, reader]) = Server::with_keys(
        [&["--scope", "admin"], &["--scope", "read"]],
        &["--workers", "0"],
    );
    let port = free_port();
    let _worker = server.worker(&["--listen", &format!("0.0.0.0:{port}")]);
    let get = async |path: &str, key: &str| {
        let address = format!("http://127.0.0.1:{port}{path}");
        let request = browser().get(address).bearer_auth(key);
        request
            .send()
            .await
            .map(|response| response.status().as_u16())
    };
    while get("/healthz", "").await.is_err() {}
    assert_eq!(get("/readyz", "").await.unwrap(), 200);
    assert_eq!(get("/metrics", "").await.unwrap(), 401);
    assert_eq!(get("/metrics", &reader).await.unwrap(), 403);
    assert_eq!(get("/metrics", &admin).await.unwrap(), 200);
}

/// Four long lists may be read at a time from here. Who asks for more is put off; who asks for anything else is not.
#[tokio::test(flavor = "multi_thread")]
#[ignore = "slow"]
async fn readers_of_long_lists_starve_nobody() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 40, 2000).await;
    let address = server.address("/v1/parameters?limit=100000&format=csv");
    let loops: Vec<_> = (0..16)
        .map(|_| {
            let (client, address) = (browser(), address.clone());
            tokio::spawn(async move {
                loop {
                    let response = client.get(&address).send().await.unwrap();
                    assert!([200, 503].contains(&response.status().as_u16()));
                    let _ = response.bytes().await;
                }
            })
        })
        .collect();
    for _ in 0..20 {
        for path in ["/healthz", "/readyz", "/v1/jobs", "/v1/bikes"] {
            assert_eq!(server.get(path).await.status(), 200, "{path}");
        }
    }
    assert!(loops.iter().all(|reader| !reader.is_finished()));
    loops.iter().for_each(tokio::task::JoinHandle::abort);
}
