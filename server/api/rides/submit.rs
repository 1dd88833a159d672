//! Turns a received upload into a queued job: checked, kept on disk, committed; in this order.

use std::collections::BTreeSet;
use std::io;
use std::sync::Arc;

use sha2::{Digest, Sha256};
use uuid::Uuid;
use veloid_engine::bicycle::Bike;
use veloid_engine::ride::sha256_of;

use super::bicycle::the_bike;
use super::facts::Given;
use super::receive::Received;
use crate::api::Server;
use crate::api::access::Caller;
use crate::api::problem::{Kind, Problem};
use crate::crash;
use crate::facts::{self, Facts};
use crate::files::{Files, Incoming, Kept, hex};
use crate::jobs;
use crate::options::Options;
use crate::store::job::{self, NewJob, Request};
use crate::store::ride::FileRow;
use crate::store::{self, Tx, bike, idempotency_key, ride, turn};

/// Name in the fleet of bikes whose file does not name them.
const UNNAMED: &str = "unnamed";

/// The job of an upload.
pub struct Submitted {
    pub id: Uuid,
    /// Whether the same was uploaded before.
    pub known: bool,
}

impl Submitted {
    fn known(id: Uuid) -> Self {
        Self { id, known: true }
    }
}

/// The job of this upload: a new one, or the one that the same request has already.
pub async fn submit(
    server: &Arc<Server>,
    caller: &Caller,
    mut received: Received,
    key: Option<&str>,
) -> Result<Submitted, Problem> {
    let options = Options::try_from(std::mem::take(&mut received.options))?;
    options.validate()?;
    let bike = the_bike(server, caller, &received.bicycle).await?;
    let request = Request { bike, options };
    let given = std::mem::take(&mut received.facts);
    Facts::default().patched(given.clone())?;

    let name = fleet_name(&request.bike);

    let sources = received.sources().await?;
    let checked = server.readers.check(sources, request.clone()).await?;
    if let Some(lacks) = checked.lacks {
        return Err(Problem::new(Kind::BadBike, lacks));
    }

    let facts = Given {
        of_file: facts::of_file(checked.comments, checked.start_s, checked.speed)?,
        given,
    };
    facts.of_new()?;

    let sums: Vec<String> = (received.files.iter())
        .map(|(_, file)| file.sha256())
        .collect();
    let (sha256, ride_name) = (sha256_of(&sums), received.name());
    let fingerprint = match sums.len() {
        1 => fingerprint(&sha256, &request),
        _ => fingerprint(&format!("{sha256} {ride_name}"), &request),
    };
    let again = received.again;
    let of_key = async |tx: &mut Tx| job_of_key(tx, caller, key, &fingerprint).await;
    let equal = async |tx: &mut Tx| match again {
        true => Ok(None),
        false => job::find_equal(tx, &caller.group, &fingerprint).await,
    };

    // Before it is kept: what is refused must not stay on disk.
    let mut tx = server.db.begin_lax().await?;
    if of_key(&mut tx).await?.is_none() && equal(&mut tx).await?.is_none() {
        caller.may_queue(&mut tx).await?;
    }
    drop(tx);

    let files = keep(&server.files, received.files).await?;
    crash::point("after_file");

    // Others may have sent something meanwhile, or erased a ride with the same bytes.
    let mut tx = server.db.begin().await?;
    // In one order, so that no two wait for each other.
    let names: BTreeSet<&str> = files.iter().map(|file| file.sha256.as_str()).collect();
    for sha256 in names {
        ride::lock_file(&mut tx, sha256).await?;
        if !server.files.has(sha256).await? {
            let detail = "the same bytes were just erased with another ride; try again";
            return Err(Problem::new(Kind::Unavailable, detail));
        }
    }
    if let Some(id) = of_key(&mut tx).await? {
        return Ok(Submitted::known(id));
    }
    let submitted = match equal(&mut tx).await? {
        Some(id) => {
            facts.add_to_job(&mut tx, &caller.group, id).await?;
            Submitted::known(id)
        }
        None => {
            caller.may_queue(&mut tx).await?;
            let (bytes, group) = (files.iter().map(|file| file.bytes).sum(), &caller.group);
            let known = facts.known(&mut tx, group, &sha256, &ride_name).await?;
            // After the jobs are locked, as by those who delete.
            bike::upsert(&mut tx, group, name, &request.bike).await?;
            let ride = ride::upsert(&mut tx, group, &sha256, &ride_name, bytes).await?;
            if files.len() > 1 {
                ride::add_files(&mut tx, ride, &files).await?;
            }
            let new = NewJob {
                id: Uuid::now_v7(),
                group: &caller.group,
                key: caller.key,
                ride,
                bike: name,
                fingerprint: &fingerprint,
                request: &request,
                summary: &checked.summary,
                ridden_at: known.ridden_ms(),
            };
            job::insert(&mut tx, &new).await?;
            store::facts::put(&mut tx, ride, &known).await?;
            let row = server.queue.observe(&mut tx, new.id).await?;
            job::enter(&mut tx, new.id, job::Stage::Observe, row).await?;
            turn::take(&mut tx, new.id).await?;
            Submitted {
                id: new.id,
                known: false,
            }
        }
    };
    if let Some(key) = key {
        idempotency_key::insert(&mut tx, &caller.group, key, &fingerprint, submitted.id).await?;
    }
    crash::point("before_commit");
    tx.commit().await?;
    crash::point("after_commit");
    if let Some(ride) = checked.ride {
        let ride = Arc::new(ride);
        server.rides.put(&sha256, &ride_name, &request, ride);
    }
    server.queue.wake(jobs::QUICK);
    Ok(submitted)
}

/// Makes the files durable.
async fn keep(files: &Files, received: Vec<(String, Incoming)>) -> io::Result<Vec<FileRow>> {
    let mut rows = Vec::new();
    for (name, incoming) in received {
        let Kept { sha256, bytes } = files.keep(incoming).await?;
        let bytes = bytes as i64;
        rows.push(FileRow {
            sha256,
            name,
            bytes,
        });
    }
    Ok(rows)
}

/// The job that the idempotency key was used for.
async fn job_of_key(
    tx: &mut Tx,
    caller: &Caller,
    key: Option<&str>,
    fingerprint: &str,
) -> Result<Option<Uuid>, Problem> {
    let Some(key) = key else { return Ok(None) };
    match idempotency_key::find(tx, &caller.group, key).await? {
        Some((used_for, id)) if used_for != fingerprint => Err(Problem::new(
            Kind::IdempotencyKeyReused,
            format!("the key was used for job {id} with another file, bike or options"),
        )),
        used => Ok(used.map(|(_, id)| id)),
    }
}

/// The bike's name in the fleet.
fn fleet_name(bike: &Bike) -> &str {
    match bike.bike.trim() {
        "" => UNNAMED,
        name => name,
    }
}

/// Names everything that determines the report.
fn fingerprint(sha256: &str, request: &Request) -> String {
    let all = serde_json::json!([sha256, request, env!("CARGO_PKG_VERSION")]);
    hex(&Sha256::digest(all.to_string()))
}
