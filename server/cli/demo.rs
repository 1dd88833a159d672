//! `serve --demo`: an example ride, sent through the server's own API.

use reqwest::header::AUTHORIZATION;
use reqwest::multipart::{Form, Part};
use reqwest::{Client, StatusCode};
use serde_json::Value;
use veloid_engine::simulate::simulated_ride::SimulatedRide;

use super::ride_csv;

/// The paper's bicycle for a minute on an ISO class B road, with 0.05 mm of noise.
fn example() -> (String, &'static str) {
    let simulated_ride = SimulatedRide {
        noise_displacement_m: 5e-5,
        ..SimulatedRide::default()
    };
    let bike = r#"{"bike": "demo", "mass_front_kg": 23.0, "mass_rear_kg": 63.0, "l_front_m": 0.808, "l_rear_m": 0.293}"#;
    (ride_csv::text(&simulated_ride.ride(), &[]), bike)
}

/// A client that shows the key in `VELOID_KEY`, if there is one.
fn client() -> Result<Client, reqwest::Error> {
    let key = std::env::var("VELOID_KEY").ok();
    let bearer = key.and_then(|key| format!("Bearer {key}").parse().ok());
    let headers = bearer.map(|value| (AUTHORIZATION, value));
    let headers = headers.into_iter().collect();
    Client::builder().default_headers(headers).build()
}

/// Uploads the example and prints where its result is, and how it ended.
pub async fn run(server: String) {
    if let Err(error) = upload_and_follow(&server).await {
        eprintln!("demo: {error}");
    }
}

async fn upload_and_follow(server: &str) -> Result<(), reqwest::Error> {
    let (ride, bike) = example();
    let form = Form::new()
        .part("file", Part::text(ride).file_name("demo.csv"))
        .text("bike", bike);
    let client = client()?;
    let request = client.post(format!("{server}/v1/rides")).multipart(form);
    let response = request.send().await?;
    let status = response.status();
    let mut job: Value = response.json().await?;
    if status != StatusCode::ACCEPTED {
        eprintln!("demo: {status}: {}", job["detail"]);
        return Ok(());
    }
    let link = |job: &Value, name: &str| {
        format!(
            "{server}{}",
            job["links"][name].as_str().unwrap_or_default()
        )
    };
    println!("demo: the result page is {}", link(&job, "page"));
    while job["finished_at"].is_null() {
        let url = format!("{}?wait=30", link(&job, "job"));
        job = client.get(url).send().await?.json().await?;
    }
    let text = |value: &Value| value.as_str().unwrap_or("none").to_owned();
    match job["failure"]["detail"].as_str() {
        Some(detail) => println!("demo: {}: {detail}", text(&job["state"])),
        None => println!(
            "demo: {}, verdict {}",
            text(&job["state"]),
            text(&job["verdict"])
        ),
    }
    Ok(())
}
