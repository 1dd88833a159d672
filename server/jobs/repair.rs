//! Earlier versions stored numbers that are none, which JSON keeps as null: their jobs failed when the next stage read
//! it, or ended with a report that nothing can read. The engine lets no such result out any more.

use veloid_engine::report::Report;

use super::anew::begin_anew;
use super::fault::Fault;
use super::queue::{QUICK, Queue};
use crate::store::job::{self, State};
use crate::store::result::DocumentError;
use crate::store::{Db, repair, result};

/// Looks at every job that the upgrade lists, each in a transaction of its own, and starts again what cannot be read.
pub async fn repair(db: &Db, queue: &Queue) -> Result<(), Fault> {
    let ended = [State::Failed, State::Succeeded];
    for id in repair::list(db).await? {
        let broken = match result::find(db, id, result::REPORT).await {
            Ok(Some(report)) => holds_a_null_for_a_number(&report.text),
            Err(DocumentError::Database(error)) => return Err(error.into()),
            Ok(None) | Err(_) => true,
        };
        let mut tx = db.begin().await?;
        job::lock(&mut tx, id).await?;
        if repair::strike(&mut tx, id).await? && broken {
            begin_anew(queue, &mut tx, id, ended).await?;
            tracing::warn!(job = %id, "restarting: a non-finite number was stored with it");
        }
        tx.commit().await?;
    }
    queue.wake(QUICK);
    Ok(())
}

fn holds_a_null_for_a_number(report: &str) -> bool {
    let read = serde_json::from_str::<Report>(report);
    read.is_err_and(|error| error.to_string().contains("invalid type: null"))
}
