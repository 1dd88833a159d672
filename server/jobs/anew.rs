use uuid::Uuid;

use super::fault::Fault;
use super::queue::Queue;
use crate::crash;
use crate::store::job::{self, Stage, State};
use crate::store::{Tx, parameter, proposal, result, trial, turn};

/// Begins a job that ended in one of these states again, without what came of it; false when it is in another.
pub async fn begin_anew(
    queue: &Queue,
    tx: &mut Tx,
    id: Uuid,
    from: [State; 2],
) -> Result<bool, Fault> {
    if !job::reset(tx, id, from).await? {
        return Ok(false);
    }
    crash::point("in_retry");
    trial::delete(tx, id).await?;
    result::clear(tx, id).await?;
    parameter::delete(tx, id).await?;
    proposal::put(tx, id, None).await?;
    queue_first(queue, tx, id).await?;
    Ok(true)
}

/// Queues the first stage of a job that was inserted or begins again: a study has but one.
pub async fn queue_first(queue: &Queue, tx: &mut Tx, id: Uuid) -> Result<(), Fault> {
    let (stage, row) = match job::is_study(tx, id).await? {
        true => (Stage::Diagnose, queue.diagnose(tx, id).await?),
        false => (Stage::Observe, queue.observe(tx, id).await?),
    };
    turn::take(tx, id).await?;
    Ok(job::enter(tx, id, stage, row).await?)
}
