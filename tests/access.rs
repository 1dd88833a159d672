//! Who may enter: keys, groups that see nothing of each other, limits, and what browsers are told.

use std::process::Command;

use reqwest::{Method, StatusCode, redirect};
use serde_json::Value;

use crate::harness::{Server, VELOID, http, key_of};
use crate::ride::{self, LONG};

const PAGES: [&str; 5] = [
    "/",
    "/jobs",
    "/bikes",
    "/parameters",
    "/parameters?bike=lab-7",
];
/// Addresses that need no key.
const OPEN: [&str; 5] = ["/healthz", "/readyz", "/openapi.json", "/docs/", "/sign-in"];

/// Addresses for admins.
const ADMIN: [&str; 5] = [
    "/metrics",
    "/v1/audit",
    "/v1/webhooks",
    "/v1/webhooks/{id}",
    "/v1/webhooks/{id}/test",
];

/// Everything that belongs to one job, by the names that the API's document gives its parameters.
struct Belongings {
    job: String,
    ride: String,
    sha256: String,
}

impl Belongings {
    /// Uploads the example as whoever the server's client is.
    async fn new(server: &Server) -> Self {
        let address = server.submit(&[]).await;
        let view = server.succeeded(&address).await;
        let ride = view["ride"]["id"].as_str().unwrap().to_owned();
        let file = server.json(&format!("/v1/rides/{ride}")).await;
        Self {
            job: view["id"].as_str().unwrap().to_owned(),
            sha256: file["sha256"].as_str().unwrap().to_owned(),
            ride,
        }
    }

    fn address(&self, path: &str) -> String {
        let id = if path.starts_with("/v1/rides") {
            &self.ride
        } else {
            &self.job
        };
        path.replace("{id}", id)
            .replace("{bike}", "lab-7")
            .replace("{effect}", "bump_stop")
    }

    fn pages(&self) -> Vec<String> {
        let own = [
            format!("/jobs/{}", self.job),
            "/bikes/lab-7".to_owned(),
            format!("/compare?job={0}&job={0}", self.job),
        ];
        own.into_iter().collect()
    }

    /// Panics when an answer holds anything of it.
    fn unseen(&self, what: &str, text: &str) {
        for secret in [&self.job, &self.ride, &self.sha256, "lab-7", "ride.csv"] {
            assert!(!text.contains(secret), "{what} shows {secret}");
        }
    }
}

/// Method and address pattern of every operation that needs a key.
async fn operations(server: &Server) -> Vec<(Method, String)> {
    let document = server.json("/openapi.json").await;
    let paths = document["paths"].as_object().unwrap();
    let all = paths.iter().flat_map(|(path, item)| {
        let methods = item.as_object().unwrap().keys();
        methods.map(move |method| (method.to_uppercase().parse().unwrap(), path.clone()))
    });
    all.filter(|(_, path)| !OPEN.contains(&path.as_str()))
        .collect()
}

async fn send(server: &Server, method: &Method, address: &str) -> (StatusCode, String) {
    let request = server
        .client
        .request(method.clone(), server.address(address));
    let response = request.send().await.unwrap();
    (response.status(), response.text().await.unwrap())
}

#[tokio::test]
async fn a_group_sees_nothing_of_another() {
    let (mut server, [ours, theirs]) =
        Server::with_keys([&["--group", "ours"], &["--group", "theirs"]], &[]);
    server.as_seen_by(&theirs);
    let belongings = Belongings::new(&server).await;
    let operations = operations(&server).await;
    for (method, path) in &operations {
        if *method == Method::GET && !ADMIN.contains(&path.as_str()) {
            let (status, text) = send(&server, method, &belongings.address(path)).await;
            assert_eq!(status, 200, "{path} for its owner: {text}");
        }
    }
    for page in belongings.pages() {
        assert_eq!(
            server.get(&page).await.status(),
            200,
            "{page} for its owner"
        );
    }

    server.as_seen_by(&ours);
    for (method, path) in &operations {
        let (status, text) = send(&server, method, &belongings.address(path)).await;
        match path.as_str() {
            path if ADMIN.contains(&path) => assert_eq!(status, 403, "{method} {path}: {text}"),
            // The library is everybody's, the rides are not.
            "/v1/fleet/effects/{effect}" => {
                assert_eq!((status, text.as_str()), (StatusCode::OK, "[]"));
            }
            _ if path.contains('{') => assert_eq!(status, 404, "{method} {path}: {text}"),
            _ if method == Method::GET => assert_eq!(status, 200, "{path}: {text}"),
            _ => assert!(
                [400, 422].contains(&status.as_u16()),
                "{method} {path}: {text}"
            ),
        }
        if !path.contains("{bike}") {
            belongings.unseen(path, &text);
        }
    }
    for page in belongings.pages() {
        assert_eq!(server.get(&page).await.status(), 404, "{page}");
    }
    for page in PAGES {
        let (status, text) = send(&server, &Method::GET, page).await;
        assert_eq!(status, 200, "{page}");
        belongings.unseen(
            page,
            &text
                .replace("value=\"lab-7\"", "")
                .replace("bike=lab-7", ""),
        );
    }
    for filter in [
        format!("/v1/jobs?ride={}", belongings.ride),
        format!("/v1/parameters?job={}&format=csv", belongings.job),
    ] {
        let (_, text) = send(&server, &Method::GET, &filter).await;
        belongings.unseen(&filter, &text);
    }
}

#[tokio::test]
async fn equal_uploads_of_two_groups_are_two_jobs() {
    let (mut server, keys) = Server::with_keys([&["--group", "a"], &["--group", "b"]], &[]);
    let mut jobs = Vec::new();
    for key in &keys {
        server.as_seen_by(key);
        let named = server.upload(ride::example(), "lab-7", &ride::QUICK).await;
        assert_eq!(
            named.status(),
            422,
            "the other group's bike is no bike here"
        );
        let query = "bike=%7B%22bike%22:%22lab-7%22,%22mass_front_kg%22:23,%22mass_rear_kg%22:63,\
                     %22l_front_m%22:0.8,%22l_rear_m%22:0.3%7D&trials=1&diagnosis=false";
        let response = server
            .client
            .post(server.address(&format!("/v1/rides?{query}")))
            .header("Idempotency-Key", "same")
            .body(ride::example())
            .send()
            .await
            .unwrap();
        assert_eq!(response.status(), 202);
        let job = response.headers()["location"].to_str().unwrap().to_owned();
        server.succeeded(&job).await;
        assert_eq!(server.json("/v1/bikes/lab-7").await["jobs"], 1);
        jobs.push(job);
    }
    assert_ne!(jobs[0], jobs[1]);
}

#[tokio::test]
async fn without_a_key_only_the_open_addresses_answer() {
    let (server, _) = Server::with_keys([&[]], &[]);
    for (method, path) in operations(&server).await {
        let address = path.replace("{id}", "0192f000-0000-7000-8000-000000000000");
        let request = server
            .client
            .request(method.clone(), server.address(&address));
        let response = request.send().await.unwrap();
        assert_eq!(response.status(), 401, "{method} {path}");
        assert_eq!(response.headers()["www-authenticate"], "Bearer");
        let problem: Value = response.json().await.unwrap();
        assert_eq!(problem["type"], "urn:veloid:problem:unauthorized");
    }
    for path in OPEN {
        assert_eq!(server.get(path).await.status(), 200, "{path}");
    }
    for path in PAGES {
        assert_eq!(server.get(path).await.status(), 401, "{path}");
    }
}

#[tokio::test]
async fn a_key_does_what_its_scopes_say() {
    let (mut server, [read, upload, admin]) = Server::with_keys(
        [
            &["--scope", "read"],
            &["--scope", "upload"],
            &["--scope", "admin"],
        ],
        &[],
    );
    let operations = operations(&server).await;
    for (key, allowed) in [(&read, "read"), (&upload, "upload"), (&admin, "admin")] {
        server.as_seen_by(key);
        for (method, path) in &operations {
            let needed = match path.as_str() {
                path if ADMIN.contains(&path) => "admin",
                // Nothing is stored.
                "/v1/validations" => "read",
                _ if method == Method::GET => "read",
                _ => "upload",
            };
            let (status, _) = send(&server, method, path).await;
            let refused = allowed != "admin" && allowed != needed;
            assert_eq!(status == 403, refused, "{method} {path} with {allowed}");
        }
    }
}

#[tokio::test]
async fn keys_are_listed_end_and_are_never_kept() {
    let (mut server, [key]) = Server::with_keys([&["--name", "logger"]], &[]);
    server.as_seen_by(&key);
    assert_eq!(server.get("/v1/jobs").await.status(), 200);

    let expired = key_of(
        &server
            .beside(&["key", "create", "--days", "1", "--name", "old"])
            .output()
            .unwrap(),
    );
    let end = "UPDATE api_key SET expires_at = created_at WHERE name = 'old' RETURNING expires_at";
    assert!(server.count(end).await > 0);
    let list = || {
        let output = server.beside(&["key", "list"]).output().unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    // The use of a key is noted in the background.
    let used = |line: &&str| line.contains("logger") && line.matches("never").count() == 1;
    let line = loop {
        let list = list();
        assert!(!list.contains(&key[7..]), "a key is shown again");
        if let Some(line) = list.lines().find(used) {
            break line.to_owned();
        }
    };
    assert!(line.contains("  yes"), "{line}");
    let id = line.split(' ').next().unwrap();
    assert!(
        server
            .beside(&["key", "revoke", id])
            .status()
            .unwrap()
            .success()
    );
    assert_eq!(server.get("/v1/jobs").await.status(), 401);
    assert!(
        !server
            .beside(&["key", "revoke", id])
            .status()
            .unwrap()
            .success()
    );
    assert!(list().contains("  revoked"));
    server.as_seen_by(&expired);
    assert_eq!(server.get("/v1/jobs").await.status(), 401);
}

#[tokio::test]
async fn limits_of_a_key_hold() {
    let (mut server, [small, rare, few]) = Server::with_keys(
        [
            &["--max-upload", "1000"],
            &["--requests-per-minute", "1"],
            &["--unfinished-jobs", "1"],
        ],
        &["--workers", "1"],
    );
    server.as_seen_by(&small);
    let response = server
        .upload(ride::example(), ride::BIKE, &ride::QUICK)
        .await;
    assert_eq!(response.status(), 413);

    server.as_seen_by(&rare);
    assert_eq!(server.get("/v1/jobs").await.status(), 200);
    let response = server.get("/v1/jobs").await;
    assert_eq!(response.status(), 429);
    let wait: u32 = response.headers()["retry-after"]
        .to_str()
        .unwrap()
        .parse()
        .unwrap();
    assert!((1..=60).contains(&wait), "{wait} s");
    let problem: Value = response.json().await.unwrap();
    assert_eq!(problem["type"], "urn:veloid:problem:too-many");

    server.as_seen_by(&few);
    let job = server.submit(&LONG).await;
    let parts = [("seed", "2"), ("diagnosis", "false")];
    let response = server.upload(ride::example(), ride::BIKE, &parts).await;
    assert_eq!(response.status(), 429);
    assert!(response.headers().contains_key("retry-after"));
    assert_eq!(
        server.submit(&LONG).await,
        job,
        "what is there already is no new job"
    );
    assert_eq!(server.cancel(&job).await.unwrap().status(), 200);
    server.submit(&[]).await;
}

#[tokio::test]
async fn a_full_queue_puts_uploads_off() {
    let server = Server::with(&["--workers", "0", "--queue", "1"]);
    server.submit(&[]).await;
    let parts = [("seed", "2")];
    let response = server.upload(ride::example(), ride::BIKE, &parts).await;
    assert_eq!(response.status(), 503);
    assert!(response.headers().contains_key("retry-after"));
}

#[tokio::test]
async fn a_browser_signs_in_and_out() {
    let (server, [key]) = Server::with_keys([&[]], &[]);
    let browser = http().redirect(redirect::Policy::none()).build().unwrap();
    let get = async |path: &str, cookie: &str| {
        let request = browser
            .get(server.address(path))
            .header("Accept", "text/html");
        request.header("Cookie", cookie).send().await.unwrap()
    };
    let led = get("/jobs?state=failed", "").await;
    assert_eq!(led.status(), 303);
    assert_eq!(
        led.headers()["location"],
        "/sign-in?next=%2Fjobs%3Fstate%3Dfailed"
    );
    let sign_in = async |key: &str, site: &str| {
        let body = format!("key={key}&next=%2Fjobs");
        let request = browser.post(server.address("/sign-in")).body(body);
        let request = request.header("Content-Type", "application/x-www-form-urlencoded");
        request.header("Sec-Fetch-Site", site).send().await.unwrap()
    };
    assert_eq!(sign_in("veloid_00", "same-origin").await.status(), 401);
    assert_eq!(sign_in(&key, "cross-site").await.status(), 403);
    let signed_in = sign_in(&key, "same-origin").await;
    assert_eq!(signed_in.status(), 303);
    assert_eq!(signed_in.headers()["location"], "/jobs");
    let cookie = signed_in.headers()["set-cookie"].to_str().unwrap();
    for part in ["HttpOnly", "SameSite=Strict", "Path=/"] {
        assert!(cookie.contains(part), "{cookie}");
    }
    let cookie = cookie.split(';').next().unwrap();
    assert_eq!(get("/jobs", cookie).await.status(), 200);

    for (method, path) in operations(&server).await {
        if method == Method::GET {
            continue;
        }
        let request = browser.request(method.clone(), server.address(&path));
        let request = request
            .header("Cookie", cookie)
            .header("Sec-Fetch-Site", "cross-site");
        let response = request.send().await.unwrap();
        assert_eq!(response.status(), 403, "{method} {path} from another site");
    }
    let out = browser
        .post(server.address("/sign-out"))
        .send()
        .await
        .unwrap();
    assert!(
        out.headers()["set-cookie"]
            .to_str()
            .unwrap()
            .contains("Max-Age=0")
    );
}

#[test]
fn a_server_that_others_reach_does_not_start_without_keys() {
    let server = Server::start();
    let folder = server.folder.0.join("other");
    let output = Command::new(&*VELOID)
        .args(["serve", "--listen", "0.0.0.0:0", "--data"])
        .arg(folder)
        .env_remove("DATABASE_URL")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    let message = String::from_utf8(output.stderr).unwrap();
    assert!(
        message.contains("veloid key create") && message.contains("--open"),
        "{message}"
    );
}

#[tokio::test]
async fn an_open_server_needs_no_key() {
    let server = Server::with(&["--open"]);
    let request = server.client.get(server.address("/v1/jobs"));
    let response = request.header("Host", "lab.example").send().await.unwrap();
    assert_eq!(response.status(), 200);
}

#[tokio::test]
async fn without_keys_a_server_answers_to_its_own_names_only() {
    let server = Server::start();
    for (host, status) in [
        ("localhost:80", 200),
        ("127.0.0.1", 200),
        ("evil.example", 403),
    ] {
        let request = server.client.get(server.address("/v1/jobs"));
        let response = request.header("Host", host).send().await.unwrap();
        assert_eq!(response.status(), status, "{host}");
    }
}

#[tokio::test]
async fn every_answer_carries_the_security_headers() {
    let server = Server::start();
    let belongings = Belongings::new(&server).await;
    let mut addresses: Vec<String> = PAGES.iter().chain(&OPEN).map(|p| (*p).to_owned()).collect();
    let operations = operations(&server).await;
    addresses.extend(operations.iter().map(|(_, path)| belongings.address(path)));
    addresses.extend(belongings.pages());
    addresses.extend(["/none", "/v1/jobs/none", "/v1/jobs?limit=x"].map(str::to_owned));
    for address in addresses {
        let response = server.get(&address).await;
        let headers = response.headers();
        for name in [
            "content-security-policy",
            "x-content-type-options",
            "x-frame-options",
            "referrer-policy",
            "cross-origin-opener-policy",
            "cross-origin-resource-policy",
            "permissions-policy",
            "cache-control",
        ] {
            assert!(headers.contains_key(name), "{address} has no {name}");
        }
        let policy = headers["content-security-policy"].to_str().unwrap();
        assert!(
            policy.starts_with("default-src 'none'"),
            "{address}: {policy}"
        );
    }
}

#[tokio::test]
async fn exported_text_is_never_a_formula() {
    let server = Server::start();
    let bike = ride::BIKE.replace("lab-7", "=HYPERLINK(1)");
    let response = server.upload(ride::example(), &bike, &ride::QUICK).await;
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    server.succeeded(&job).await;
    let csv = server
        .get("/v1/parameters?format=csv")
        .await
        .text()
        .await
        .unwrap();
    assert!(csv.contains(",'=HYPERLINK(1),"), "{csv}");
    assert!(!csv.contains(",=") && !csv.contains("\n="));
}

/// Nonsense is refused, and what is said of a missing key is true where it is missing.
#[tokio::test]
async fn keys_that_open_nothing_are_not_made_and_what_lacks_is_said() {
    let mut server = Server::start();
    for wrong in [
        &["--group", ""][..],
        &["--group", "  "],
        &["--group", "a\nb"],
        &["--days", "0"],
        &["--days", "-1"],
        &["--requests-per-minute", "0"],
        &["--max-upload", "0"],
    ] {
        let made = server.beside(&["key", "create"]).args(wrong).output();
        let made = made.unwrap();
        assert_eq!(made.status.code(), Some(2), "{wrong:?}");
        assert!(made.stdout.is_empty(), "{wrong:?}");
    }
    server.kill();
    for (listen, args, said) in [
        ("127.0.0.1:0", &["--keys"][..], "omit `--keys`"),
        ("[::1]:0", &["--keys"], "omit `--keys`"),
        ("0.0.0.0:0", &[], "reached from other machines"),
        ("0.0.0.0:0", &["--keys"], "reached from other machines"),
    ] {
        let serve = ["serve", "--workers", "0", "--listen", listen];
        let output = server.beside(&serve).args(args).output().unwrap();
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(1), "{listen} {args:?}");
        assert!(message.contains(said), "{listen} {args:?}: {message}");
    }
}
