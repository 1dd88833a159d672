//! Turns a received upload into a queued job: checked, kept on disk, committed; in this order.

use std::sync::Arc;

use sha2::{Digest, Sha256};
use uuid::Uuid;
use veloid_engine::bicycle::Bike;

use super::receive::Received;
use crate::api::Server;
use crate::api::access::Caller;
use crate::api::problem::{Kind, Problem};
use crate::crash;
use crate::files::hex;
use crate::jobs;
use crate::options::Options;
use crate::store::job::{self, NewJob, Request};
use crate::store::{Tx, bike, idempotency_key, ride, turn};

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
    let bike = the_bike(server, caller, received.bike.as_deref()).await?;
    let request = Request { bike, options };

    let name = fleet_name(&request.bike);

    let permit = server.readers.acquire().await.map_err(Problem::internal)?;
    let bytes = received.incoming.contents().await?;
    let parsed = jobs::read(bytes, received.name.clone(), request.clone()).await??;
    drop(permit);
    parsed.fits(&request.bike)?;

    let fingerprint = fingerprint(&received.incoming.sha256(), &request);
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

    let kept = server.files.keep(received.incoming).await?;
    crash::point("after_file");

    // Others may have sent something meanwhile.
    let mut tx = server.db.begin().await?;
    if let Some(id) = of_key(&mut tx).await? {
        return Ok(Submitted::known(id));
    }
    let submitted = match equal(&mut tx).await? {
        Some(id) => Submitted::known(id),
        None => {
            caller.may_queue(&mut tx).await?;
            bike::upsert(&mut tx, &caller.group, name, &request.bike).await?;
            let bytes = kept.bytes as i64;
            let ride =
                ride::upsert(&mut tx, &caller.group, &kept.sha256, &received.name, bytes).await?;
            let new = NewJob {
                id: Uuid::now_v7(),
                group: &caller.group,
                key: caller.key,
                ride,
                bike: name,
                fingerprint: &fingerprint,
                request: &request,
                summary: &parsed.summary,
            };
            job::insert(&mut tx, &new).await?;
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
    server.rides.put(&kept.sha256, &request, Arc::new(parsed));
    server.queue.wake(jobs::QUICK);
    Ok(submitted)
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

/// The bike file that came along, or the fleet's bike of that name.
pub async fn the_bike(
    server: &Server,
    caller: &Caller,
    text: Option<&str>,
) -> Result<Bike, Problem> {
    let Some(text) = text else {
        return Err(Problem::new(
            Kind::BadBike,
            "no bike, expected a bike file or the name of a bike of the fleet as `bike`",
        ));
    };
    if text.starts_with('{') {
        return Ok(Bike::from_json(text)?);
    }
    let known = bike::find(&server.db, &caller.group, text).await?;
    known.map(|row| row.document.0).ok_or_else(|| {
        Problem::new(
            Kind::BadBike,
            format!("'{text}' is no bike of the fleet, expected one or a bike file as JSON"),
        )
    })
}

/// Names everything that determines the report.
fn fingerprint(sha256: &str, request: &Request) -> String {
    let all = serde_json::json!([sha256, request, env!("CARGO_PKG_VERSION")]);
    hex(&Sha256::digest(all.to_string()))
}
