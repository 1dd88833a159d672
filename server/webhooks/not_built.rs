//! In the place of `post.rs` where the program is built without the feature `webhooks`. Nothing takes messages from the queue there.

use std::net::SocketAddr;

use axum::http::StatusCode;
use url::Url;

use super::message::Message;
use crate::built::NotBuilt;

pub async fn post(
    _: Url,
    _: &[SocketAddr],
    _: &str,
    _: &Message<'_>,
) -> Result<StatusCode, String> {
    Err(NotBuilt::of("webhooks", "a message").to_string())
}
