//! A server from outside: the time from an upload to its results, and how fast it answers.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use axum::http::header::ETAG;
use axum::http::{HeaderValue, StatusCode};
use serde_json::Value;
use veloid_engine::Settings;

use super::engine::{self, bike, ride};
use super::figure::Figure;
use super::machine::processor_time;
use crate::cli::client::Client;
use crate::cli::form::Form;
use crate::cli::runtime::runtime;
use crate::cli::{CliError, ride_csv};

/// Requests in flight when the rate of reading is measured, and for how long.
const READERS: usize = 8;
const READING: Duration = Duration::from_secs(2);
/// Rides in flight when the rate of rides is measured, without and with a diagnosis.
const RIDES: [(usize, bool); 2] = [(64, false), (16, true)];

/// Times the server at `address`, or one of its own.
pub fn figures(address: Option<String>, runs: usize) -> Result<Vec<Figure>, CliError> {
    let own = match address {
        Some(_) => None,
        None => Some(Own::start()?),
    };
    let url = match (&address, &own) {
        (Some(url), _) => url.trim_end_matches('/').to_owned(),
        (None, Some(own)) => own.url.clone(),
        (None, None) => String::new(),
    };
    let visitor = Visitor {
        client: Client::new(),
        url,
    };
    let process = own.as_ref().map(|own| own.child.id());
    runtime()?.block_on(visitor.measure(runs, process))
}

/// A server of its own, gone with its data when dropped.
struct Own {
    child: Child,
    url: String,
    data: std::path::PathBuf,
}

impl Own {
    fn start() -> Result<Self, CliError> {
        let data = std::env::temp_dir().join(format!("veloid-bench-{}", std::process::id()));
        std::fs::create_dir_all(&data)?;
        let mut child = Command::new(std::env::current_exe()?)
            .args([
                "--log",
                "warn",
                "serve",
                "--listen",
                "127.0.0.1:0",
                "--data",
            ])
            .arg(&data)
            .env_remove("DATABASE_URL")
            .stdout(Stdio::piped())
            .spawn()?;
        let lines = child.stdout.take().map(|out| BufReader::new(out).lines());
        let mut own = Self {
            child,
            url: String::new(),
            data,
        };
        own.url = lines
            .into_iter()
            .flatten()
            .map_while(Result::ok)
            .find_map(|line| line.strip_prefix("veloid listens on ").map(str::to_owned))
            .ok_or_else(|| std::io::Error::other("the server ended before it was listening"))?;
        Ok(own)
    }
}

impl Drop for Own {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = std::fs::remove_dir_all(&self.data);
    }
}

#[derive(Clone)]
struct Visitor {
    client: Client,
    url: String,
}

/// Times from the first byte of an upload.
struct Seen {
    accepted: Duration,
    least_squares: Duration,
    swarm: Duration,
    job: String,
}

impl Visitor {
    /// `process`: the server's, if it is here.
    async fn measure(&self, runs: usize, process: Option<u32>) -> Result<Vec<Figure>, CliError> {
        let mut seen = Vec::new();
        // The first one warms up.
        for run in 0..=runs as u64 {
            seen.push(self.follow(minute(run, 0)).await?);
        }
        let job = seen.swap_remove(0).job;
        let times = |of: fn(&Seen) -> Duration| seen.iter().map(of).collect::<Vec<_>>();
        let mut figures = vec![
            Figure::time("upload of a 60 s ride to 202", &times(|s| s.accepted)),
            Figure::time(
                "upload to least squares visible, 60 s",
                &times(|s| s.least_squares),
            ),
            Figure::time("upload to swarm finished, 60 s", &times(|s| s.swarm)),
        ];
        for (part, (rides, diagnosis)) in (1..).zip(RIDES) {
            let files: Vec<_> = (0..rides as u64).map(|i| minute(i, part)).collect();
            let settings = Settings {
                diagnosis,
                ..Settings::default()
            };
            let name = format!(
                "rides of 60 s, {} diagnosis",
                if diagnosis { "with" } else { "no" }
            );
            let meter = Meter::start(Some(std::process::id()));
            tokio::task::block_in_place(|| engine::alone(&files, &settings))?;
            figures.extend(meter.figures(&format!("{name}, engine alone"), rides));
            let meter = Meter::start(process);
            self.all_at_once(files, diagnosis).await?;
            figures.extend(meter.figures(&format!("{name}, all at once"), rides));
        }
        figures.extend(self.reading(&job).await?);
        Ok(figures)
    }

    /// Uploads a ride and waits, by long polls, for what comes of it.
    async fn follow(&self, file: Vec<u8>) -> Result<Seen, CliError> {
        let begin = Instant::now();
        let job = self.submit(file, false).await?;
        let accepted = begin.elapsed();
        let (mut least_squares, mut etag) = (None, None::<HeaderValue>);
        loop {
            let url = format!("{}{job}", self.url);
            let answer = match &etag {
                Some(tag) => self.client.get_unless(&(url + "?wait=30"), tag).await?,
                None => self.client.get(&url).await?,
            };
            if answer.status == StatusCode::NOT_MODIFIED {
                continue;
            }
            let view: Value = answer.json()?;
            etag = answer.headers.get(ETAG).cloned();
            if !view["least_squares"].is_null() {
                least_squares.get_or_insert_with(|| begin.elapsed());
            }
            if view["trials"]["done"] == view["trials"]["total"] {
                let swarm = begin.elapsed();
                return Ok(Seen {
                    accepted,
                    least_squares: least_squares.unwrap_or(swarm),
                    swarm,
                    job,
                });
            }
            if view["state"] == "failed" || view["state"] == "cancelled" {
                let detail = view["failure"]["detail"].to_string();
                return Err(std::io::Error::other(detail).into());
            }
        }
    }

    /// Uploads a ride; the address of its job.
    async fn submit(&self, file: Vec<u8>, diagnosis: bool) -> Result<String, CliError> {
        let form = Form::new()
            .file("file", "bench.csv", &file)
            .text("bike", &serde_json::to_string(&bike())?)
            .text("diagnosis", &diagnosis.to_string());
        let url = format!("{}/v1/rides", self.url);
        let answer = self.client.post_form(&url, form).await?;
        let (status, job) = (answer.status, answer.json::<Value>()?);
        match job["links"]["job"].as_str() {
            Some(job) if status == StatusCode::ACCEPTED => Ok(job.to_owned()),
            _ => Err(std::io::Error::other(format!("{status}: {}", job["detail"])).into()),
        }
    }

    /// From the first upload to the last result.
    async fn all_at_once(&self, files: Vec<Vec<u8>>, diagnosis: bool) -> Result<(), CliError> {
        let running: Vec<_> = files
            .into_iter()
            .map(|file| {
                let visitor = self.clone();
                tokio::spawn(async move {
                    let job = visitor.submit(file, diagnosis).await?;
                    visitor.ended(&job).await?;
                    Ok::<_, CliError>(())
                })
            })
            .collect();
        for ride in running {
            ride.await.map_err(std::io::Error::other)??;
        }
        Ok(())
    }

    async fn ended(&self, job: &str) -> Result<(), CliError> {
        let url = format!("{}{job}?wait=60", self.url);
        loop {
            let view: Value = self.client.get(&url).await?.json()?;
            if view["state"] != "queued" && view["state"] != "running" {
                return Ok(());
            }
        }
    }

    /// Reads a finished job over and over, with the server idle and with it at work.
    async fn reading(&self, job: &str) -> Result<Vec<Figure>, CliError> {
        let mut figures = Vec::new();
        let (count, _) = self.read_for_a_while(job).await?;
        figures.push(Figure::rate(
            format!("GET of a job, {READERS} connections"),
            "requests/s",
            count as f64,
            &[READING],
        ));
        let busy: Vec<_> = (0..RIDES[0].0 as u64)
            .map(|i| {
                let visitor = self.clone();
                tokio::spawn(async move { visitor.submit(minute(i, 3), false).await })
            })
            .collect();
        let (_, mut times) = self.read_for_a_while(job).await?;
        for ride in busy {
            ride.await.map_err(std::io::Error::other)??;
        }
        times.sort();
        let p99 = times.get(times.len() * 99 / 100).copied();
        let name = "GET of a job while rides come in and compute, p99";
        figures.push(Figure::time(name, &p99.into_iter().collect::<Vec<_>>()));
        Ok(figures)
    }

    async fn read_for_a_while(&self, job: &str) -> Result<(usize, Vec<Duration>), CliError> {
        let url = format!("{}{job}", self.url);
        let readers: Vec<_> = (0..READERS)
            .map(|_| {
                let (client, url) = (self.client.clone(), url.clone());
                tokio::spawn(async move {
                    let (begin, mut times) = (Instant::now(), Vec::new());
                    while begin.elapsed() < READING {
                        let asked = Instant::now();
                        client.get(&url).await?;
                        times.push(asked.elapsed());
                    }
                    Ok::<_, CliError>(times)
                })
            })
            .collect();
        let mut all = Vec::new();
        for reader in readers {
            all.extend(reader.await.map_err(std::io::Error::other)??);
        }
        Ok((all.len(), all))
    }
}

/// Wall time and processor time of many rides.
struct Meter {
    begin: Instant,
    process: Option<(u32, f64)>,
}

impl Meter {
    fn start(process: Option<u32>) -> Self {
        Self {
            process: process.and_then(|id| Some((id, processor_time(id)?))),
            begin: Instant::now(),
        }
    }

    fn figures(&self, name: &str, rides: usize) -> Vec<Figure> {
        let wall = Figure::rate(name, "rides/s", rides as f64, &[self.begin.elapsed()]);
        let spent = self.process.and_then(|(id, before)| {
            let each = (processor_time(id)? - before) / rides as f64;
            let name = format!("{name}, processor time of one");
            Some(Figure::time(name, &[Duration::from_secs_f64(each)]))
        });
        std::iter::once(wall).chain(spent).collect()
    }
}

/// A ride of a minute that the server has not met.
fn minute(index: u64, part: u64) -> Vec<u8> {
    let fresh = u64::from(std::process::id()) << 20;
    ride_csv::text(&ride(60.0, fresh + 1000 * part + index), &[]).into_bytes()
}
