//! Turns a received upload into a queued job: checked, kept on disk, committed; in this order.

use std::collections::BTreeSet;
use std::io;
use std::sync::Arc;

use serde_json::{Map, Value};
use sha2::{Digest, Sha256};
use uuid::Uuid;
use veloid_engine::bicycle::Bike;
use veloid_engine::ride::{RideSummary, sha256_of};

use super::bicycle::the_bike;
use super::facts::Given;
use super::receive::Received;
use crate::api::Server;
use crate::api::access::Caller;
use crate::api::problem::{Kind, Problem};
use crate::crash;
use crate::facts::{self, Facts};
use crate::files::{Files, Incoming, Kept, hex};
use crate::jobs::{self, Purpose};
use crate::options::Options;
use crate::store::job::{self, JobRow, NewJob, Request};
use crate::store::ride::FileRow;
use crate::store::{self, Tx, bike, idempotency_key, ride};

/// Name in the fleet of bikes whose file does not name them.
const UNNAMED: &str = "unnamed";

/// The job of an upload.
pub struct Submitted {
    /// As the transaction saw it that stored the upload: somebody may delete it at once.
    pub job: JobRow,
    /// Whether the same was uploaded before.
    pub known: bool,
}

impl Submitted {
    async fn of(tx: &mut Tx, id: Uuid, known: bool) -> Result<Self, Problem> {
        let erased = || Problem::new(Kind::Unavailable, "the job was just erased; try again");
        let job = job::load_in(tx, id).await?.ok_or_else(erased)?;
        Ok(Self { job, known })
    }
}

/// The job of this upload: a new one, or the one that the same request has already.
pub async fn submit(
    server: &Arc<Server>,
    caller: &Caller,
    mut received: Received,
    key: Option<&str>,
) -> Result<Submitted, Problem> {
    let (request, given) = asked(server, caller, &mut received).await?;

    let sources = received.sources().await?;
    let reader = (server.readers)
        .turn(&caller.group, received.bytes(), Purpose::Request)
        .await?;
    let checked = reader.check(sources, request.clone()).await?;
    if let Some(lacks) = checked.lacks {
        return Err(Problem::new(Kind::BadBike, lacks));
    }

    let facts = Given {
        of_file: facts::of_file(checked.comments, checked.begun_s, checked.speed)?,
        given,
    };
    facts.of_new()?;
    let upload = Upload::new(caller, key, &received, request, facts);

    // Before it is kept: what is refused must not stay on disk.
    let mut tx = server.db.begin_lax().await?;
    if upload.job_of_key(&mut tx).await?.is_none() && upload.equal_job(&mut tx).await?.is_none() {
        caller.may_queue(&mut tx).await?;
    }
    drop(tx);

    server.files.check().await.map_err(io::Error::from)?;
    let files = keep(&server.files, received.files).await?;
    crash::point("after_file");

    // Others may have sent something meanwhile, or erased a ride with the same bytes.
    let mut tx = server.db.begin().await?;
    lock(&server.files, &mut tx, &files).await?;
    if let Some(id) = upload.job_of_key(&mut tx).await? {
        return Submitted::of(&mut tx, id, true).await;
    }
    let equal = upload.equal_job(&mut tx).await?;
    let id = match equal {
        Some(id) => {
            (upload.facts.add_to_job(&mut tx, &caller.group, id)).await?;
            id
        }
        None => {
            caller.may_queue(&mut tx).await?;
            upload
                .queue(server, &mut tx, &files, &checked.summary)
                .await?
        }
    };
    upload.remember_key(&mut tx, id).await?;
    let submitted = Submitted::of(&mut tx, id, equal.is_some()).await?;
    crash::point("before_commit");
    tx.commit().await?;
    crash::point("after_commit");
    // The files may have come to lie where the store was unmounted.
    server.files.check().await.map_err(io::Error::from)?;
    if let Some(ride) = checked.ride {
        let (ride, request) = (Arc::new(ride), &upload.request);
        (server.rides).put(&upload.sha256, &upload.name, request, ride);
    }
    server.queue.wake(jobs::QUICK);
    Ok(submitted)
}

/// What is asked of which bicycle, and what the sender says of the ride.
async fn asked(
    server: &Server,
    caller: &Caller,
    received: &mut Received,
) -> Result<(Request, Map<String, Value>), Problem> {
    let options = Options::try_from(std::mem::take(&mut received.options))?;
    options.validate()?;
    let bike = the_bike(server, caller, &received.bicycle).await?;
    let request = Request { bike, options };
    let given = std::mem::take(&mut received.facts);
    Facts::default().patched(given.clone())?;
    Ok((request, given))
}

/// An upload that can be identified.
struct Upload<'a> {
    caller: &'a Caller,
    key: Option<&'a str>,
    request: Request,
    facts: Given,
    /// Of the ride.
    sha256: String,
    name: String,
    fingerprint: String,
    again: bool,
}

impl<'a> Upload<'a> {
    fn new(
        caller: &'a Caller,
        key: Option<&'a str>,
        received: &Received,
        request: Request,
        facts: Given,
    ) -> Self {
        let sums: Vec<String> = (received.files.iter())
            .map(|(_, file)| file.sha256())
            .collect();
        let (sha256, name) = (sha256_of(&sums), received.name());
        let fingerprint = match sums.len() {
            1 => fingerprint(&sha256, &request),
            _ => fingerprint(&format!("{sha256} {name}"), &request),
        };
        Self {
            caller,
            key,
            request,
            facts,
            sha256,
            name,
            fingerprint,
            again: received.again,
        }
    }

    /// The job that the idempotency key was used for.
    async fn job_of_key(&self, tx: &mut Tx) -> Result<Option<Uuid>, Problem> {
        let Some(key) = self.key else { return Ok(None) };
        match idempotency_key::find(tx, &self.caller.group, key).await? {
            Some((used_for, id)) if used_for != self.fingerprint => Err(Problem::new(
                Kind::IdempotencyKeyReused,
                format!("the key was used for job {id} with another file, bike or options"),
            )),
            used => Ok(used.map(|(_, id)| id)),
        }
    }

    /// The job of the same request, unless it is to be identified again.
    async fn equal_job(&self, tx: &mut Tx) -> Result<Option<Uuid>, Problem> {
        match self.again {
            true => Ok(None),
            false => Ok(job::find_equal(tx, &self.caller.group, &self.fingerprint).await?),
        }
    }

    /// Puts bicycle, ride and job into the store, and the job into the queue.
    async fn queue(
        &self,
        server: &Server,
        tx: &mut Tx,
        files: &[FileRow],
        summary: &RideSummary,
    ) -> Result<Uuid, Problem> {
        let (bytes, group) = (
            files.iter().map(|file| file.bytes).sum(),
            &self.caller.group,
        );
        let known = (self.facts.known(tx, group, &self.sha256, &self.name)).await?;
        let bicycle = fleet_name(&self.request.bike);
        // After the jobs are locked, as by those who delete.
        bike::upsert(tx, group, bicycle, &self.request.bike).await?;
        let ride = ride::upsert(tx, group, &self.sha256, &self.name, bytes).await?;
        if files.len() > 1 {
            ride::add_files(tx, ride, files).await?;
        }
        let new = NewJob {
            id: Uuid::now_v7(),
            group,
            key: self.caller.key,
            ride,
            bike: bicycle,
            fingerprint: &self.fingerprint,
            request: &self.request,
            summary,
            ridden_at: known.ridden_ms(),
            study: None,
        };
        job::insert(tx, &new).await?;
        store::facts::put(tx, ride, &known).await?;
        jobs::queue_first(&server.queue, tx, new.id).await?;
        Ok(new.id)
    }

    async fn remember_key(&self, tx: &mut Tx, id: Uuid) -> Result<(), Problem> {
        let Some(key) = self.key else { return Ok(()) };
        idempotency_key::insert(tx, &self.caller.group, key, &self.fingerprint, id).await?;
        Ok(())
    }
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

/// Locks the files against those who erase the same bytes.
async fn lock(files: &Files, tx: &mut Tx, kept: &[FileRow]) -> Result<(), Problem> {
    // In one order, so that no two wait for each other.
    let names: BTreeSet<&str> = kept.iter().map(|file| file.sha256.as_str()).collect();
    for sha256 in names {
        ride::lock_file(tx, sha256).await?;
        if !files.has(sha256).await? {
            let detail = "the same bytes were just erased with another ride; try again";
            return Err(Problem::new(Kind::Unavailable, detail));
        }
    }
    Ok(())
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
