//! One attempt at a delivery.

use std::time::Duration;

use reqwest::redirect::Policy;
use reqwest::{Client, StatusCode};

use super::sign::Secret;
use super::target::{TargetError, Targets};

/// Longest wait for an answer.
const PATIENCE: Duration = Duration::from_secs(10);

/// What is sent; the same identifier at each attempt, so that a receiver knows what it has.
pub struct Message<'a> {
    pub id: &'a str,
    pub body: &'a str,
    /// Of this attempt (s since 1970).
    pub timestamp: i64,
}

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

impl From<reqwest::Error> for SendError {
    /// Without the address, which may hold what is not for logs.
    fn from(error: reqwest::Error) -> Self {
        let mut error: &dyn std::error::Error = &error.without_url();
        let mut reported = error.to_string();
        while let Some(source) = error.source() {
            reported = format!("{reported}: {source}");
            error = source;
        }
        Self::Request(reported)
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
    let client = Client::builder()
        .redirect(Policy::none())
        .no_proxy()
        .timeout(PATIENCE)
        .resolve_to_addrs(url.host_str().unwrap_or_default(), &addresses)
        .user_agent(concat!("veloid/", env!("CARGO_PKG_VERSION")))
        .build()?;
    let response = client
        .post(url)
        .header("content-type", "application/json")
        .header("webhook-id", message.id)
        .header("webhook-timestamp", message.timestamp)
        .header("webhook-signature", signature.ok_or(SendError::Secret)?)
        .body(message.body.to_owned())
        .send()
        .await?;
    match response.status() {
        status if status.is_success() => Ok(status),
        status => Err(SendError::Refused(status)),
    }
}
