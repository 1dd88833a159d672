//! One attempt at a delivery.

use axum::http::StatusCode;

use super::message::{Message, PATIENCE};
use super::post::post;
use super::sign::Secret;
use super::target::{TargetError, Targets};

#[derive(Debug, thiserror::Error)]
pub enum SendError {
    #[error(transparent)]
    Target(#[from] TargetError),
    #[error("the secret cannot be used to sign")]
    Secret,
    #[error("no answer: {0}")]
    Request(String),
    #[error("the answer was {0}, expected 200 to 299")]
    Refused(StatusCode),
}

impl SendError {
    /// Whether the host could not be reached or did not answer.
    pub fn is_silence(&self) -> bool {
        match self {
            Self::Request(_) => true,
            Self::Target(error) => error.is_unknown(),
            Self::Secret | Self::Refused(_) => false,
        }
    }
}

/// Sends a message to an address that is allowed, without following where it leads; its status.
pub async fn send(
    targets: &Targets,
    url: &str,
    secret: &Secret,
    message: &Message<'_>,
) -> Result<StatusCode, SendError> {
    let url = targets.check(url)?;
    let addresses = tokio::time::timeout(PATIENCE, targets.resolve(&url)).await;
    let addresses = addresses
        .map_err(|_| SendError::Request("the host's name was not resolved in time".to_owned()))??;
    let signature = secret.signature(message.id, message.timestamp, message.body);
    let signature = signature.ok_or(SendError::Secret)?;
    let answer = post(url, &addresses, &signature, message).await;
    match answer.map_err(SendError::Request)? {
        status if status.is_success() => Ok(status),
        status => Err(SendError::Refused(status)),
    }
}
