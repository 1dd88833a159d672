//! Who may enter, and what of: keys, the groups they belong to, and their limits.

mod bucket;
mod caller;
pub mod credentials;
mod limits;
mod session;
mod token;

use std::collections::HashMap;
use std::net::IpAddr;
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use axum::http::HeaderMap;
use uuid::Uuid;

use self::bucket::Bucket;
use self::credentials::{bearer, cookie};
use super::problem::{Kind, Problem};
use crate::store::key::{self, KeyRow, Scope};
use crate::store::{Db, now_ms};

pub use caller::Caller;
pub use credentials::COOKIE;
pub use limits::Limits;
pub use session::{sign_in, sign_out};
pub use token::Token;

/// Attempts to sign in per minute and address, of which ten seconds' worth may come at once.
const ATTEMPTS: u32 = 60;
/// Addresses whose attempts are counted; beyond it all counts start again.
const ADDRESSES: usize = 10_000;
/// The last use of a key is noted this often at most (ms).
const NOTED_EVERY_MS: i64 = 60_000;

/// Who needs a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Nobody: only this machine reaches the server.
    Local,
    /// Everybody.
    Keys,
    /// Nobody, though others reach the server.
    Open,
}

pub struct Access {
    pub mode: Mode,
    pub limits: Limits,
    /// Requests that keys have left; gone with the process.
    buckets: Mutex<HashMap<Uuid, Bucket>>,
    /// Attempts to sign in that addresses have left.
    attempts: Mutex<HashMap<IpAddr, Bucket>>,
}

impl Access {
    pub fn new(mode: Mode, limits: Limits) -> Self {
        Self {
            mode,
            limits,
            buckets: Mutex::default(),
            attempts: Mutex::default(),
        }
    }

    /// Whose request this is.
    pub async fn caller(&self, db: &Db, headers: &HeaderMap) -> Result<Caller, Problem> {
        let found = match (bearer(headers), cookie(headers)) {
            (Some(token), _) => Some((self.key(db, token).await?.ok_or_else(unknown)?, None)),
            // A browser whose session or key has ended is one without a key.
            (None, Some(token)) => session::of(db, token).await?,
            (None, None) => None,
        };
        match found {
            Some((row, session)) => {
                note(db, &row);
                Ok(Caller::with(row, session, self.limits))
            }
            None if self.mode == Mode::Keys => Err(Problem::new(
                Kind::Unauthorized,
                "no key, expected `Authorization: Bearer KEY`; `veloid key create` makes one",
            )),
            None => Ok(Caller::home(self.limits)),
        }
    }

    /// The key of this token, if it is valid.
    pub async fn key(&self, db: &Db, token: &str) -> Result<Option<KeyRow>, Problem> {
        let row = key::find(db, &token::sha256(token)).await?;
        Ok(row.filter(KeyRow::is_valid))
    }

    /// Whether the details of a fault may be reported: to who holds a key of an admin, and to all where nobody needs one.
    pub async fn is_operator(&self, db: &Db, headers: &HeaderMap) -> bool {
        self.mode != Mode::Keys || (bearer(headers).is_some() && admin(db, headers).await.is_ok())
    }

    /// Takes a request off what the caller has left.
    pub fn spend(&self, caller: &Caller) -> Result<(), Problem> {
        let (Some(key), Some(rate)) = (caller.key, caller.requests_per_minute) else {
            return Ok(());
        };
        let mut buckets = self.buckets.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        let bucket = buckets.entry(key).or_insert_with(|| Bucket::new(rate, now));
        bucket.take(rate, now).map_err(|wait| {
            let detail = format!("the key may send {rate} requests per minute");
            Problem::new(Kind::TooMany, detail).retry_after(wait)
        })
    }
}

impl Access {
    /// Takes an attempt to sign in off what an address has left.
    pub fn attempt(&self, address: IpAddr) -> Result<(), Problem> {
        let mut attempts = self.attempts.lock().unwrap_or_else(PoisonError::into_inner);
        if attempts.len() >= ADDRESSES {
            attempts.clear();
        }
        let now = Instant::now();
        let bucket = (attempts.entry(address)).or_insert_with(|| Bucket::new(ATTEMPTS, now));
        bucket.take(ATTEMPTS, now).map_err(|wait| {
            let detail = "too many attempts to sign in from this address";
            Problem::new(Kind::TooMany, detail).retry_after(wait)
        })
    }
}

/// Refuses whoever has no key with the scope `admin`, where there are no other limits.
pub async fn admin(db: &Db, headers: &HeaderMap) -> Result<(), Problem> {
    let token = bearer(headers).unwrap_or_default();
    let row = key::find(db, &token::sha256(token))
        .await?
        .filter(KeyRow::is_valid);
    match row.ok_or_else(unknown)?.scopes.allow(Scope::Admin) {
        true => Ok(()),
        false => Err(Problem::new(
            Kind::Forbidden,
            "a key with the scope 'admin' is required",
        )),
    }
}

/// The answer to an unknown, expired or revoked key.
pub fn unknown() -> Problem {
    Problem::new(Kind::Unauthorized, "the key is unknown, expired or revoked")
}

/// Notes the use of a key; nobody waits for it.
fn note(db: &Db, row: &KeyRow) {
    if row
        .last_used_at
        .is_some_and(|at| now_ms() < at + NOTED_EVERY_MS)
    {
        return;
    }
    if db.condition().check_database().is_err() {
        return;
    }
    let (db, id) = (db.clone(), row.id);
    tokio::spawn(async move {
        let noted = async {
            let mut tx = db.begin().await?;
            key::used(&mut tx, id).await?;
            tx.commit().await
        };
        if let Err(error) = noted.await {
            tracing::warn!(%error, key = %id, "the last use of a key was not recorded");
        }
    });
}
