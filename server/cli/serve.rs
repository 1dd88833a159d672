use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use clap::Args;
use tokio::net::TcpListener;
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;

use super::CliError;
use super::demo;
use super::keeping::{Keeping, keep_tidy};
use super::storage::Storage;
use super::worker::{WorkLimits, asked_to_stop, cores};
use crate::api::Server;
use crate::api::access::{Access, Limits, Mode};
use crate::api::signs::Signs;
use crate::cli::webhook_options::WebhookOptions;
use crate::http::{self, HttpLimits};
use crate::jobs::{self, Hub, Queue, RideCache};
use crate::store::Db;
use crate::store::key::{self, KeyRow};
use crate::watch::watch;

/// Time that answers in progress get, from the moment on in which the server is asked to stop.
const DRAIN: Duration = Duration::from_secs(5);

/// Serves the HTTP API and the web pages, with workers in the same process unless `--workers 0`.
#[derive(Args)]
pub struct Serve {
    #[command(flatten)]
    storage: Storage,
    #[command(flatten)]
    limits: WorkLimits,
    /// Address to listen on.
    #[arg(long, env = "VELOID_LISTEN", default_value = "127.0.0.1:8080")]
    listen: SocketAddr,
    /// Threads for swarms and diagnoses; by default one per core; 0 leaves the work to other processes.
    #[arg(long, env = "VELOID_WORKERS")]
    workers: Option<usize>,
    /// Largest upload (bytes).
    #[arg(long, env = "VELOID_MAX_UPLOAD", default_value_t = 256 << 20)]
    max_upload: u64,
    #[command(flatten)]
    http: HttpLimits,
    #[command(flatten)]
    entry: Entry,
    #[command(flatten)]
    keeping: Keeping,
    #[command(flatten)]
    webhooks: WebhookOptions,
    /// Upload example rides and a season of one bicycle through the API and print the addresses of the results.
    #[arg(long)]
    demo: bool,
}

/// Who may enter.
#[derive(Args)]
struct Entry {
    /// Require a key on a loopback address too, for example behind a proxy.
    #[arg(long, env = "VELOID_KEYS", conflicts_with = "open")]
    keys: bool,
    /// Serve everyone who can reach the address, without keys.
    #[arg(long, env = "VELOID_OPEN")]
    open: bool,
    /// Requests per minute of a key without its own limit.
    #[arg(long, env = "VELOID_REQUESTS_PER_MINUTE", default_value_t = 6000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    requests_per_minute: u32,
    /// Queued and running jobs of a key without its own limit.
    #[arg(long, env = "VELOID_UNFINISHED_JOBS", default_value_t = 1000)]
    unfinished_jobs: i64,
    /// Queued and running jobs in total; further uploads are rejected for the moment.
    #[arg(long, env = "VELOID_QUEUE", default_value_t = 10_000)]
    queue: i64,
}

impl Entry {
    /// A server that others reach needs a key, or the word that it needs none.
    async fn access(&self, db: &Db, address: SocketAddr) -> Result<Access, CliError> {
        let mode = match (self.open, self.keys || !address.ip().is_loopback()) {
            (true, _) => Mode::Open,
            (false, true) => Mode::Keys,
            (false, false) => Mode::Local,
        };
        if mode == Mode::Keys && !key::list(db).await?.iter().any(KeyRow::is_valid) {
            return Err(match address.ip().is_loopback() {
                true => CliError::NoKeysAskedFor,
                false => CliError::NoKeys(address),
            });
        }
        let limits = Limits {
            requests_per_minute: self.requests_per_minute,
            unfinished_jobs: self.unfinished_jobs,
            queue: self.queue,
        };
        Ok(Access::new(mode, limits))
    }
}

impl Serve {
    pub async fn run(self) -> Result<(), CliError> {
        let storage = self.storage.clone();
        (self.serve().await).map_err(|error| storage.blame(error))
    }

    async fn serve(self) -> Result<(), CliError> {
        let targets = self.webhooks.targets()?;
        let (db, files) = self.storage.begin().await?;
        db.settle().await?;
        let access = self.entry.access(&db, self.listen).await?;
        let (readers, hub) = (self.limits.readers(&self.storage)?, Hub::new());
        let rides = RideCache::new(db.clone(), files.clone(), Arc::clone(&readers));
        let threads = self.workers.unwrap_or_else(cores);
        let lock = match threads {
            0 => None,
            _ => self.storage.lock_for_work(&db)?,
        };
        let running = match threads {
            0 => None,
            _ => Some(
                jobs::start(
                    self.limits
                        .work(&db, &rides, &hub, threads, targets.clone())?,
                )
                .await?,
            ),
        };
        let queue = match &running {
            Some(running) => running.queue.clone(),
            None => Queue(db.river().build()?),
        };

        let stop = CancellationToken::new();
        tokio::spawn(watch(db.clone(), files.clone(), stop.clone()));
        let server = Arc::new(Server {
            db,
            files,
            rides,
            queue,
            hub,
            readers,
            long_readers: Arc::default(),
            signs: Signs::default(),
            max_upload: self.max_upload,
            access,
            policy: self.keeping.policy(),
            targets,
            stop: stop.clone(),
        });
        tokio::spawn(keep_tidy(
            Arc::clone(&server),
            self.storage.clone(),
            stop.clone(),
        ));
        let listener = TcpListener::bind(self.listen).await?;
        let address = listener.local_addr()?;
        println!("veloid listens on http://{address}");
        let served = http::serve(
            listener,
            crate::router::router(server),
            self.http.granted(),
            stop.clone(),
        );
        let mut served = tokio::spawn(served);
        if self.demo {
            tokio::spawn(demo::run(format!("http://{address}")));
        }

        tokio::select! {
            asked = asked_to_stop() => asked?,
            ended = &mut served => return Ok(ended.map_err(std::io::Error::other)?),
        }
        eprintln!("veloid is stopping");
        let until = Instant::now() + DRAIN;
        stop.cancel();
        if let Some(running) = running {
            running.stop().await?;
        }
        // Whoever still downloads after that is cut off.
        let _ = tokio::time::timeout_at(until, served).await;
        drop(lock);
        Ok(())
    }
}
