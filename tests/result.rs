//! The one answer, wherever it is shown.

use serde_json::{Value, json};

use crate::harness::{Folder, Server, identify, veloid};
use crate::ride::BIKE;

const QUICK: [&str; 6] = ["--trials", "1", "--iterations", "3", "--particles", "6"];

/// A simulated ride.
fn simulated(folder: &Folder, args: &[&str]) -> Vec<u8> {
    let ride = folder.0.join("ride.csv");
    let path = ride.to_str().unwrap();
    let more = [
        &["simulate", path, "--duration", "30", "--noise", "2e-5"],
        args,
    ]
    .concat();
    assert!(veloid(&more).status.success());
    std::fs::read(ride).unwrap()
}

async fn result_rows(server: &Server, job: &Value) -> Vec<Value> {
    let id = job["id"].as_str().unwrap();
    let rows = server
        .json(&format!("/v1/parameters?method=result&job={id}"))
        .await;
    rows["items"].as_array().unwrap().clone()
}

/// A value as people read it: to two digits of its 95 % interval.
fn shown(found: &Value) -> String {
    let [value, error] = ["value", "std_error"].map(|name| found[name].as_f64().unwrap());
    let exponent = (1.96 * error).log10().floor() as i32 - 1;
    let step = 10f64.powi(exponent);
    let decimals = exponent.min(0).unsigned_abs() as usize;
    format!("{:.decimals$}", (value / step).round() * step)
}

#[tokio::test]
async fn friction_is_in_the_one_result_that_every_place_shows() {
    let folder = Folder::new();
    let ride = simulated(&folder, &["--effect", "coulomb_friction:front:friction=40"]);
    let server = Server::start();
    let quick = json!({"trials": 1, "iterations": 3, "particles": 6}).to_string();
    let answer = server.upload(ride, BIKE, &[("options", &quick)]).await;
    let job = answer.headers()["location"].to_str().unwrap().to_owned();
    let view = server.succeeded(&job).await;
    assert_eq!(view["verdict"], "named");
    let report = server.json(&format!("{job}/report")).await;

    let b = &report["result"]["front"]["B"];
    assert_eq!(
        (&b["method"], &b["unit"]),
        (&json!("extended"), &json!("N s/m"))
    );
    assert_eq!(
        b["value"],
        report["diagnosis"]["extended"]["front"]["b_n_s_m"]
    );
    let [low, high] = [0, 1].map(|i| b["interval"][i].as_f64().unwrap());
    assert!(low < 1150.0 && 1150.0 < high, "{b}");
    let off = report["output_error"]["front"]["b_n_s_m"].as_f64().unwrap();
    assert!(
        off > high,
        "{off}: the plain model takes friction for damping"
    );
    let mass = &report["result"]["front"]["mass"];
    assert_eq!(
        (&mass["value"], &mass["std_error"]),
        (&json!(23.0), &Value::Null)
    );
    assert_eq!(mass["why"], "given in the bike file");

    let rows = result_rows(&server, &view).await;
    assert_eq!(rows.len(), 4, "k and B of both axles");
    let row = rows
        .iter()
        .find(|r| r["axle"] == "front" && r["name"] == "b_n_s_m");
    assert_eq!(row.unwrap()["value"], b["value"]);
    let course = server.json("/v1/bikes/lab-7/course").await;
    let of_front = |c: &&Value| c["axle"] == "front" && c["name"] == "b_n_s_m";
    let followed = course["courses"].as_array().unwrap().iter().find(of_front);
    assert_eq!(followed.unwrap()["points"][0]["value"], b["value"]);

    let digits = shown(b);
    let page = view["links"]["page"].as_str().unwrap();
    for path in [page, "/jobs", "/bikes/lab-7"] {
        let html = server.get(path).await.text().await.unwrap();
        let plain = html.replace(['\u{202f}', '\u{a0}'], "");
        assert!(plain.contains(&digits), "{path} shows B = {digits}");
    }
    let html = server.get(page).await.text().await.unwrap();
    let (result, sentence) = (html.find("id=\"result\""), html.find("id=\"sentence\""));
    assert!(result < sentence, "the answer comes first");
    assert!(html.contains("Extended model"), "a row of the methods");
}

#[tokio::test]
async fn without_a_verdict_no_place_shows_a_number() {
    let folder = Folder::new();
    let ride = String::from_utf8(simulated(&folder, &[])).unwrap();
    // The front displacement with the wrong sign.
    let mut lines = ride.lines();
    let header = lines.next().unwrap();
    let column = header.split(',').position(|name| name == "z_f").unwrap();
    let mut turned = format!("{header}\n");
    for line in lines {
        let cell = |(i, cell): (usize, &str)| match i == column {
            true => (-cell.parse::<f64>().unwrap()).to_string(),
            false => cell.to_owned(),
        };
        let cells: Vec<String> = line.split(',').enumerate().map(cell).collect();
        turned += &(cells.join(",") + "\n");
    }
    let path = folder.write("turned.csv", &turned);
    let (report, text) = identify(&path, &folder.write("bike.json", BIKE), &QUICK);
    assert_eq!(report["diagnosis"]["verdict"], "cannot_tell");
    for name in ["k", "B"] {
        let found = &report["result"]["front"][name];
        assert_eq!(
            (&found["value"], &found["interval"]),
            (&Value::Null, &Value::Null)
        );
        assert!(!found["why"].as_str().unwrap().is_empty());
    }
    assert!(text.starts_with("front  k withheld"), "{text}");

    let server = Server::start();
    let quick = json!({"trials": 1, "iterations": 3, "particles": 6}).to_string();
    let answer = server
        .upload(turned.into_bytes(), BIKE, &[("options", &quick)])
        .await;
    let job = answer.headers()["location"].to_str().unwrap().to_owned();
    let view = server.succeeded(&job).await;
    assert!(result_rows(&server, &view).await.is_empty());
    let course = server.json("/v1/bikes/lab-7/course").await;
    assert_eq!(course["courses"], json!([]));
    let page = view["links"]["page"].as_str().unwrap();
    let html = server.get(page).await.text().await.unwrap();
    assert!(html.contains("withheld") && html.contains("No result: fix this first"));
    assert!(html.contains("state unanswered") && !html.contains("state succeeded"));
}
