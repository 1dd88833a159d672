//! What is known of rides besides their files: sent, changed, searched, exported, and what trends go by.

use reqwest::Response;
use reqwest::multipart::{Form, Part};
use serde_json::{Value, json};

use crate::built::has;
use crate::deletion::{Sent, sent};
use crate::harness::{Server, nothing_is_kept, time};
use crate::ride;

async fn patch(server: &Server, sent: &Sent, patch: &Value) -> Response {
    let request = server.client.patch(server.address(&sent.ride));
    let request = request.header("content-type", "application/merge-patch+json");
    request.body(patch.to_string()).send().await.unwrap()
}

async fn facts(server: &Server, sent: &Sent) -> Value {
    let mut facts = server.json(&sent.ride).await["facts"].clone();
    assert_eq!(server.json(&sent.job).await["ride"]["facts"], facts);
    let known = facts.as_object_mut().unwrap();
    known.retain(|_, value| !value.is_null() && *value != json!([]));
    facts
}

async fn jobs(server: &Server, query: &str) -> Vec<String> {
    let page = server.json(&format!("/v1/jobs?{query}")).await;
    let jobs = page["items"].as_array().unwrap().iter();
    jobs.map(|job| job["links"]["job"].as_str().unwrap().to_owned())
        .collect()
}

#[tokio::test]
async fn facts_come_with_the_file_and_the_form_and_are_changed_later() {
    let server = Server::start();
    let said = "# lab-7, dry\n# pressure_front_bar: 2.2\n# gain: 3\n# road: gravel\n";
    let file = [said, &ride::table(1000, 200.0)].concat().into_bytes();
    let parts = [
        ("road", "cobbles"),
        ("tags", "wet, race"),
        ("facts", r#"{"rider_mass_kg": 71.5, "stem_mm": 90}"#),
    ];
    let upload = async |parts: &[(&str, &str)]| {
        let parts = [&ride::QUICK, parts].concat();
        server.upload(file.clone(), ride::BIKE, &parts).await
    };
    let response = upload(&parts).await;
    assert_eq!(response.status(), 202);
    let job: Value = response.json().await.unwrap();
    let sent = Sent {
        job: job["links"]["job"].as_str().unwrap().to_owned(),
        ride: format!("/v1/rides/{}", job["ride"]["id"].as_str().unwrap()),
        sha256: String::new(),
    };
    let known = json!({"pressure_front_bar": 2.2, "gain": 3.0, "road": "cobbles", "tags": ["wet", "race"],
        "rider_mass_kg": 71.5, "stem_mm": 90.0});
    assert_eq!(facts(&server, &sent).await, known);
    server.succeeded(&sent.job).await;

    let revision = server.json(&sent.job).await["revision"].clone();
    let change = json!({"pressure_front_bar": 1.9, "road": null, "notes": "a\nb"});
    assert_eq!(patch(&server, &sent, &change).await.status(), 200);
    let known = json!({"pressure_front_bar": 1.9, "gain": 3.0, "tags": ["wet", "race"], "rider_mass_kg": 71.5,
        "stem_mm": 90.0, "notes": "a\nb"});
    assert_eq!(facts(&server, &sent).await, known);
    assert_ne!(server.json(&sent.job).await["revision"], revision);
    // The same file again takes nothing back, but what is said of it counts.
    assert_eq!(upload(&[]).await.status(), 202);
    assert_eq!(facts(&server, &sent).await, known);
    assert_eq!(
        upload(&[("rider", "Ada")]).await.headers()["veloid-known"],
        "true"
    );
    assert_eq!(facts(&server, &sent).await["rider"], "Ada");

    for (refused, said) in [
        (
            json!({"pressure_rear_bar": 220}),
            "pressure_rear_bar: 220 bar, expected 0.1 to 20 bar",
        ),
        (json!({"colour": "red"}), "unknown fact `colour`"),
        (json!({"rider": 7}), "expected a text"),
        (json!([1]), "facts: "),
    ] {
        let response = patch(&server, &sent, &refused).await;
        assert_eq!(response.status(), 422, "{refused}");
        let problem: Value = response.json().await.unwrap();
        assert_eq!(problem["type"], "urn:veloid:problem:bad-fact");
        assert!(
            problem["detail"].as_str().unwrap().contains(said),
            "{problem}"
        );
    }
    let large = json!({"notes": "x".repeat(70_000)});
    assert_eq!(patch(&server, &sent, &large).await.status(), 413);
    let trail = server.json("/v1/audit").await;
    let subject = trail["items"][0]["subject"].as_str().unwrap();
    assert!(
        subject.ends_with(": notes, pressure_front_bar, road"),
        "{subject}"
    );
}

#[tokio::test]
async fn a_fact_that_is_refused_leaves_no_file() {
    let server = Server::start();
    for (above, part, said) in [
        (
            "",
            ("temperature_c", "warm"),
            "temperature_c: 'warm', expected a number",
        ),
        (
            "",
            ("facts", r#"{"rider": 1}"#),
            "rider: '1', expected a text",
        ),
        (
            "# rider: me\n# ridden_at: tomorrow\n",
            ("rider", "you"),
            "line 2: ridden_at: 'tomorrow'",
        ),
        (
            "# rider_mass_kg: 700\n",
            ("rider", "you"),
            "700 kg, expected 5 to 300 kg",
        ),
    ] {
        let file = [above, &ride::table(500, 200.0)].concat().into_bytes();
        let response = server.upload(file, ride::BIKE, &[part]).await;
        assert_eq!(response.status(), 422);
        let problem: Value = response.json().await.unwrap();
        assert!(
            problem["detail"].as_str().unwrap().contains(said),
            "{problem}"
        );
    }
    nothing_is_kept(&server);
}

#[tokio::test]
async fn rides_are_found_by_tag_and_date_and_exported_with_their_facts() {
    let server = Server::start();
    let may = [
        ("ridden_at", "2026-05-01"),
        ("tags", "wet,race"),
        ("rider", "=Ada"),
    ];
    let may = sent(&server, 1000, &may).await;
    let june = sent(
        &server,
        1001,
        &[
            ("ridden_at", "2026-06-01T10:00:00+02:00"),
            ("tags", "wet"),
            ("more", "stem_mm: 90"),
        ],
    )
    .await;
    let undated = sent(&server, 1002, &[]).await;
    for (query, expected) in [
        ("tag=wet", vec![&june, &may]),
        ("tag=race&bike=lab-7", vec![&may]),
        ("tag=dry", vec![]),
        ("to=2026-05-31", vec![&may]),
        ("from=2026-05-01&to=2026-06-01", vec![&june, &may]),
        ("from=2026-06-02", vec![&undated]),
    ] {
        let expected: Vec<&String> = expected.iter().map(|sent| &sent.job).collect();
        assert_eq!(
            jobs(&server, query).await.iter().collect::<Vec<_>>(),
            expected,
            "{query}"
        );
        let page = server
            .get(&format!("/jobs?{query}"))
            .await
            .text()
            .await
            .unwrap();
        for sent in [&may, &june, &undated] {
            let shown = page.contains(sent.job.trim_start_matches("/v1"));
            assert_eq!(shown, expected.contains(&&sent.job), "{query}");
        }
    }
    assert_eq!(server.get("/v1/jobs?from=soon").await.status(), 400);

    let id = may.job.rsplit('/').next().unwrap();
    let found = server.json(&format!("/v1/parameters?job={id}")).await;
    assert_eq!(found["items"][0]["facts"]["tags"], json!(["wet", "race"]));
    let csv = server
        .get("/v1/parameters?format=csv&limit=1000")
        .await
        .text()
        .await
        .unwrap();
    assert!(csv.lines().next().unwrap().ends_with("version,ridden_at,pressure_front_bar,pressure_rear_bar,temperature_c,rider,rider_mass_kg,tyres,road,tags,notes,further,ride,file,low,high,page"));
    assert!(
        csv.contains(",2026-05-01,,,,'=Ada,,,,\"wet, race\",,,"),
        "{csv}"
    );
    assert!(csv.contains("\"{\"\"stem_mm\"\":90.0}\","), "{csv}");
    assert!(csv.lines().nth(1).unwrap().contains(",ride.csv,"), "{csv}");
    if !has("parquet") {
        return;
    }
    let parquet = server
        .get("/v1/parameters?format=parquet")
        .await
        .bytes()
        .await
        .unwrap();
    assert!(parquet.starts_with(b"PAR1"));
}

#[tokio::test]
async fn a_bicycles_course_goes_by_the_date_ridden() {
    let server = Server::start();
    let first = sent(&server, 1000, &[("ridden_at", "2026-06-01")]).await;
    let second = sent(&server, 1001, &[("ridden_at", "2026-05-01")]).await;
    let third = sent(&server, 1002, &[]).await;
    let order = async || {
        let course = server.json("/v1/bikes/lab-7/course").await;
        let points = course["courses"][0]["points"].as_array().unwrap().clone();
        let dated = points
            .windows(2)
            .all(|pair| time(&pair[0]["dated_at"]) < time(&pair[1]["dated_at"]));
        assert!(dated, "{points:#?}");
        let jobs = points
            .iter()
            .map(|point| format!("/v1/jobs/{}", point["job"].as_str().unwrap()));
        jobs.collect::<Vec<_>>()
    };
    assert_eq!(order().await, [&*second.job, &first.job, &third.job]);
    let early = json!({"ridden_at": "2026-04-01"});
    assert_eq!(patch(&server, &third, &early).await.status(), 200);
    assert_eq!(order().await, [&*third.job, &second.job, &first.job]);
    assert_eq!(
        patch(&server, &third, &json!({"ridden_at": null}))
            .await
            .status(),
        200
    );
    assert_eq!(order().await, [&*second.job, &first.job, &third.job]);
}

#[tokio::test]
async fn stamps_that_count_from_1970_date_a_ride() {
    let server = Server::start();
    let table = ride::table(1000, 200.0);
    let mut lines = table.lines();
    let mut file = format!("{}\n", lines.next().unwrap());
    for line in lines {
        let (t, rest) = line.split_once(',').unwrap();
        let t: f64 = t.parse().unwrap();
        file.push_str(&format!("{:.3},{rest}\n", 1_777_628_400.0 + t));
    }
    let response = server
        .upload(file.into_bytes(), ride::BIKE, &ride::QUICK)
        .await;
    assert_eq!(response.status(), 202);
    let job: Value = response.json().await.unwrap();
    assert_eq!(job["ride"]["facts"]["ridden_at"], "2026-05-01T09:40:00Z");
    assert_eq!(job["dated_at"], "2026-05-01T09:40:00.000Z");
}

/// Dates of ISO 8601 in the time column, or in a track beside it, date a ride, unless the user does.
#[tokio::test]
async fn dates_in_a_file_date_a_ride() {
    let server = Server::start();
    let table = ride::table(1000, 200.0);
    let iso = |day: &str| {
        let row = |(i, line): (usize, &str)| match line.split_once(',') {
            Some((_, rest)) if i > 0 => {
                let ms = 5 * (i - 1);
                format!(
                    "{day}T09:40:{:02}.{:03}+02:00,{rest}\n",
                    ms / 1000,
                    ms % 1000
                )
            }
            _ => format!("{line}\n"),
        };
        table.lines().enumerate().map(row).collect::<String>()
    };
    let upload = async |files: &[(&str, String)], parts: &[(&str, &str)]| -> Value {
        let mut form = Form::new().text("bike", ride::BIKE);
        for (name, text) in files {
            let part = Part::bytes(text.clone().into_bytes()).file_name((*name).to_owned());
            form = form.part("file", part);
        }
        for (name, text) in ride::QUICK.iter().chain(parts) {
            form = form.text((*name).to_owned(), (*text).to_owned());
        }
        let request = server.client.post(server.address("/v1/rides"));
        let response = request.multipart(form).send().await.unwrap();
        let (status, body) = (response.status(), response.text().await.unwrap());
        assert_eq!(status, 202, "{body}");
        serde_json::from_str(&body).unwrap()
    };
    let points: String = (0..8)
        .map(|s| format!("<trkpt lat=\"49\" lon=\"8\"><time>2026-05-03T10:00:0{s}Z</time><extensions><speed>5.{s}</speed></extensions></trkpt>"))
        .collect();
    let gpx = format!(
        "<?xml version=\"1.0\"?><gpx version=\"1.1\"><trk><trkseg>{points}</trkseg></trk></gpx>"
    );
    let may = upload(&[("may.csv", iso("2026-05-01"))], &[]).await;
    assert_eq!(may["ride"]["facts"]["ridden_at"], "2026-05-01T07:40:00Z");
    assert_eq!(may["dated_at"], "2026-05-01T07:40:00.000Z");
    let said = [("ridden_at", "2026-05-09")];
    let said = upload(&[("june.csv", iso("2026-05-02"))], &said).await;
    assert_eq!(said["ride"]["facts"]["ridden_at"], "2026-05-09");
    let two = upload(&[("imu.csv", table.clone()), ("unit.gpx", gpx)], &[]).await;
    assert_eq!(two["ride"]["facts"]["ridden_at"], "2026-05-03T10:00:00Z");
    let ahead = upload(&[("ahead.csv", iso("2099-05-02"))], &[]).await;
    assert_eq!(ahead["ride"]["facts"]["ridden_at"], Value::Null);
}

#[tokio::test]
async fn facts_of_a_deleted_ride_do_not_come_back_with_its_file() {
    let server = Server::start();
    let before = sent(&server, 1000, &[("rider", "Ada"), ("tags", "wet")]).await;
    let deleted = server
        .client
        .delete(server.address(&before.ride))
        .send()
        .await;
    assert_eq!(deleted.unwrap().status(), 200);
    assert_eq!(
        patch(&server, &before, &json!({"rider": "Bob"}))
            .await
            .status(),
        404
    );
    let after = sent(&server, 1000, &[("road", "gravel")]).await;
    assert_eq!(
        (after.ride == before.ride, after.job == before.job),
        (true, false)
    );
    assert_eq!(facts(&server, &after).await, json!({"road": "gravel"}));
    assert!(jobs(&server, "tag=wet").await.is_empty());
}

#[tokio::test]
async fn the_result_page_shows_facts_and_changes_them() {
    let server = Server::start();
    let sent = sent(
        &server,
        1000,
        &[
            ("rider", "<script>Ada"),
            ("tags", "wet"),
            ("more", "stem_mm: 90"),
        ],
    )
    .await;
    let path = sent.job.trim_start_matches("/v1");
    let page = server.get(path).await.text().await.unwrap();
    for part in [
        "&#60;script&#62;Ada",
        "Stem mm",
        "name=\"pressure_front_bar\"",
        "stem_mm: 90",
    ] {
        assert!(page.contains(part), "{part} is missing");
    }
    let press = async |site: &str, body: &'static str| {
        let address = server.address(&format!("{}/facts", sent.ride.trim_start_matches("/v1")));
        let request = server.client.post(address).header("Sec-Fetch-Site", site);
        let request = request.header("content-type", "application/x-www-form-urlencoded");
        request.body(body).send().await.unwrap().status()
    };
    let filled = "rider=&tags=dry&pressure_front_bar=2.1&notes=a%0D%0Ab&more=fork_clicks:+7";
    assert_eq!(press("cross-site", filled).await, 403);
    assert_eq!(press("same-origin", filled).await, 200);
    let known =
        json!({"tags": ["dry"], "pressure_front_bar": 2.1, "notes": "a\r\nb", "fork_clicks": 7.0});
    assert_eq!(facts(&server, &sent).await, known);
    assert_eq!(press("same-origin", "pressure_front_bar=much").await, 422);
    assert_eq!(press("same-origin", "colour=red").await, 422);
    let form = server.get("/").await.text().await.unwrap();
    assert!(form.contains("About the ride") && form.contains("name=\"temperature_c\""));
}
