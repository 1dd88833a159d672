//! The POST of a message.

use std::error::Error;
use std::net::SocketAddr;

use axum::http::StatusCode;
use reqwest::Client;
use reqwest::redirect::Policy;
use url::Url;

use super::message::{Message, PATIENCE};

/// The status of the answer, or why there was none.
pub async fn post(
    url: Url,
    addresses: &[SocketAddr],
    signature: &str,
    message: &Message<'_>,
) -> Result<StatusCode, String> {
    let request = async {
        let client = Client::builder()
            .redirect(Policy::none())
            .no_proxy()
            .timeout(PATIENCE)
            .resolve_to_addrs(url.host_str().unwrap_or_default(), addresses)
            .user_agent(concat!("veloid/", env!("CARGO_PKG_VERSION")))
            .build()?;
        let request = client
            .post(url)
            .header("content-type", "application/json")
            .header("webhook-id", message.id)
            .header("webhook-timestamp", message.timestamp)
            .header("webhook-signature", signature)
            .body(message.body.to_owned());
        Ok(request.send().await?.status())
    };
    request.await.map_err(reported)
}

/// Without the address, which may hold what is not for logs.
fn reported(error: reqwest::Error) -> String {
    let mut error: &dyn Error = &error.without_url();
    let mut reported = error.to_string();
    while let Some(source) = error.source() {
        reported = format!("{reported}: {source}");
        error = source;
    }
    reported
}
