use uuid::Uuid;

use crate::crash;
use crate::jobs::{Fault, Queue, give_up};
use crate::store::audit::{self, Actor};
use crate::store::deletion::{self, Of};
use crate::store::{Tx, now_ms};

/// Deletes the jobs of a ride or a bike, and the bike; those that were cancelled for it, or none where the group
/// has nothing to delete. What is deleted already keeps its time.
pub async fn delete(
    queue: &Queue,
    tx: &mut Tx,
    group: &str,
    of: Of<'_>,
    actor: Actor,
) -> Result<Option<Vec<Uuid>>, Fault> {
    let jobs = deletion::lock(tx, group, of).await?;
    let now = now_ms();
    let found = match of {
        Of::Ride(_) => jobs > 0,
        Of::Bike(name) => deletion::mark_bike(tx, group, name, now).await?,
    };
    if !found {
        return Ok(None);
    }
    let cancelled = deletion::unfinished(tx, group, of).await?;
    for job in &cancelled {
        give_up(queue, tx, *job, None).await?;
    }
    let marked = deletion::mark(tx, group, of, now).await?;
    if marked > 0 || matches!(of, Of::Bike(_)) {
        audit::note(tx, group, actor, "delete", &subject(of)).await?;
    }
    crash::point("in_delete");
    Ok(Some(cancelled))
}

/// Brings the jobs of a ride back; false where none of it is deleted.
pub async fn restore_ride(
    tx: &mut Tx,
    group: &str,
    ride: Uuid,
    actor: Actor,
) -> sqlx::Result<bool> {
    let of = Of::Ride(ride);
    deletion::lock(tx, group, of).await?;
    let back = deletion::unmark(tx, group, of, None).await? > 0;
    if back {
        audit::note(tx, group, actor, "restore", &subject(of)).await?;
    }
    Ok(back)
}

/// Brings a bike back with the jobs that were deleted with it; false where it is not deleted.
pub async fn restore_bike(
    tx: &mut Tx,
    group: &str,
    name: &str,
    actor: Actor,
) -> sqlx::Result<bool> {
    let of = Of::Bike(name);
    deletion::lock(tx, group, of).await?;
    let Some(marked_at) = deletion::bike_mark(tx, group, name).await? else {
        return Ok(false);
    };
    deletion::unmark(tx, group, of, Some(marked_at)).await?;
    audit::note(tx, group, actor, "restore", &subject(of)).await?;
    Ok(true)
}

fn subject(of: Of<'_>) -> String {
    match of {
        Of::Ride(ride) => format!("ride {ride}"),
        Of::Bike(name) => format!("bike {name}"),
    }
}
