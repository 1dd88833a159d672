//! A server from outside: the time from an upload to its results, and how fast it answers.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use reqwest::header::{ETAG, IF_NONE_MATCH};
use reqwest::multipart::{Form, Part};
use reqwest::{Client, StatusCode};
use serde_json::Value;

use super::engine::{bike, ride};
use super::figure::Figure;
use crate::cli::{CliError, ride_csv, runtime};

/// Requests in flight when the rate of reading is measured, and for how long.
const READERS: usize = 8;
const READING: Duration = Duration::from_secs(2);
/// Rides in flight when the rate of rides is measured.
const RIDES: usize = 16;

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
    runtime()?.block_on(visitor.measure(runs))
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
            .ok_or_else(|| std::io::Error::other("the server ended before it listened"))?;
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
    async fn measure(&self, runs: usize) -> Result<Vec<Figure>, CliError> {
        let mut seen = Vec::new();
        // The first one warms up.
        for run in 0..=runs as u64 {
            seen.push(self.follow(minute(run)).await?);
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
        figures.push(self.rides_a_second().await?);
        figures.extend(self.reading(&job).await?);
        Ok(figures)
    }

    /// Uploads a ride and waits, by long polls, for what comes of it.
    async fn follow(&self, file: Vec<u8>) -> Result<Seen, CliError> {
        let begin = Instant::now();
        let job = self.submit(file).await?;
        let accepted = begin.elapsed();
        let (mut least_squares, mut etag) = (None, None::<reqwest::header::HeaderValue>);
        loop {
            let url = format!("{}{job}", self.url);
            let request = match &etag {
                Some(tag) => self.client.get(url + "?wait=30").header(IF_NONE_MATCH, tag),
                None => self.client.get(url),
            };
            let response = request.send().await?;
            if response.status() == StatusCode::NOT_MODIFIED {
                continue;
            }
            etag = response.headers().get(ETAG).cloned();
            let view: Value = response.json().await?;
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
    async fn submit(&self, file: Vec<u8>) -> Result<String, CliError> {
        let form = Form::new()
            .part("file", Part::bytes(file).file_name("bench.csv"))
            .text("bike", serde_json::to_string(&bike())?)
            .text("diagnosis", "false");
        let request = self.client.post(format!("{}/v1/rides", self.url));
        let response = request.multipart(form).send().await?;
        let status = response.status();
        let job: Value = response.json().await?;
        match job["links"]["job"].as_str() {
            Some(job) if status == StatusCode::ACCEPTED => Ok(job.to_owned()),
            _ => Err(std::io::Error::other(format!("{status}: {}", job["detail"])).into()),
        }
    }

    /// Many rides at once, from the first upload to the last result.
    async fn rides_a_second(&self) -> Result<Figure, CliError> {
        let files: Vec<_> = (0..RIDES as u64).map(|i| minute(1000 + i)).collect();
        let begin = Instant::now();
        let running: Vec<_> = files
            .into_iter()
            .map(|file| {
                let visitor = self.clone();
                tokio::spawn(async move {
                    let job = visitor.submit(file).await?;
                    let end = format!("{}{job}?wait=60", visitor.url);
                    visitor.client.get(end).send().await?.bytes().await?;
                    Ok::<_, CliError>(())
                })
            })
            .collect();
        for ride in running {
            ride.await.map_err(std::io::Error::other)??;
        }
        let time = [begin.elapsed()];
        let name = format!("rides of 60 s, {RIDES} at once, no diagnosis");
        Ok(Figure::rate(name, "rides/s", RIDES as f64, &time))
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
        let busy: Vec<_> = (0..RIDES as u64)
            .map(|i| {
                let visitor = self.clone();
                tokio::spawn(async move { visitor.submit(minute(2000 + i)).await })
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
                        client.get(&url).send().await?.bytes().await?;
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

/// A ride of a minute that the server has not met.
fn minute(seed: u64) -> Vec<u8> {
    let fresh = u64::from(std::process::id()) << 20;
    ride_csv::text(&ride(60.0, fresh + seed)).into_bytes()
}
