use std::time::Duration;

use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use uuid::Uuid;

use super::limits::Limits;
use crate::api::problem::{Kind, Problem};
use crate::store::audit::Actor;
use crate::store::key::{self, HOME, KeyRow, Scope, Scopes};
use crate::store::{Db, Tx, job, session};

/// Wait that is asked for where jobs have to end first.
const JOBS_WAIT: Duration = Duration::from_secs(10);

/// Whose request this is. Everything that a handler reads or writes belongs to the caller's group.
#[derive(Clone)]
pub struct Caller {
    pub group: String,
    /// None where none is needed.
    pub key: Option<Uuid>,
    pub requests_per_minute: Option<u32>,
    /// Where a browser calls.
    session: Option<Uuid>,
    scopes: Scopes,
    max_upload: Option<u64>,
    unfinished_jobs: Option<i64>,
    queue: i64,
}

impl Caller {
    /// Someone without a key, where none is needed.
    pub(super) fn home(limits: Limits) -> Self {
        Self {
            group: HOME.to_owned(),
            key: None,
            requests_per_minute: None,
            session: None,
            scopes: Scopes(vec![Scope::Admin]),
            max_upload: None,
            unfinished_jobs: None,
            queue: limits.queue,
        }
    }

    pub(super) fn with(row: KeyRow, session: Option<Uuid>, limits: Limits) -> Self {
        let rate = row.requests_per_minute.and_then(|n| n.try_into().ok());
        Self {
            group: row.group_name,
            key: Some(row.id),
            requests_per_minute: Some(rate.unwrap_or(limits.requests_per_minute)),
            session,
            scopes: row.scopes,
            max_upload: row.max_upload_bytes.and_then(|n| n.try_into().ok()),
            unfinished_jobs: Some(row.unfinished_jobs.unwrap_or(limits.unfinished_jobs)),
            queue: limits.queue,
        }
    }

    /// As the audit trail has it.
    pub fn actor(&self) -> Actor {
        self.key.map_or(Actor::Keyless, Actor::Key)
    }

    pub fn needs(&self, scope: Scope) -> Result<(), Problem> {
        if self.scopes.allow(scope) {
            return Ok(());
        }
        let needed = Scopes(vec![scope]);
        Err(Problem::new(
            Kind::Forbidden,
            format!(
                "the key has the scopes '{}', this needs '{needed}'",
                self.scopes
            ),
        ))
    }

    /// Whether the caller may still be here: a key or a session may end while an answer is being sent.
    pub async fn is_admitted(&self, db: &Db) -> sqlx::Result<bool> {
        if let Some(session) = self.session
            && !session::goes_on(db, session).await?
        {
            return Ok(false);
        }
        let Some(key) = self.key else { return Ok(true) };
        let row = key::by_id(db, key).await?;
        Ok(row.is_some_and(|row| row.is_valid()))
    }

    /// Largest upload (bytes), at most the server's own.
    pub fn max_upload(&self, server: u64) -> u64 {
        self.max_upload.map_or(server, |own| own.min(server))
    }

    /// Whether one more job may be queued, as seen by the transaction that queues it.
    pub async fn may_queue(&self, tx: &mut Tx) -> Result<(), Problem> {
        if let (Some(key), Some(most)) = (self.key, self.unfinished_jobs)
            && key::unfinished_jobs(tx, key).await? >= most
        {
            let detail = format!("the key has {most} unfinished jobs, its limit");
            return Err(Problem::new(Kind::TooMany, detail).retry_after(JOBS_WAIT));
        }
        if job::unfinished(tx).await? >= self.queue {
            let detail = format!("{} jobs are queued, the limit of this server", self.queue);
            return Err(Problem::new(Kind::Unavailable, detail).retry_after(JOBS_WAIT));
        }
        Ok(())
    }
}

impl<S: Sync> FromRequestParts<S> for Caller {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Problem> {
        let caller = parts.extensions.get::<Caller>().cloned();
        caller.ok_or_else(|| Problem::internal("the caller was not determined"))
    }
}
