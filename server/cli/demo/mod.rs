//! `serve --demo`: example rides and a season of one bicycle, sent through the server's own API.

mod rides;

use axum::http::StatusCode;
use serde_json::{Value, json};
use veloid_engine::EngineError;

use super::client::{Client, ClientError};
use super::form::Form;
use rides::Example;

/// Why the demo ended early.
#[derive(Debug, thiserror::Error)]
enum DemoError {
    #[error("{0}")]
    Http(#[from] ClientError),
    #[error("the example rides: {0}")]
    Simulation(#[from] EngineError),
    #[error("the example rides: {0}")]
    Thread(#[from] tokio::task::JoinError),
    #[error("{status}: {detail}")]
    Refused { status: StatusCode, detail: Value },
}

/// Uploads the examples and prints where their results are, and how they ended.
pub async fn run(server: String) {
    if let Err(error) = upload_and_follow(&server).await {
        eprintln!("demo: {error}");
    }
}

async fn upload_and_follow(server: &str) -> Result<(), DemoError> {
    let client = Client::with_key(std::env::var("VELOID_KEY").ok());
    let mut jobs = Vec::new();
    for example in tokio::task::spawn_blocking(rides::singles).await?? {
        let about = example.about;
        let job = upload(&client, server, example).await?;
        println!("demo: {about}: {}", link(server, &job, "page"));
        jobs.push(job);
    }
    let mut season = Vec::new();
    for example in tokio::task::spawn_blocking(rides::season).await?? {
        season.push(upload(&client, server, example).await?);
    }
    note_service(&client, server).await?;
    println!(
        "demo: a season with a service: {server}/bikes/{}",
        rides::SEASON
    );
    for job in jobs {
        report(&finished(&client, server, job).await?);
    }
    for job in season {
        finished(&client, server, job).await?;
    }
    let study = study(&client, server).await?;
    println!(
        "demo: the season's rides as one: {}",
        link(server, &study, "page")
    );
    report(&finished(&client, server, study).await?);
    println!("demo: done, all bicycles are at {server}/bikes");
    Ok(())
}

/// Sends a ride; its job.
async fn upload(client: &Client, server: &str, example: Example) -> Result<Value, DemoError> {
    let mut form = Form::new()
        .file("file", &example.file, example.csv.as_bytes())
        .text("bike", &example.bike.to_string())
        .text("options", &example.options.to_string());
    if let Some(day) = example.ridden_at {
        form = form.text("facts", &json!({"ridden_at": day}).to_string());
    }
    let answer = client
        .post_form(&format!("{server}/v1/rides"), form)
        .await?;
    let (status, job) = (answer.status, answer.json::<Value>()?);
    if status != StatusCode::ACCEPTED {
        let detail = job["detail"].clone();
        return Err(DemoError::Refused { status, detail });
    }
    Ok(job)
}

/// Notes the service in the season bicycle's history.
async fn note_service(client: &Client, server: &str) -> Result<(), DemoError> {
    let url = format!("{server}/v1/bikes/{}/events", rides::SEASON);
    let event = json!({"date": rides::SERVICE_DAY, "text": "fork service"});
    let answer = client.post_json(&url, &event).await?;
    if answer.status.is_success() {
        return Ok(());
    }
    let problem: Value = answer.json()?;
    Err(DemoError::Refused {
        status: answer.status,
        detail: problem["detail"].clone(),
    })
}

/// The study of the season's rides, which the server queues by itself too; its job.
async fn study(client: &Client, server: &str) -> Result<Value, DemoError> {
    let url = format!("{server}/v1/studies");
    let rides = json!({"bike": rides::SEASON});
    let answer = client.post_json(&url, &rides).await?;
    let (status, job) = (answer.status, answer.json::<Value>()?);
    match status {
        StatusCode::ACCEPTED => Ok(job),
        _ => Err(DemoError::Refused {
            status,
            detail: job["detail"].clone(),
        }),
    }
}

fn link(server: &str, job: &Value, name: &str) -> String {
    format!(
        "{server}{}",
        job["links"][name].as_str().unwrap_or_default()
    )
}

/// The job at its end.
async fn finished(client: &Client, server: &str, mut job: Value) -> Result<Value, DemoError> {
    while job["finished_at"].is_null() {
        let url = format!("{}?wait=30", link(server, &job, "job"));
        job = client.get(&url).await?.json()?;
    }
    Ok(job)
}

fn report(job: &Value) {
    let text = |value: &Value| value.as_str().unwrap_or("none").to_owned();
    let name = match job["study"].as_array() {
        Some(rides) => format!("{} rides as one", rides.len()),
        None => text(&job["ride"]["name"]),
    };
    let state = text(&job["state"]);
    match job["failure"]["detail"].as_str() {
        Some(detail) => println!("demo: {name}: {state}: {detail}"),
        None => println!("demo: {name}: {state}, verdict {}", text(&job["verdict"])),
    }
}
