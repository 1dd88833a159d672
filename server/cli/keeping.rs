//! For how long what is kept, and the end of what is not.

use std::fs::File;
use std::sync::Arc;
use std::time::Duration;

use clap::Args;
use tokio::time::MissedTickBehavior;
use tokio_util::sync::CancellationToken;

use super::CliError;
use super::storage::Storage;
use crate::api::Server;
use crate::erasure::{DAY_MS, Erased, Policy, Prune};
use crate::store::audit::Actor;
use crate::store::scrub;

/// How often a server erases what is to be erased.
const EVERY: Duration = Duration::from_secs(3600);

#[derive(Args, Clone, Default)]
pub struct Keeping {
    /// Days for which deleted data can be restored; then it is erased.
    #[arg(long, env = "VELOID_GRACE_DAYS", default_value_t = 7, value_parser = clap::value_parser!(u32).range(..=36_500))]
    grace_days: u32,
    /// Days after which results are deleted; by default never.
    #[arg(long, env = "VELOID_RETAIN_DAYS", value_parser = clap::value_parser!(u32).range(1..=36_500))]
    retain_days: Option<u32>,
    /// The same for one group, as GROUP=DAYS; may be given several times.
    #[arg(long = "retain-group", env = "VELOID_RETAIN_GROUPS", value_name = "GROUP=DAYS", value_delimiter = ',', value_parser = group_days)]
    retain_groups: Vec<(String, u32)>,
}

fn group_days(text: &str) -> Result<(String, u32), String> {
    let parts = text.rsplit_once('=').and_then(|(group, days)| {
        let days = days.trim().parse().ok()?;
        (1..=36_500)
            .contains(&days)
            .then(|| (group.trim().to_owned(), days))
    });
    parts.ok_or_else(|| "expected GROUP=DAYS with 1 to 36500 days".to_owned())
}

impl Keeping {
    pub fn policy(&self) -> Policy {
        let ms = |days: u32| i64::from(days) * DAY_MS;
        let groups = self.retain_groups.iter();
        Policy {
            grace_ms: ms(self.grace_days),
            retain_ms: self.retain_days.map(ms),
            retain_of_ms: groups
                .map(|(group, days)| (group.clone(), ms(*days)))
                .collect(),
        }
    }
}

/// Erases now and then what is to be erased, until the server stops.
pub async fn keep_tidy(server: Arc<Server>, storage: Storage, stop: CancellationToken) {
    let mut ticks = tokio::time::interval(EVERY);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    while stop.run_until_cancelled(ticks.tick()).await.is_some() {
        match server.files.clear().await {
            Ok(0) => {}
            Ok(removed) => {
                tracing::info!(removed, "removed abandoned partial uploads")
            }
            Err(error) => tracing::error!(%error, "partial uploads were not checked"),
        }
        match scrub::first_fault(&server.db).await {
            Ok(Some(fault)) => server.db.condition().suspect(fault),
            Ok(None) => {}
            Err(error) => tracing::error!(%error, "the database was not checked"),
        }
        let pruned = stop.run_until_cancelled(prune(&server, &storage)).await;
        match pruned {
            Some(Ok(Some(erased))) if erased != Erased::default() => {
                tracing::info!(?erased, "erased deleted data");
            }
            Some(Ok(None)) => tracing::info!("nothing is erased during a backup"),
            Some(Err(error)) => tracing::error!(%error, "deleted data was not completely erased"),
            _ => {}
        }
    }
}

/// None while a backup or another command has the lock.
async fn prune(server: &Server, storage: &Storage) -> Result<Option<Erased>, CliError> {
    let Some(_lock): Option<File> = storage.try_lock_for_erasure()? else {
        return Ok(None);
    };
    let prune = Prune {
        db: &server.db,
        files: &server.files,
        queue: &server.queue,
        policy: &server.policy,
        actor: Actor::Server,
        dry_run: false,
        note: &|line| tracing::info!("{line}"),
    };
    Ok(Some(prune.run().await?))
}
