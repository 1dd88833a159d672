//! A long list, read from the database as its reader takes it: a slow reader holds a thousand rows, and neither a
//! connection to the database nor a transaction.

use std::sync::Arc;

use axum::BoxError;
use axum::body::{Body, Bytes};
use futures_util::TryStreamExt;
use tokio::task::{JoinError, spawn_blocking};

use super::document::{Document, DocumentError};
use super::query::Params;
use crate::api::Server;
use crate::api::access::Caller;
use crate::api::long_readers::Seat;
use crate::store::parameter::{self, Filter, Key, ParameterRow};

/// Rows that are read at a time, and those up to which a list is no long one.
pub const PIECE: i64 = 1000;

/// Why a list ends before its end.
#[derive(Debug, thiserror::Error)]
enum Broken {
    /// What was understood when the list began.
    #[error("{0}")]
    Query(String),
    #[error(transparent)]
    Database(#[from] sqlx::Error),
    #[error(transparent)]
    Document(#[from] DocumentError),
    #[error(transparent)]
    Task(#[from] JoinError),
}

/// A list that is being sent.
pub struct Long {
    pub server: Arc<Server>,
    pub caller: Caller,
    pub params: Params,
    /// The last row, where the list has more than were asked for.
    pub through: Option<Key>,
    /// `next` of the document.
    pub next: Option<String>,
    /// The reader's place among those of the same key.
    pub seat: Seat,
}

impl Long {
    /// The answer that begins with these rows. Whatever fails on the way ends the connection: what arrives without an
    /// error is complete.
    pub fn body(self, document: Document, begin: Vec<u8>, first: Vec<ParameterRow>) -> Body {
        let pieces = async_stream::try_stream! {
            let _place = &self.seat;
            let (mut document, mut rows) = (document, first);
            yield begin;
            loop {
                let last = rows.last().map(ParameterRow::key);
                let is_full = rows.len() as i64 >= PIECE;
                let piece;
                (document, piece) = write(document, rows).await?;
                yield piece;
                if !is_full {
                    break;
                }
                rows = self.after(last).await?;
            }
            yield document.end(self.next.as_deref()).map_err(Broken::from)?;
        };
        let pieces = pieces
            .inspect_err(|error: &Broken| tracing::error!(%error, "a long list was aborted"))
            .map_ok(Bytes::from)
            .map_err(BoxError::from);
        Body::from_stream(pieces)
    }

    /// The rows after this one. They are fetched whether the reader waits for them or not, so that he never holds the
    /// connection to the database.
    async fn after(&self, last: Option<Key>) -> Result<Vec<ParameterRow>, Broken> {
        let (server, group) = (Arc::clone(&self.server), self.caller.group.clone());
        let (params, through) = (self.params.clone(), self.through.clone());
        let fetched = tokio::spawn(async move {
            let asked = params.filter(&group);
            let filter = Filter {
                after: last,
                through,
                ..asked.map_err(|problem| Broken::Query(problem.detail))?
            };
            Ok(parameter::page(&server.db, &filter, PIECE).await?)
        });
        fetched.await?
    }
}

/// The next piece of a document.
async fn write(
    mut document: Document,
    rows: Vec<ParameterRow>,
) -> Result<(Document, Vec<u8>), Broken> {
    let written = spawn_blocking(move || {
        let piece = document.rows(rows)?;
        Ok((document, piece))
    });
    written.await?
}
