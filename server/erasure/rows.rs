//! Holds the rows of the database against each other.

use std::collections::{BTreeMap, BTreeSet};

use uuid::Uuid;
use veloid_engine::ride::sha256_of;

use super::job_rows;
use crate::store::scrub::{self, readable};
use crate::store::{Db, ride, river};

/// Rows that are asked for at once.
const PAGE: i64 = 500;

/// Says every row that is missing or does not agree with others.
pub async fn compare(db: &Db, say: &mut impl FnMut(String)) -> sqlx::Result<()> {
    for fault in scrub::orphans(db).await? {
        say(format!("database: {fault}"));
    }
    let mut last = Uuid::nil();
    loop {
        let page = scrub::jobs(db, last, PAGE).await?;
        let Some(end) = page.last() else { break };
        last = *end;
        for id in page {
            for fault in job_rows::faults(db, id).await? {
                say(format!("job {id}: {fault}"));
            }
        }
    }
    for id in river::strays(db).await? {
        say(format!(
            "job {id}: it has not ended, and the queue has no work of it"
        ));
    }
    rides(db, say).await?;
    for (group, name) in scrub::bikes(db).await? {
        if let Err(fault) = readable(scrub::bike(db, &group, &name).await)? {
            say(format!("bike {name} of group {group}: {fault}"));
        }
    }
    for (name, job) in scrub::keys_of_others(db).await? {
        say(format!(
            "idempotency key {name}: job {job} has another request"
        ));
    }
    for id in scrub::missing_keys(db).await? {
        say(format!("key {id} is missing, the audit names it"));
    }
    for what in vanished(db).await? {
        say(format!(
            "{what} is missing, the audit says that it was created"
        ));
    }
    Ok(())
}

async fn rides(db: &Db, say: &mut impl FnMut(String)) -> sqlx::Result<()> {
    let mut last = Uuid::nil();
    loop {
        let page = scrub::rides(db, last, PAGE).await?;
        let Some(end) = page.last() else {
            return Ok(());
        };
        last = *end;
        for id in page {
            let mut found = of_ride(db, id).await?;
            if !found.is_empty() {
                // It may have been changed between two of its statements.
                found = of_ride(db, id).await?;
            }
            for fault in found {
                say(format!("ride {id}: {fault}"));
            }
        }
    }
}

async fn of_ride(db: &Db, id: Uuid) -> sqlx::Result<Vec<String>> {
    let row = match readable(scrub::ride(db, id).await)? {
        Ok(Some(row)) => row,
        Ok(None) => return Ok(Vec::new()),
        Err(fault) => return Ok(vec![fault]),
    };
    let mut found = Vec::new();
    if row.jobs == 0 {
        found.push("it has no job".to_owned());
    }
    let files = ride::files(db, id).await?;
    let sums: Vec<String> = files.iter().map(|file| file.sha256.clone()).collect();
    let bytes: i64 = files.iter().map(|file| file.bytes).sum();
    if (sha256_of(&sums), bytes) != (row.sha256, row.bytes) {
        found.push("its files are not those that it was uploaded with".to_owned());
    }
    let tags: BTreeSet<String> = scrub::tags(db, id).await?.into_iter().collect();
    let meant = row.facts.map(|facts| facts.0.tags).unwrap_or_default();
    if tags != meant.into_iter().collect() {
        found.push("its tags are not those of its facts".to_owned());
    }
    Ok(found)
}

/// Webhooks and bicycles' events that were created, not deleted since, and are not there.
async fn vanished(db: &Db) -> sqlx::Result<BTreeSet<String>> {
    let created = created(&scrub::noted(db).await?);
    let there: BTreeSet<Uuid> = scrub::notables(db).await?.into_iter().collect();
    let missing = |all: BTreeMap<Uuid, String>| -> BTreeSet<String> {
        let missing = all.into_iter().filter(|(id, _)| !there.contains(id));
        missing.map(|(_, what)| what).collect()
    };
    let gone = missing(created);
    if gone.is_empty() {
        return Ok(gone);
    }
    // Some may have been deleted between the two.
    let later = missing(self::created(&scrub::noted(db).await?));
    Ok(gone.intersection(&later).cloned().collect())
}

/// What of all that was noted is to be there.
fn created(noted: &[(String, String)]) -> BTreeMap<Uuid, String> {
    let mut all = BTreeMap::new();
    for (action, subject) in noted {
        let mut words = subject.split(' ');
        match action.as_str() {
            "create webhook" | "delete webhook" => {
                let Some(id) = words.next().and_then(|word| word.parse().ok()) else {
                    continue;
                };
                match action == "create webhook" {
                    true => all.insert(id, format!("webhook {subject}")),
                    false => all.remove(&id),
                };
            }
            "create" | "delete" => {
                let Some(id) = words.nth(1).and_then(|word| word.parse().ok()) else {
                    continue;
                };
                match action == "create" {
                    true => all.insert(id, subject.clone()),
                    false => all.remove(&id),
                };
            }
            // Events that were deleted with their bicycle.
            _ => {
                let bike = subject.split_once(" events").map(|(_, bike)| bike);
                all.retain(|_, what| bike.is_none_or(|bike| !what.ends_with(bike)));
            }
        }
    }
    all
}
