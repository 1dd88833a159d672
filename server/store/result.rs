//! What a stage hands to the next one, and at last the report, each with the SHA-256 of its text.

use std::string::FromUtf8Error;

use serde::Serialize;
use serde::de::{DeserializeOwned, IgnoredAny};
use sha2::{Digest, Sha256};
use uuid::Uuid;
use veloid_engine::report::Report;

use super::{Db, Tx, is_damage};
use crate::files::hex;

pub const OBSERVED: &str = "observed";
pub const CONCLUSION: &str = "conclusion";
pub const REPORT: &str = "report";

/// Why a stored document cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum DocumentError {
    #[error("database: {0}")]
    Database(#[from] sqlx::Error),
    #[error(
        "the stored {name} was altered: the SHA-256 of its text is {found}, {kept} was stored with it"
    )]
    Altered {
        name: &'static str,
        found: String,
        kept: String,
    },
    #[error("the stored {name} is not text: {source}")]
    NotText {
        name: &'static str,
        source: FromUtf8Error,
    },
    #[error("the stored {name} is malformed: {source}")]
    Malformed {
        name: &'static str,
        source: serde_json::Error,
    },
    #[error("the stored {name} lies on damaged pages of the database: {source}")]
    Damaged {
        name: &'static str,
        source: sqlx::Error,
    },
}

/// A document as it is stored.
pub struct Document {
    name: &'static str,
    pub text: String,
    /// Whether it was compared with a checksum; those of earlier versions have none.
    pub is_checked: bool,
}

impl Document {
    fn of(
        name: &'static str,
        bytes: Vec<u8>,
        kept: Option<Vec<u8>>,
    ) -> Result<Self, DocumentError> {
        if let Some(kept) = &kept {
            let found = hex(&Sha256::digest(&bytes));
            if found.as_bytes() != kept {
                let kept = String::from_utf8_lossy(kept).into_owned();
                return Err(DocumentError::Altered { name, found, kept });
            }
        }
        let text = String::from_utf8(bytes);
        let document = Self {
            name,
            text: text.map_err(|source| DocumentError::NotText { name, source })?,
            is_checked: kept.is_some(),
        };
        if !document.is_checked {
            document.parse::<IgnoredAny>()?;
        }
        Ok(document)
    }

    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, DocumentError> {
        let name = self.name;
        serde_json::from_str(&self.text).map_err(|source| DocumentError::Malformed { name, source })
    }
}

pub async fn put<T: Serialize + Sync>(
    tx: &mut Tx,
    job: Uuid,
    name: &str,
    document: &T,
) -> sqlx::Result<()> {
    macro_rules! sql {
        ($document:literal) => {
            concat!(
                "INSERT INTO result (job_id, name, document, sha256) VALUES ($1, $2, ",
                $document,
                ", $4) ON CONFLICT (job_id, name) DO UPDATE SET document = excluded.document, sha256 = excluded.sha256"
            )
        };
    }
    // As text: PostgreSQL would write a document in its own way.
    let sql = tx.spelt(sql!("$3"), sql!("CAST($3 AS JSON)"));
    let text = serde_json::to_string(document).map_err(|e| sqlx::Error::Encode(e.into()))?;
    let sha256 = hex(&Sha256::digest(&text));
    on!(tx, t => sqlx::query(sql)
        .bind(job)
        .bind(name)
        .bind(text)
        .bind(sha256)
        .execute(&mut **t)
        .await
        .map(drop))
}

/// The document, or [`sqlx::Error::RowNotFound`].
pub async fn get<T: DeserializeOwned>(
    db: &Db,
    job: Uuid,
    name: &'static str,
) -> Result<T, DocumentError> {
    let document = find(db, job, name).await?;
    document.ok_or(sqlx::Error::RowNotFound)?.parse()
}

/// The document as it was stored, number for number.
pub async fn find(
    db: &Db,
    job: Uuid,
    name: &'static str,
) -> Result<Option<Document>, DocumentError> {
    const SQLITE: &str = "SELECT CAST(document AS BLOB), CAST(sha256 AS BLOB) FROM result WHERE job_id = $1 AND name = $2";
    const POSTGRES: &str = "\
        SELECT convert_to(CAST(document AS TEXT), 'UTF8'), convert_to(sha256, 'UTF8') FROM result \
        WHERE job_id = $1 AND name = $2";
    let sql = db.spelt(SQLITE, POSTGRES);
    type Row = (Vec<u8>, Option<Vec<u8>>);
    let found: sqlx::Result<Option<Row>> =
        on!(read db, p => sqlx::query_as(sql).bind(job).bind(name).fetch_optional(p).await);
    match found {
        Ok(Some((bytes, kept))) => Document::of(name, bytes, kept).map(Some),
        Ok(None) => Ok(None),
        Err(source) if is_damage(&source) => Err(DocumentError::Damaged { name, source }),
        Err(error) => Err(error.into()),
    }
}

/// The job's report, if it has one.
pub async fn report(db: &Db, job: Uuid) -> Result<Option<Report>, DocumentError> {
    let document = find(db, job, REPORT).await?;
    document.map(|document| document.parse()).transpose()
}

/// Drops what the stages handed on and the report.
pub async fn clear(tx: &mut Tx, job: Uuid) -> sqlx::Result<()> {
    const SQL: &str = "DELETE FROM result WHERE job_id = $1";
    on!(tx, t => sqlx::query(SQL).bind(job).execute(&mut **t).await.map(drop))
}
