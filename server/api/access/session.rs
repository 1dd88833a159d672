//! A browser's session: a token of its own in place of the key, which ends by itself, by signing out, by
//! `veloid key end`, and with its key.

use axum::http::HeaderMap;
use uuid::Uuid;

use super::credentials::cookie;
use super::token::{self, Token};
use crate::api::problem::Problem;
use crate::store::key::{self, KeyRow};
use crate::store::{Db, session};

/// The key that the session of this token belongs to, and the session.
pub(super) async fn of(db: &Db, token: &str) -> Result<Option<(KeyRow, Option<Uuid>)>, Problem> {
    let Some((id, key)) = session::find(db, &token::sha256(token)).await? else {
        return Ok(None);
    };
    let row = key::by_id(db, key).await?.filter(KeyRow::is_valid);
    Ok(row.map(|row| (row, Some(id))))
}

/// Begins a session in place of the one that the browser has, if any.
pub async fn sign_in(
    db: &Db,
    headers: &HeaderMap,
    key: Uuid,
    lasts_ms: i64,
) -> Result<Token, Problem> {
    let token = Token::draw().map_err(Problem::internal)?;
    let mut tx = db.begin().await?;
    if let Some(before) = cookie(headers) {
        session::end(&mut tx, &token::sha256(before)).await?;
    }
    session::begin(&mut tx, &token.sha256(), key, lasts_ms).await?;
    tx.commit().await?;
    Ok(token)
}

/// Ends the browser's session, if it has one.
pub async fn sign_out(db: &Db, headers: &HeaderMap) -> Result<(), Problem> {
    if let Some(token) = cookie(headers) {
        let mut tx = db.begin().await?;
        session::end(&mut tx, &token::sha256(token)).await?;
        tx.commit().await?;
    }
    Ok(())
}
