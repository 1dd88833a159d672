use reqwest::multipart::{Form, Part};
use reqwest::{Response, redirect};
use serde_json::Value;

use crate::harness::{Server, http, veloid};
use crate::ride::{self, LONG};
use crate::season;

const HOSTILE: &str = "<img src=x onerror=alert(1)>\"'&.csv";

/// The page, which must be one and may run nothing but this server's scripts.
async fn page(server: &Server, path: &str) -> String {
    let response = server.get(path).await;
    assert_eq!(response.status(), 200, "{path}");
    html(response).await
}

async fn html(response: Response) -> String {
    let headers = response.headers();
    assert_eq!(headers["content-type"], "text/html; charset=utf-8");
    let policy = headers["content-security-policy"].to_str().unwrap();
    assert!(policy.contains("script-src 'self';"), "{policy}");
    assert_eq!(headers["x-content-type-options"], "nosniff");
    let text = response.text().await.unwrap();
    assert!(text.starts_with("<!doctype html>"));
    assert!(!text.contains("onerror=alert(1)>"), "a name got through");
    text
}

/// A browser's form, redirects not followed.
async fn send_form(server: &Server, name: &str, bike: &str) -> Response {
    let file = Part::bytes(ride::example()).file_name(name.to_owned());
    let mut form = Form::new().part("file", file).text("bike", bike.to_owned());
    for (key, value) in ride::QUICK {
        form = form.text(key, value);
    }
    let client = http().redirect(redirect::Policy::none()).build().unwrap();
    let request = client.post(server.address("/")).multipart(form);
    request.send().await.unwrap()
}

#[tokio::test]
async fn the_plain_form_leads_to_the_result() {
    let server = Server::start();
    let form = page(&server, "/").await;
    assert!(form.contains("enctype=\"multipart/form-data\""));
    let response = send_form(&server, "morning.csv", ride::BIKE).await;
    assert_eq!(response.status(), 303);
    let path = response.headers()["location"].to_str().unwrap().to_owned();
    page(&server, &path).await;
    server.succeeded(&format!("/v1{path}")).await;
    let result = page(&server, &path).await;
    for part in [
        "lab-7: morning.csv",
        "Front axle",
        "table 1 of the paper",
        "Output error",
        "SHA-256",
        "id=\"displacement-front\"",
    ] {
        assert!(result.contains(part), "{part} is missing");
    }
    let jobs = page(&server, "/jobs").await;
    assert!(jobs.contains(&path) && jobs.contains("morning.csv"));
    let none = page(&server, "/jobs?state=failed&bike=&verdict=").await;
    assert!(none.contains("No job matches") && !none.contains(&path));
}

#[tokio::test]
async fn a_form_that_is_refused_says_why_beside_the_field() {
    let server = Server::start();
    let response = send_form(&server, "a.csv", "no such bike").await;
    assert_eq!(response.status(), 422);
    let text = html(response).await;
    assert!(text.contains("is not a bike of the fleet"), "{text}");
    assert!(text.contains("class=\"fault\""));
}

#[tokio::test]
async fn hostile_names_are_only_shown() {
    let server = Server::start();
    let bike = ride::BIKE.replace("lab-7", "<script>alert(1)</script>");
    let response = send_form(&server, HOSTILE, &bike).await;
    let path = response.headers()["location"].to_str().unwrap().to_owned();
    server.succeeded(&format!("/v1{path}")).await;
    let bike = "/bikes/%3Cscript%3Ealert(1)%3C%2Fscript%3E";
    for path in [
        "/",
        "/jobs",
        "/bikes",
        bike,
        "/parameters?bike=%3Cscript%3Ealert",
        &path,
    ] {
        let text = page(&server, path).await;
        assert!(!text.contains("<script>alert"), "{path}");
    }
    assert!(page(&server, &path).await.contains("&#60;img src=x"));
}

#[tokio::test]
async fn a_job_is_cancelled_and_retried_by_its_buttons_but_not_from_elsewhere() {
    let server = Server::start();
    let job = server.submit(&LONG).await;
    let path = job.trim_start_matches("/v1");
    let press = async |button: &str, site: &str| {
        let address = server.address(&format!("{path}/{button}"));
        let request = server.client.post(address).header("Sec-Fetch-Site", site);
        request.send().await.unwrap().status().as_u16()
    };
    assert_eq!(press("cancel", "cross-site").await, 403);
    assert_eq!(press("cancel", "same-origin").await, 200);
    assert_eq!(server.json(&job).await["state"], "cancelled");
    assert!(page(&server, path).await.contains("Try again"));
    assert_eq!(press("retry", "same-origin").await, 200);
    assert_eq!(press("cancel", "same-origin").await, 200);
}

#[tokio::test]
async fn a_missing_page_is_a_page() {
    let server = Server::start();
    let nobody = format!("/jobs/{}", uuid::Uuid::now_v7());
    for path in [nobody.as_str(), "/jobs/none", "/assets/x/none.js"] {
        let response = server.get(path).await;
        assert_eq!(response.status(), 404, "{path}");
        html(response).await;
    }
}

#[tokio::test]
async fn the_library_of_effects_is_a_page_a_command_and_a_document() {
    let printed = String::from_utf8(veloid(&["effects"]).stdout).unwrap();
    let committed = include_str!("../docs/effects.md");
    assert!(
        printed == committed,
        "docs/effects.md is out of date: cargo run -- effects > docs/effects.md"
    );
    let shown = page(&Server::start(), "/effects").await;
    let sections = printed.lines().filter_map(|line| line.strip_prefix("## "));
    let missing: Vec<&str> = sections
        .filter(|id| !shown.contains(&format!("id=\"{id}\"")))
        .collect();
    assert!(missing.is_empty(), "{missing:?}");
}

#[tokio::test]
async fn assets_are_kept_for_ever_and_come_from_the_binary() {
    let server = Server::start();
    let form = page(&server, "/").await;
    let assets: Vec<&str> = form
        .split('"')
        .filter(|part| part.starts_with("/assets/"))
        .collect();
    assert!(assets.len() >= 4, "{assets:?}");
    for address in &assets {
        let response = server.get(address).await;
        assert_eq!(response.status(), 200, "{address}");
        let keep = response.headers()["cache-control"].to_str().unwrap();
        assert!(keep.contains("immutable"), "{address}: {keep}");
    }
    let plotly = assets[0].rsplit_once('/').unwrap().0.to_owned() + "/plotly.js";
    for (encoding, is_packed) in [("br, gzip", true), ("identity", false)] {
        let request = server.client.get(server.address(&plotly));
        let response = request.header("accept-encoding", encoding).send();
        let response = response.await.unwrap();
        let headers = response.headers();
        assert_eq!(headers["content-type"], "text/javascript; charset=utf-8");
        assert_eq!(headers["vary"], "accept-encoding");
        assert_eq!(headers.contains_key("content-encoding"), is_packed);
        let script = response.bytes().await.unwrap();
        assert_eq!(script.starts_with(b"\x1f\x8b"), is_packed);
        assert!(script.len() > 1_000_000);
    }
    // No page asks any other host for anything.
    for address in form.split(['"', '\'']).filter(|part| part.contains("://")) {
        assert!(address.starts_with(&server.url), "{address}");
    }
}

#[tokio::test]
async fn a_preview_says_what_was_understood_and_keeps_nothing() {
    let server = Server::start();
    let preview = async |bytes: Vec<u8>| -> (u16, Value) {
        let form = Form::new().part("file", Part::bytes(bytes).file_name("a.csv"));
        let request = server.client.post(server.address("/v1/rides/preview"));
        let response = request.multipart(form).send().await.unwrap();
        (response.status().as_u16(), response.json().await.unwrap())
    };
    let (status, seen) = preview(ride::example()).await;
    assert_eq!(status, 200, "{seen}");
    for (bike, lacks) in [
        (ride::BIKE, None),
        (r#"{"mass_rear_kg": 63}"#, Some("mass_front_kg")),
        ("{", None),
    ] {
        let file = Part::bytes(ride::example()).file_name("a.csv");
        let form = Form::new().part("file", file).text("bike", bike);
        let request = server.client.post(server.address("/v1/rides/preview"));
        let response = request.multipart(form).send().await.unwrap();
        let seen: Value = response.json().await.unwrap();
        let problem = seen["problem"].as_str();
        assert_eq!(problem.is_some(), lacks.is_some(), "{bike}: {seen}");
        assert!(
            problem.is_none_or(|p| p.contains("mass_front_kg is null")),
            "{seen}"
        );
    }
    assert_eq!(seen["columns"].as_array().unwrap().len(), 5);
    assert_eq!(seen["samples"], 4000);
    assert!(seen["problem"].is_null());
    let (status, seen) = preview(b"t,z_f\n0,1\n".to_vec()).await;
    assert_eq!(status, 200);
    assert!(seen["problem"].is_string(), "{seen}");
    let (status, problem) = preview(vec![0; 100]).await;
    assert_eq!(status, 422, "{problem}");
    assert_eq!(server.json("/v1/jobs").await["items"], Value::Array(vec![]));
}

#[tokio::test]
async fn jobs_are_compared_by_their_differences() {
    let server = Server::start();
    let stiffer = ride::BIKE.replace("lab-7", "lab-8").replace("23.0", "25.0");
    let mut query = Vec::new();
    for bike in [ride::BIKE, stiffer.as_str()] {
        let response = server.upload(ride::example(), bike, &ride::QUICK).await;
        let job: Value = response.json().await.unwrap();
        server
            .succeeded(job["links"]["job"].as_str().unwrap())
            .await;
        query.push(format!("job={}", job["id"].as_str().unwrap()));
    }
    let text = page(&server, &format!("/compare?{}", query.join("&"))).await;
    for part in ["front k", "lab-7", "lab-8", "σ</span>"] {
        assert!(text.contains(part), "{part} is missing");
    }
    for (query, status) in [(query[0].as_str(), 400), ("job=x&job=y", 400), ("", 400)] {
        let response = server.get(&format!("/compare?{query}")).await;
        assert_eq!(response.status(), status, "{query}");
        html(response).await;
    }
}

#[tokio::test]
async fn a_filter_that_is_misspelt_is_refused_by_name() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 2, 10).await;
    for (path, said) in [
        ("/jobs?naem=k", "naem"),
        ("/jobs?state=done", "done"),
        ("/jobs?verdict=unamed", "unamed"),
        ("/jobs?cursor=last", "cursor"),
        ("/parameters?naem=k", "naem"),
        ("/parameters?method=pso", "pso"),
        ("/parameters?axle=left", "left"),
        ("/parameters?verdict=good", "good"),
        ("/parameters?from=yesterday", "yesterday"),
        ("/parameters?to=2026-13-01", "2026-13-01"),
        ("/parameters?from=2026-9-01", "2026-9-01"),
        ("/compare?jobs=x", "jobs"),
        ("/compare?job=x", "x"),
        ("/?bicycle=x", "bicycle"),
        ("/sign-in?then=x", "then"),
        ("/jobs.atom?state=failed", "state"),
        ("/effects?naem=k", "naem"),
        ("/effects/coulomb_friction?bike=x", "bike"),
        ("/bikes?naem=k", "naem"),
        ("/bikes/lab-7?naem", "naem"),
        ("/dependence?naem=", "naem"),
        ("/jobs/01890000-0000-7000-8000-000000000000?naem=k", "naem"),
    ] {
        let response = server.get(path).await;
        assert_eq!(response.status(), 400, "{path}");
        let text = html(response).await;
        assert!(
            text.contains(said) && (text.contains("expected") || said == "cursor"),
            "{path}: {text}"
        );
    }
    assert_eq!(server.get("/?bike=unknown").await.status(), 404);
    for path in [
        "/jobs?state=&verdict=&bike=&theme=dark",
        "/parameters?bike=&name=&effect=&method=&axle=&verdict=&from=&to=&theme=light",
        "/parameters?from=2020-01-01&to=2100-01-01",
        "/parameters?from=2020-01-01T00:00:00Z",
    ] {
        assert!(page(&server, path).await.contains("season-001"), "{path}");
    }
    assert_eq!(server.get("/effects?theme=dark").await.status(), 200);
    for path in ["/sign-out?naem=k", "/rides/x/delete?naem=k"] {
        let sent = server.client.post(server.address(path)).send().await;
        assert_eq!(sent.unwrap().status(), 400, "{path}");
    }
}

#[tokio::test]
async fn blank_fields_of_the_plain_form_ask_for_nothing() {
    let server = Server::start();
    assert_eq!(send_form(&server, "a.csv", ride::BIKE).await.status(), 303);
    for (seed, bikes) in [("2", ["lab-7", ""]), ("3", ["", ride::BIKE])] {
        let file = Part::text(ride::table(2000, 200.0).replacen("z_f", "V2", 1)).file_name("b.csv");
        let mut form = Form::new()
            .part("file", file)
            .text("seed", seed)
            .text("rows", " ");
        // The list of the fleet, and the box.
        for (name, bike) in ["fleet", "bike"].into_iter().zip(bikes) {
            form = form.text(name, bike);
        }
        for map in ["", "z_f=V2"] {
            form = form.text("map", map);
        }
        let client = http().redirect(redirect::Policy::none()).build().unwrap();
        let request = client.post(server.address("/")).multipart(form);
        assert_eq!(request.send().await.unwrap().status(), 303, "{bikes:?}");
    }
}

#[tokio::test]
async fn a_browser_gets_a_page_for_what_is_not_there_and_a_program_a_problem() {
    let server = Server::with(&["--workers", "0"]);
    let ask = async |method: &str, path: &str, accept: &str| {
        let request = server
            .client
            .request(method.parse().unwrap(), server.address(path));
        request.header("Accept", accept).send().await.unwrap()
    };
    const BROWSER: &str = "text/html,application/xhtml+xml,application/xml;q=0.9,*/*;q=0.8";
    for (method, path, status) in [("GET", "/nosuchpage", 404), ("PUT", "/jobs", 405)] {
        let answer = ask(method, path, BROWSER).await;
        assert_eq!(answer.status(), status);
        let text = html(answer).await;
        assert!(text.contains(path) && text.contains("<nav"), "{text}");
        for accept in ["*/*", "application/json"] {
            let answer = ask(method, path, accept).await;
            assert_eq!(answer.status(), status);
            assert_eq!(answer.headers()["content-type"], "application/problem+json");
        }
    }
    let icon = ask("GET", "/favicon.ico", "image/*").await;
    assert_eq!(icon.status(), 200);
    assert_eq!(icon.headers()["content-type"], "image/svg+xml");
    assert!(icon.text().await.unwrap().contains("<svg"));
    for (jobs, said) in [(0, "0 jobs were chosen"), (1, "1 job was chosen")] {
        let id = "job=01890000-0000-7000-8000-000000000000";
        let answer = server
            .get(&format!("/compare?{}", vec![id; jobs].join("&")))
            .await;
        let text = html(answer).await;
        assert!(text.contains(said), "{text}");
    }
}

#[tokio::test]
async fn the_filters_of_parameters_speak_as_the_page_does_and_a_cut_export_says_so() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 2, 5500).await;
    let text = page(&server, "/parameters").await;
    for option in [
        ">stiffness k</option>",
        "<option value=\"coulomb_friction.friction\">coulomb friction: friction</option>",
        "<option value=\"coulomb_friction\">coulomb friction</option>",
        "<option value=\"swarm\">particle swarm</option>",
    ] {
        assert!(text.contains(option), "{option}");
    }
    assert!(text.contains("Bicycle (exact name)"));
    let said = "id=\"cut\"";
    assert!(text.contains(said), "more than 100 000 rows");
    for few in [
        "name=k_n_m",
        "axle=front&method=swarm",
        "effect=coulomb_friction",
        "to=2001-01-01",
    ] {
        let text = page(&server, &format!("/parameters?{few}")).await;
        assert!(!text.contains(said), "{few}");
    }
    assert!(
        page(&server, "/parameters?bike=&name=&from=2001-01-01")
            .await
            .contains(said)
    );
    let csv = server.get("/v1/parameters?format=csv&limit=100000").await;
    assert!(
        csv.headers()["link"]
            .to_str()
            .unwrap()
            .contains("rel=\"next\"")
    );
    assert_eq!(csv.text().await.unwrap().lines().count(), 100_001);
}

/// What is guessed of a header is told beside what is read, and changes nothing of it.
#[tokio::test]
async fn a_preview_guesses_what_other_columns_hold() {
    let server = Server::with(&["--workers", "0"]);
    let headers = "Zeit [s],Fahrbahn vorne,u_r,Weg vorne,z_r,V7";
    let table = ride::table(400, 200.0).replacen("t,u_f,u_r,z_f,z_r", headers, 1);
    let table = table.replace('\n', ",0\n").replacen("V7,0", "V7", 1);
    let preview = async |maps: &[&str]| -> Value {
        let file = Part::bytes(table.clone().into_bytes()).file_name("a.csv");
        let form = Form::new().part("file", file).text("band_hz", "0.5:40");
        let form = maps
            .iter()
            .fold(form, |form, map| form.text("map", (*map).to_owned()));
        let request = server.client.post(server.address("/v1/rides/preview"));
        request
            .multipart(form)
            .send()
            .await
            .unwrap()
            .json()
            .await
            .unwrap()
    };
    let seen = preview(&[]).await;
    let guess = |header: &str, channel: &str, unread: Option<&str>| serde_json::json!({"header": header, "channel": channel, "unread_unit": unread});
    let expected = [
        guess("Fahrbahn vorne", "u_f", None),
        guess("Weg vorne", "z_f", None),
    ];
    assert_eq!(seen["guesses"], Value::from(expected.to_vec()), "{seen}");
    assert_eq!(seen["columns"].as_array().unwrap().len(), 3);
    assert_eq!(seen["reading"][0], "Zeit [s] is read as t (s)");
    let seen = preview(&["u_f=Fahrbahn vorne"]).await;
    assert_eq!(seen["columns"].as_array().unwrap().len(), 4, "{seen}");
    assert_eq!(seen["guesses"], Value::from(expected[1..].to_vec()));
}

#[tokio::test]
async fn the_fleet_is_sorted_and_filtered_by_its_address() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 8, 240).await;
    let names = async |query: &str| -> Vec<String> {
        let text = page(&server, &format!("/bikes?{query}")).await;
        let rows = text
            .split("data-label=\"Bicycle\"><a href=\"/bikes/")
            .skip(1);
        rows.map(|row| row[..row.find('"').unwrap()].to_owned())
            .collect()
    };
    let all = names("").await;
    assert_eq!(all.len(), 8);
    assert!(all.is_sorted());
    let blank = names("name=&shows=&effect=&sort=name&order=").await;
    assert_eq!(blank, all, "the form's blank fields ask for nothing");
    let fleet = server.json("/v1/fleet").await;
    let bikes = fleet["bikes"].as_array().unwrap();
    let of = |name: &String| bikes.iter().find(|bike| bike["bike"] == **name).unwrap();
    let k_front = |name: &String| {
        of(name)["parameters"][0]["pooled"]["value"]
            .as_f64()
            .unwrap()
    };
    let sorted = names("sort=k_front&order=falling").await;
    assert_eq!(sorted.len(), 8);
    assert!(
        sorted.is_sorted_by(|a, b| k_front(a) >= k_front(b)),
        "{sorted:?}"
    );
    let last = |name: &String| of(name)["last_ride_at"].as_str().unwrap().to_owned();
    let sorted = names("sort=last").await;
    assert!(sorted.is_sorted_by(|a, b| last(a) <= last(b)), "{sorted:?}");
    assert_eq!(names("name=SEASON-003").await, ["season-003"]);
    assert!(names("name=nobody").await.is_empty());
    for (shows, kinds) in [("drift", ["drift", "both"]), ("step", ["step", "both"])] {
        let shown = names(&format!("shows={shows}")).await;
        let expected: Vec<&String> = (all.iter())
            .filter(|name| {
                let mut parameters = of(name)["parameters"].as_array().unwrap().iter();
                parameters.any(|p| kinds.iter().any(|kind| p["development"]["kind"] == **kind))
            })
            .collect();
        assert_eq!(shown.iter().collect::<Vec<_>>(), expected, "{shows}");
    }
    let effects: Vec<&Value> = bikes
        .iter()
        .flat_map(|b| b["effects"].as_array().unwrap())
        .collect();
    let with_some = bikes
        .iter()
        .filter(|b| b["effects"] != Value::Array(Vec::new()));
    assert_eq!(names("shows=effect").await.len(), with_some.count());
    if let Some(effect) = effects.first().and_then(|effect| effect.as_str()) {
        assert!(!names(&format!("effect={effect}")).await.is_empty());
    }
    assert!(names("effect=no_such_effect").await.is_empty());
    for query in ["sort=k", "order=down", "shows=all", "sorted=name"] {
        let refused = server.get(&format!("/bikes?{query}")).await;
        assert_eq!(refused.status(), 400, "{query}");
    }
}
