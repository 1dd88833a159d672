//! A list of parameters in the format that was asked for, made piece by piece.

use axum::http::HeaderValue;

use super::csv;
#[cfg(feature = "parquet")]
use super::parquet;
use super::query::Format;
use crate::api::parameter_view::ParameterView;
use crate::api::problem::Problem;
#[cfg(not(feature = "parquet"))]
use crate::built::NotBuilt;
use crate::store::parameter::ParameterRow;

#[derive(Debug, thiserror::Error)]
pub enum DocumentError {
    #[error(transparent)]
    Json(#[from] serde_json::Error),
    #[error(transparent)]
    Csv(#[from] ::csv::Error),
    #[cfg(feature = "parquet")]
    #[error(transparent)]
    Parquet(#[from] ::parquet::errors::ParquetError),
    #[cfg(not(feature = "parquet"))]
    #[error(transparent)]
    NotBuilt(#[from] NotBuilt),
}

impl From<DocumentError> for Problem {
    fn from(error: DocumentError) -> Self {
        match error {
            #[cfg(not(feature = "parquet"))]
            DocumentError::NotBuilt(error) => error.into(),
            error => Self::internal(error),
        }
    }
}

/// A document that is being written.
pub enum Document {
    /// Whether an item is in it yet.
    Json(bool),
    Csv,
    #[cfg(feature = "parquet")]
    Parquet(Box<parquet::Writer>),
}

impl Document {
    /// A new one, and how it begins.
    pub fn begin(format: Format) -> Result<(Self, Vec<u8>), DocumentError> {
        Ok(match format {
            Format::Json => (Self::Json(false), b"{\"items\":[".to_vec()),
            Format::Csv => (Self::Csv, csv::head()?),
            #[cfg(not(feature = "parquet"))]
            Format::Parquet => return Err(NotBuilt::of("parquet", "Parquet files").into()),
            #[cfg(feature = "parquet")]
            Format::Parquet => (Self::Parquet(Box::new(parquet::Writer::new()?)), Vec::new()),
        })
    }

    /// How it goes on.
    pub fn rows(&mut self, rows: Vec<ParameterRow>) -> Result<Vec<u8>, DocumentError> {
        if rows.is_empty() {
            return Ok(Vec::new());
        }
        Ok(match self {
            Self::Json(begun) => {
                let mut json = Vec::new();
                for row in rows {
                    if std::mem::replace(begun, true) {
                        json.push(b',');
                    }
                    serde_json::to_writer(&mut json, &ParameterView::from(row))?;
                }
                json
            }
            Self::Csv => {
                let items: Vec<_> = rows.into_iter().map(ParameterView::from).collect();
                csv::lines(&items)?
            }
            #[cfg(feature = "parquet")]
            Self::Parquet(writer) => writer.rows(rows)?,
        })
    }

    /// How it ends; `next` names what comes after it.
    pub fn end(self, next: Option<&str>) -> Result<Vec<u8>, DocumentError> {
        Ok(match self {
            Self::Json(_) => format!("],\"next\":{}}}", serde_json::to_string(&next)?).into_bytes(),
            Self::Csv => Vec::new(),
            #[cfg(feature = "parquet")]
            Self::Parquet(writer) => writer.end()?,
        })
    }
}

/// What a format is called, and the name of a file that is to be kept.
pub fn kind(format: Format) -> (HeaderValue, Option<HeaderValue>) {
    let (kind, attachment) = match format {
        Format::Json => ("application/json", None),
        Format::Csv => (
            "text/csv; charset=utf-8",
            Some("attachment; filename=\"parameters.csv\""),
        ),
        Format::Parquet => (
            "application/vnd.apache.parquet",
            Some("attachment; filename=\"parameters.parquet\""),
        ),
    };
    let value = HeaderValue::from_static;
    (value(kind), attachment.map(value))
}
