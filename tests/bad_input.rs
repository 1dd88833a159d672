//! Whatever is sent, the answer is a problem of its own kind, and the server lives on.

use std::io::Write;

use reqwest::multipart::{Form, Part};
use serde_json::Value;

use crate::harness::{Folder, Server, veloid, whole_form};
use crate::ride;

/// A file, the parts sent with it, and the fault that is expected.
fn rejected() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let good = ride::table(400, 200.0);
    let with = |from: &str, to: &str| good.replacen(from, to, 1).into_bytes();
    let line = |number: usize, text: &str| {
        // More than one line in a hundred, which would be left out.
        let mut lines: Vec<&str> = good.lines().collect();
        lines[number..number + 6].fill(text);
        lines.join("\n").into_bytes()
    };
    vec![
        ("empty", Vec::new(), "empty-file"),
        (
            "binary",
            b"\x7fELF\x02\x01\x01\0\0\0\0\0".repeat(50),
            "binary-file",
        ),
        ("header only", b"t,u_f,z_f\n".to_vec(), "header-only"),
        ("infinite", line(7, "0.03,0,0,inf,0"), "not-finite"),
        ("word", line(7, "0.03,0,0,oops,0"), "not-a-number"),
        (
            "no displacement",
            with("u_f,u_r,z_f,z_r", "u_f,u_r,p,q"),
            "axle-missing",
        ),
        ("unknown unit", with("z_f", "z_f [furlong]"), "unknown-unit"),
        ("gzip bomb", bomb(), "gzip-bomb"),
        (
            "letter",
            b"Dear all,\nplease find attached\nthe ride\n".to_vec(),
            "no-table",
        ),
        (
            "web page",
            b"<html><body>\n<p>not found</p>\n</body></html>\n".to_vec(),
            "no-table",
        ),
        ("words", b"t,u_f,z_f\nmonday,up,down\n".to_vec(), "no-table"),
    ]
}

/// A gzip file of 1.7 MB that unpacks to 256 MiB: a table, then empty lines.
fn bomb() -> Vec<u8> {
    let mut file = b"\x1f\x8b\x08\0\0\0\0\0\0\xff".to_vec();
    // One deflate block with fixed codes: the table, then copies of 258 bytes of its last line feed.
    let mut bits = Bits::default();
    bits.put(0b011, 3);
    for byte in b"t,u_f,z_f\n0,0,0\n1,1,1\n" {
        bits.code(0x30 + u64::from(*byte), 8);
    }
    for _ in 0..(256 << 20) / 258 {
        // Length 258 is code 285 (fixed code 11000101), distance 1 is code 0 (00000).
        bits.code(0b1100_0101, 8);
        bits.code(0, 5);
    }
    bits.code(0, 7);
    file.extend(bits.done());
    file.extend([0; 8]);
    file
}

#[derive(Default)]
struct Bits {
    bytes: Vec<u8>,
    held: u64,
    count: u32,
}

impl Bits {
    /// Bits from the lowest on, as deflate packs numbers.
    fn put(&mut self, value: u64, count: u32) {
        self.held |= value << self.count;
        self.count += count;
        while self.count >= 8 {
            self.bytes.push(self.held as u8);
            self.held >>= 8;
            self.count -= 8;
        }
    }

    /// A Huffman code, highest bit first.
    fn code(&mut self, code: u64, count: u32) {
        self.put(code.reverse_bits() >> (64 - count), count);
    }

    fn done(mut self) -> Vec<u8> {
        if self.count > 0 {
            self.bytes.push(self.held as u8);
        }
        self.bytes
    }
}

#[tokio::test]
async fn every_bad_ride_gets_its_own_problem() {
    let server = Server::start();
    for (what, file, fault) in rejected() {
        let response = server.upload(file, ride::BIKE, &[]).await;
        assert_eq!(response.status(), 422, "{what}");
        assert_eq!(
            response.headers()["content-type"],
            "application/problem+json"
        );
        let problem: Value = response.json().await.unwrap();
        assert_eq!(
            problem["type"], "urn:veloid:problem:unreadable-ride",
            "{what}"
        );
        assert_eq!(problem["place"]["fault"], fault, "{what}: {problem:#}");
        if ["not-finite", "not-a-number", "time-not-increasing"].contains(&fault) {
            assert_eq!(problem["place"]["line"], 8, "{what}: {problem:#}");
        }
    }
    assert_eq!(server.get("/readyz").await.status(), 200);
    let jobs = server.json("/v1/jobs").await;
    assert_eq!(jobs["items"], Value::Array(Vec::new()), "none was queued");
}

#[tokio::test]
async fn bikes_and_options_are_checked_before_the_job_is_queued() {
    let server = Server::start();
    let half = r#"{"bike": "lab-7", "mass_front_kg": "heavy"}"#;
    for (bike, parts, kind) in [
        ("nobody", &[][..], "bad-bike"),
        (half, &[], "bad-bike"),
        ("{", &[], "bad-bike"),
        (r#"{"bike": "b", "mass_front": 23}"#, &[], "bad-bike"),
        (r#"{"bike": "b", "mass_front_kg": 1e-300}"#, &[], "bad-bike"),
        (r#"{"bike": "b", "l_front_m": 808}"#, &[], "bad-bike"),
        (r#"{"bike": "b", "mass_front_kg": 23}"#, &[], "bad-bike"),
        (r#"{"bike": ".."}"#, &[], "bad-bike"),
        (r#"{"bike": "a\u202eb"}"#, &[], "bad-bike"),
        (
            ride::BIKE,
            &[("map", "z_f=z_f"), ("map", "z_f=z_r")],
            "bad-option",
        ),
        (ride::BIKE, &[("map", "height=z_f")], "unreadable-ride"),
        (
            ride::BIKE,
            &[("options", r#"{"map": {"height": "z_f"}}"#)],
            "unreadable-ride",
        ),
        (ride::BIKE, &[("options", r#"{"sead": 1}"#)], "bad-option"),
        (ride::BIKE, &[("rate_hz", "1e-10")], "unreadable-ride"),
        (ride::BIKE, &[("particles", "1000000000")], "bad-option"),
        (ride::BIKE, &[("sead", "1")], "bad-option"),
        (ride::BIKE, &[("rows", "7")], "bad-option"),
        (ride::BIKE, &[("options", "{")], "bad-option"),
    ] {
        let response = server.upload(ride::example(), bike, parts).await;
        let problem: Value = response.json().await.unwrap();
        let expected = format!("urn:veloid:problem:{kind}");
        assert_eq!(problem["type"], expected, "{bike} {parts:?}: {problem:#}");
        assert_eq!(problem["status"], 422);
    }
}

#[tokio::test]
async fn refused_uploads_are_listed_with_sender_time_and_reason() {
    let (server, [sender, other]) = Server::with_keys(
        [
            &["--scope", "upload", "--scope", "read"],
            &["--scope", "read", "--group", "others"],
        ],
        &[],
    );
    let send = async |file: Vec<u8>, bike: &str| {
        let part = Part::bytes(file).file_name("ride 7.csv");
        let form = Form::new().part("file", part).text("bike", bike.to_owned());
        let request = server
            .client
            .post(server.address("/v1/rides"))
            .multipart(form);
        request.bearer_auth(&sender).send().await.unwrap()
    };
    let list = async |key: &str, query: &str| -> Value {
        let request = server
            .client
            .get(server.address(&format!("/v1/rides/refused{query}")));
        request
            .bearer_auth(key)
            .send()
            .await
            .unwrap()
            .json()
            .await
            .unwrap()
    };
    assert_eq!(send(ride::example(), ride::BIKE).await.status(), 202);
    assert_eq!(
        list(&sender, "").await["items"],
        Value::Array(Vec::new()),
        "it was taken"
    );
    let refused = [
        send(b"t,z_f\n0,1\n1,x\n".to_vec(), ride::BIKE).await,
        send(ride::example(), "nobody").await,
    ];
    for refused in &refused {
        assert_eq!(refused.status(), 422);
    }
    let [ride, bike] = refused;
    let found = list(&sender, "?limit=1").await;
    let newest = &found["items"][0];
    let problem: Value = bike.json().await.unwrap();
    assert_eq!(newest["detail"], problem["detail"]);
    assert_eq!(newest["problem"], "urn:veloid:problem:bad-bike");
    assert_eq!(
        (&newest["file"], &newest["bike"]),
        (&"ride 7.csv".into(), &"nobody".into())
    );
    assert_eq!(newest["actor"], "key");
    let rest = list(
        &sender,
        &format!("?cursor={}", found["next"].as_str().unwrap()),
    )
    .await;
    let problem: Value = ride.json().await.unwrap();
    assert_eq!(rest["items"][0]["detail"], problem["detail"]);
    assert_eq!(rest["items"][0]["bike"], "lab-7");
    assert_eq!(rest["items"].as_array().unwrap().len(), 1);
    assert_eq!(
        list(&other, "").await["items"],
        Value::Array(Vec::new()),
        "of another group"
    );
}

#[tokio::test]
async fn what_is_too_large_is_refused_however_it_comes() {
    let server = Server::with(&["--max-upload", "100000"]);
    let large = vec![b'1'; 200_000];
    let form = server.upload(large.clone(), ride::BIKE, &[]).await;
    assert_eq!(form.status(), 413);
    let streamed =
        futures_util::stream::iter((0..20).map(|_| Ok::<_, std::io::Error>(vec![b'1'; 10_000])));
    let part = Part::stream(reqwest::Body::wrap_stream(streamed)).file_name("ride.csv");
    let response = server
        .client
        .post(server.address("/v1/rides"))
        .multipart(Form::new().part("file", part))
        .send()
        .await
        .unwrap();
    assert_eq!(response.status(), 413, "without a length");
    let problem: Value = response.json().await.unwrap();
    assert_eq!(problem["type"], "urn:veloid:problem:too-large");
    let leftover = std::fs::read_dir(server.folder.0.join("incoming")).unwrap();
    assert_eq!(leftover.count(), 0, "nothing is left behind");
}

/// A body of 2 GB as its header says: refused at once, before it comes.
#[tokio::test]
async fn two_gigabytes_are_refused_before_they_come() {
    let server = Server::start();
    let address = server.url.trim_start_matches("http://");
    let mut stream = std::net::TcpStream::connect(address).unwrap();
    write!(
        stream,
        "POST /v1/rides HTTP/1.1\r\nHost: x\r\nContent-Length: 2000000000\r\n\r\n"
    )
    .unwrap();
    let mut answer = [0; 12];
    std::io::Read::read_exact(&mut stream, &mut answer).unwrap();
    assert_eq!(&answer, b"HTTP/1.1 413");
}

#[tokio::test]
async fn strange_addresses_and_methods_are_problems_too() {
    let server = Server::start();
    let none = "/v1/jobs/01890000-0000-7000-8000-000000000000";
    for (method, path, status) in [
        ("GET", "/nowhere", 404),
        ("GET", none, 404),
        ("GET", "/v1/jobs/not-an-id", 404),
        ("DELETE", none, 404),
        ("GET", "/v1/bikes/nobody", 404),
        ("PUT", "/v1/jobs", 405),
        ("GET", "/v1/jobs?state=asleep", 400),
        ("GET", "/v1/jobs?cursor=x", 400),
        ("GET", "/v1/parameters?from=yesterday", 400),
        ("POST", "/v1/rides", 422),
    ] {
        let request = server
            .client
            .request(method.parse().unwrap(), server.address(path));
        let response = request.send().await.unwrap();
        assert_eq!(response.status(), status, "{method} {path}");
        assert_eq!(
            response.headers()["content-type"],
            "application/problem+json"
        );
        let problem: Value = response.json().await.unwrap();
        assert_eq!(problem["status"], status);
    }
}

/// What is neither true nor false, and what comes twice, is refused by its name wherever it stands.
#[tokio::test]
async fn booleans_and_doubled_parts_are_refused_by_name() {
    let server = Server::with(&["--workers", "0"]);
    let raw = async |query: &str| {
        let url = server.address(&format!("/v1/rides/preview?{query}"));
        let response = server.client.post(url).body(ride::example()).send().await;
        let response = response.unwrap();
        (response.status().as_u16(), response.text().await.unwrap())
    };
    for name in ["again", "diagnosis"] {
        for good in ["true", "True", "false", "False", ""] {
            let (status, text) = raw(&format!("{name}={good}")).await;
            assert_eq!(status, 200, "{name}={good}: {text}");
        }
        for bad in ["no", "0", "1", "banana", "TRUE", "null"] {
            let said = format!("{name}: '{bad}', expected true or false");
            let (status, text) = raw(&format!("{name}={bad}")).await;
            assert!(status == 422 && text.contains(&said), "{text}");
            let answer = server
                .upload(ride::example(), ride::BIKE, &[(name, bad)])
                .await;
            assert_eq!(answer.status(), 422, "{name}={bad}");
            assert!(answer.text().await.unwrap().contains(&said));
        }
    }
    let doubled = async |parts: &[(&str, &str)]| {
        let form = whole_form(ride::example(), ride::BIKE, parts);
        let request = server.client.post(server.address("/v1/rides"));
        let answer = request.multipart(form).send().await.unwrap();
        (answer.status(), answer.text().await.unwrap())
    };
    for (name, value) in [
        ("seed", "1"),
        ("name", "a.csv"),
        ("again", "true"),
        ("diagnosis", "false"),
        ("rows", "0:9"),
        ("bike", ride::BIKE),
        ("fleet", "lab-7"),
    ] {
        let said = format!("{name}: given twice, expected once");
        let parts = [(name, value), (name, " "), (name, value)];
        let (status, text) = doubled(&parts).await;
        assert!(status == 422 && text.contains(&said), "{name}: {text}");
    }
    let options = r#"{"seed": 1}"#;
    for parts in [
        [("options", options), ("seed", "1")],
        [("seed", "1"), ("options", options)],
        [("options", options), ("options", options)],
        [("options", r#"{"seed": 1, "seed": 2}"#), ("trials", "2")],
        [
            ("options", r#"{"map": {"z_f": "z_f", "z_f": "z_r"}}"#),
            ("trials", "2"),
        ],
    ] {
        let (status, text) = doubled(&parts).await;
        assert!(
            status == 422 && text.contains("given twice"),
            "{parts:?}: {text}"
        );
    }
    let request = server.client.post(server.address("/v1/rides?bike=lab-7"));
    let request = request.header("Veloid-Bike", "lab-7").body(ride::example());
    let answer = request.send().await.unwrap();
    assert_eq!(answer.status(), 422);
    assert!(answer.text().await.unwrap().contains("bike: given twice"));
    let said = "query";
    let answer = server.get("/v1/parameters?axle=front&axle=rear").await;
    assert_eq!(answer.status(), 400);
    assert!(answer.text().await.unwrap().contains(said));
    let jobs = server.json("/v1/jobs").await;
    assert_eq!(jobs["items"], Value::Array(Vec::new()), "none was queued");
}

/// A name that no list knows would read as if there were nothing.
#[tokio::test]
async fn names_and_spans_that_cannot_be_are_refused_with_what_can() {
    let server = Server::start();
    let job = server.submit(&[]).await;
    server.succeeded(&job).await;
    let refused = async |path: &str, said: &[&str]| {
        let answer = server.get(path).await;
        let (status, text) = (answer.status(), answer.text().await.unwrap());
        assert_eq!(status, 400, "{path}: {text}");
        for said in said {
            assert!(text.contains(said), "{path}: {text}");
        }
    };
    let lists = ["/v1/parameters", "/v1/bikes/lab-7/history", "/parameters"];
    for (name, known) in [
        ("method", "output_error"),
        ("axle", "front, rear, both"),
        ("name", "k_n_m, b_n_s_m, mass_kg"),
        ("effect", "coulomb_friction"),
        (
            "verdict",
            "nothing_missing, named, named_in_part, ambiguous, unnamed, cannot_tell",
        ),
    ] {
        for list in lists {
            for bad in [
                "xyz",
                "Front",
                "both%20",
                "coulomb_friction.grip",
                "power_damping",
            ] {
                let trimmed = list == "/parameters" && name == "axle" && bad == "both%20";
                if !trimmed {
                    refused(&format!("{list}?{name}={bad}"), &[name, known]).await;
                }
            }
        }
    }
    for list in ["/v1/jobs", "/jobs"] {
        refused(&format!("{list}?verdict=foo"), &["verdict", "unnamed"]).await;
        refused(&format!("{list}?state=foo"), &["state", "queued"]).await;
    }
    for list in lists {
        refused(
            &format!("{list}?from=2026-09-02&to=2026-09-01"),
            &["later than"],
        )
        .await;
        let day = format!("{list}?from=1970-01-01&to=9999-12-31");
        assert_eq!(server.get(&day).await.status(), 200, "{day}");
    }
    refused(
        "/v1/bikes/lab-7/history?bike=lab-7",
        &["unknown parameter `bike`"],
    )
    .await;
    for bad in ["t0=nan", "t0=inf", "t1=-inf", "t1=NaN", "t0=2&t1=1", "t0=x"] {
        refused(&format!("{job}/series?{bad}"), &["t"]).await;
    }
    assert_eq!(
        server
            .get(&format!("{job}/series?t0=1&t1=1"))
            .await
            .status(),
        200
    );
    for bad in ["wait=inf", "wait=nan", "wait=-1", "wait=1e999"] {
        refused(&format!("{job}?{bad}"), &["wait"]).await;
    }
    // What the document names is taken.
    let document = server.json("/openapi.json").await;
    let mut asked = 0;
    for path in ["/v1/parameters", "/v1/bikes/{bike}/history", "/v1/jobs"] {
        let parameters = &document["paths"][path]["get"]["parameters"];
        let filters = parameters.as_array().unwrap().iter();
        for parameter in filters.filter(|parameter| parameter["name"] != "format") {
            for value in parameter["schema"]["enum"].as_array().into_iter().flatten() {
                let (name, value) = (parameter["name"].as_str().unwrap(), value.as_str().unwrap());
                let address = path.replace("{bike}", "lab-7");
                server.json(&format!("{address}?{name}={value}")).await;
                asked += 1;
            }
        }
    }
    assert!(asked > 100, "{asked}");
}

/// A mistyped filter would give everything.
#[tokio::test]
async fn unknown_query_parameters_are_refused_by_name() {
    let server = Server::start();
    let job = server.submit(&[]).await;
    server.succeeded(&job).await;
    let document = server.json("/openapi.json").await;
    let mut asked = 0;
    for (path, item) in document["paths"].as_object().unwrap() {
        let address = path
            .replace("/v1/jobs/{id}", &job)
            .replace("{bike}", "lab-7")
            .replace("{name}", "lab-7")
            .replace("{id}", "01890000-0000-7000-8000-000000000000");
        for (method, operation) in item.as_object().unwrap() {
            let method = method.to_uppercase().parse().unwrap();
            let url = server.address(&format!("{address}?naem=k"));
            let response = server.client.request(method, url).send().await.unwrap();
            assert_eq!(response.status(), 400, "{path}");
            let problem: Value = response.json().await.unwrap();
            assert_eq!(problem["type"], "urn:veloid:problem:bad-request");
            let detail = problem["detail"].as_str().unwrap();
            assert!(detail.contains("unknown parameter `naem`"), "{detail}");
            let parameters = operation["parameters"].as_array();
            for known in parameters.into_iter().flatten() {
                let name = known["name"].as_str().unwrap();
                assert!(known["in"] != "query" || detail.contains(&format!("`{name}`")));
            }
            asked += 1;
        }
    }
    assert!(asked > 20, "{asked}");
    for page in ["/jobs", "/parameters", "/"] {
        let response = server.get(&format!("{page}?naem=k")).await;
        assert_eq!(response.status(), 400, "{page}");
        assert!(response.text().await.unwrap().contains("naem"), "{page}");
        let response = server.get(&format!("{page}?bike=lab-7&theme=dark")).await;
        assert_eq!(response.status(), 200, "{page}");
    }
    // Options may stand in the query of an upload.
    let raw = |query: &str| {
        let url = server.address(&format!("/v1/rides/preview?{query}"));
        server.client.post(url).body(ride::example()).send()
    };
    assert_eq!(raw("name=a.csv&seed=3").await.unwrap().status(), 200);
    assert_eq!(raw("sead=3").await.unwrap().status(), 400);
}

#[tokio::test]
async fn a_day_is_taken_wherever_a_time_is() {
    let server = Server::start();
    let job = server.submit(&[]).await;
    server.succeeded(&job).await;
    let count = async |query: &str| {
        let mut counts = Vec::new();
        for list in ["/v1/parameters", "/v1/bikes/lab-7/history"] {
            let list = server.json(&format!("{list}?{query}")).await;
            counts.push(list["items"].as_array().unwrap().len());
        }
        assert_eq!(counts[0], counts[1], "{query}");
        counts[0]
    };
    let all = count("limit=1000").await;
    assert!(all > 0);
    let items = server.json("/v1/parameters").await;
    let day = &items["items"][0]["identified_at"].as_str().unwrap()[..10];
    assert_eq!(count(&format!("limit=1000&from={day}&to={day}")).await, all);
    assert_eq!(count("from=2999-01-01").await, 0);
    assert_eq!(count("to=2001-01-01").await, 0);
    for bad in ["2026-02-30", "2026-9-1", "2026-09-01T00:00"] {
        let response = server.get(&format!("/v1/parameters?from={bad}")).await;
        assert_eq!(response.status(), 400, "{bad}");
    }
}

#[test]
fn the_command_line_says_it_in_one_line_and_exits_with_2() {
    let folder = Folder::new();
    let bike = folder.write("bike.json", ride::BIKE);
    for (what, file, _) in rejected() {
        let path = folder.write("ride.csv", file);
        let args = [
            "identify",
            path.to_str().unwrap(),
            "--bike",
            bike.to_str().unwrap(),
        ];
        let output = veloid(&args);
        assert_eq!(output.status.code(), Some(2), "{what}");
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(message.lines().count(), 1, "{what}: {message}");
        assert!(message.contains("ride.csv"), "{what}: {message}");
        assert!(output.stdout.is_empty(), "{what}");
    }
    let table = folder.write("ride.csv", ride::example());
    for (bike, args, said) in [
        (
            r#"{"owner": "x"}"#,
            &[][..],
            "unknown key 'owner', expected bike",
        ),
        (
            r#"{"mass_front_kg": 1e-300}"#,
            &[],
            "mass_front_kg is 1e-300, expected 0.1 to 1000",
        ),
        (
            ride::BIKE,
            &["--map", "height=z_f"],
            "channel 'height', expected one of t, u_f",
        ),
        (
            ride::BIKE,
            &["--map", "z_f=z_f", "--map", "z_f=z_r"],
            "expected one column",
        ),
        (
            ride::BIKE,
            &["--map", "z_f=V2"],
            "z_f=V2 names no column of the file",
        ),
    ] {
        let bike = folder.write("other.json", bike);
        let files = [
            "identify",
            table.to_str().unwrap(),
            "--bike",
            bike.to_str().unwrap(),
        ];
        let output = veloid(&[&files[..], args].concat());
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(
            message.contains(said) && message.lines().count() == 1,
            "{message}"
        );
    }
    let missing = veloid(&["identify", "/nowhere.csv", "--bike", bike.to_str().unwrap()]);
    assert_eq!(missing.status.code(), Some(2));
    let path = folder.write("ride.csv", ride::example());
    let ride = path.to_str().unwrap();
    let huge = veloid(&[
        "identify",
        ride,
        "--bike",
        bike.to_str().unwrap(),
        "--particles",
        "1000000000",
    ]);
    assert_eq!(huge.status.code(), Some(2));
}

/// Names and notes that look like others, or turn the text around them.
#[tokio::test]
async fn what_cannot_be_seen_is_refused_or_left_out() {
    let server = Server::with(&["--workers", "0"]);
    let mut sent = 0;
    // Format characters, fillers, blanks, and joiners and selectors beside what they do not change.
    let unseen = "\u{1}\u{85}\u{200d}\u{200e}\u{200f}\u{2028}\u{2029}\u{202a}\u{202e}\u{2066}\u{2069}\u{feff}\
                  \u{34f}\u{115f}\u{1160}\u{17b4}\u{180e}\u{2800}\u{3164}\u{fe0f}\u{ffa0}\u{1bca0}\u{1d173}\u{e0100}";
    for c in unseen.chars() {
        let odd = format!("a{c}b");
        let code = format!("U+{:04X}", c as u32);
        let bike = ride::BIKE.replace(
            "lab-7",
            &serde_json::json!(odd).to_string().replace('"', ""),
        );
        for (bike, parts) in [
            (bike.as_str(), vec![]),
            (ride::BIKE, vec![("rider", odd.as_str())]),
            (ride::BIKE, vec![("tyres", &odd)]),
            (ride::BIKE, vec![("road", &odd)]),
            (ride::BIKE, vec![("notes", &odd)]),
            (ride::BIKE, vec![("tags", &odd)]),
        ] {
            let refused = server.upload(ride::example(), bike, &parts).await;
            assert_eq!(refused.status(), 422, "{code} {parts:?}");
            let problem: Value = refused.json().await.unwrap();
            let said = problem["detail"].as_str().unwrap();
            assert!(said.contains(&code) || parts.is_empty(), "{code}: {said}");
            assert!(!said.contains(c), "{said:?}");
        }
        let file = Part::bytes(ride::example()).file_name(format!("{odd}{sent}.csv"));
        let form = Form::new().part("file", file).text("bike", ride::BIKE);
        let form = form.text("seed", sent.to_string());
        let request = server
            .client
            .post(server.address("/v1/rides"))
            .multipart(form);
        let taken = request.send().await.unwrap();
        if taken.status() == 400 && c.is_control() {
            // No head of a part may hold it as it is.
            continue;
        }
        assert_eq!(taken.status(), 202, "{code}");
        let job = taken.headers()["location"].to_str().unwrap().to_owned();
        let name = server.json(&job).await["ride"]["name"].clone();
        let name = name.as_str().unwrap();
        assert!(
            !name.contains(c) && name.ends_with(".csv"),
            "{code}: {name:?}"
        );
        sent += 1;
    }
}

/// Persian, Hindi, Bengali, Japanese and emoji are written with joiners and selectors.
#[tokio::test]
async fn names_keep_the_joiners_and_selectors_that_they_are_written_with() {
    let server = Server::with(&["--workers", "0"]);
    for name in [
        "دوچرخه\u{200c}ها می\u{200c}روند",
        "क्\u{200d}ष",
        "র\u{200d}\u{9cd}যাম",
        "葛\u{e0100}城",
        "❤\u{fe0f}\u{200d}🔥 🚴🏽\u{200d}♀\u{fe0f} ⚡\u{fe0f} 1\u{fe0f}\u{20e3}",
    ] {
        let bike = ride::BIKE.replace("lab-7", name);
        let file = Part::bytes(ride::example()).file_name(format!("{name}.csv"));
        let form = Form::new().part("file", file).text("bike", bike);
        let form = form.text("tags", name).text("notes", name);
        let request = server.client.post(server.address("/v1/rides"));
        let response = request.multipart(form).send().await.unwrap();
        let (status, job) = (response.status(), response.json::<Value>().await.unwrap());
        assert_eq!(status, 202, "{name}: {job:#}");
        assert_eq!(job["bike"], name);
        assert_eq!(job["ride"]["name"], format!("{name}.csv"));
        assert_eq!(job["ride"]["facts"]["tags"][0], name);
    }
}
