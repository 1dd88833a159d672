use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::from_fn;
use axum::routing::get;
use clap::{Args, ValueEnum};
use tokio::net::TcpListener;
use tokio::signal::unix::{SignalKind, signal};
use tokio_util::sync::CancellationToken;

use super::CliError;
use super::storage::Storage;
use crate::api::access;
use crate::api::problem::Problem;
use crate::cli::webhook_options::WebhookOptions;
use crate::files::Files;
use crate::http::{self, HttpLimits};
use crate::jobs::{self, Budget, Compute, Gate, Hub, Patience, Readers, RideCache, Work};
use crate::metrics::METRICS;
use crate::router::connection;
use crate::store::Db;
use crate::watch::watch;
use crate::webhooks::{Targets, Turns};

/// Works on queued jobs, without HTTP: for additional machines on one PostgreSQL database.
#[derive(Args)]
pub struct Worker {
    #[command(flatten)]
    storage: Storage,
    #[command(flatten)]
    limits: WorkLimits,
    /// Threads for swarms and diagnoses; by default one per core.
    #[arg(long, env = "VELOID_WORKERS")]
    workers: Option<usize>,
    /// Address that serves /healthz, /readyz and /metrics; by default none.
    #[arg(long, env = "VELOID_LISTEN")]
    listen: Option<SocketAddr>,
    /// Serve /metrics to everyone who can reach the address, without a key.
    #[arg(long, env = "VELOID_OPEN")]
    open: bool,
    #[command(flatten)]
    http: HttpLimits,
    #[command(flatten)]
    webhooks: WebhookOptions,
}

#[derive(Args, Clone, Copy)]
pub struct WorkLimits {
    /// Time limit of one stage of a job (s).
    #[arg(long, env = "VELOID_STAGE_TIMEOUT", default_value_t = 1800)]
    stage_timeout: u64,
    /// Time limit of reading a file, or of drawing its curves, for a request (s).
    #[arg(long, env = "VELOID_READ_TIMEOUT", default_value_t = 120)]
    read_timeout: u64,
    /// Whether rides are read and stages computed in child processes, so that a crash affects only one ride.
    #[arg(long, env = "VELOID_ISOLATE", value_enum, default_value_t = Isolate::On)]
    isolate: Isolate,
    /// Memory limit of one job (bytes).
    #[arg(long, env = "VELOID_MEMORY_BUDGET", default_value_t = 4 << 30)]
    memory_budget: u64,
    /// Identify a bicycle's latest rides as one when it has so many new ones, and a ride that a report proposed with the ride that
    /// asked for it; 0: never by itself.
    #[arg(long, env = "VELOID_STUDY_AFTER", default_value_t = 5)]
    study_after: usize,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Isolate {
    On,
    Off,
}

impl WorkLimits {
    fn budget(self) -> Budget {
        Budget(self.memory_budget)
    }

    /// Memory of a child process (bytes), where there are some.
    fn isolated(self) -> Option<u64> {
        (self.isolate == Isolate::On).then_some(self.memory_budget)
    }

    fn limit(self) -> Duration {
        Duration::from_secs(self.stage_timeout)
    }

    /// Who reads rides.
    pub fn readers(self, storage: &Storage) -> Result<Arc<Readers>, CliError> {
        let patience = Patience {
            request: Duration::from_secs(self.read_timeout),
            job: self.limit(),
        };
        let loggers = storage.loggers()?;
        let readers = Readers::new(self.isolated(), self.budget(), patience, loggers)?;
        Ok(Arc::new(readers))
    }

    /// All that a working process needs.
    pub fn work(
        self,
        db: &Db,
        rides: &RideCache,
        hub: &Hub,
        threads: usize,
        targets: Targets,
    ) -> Result<Arc<Work>, CliError> {
        Ok(Arc::new(Work {
            db: db.clone(),
            rides: rides.clone(),
            compute: Compute::new(threads, self.isolated())?,
            budget: self.budget(),
            gate: Gate::default(),
            hub: hub.clone(),
            targets,
            turns: Turns::default(),
            study_after: self.study_after,
            limit: self.limit(),
        }))
    }
}

impl Worker {
    pub async fn run(self) -> Result<(), CliError> {
        let storage = self.storage.clone();
        (self.work().await).map_err(|error| storage.blame(error))
    }

    async fn work(self) -> Result<(), CliError> {
        let targets = self.webhooks.targets()?;
        let (db, files): (Db, Files) = self.storage.begin().await?;
        db.settle().await?;
        let stop = CancellationToken::new();
        tokio::spawn(watch(db.clone(), files.clone(), stop.clone()));
        let _lock = self.storage.lock_for_work(&db)?;
        let threads = self.workers.unwrap_or_else(cores).max(1);
        let work = self.limits.work(
            &db,
            &RideCache::new(db.clone(), files, self.limits.readers(&self.storage)?),
            &Hub::new(),
            threads,
            targets,
        )?;
        let running = jobs::start(work).await?;
        if let Some(address) = self.listen {
            let listener = TcpListener::bind(address).await?;
            let never = CancellationToken::new();
            let limits = self.http.granted();
            let asks = !self.open && !address.ip().is_loopback();
            tokio::spawn(http::serve(listener, signs(db, asks), limits, never));
        }
        eprintln!("veloid works with {threads} threads");
        asked_to_stop().await?;
        stop.cancel();
        Ok(running.stop().await?)
    }
}

/// The signs of life of a worker, and its figures, for which it may ask for a key.
fn signs(db: Db, asks: bool) -> Router {
    let of_keys = db.clone();
    let figures = async move |headers: HeaderMap| {
        if asks {
            access::admin(&of_keys, &headers).await?;
        }
        Ok::<_, Problem>(METRICS.render())
    };
    let ready = async move || {
        if let Err(fault) = db.condition().check() {
            return (
                StatusCode::SERVICE_UNAVAILABLE,
                format!("{}\n", fault.what()),
            );
        }
        match db.ping().await {
            Ok(()) => (StatusCode::OK, "ready\n".to_owned()),
            Err(_) => (
                StatusCode::SERVICE_UNAVAILABLE,
                "the database is unavailable\n".to_owned(),
            ),
        }
    };
    Router::new()
        .route("/healthz", get(|| async { "ok\n" }))
        .route("/readyz", get(ready))
        .route("/metrics", get(figures))
        .layer(from_fn(connection::sound))
}

/// Cores of this machine.
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Returns at SIGTERM or Ctrl-C.
pub async fn asked_to_stop() -> std::io::Result<()> {
    let mut terminate = signal(SignalKind::terminate())?;
    tokio::select! {
        interrupt = tokio::signal::ctrl_c() => interrupt,
        _ = terminate.recv() => Ok(()),
    }
}
