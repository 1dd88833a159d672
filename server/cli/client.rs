//! What commands ask of a server: HTTP/1.1 without TLS, on connections that are used again.

use std::error::Error;
use std::time::Duration;

use axum::body::{Body, Bytes, to_bytes};
use axum::http::header::{AUTHORIZATION, CONTENT_TYPE, IF_NONE_MATCH};
use axum::http::request::Builder;
use axum::http::{HeaderMap, HeaderValue, Method, Request, StatusCode, Uri};
use hyper_util::client::legacy;
use hyper_util::client::legacy::connect::HttpConnector;
use hyper_util::rt::{TokioExecutor, TokioTimer};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::form::Form;

/// How long a connection may rest and be used again: the server closes them after a minute.
const RESTING: Duration = Duration::from_secs(5);

#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    #[error("'{0}' is not an address such as http://127.0.0.1:8080")]
    Address(String),
    #[error("no answer from {0}: {1}")]
    Silent(Uri, String),
    #[error("the answer of {0} ended early: {1}")]
    Incomplete(Uri, axum::Error),
    #[error("the answer of {0} is not as expected: {1}")]
    Json(Uri, serde_json::Error),
    #[error("cannot be sent: {0}")]
    Request(#[from] axum::http::Error),
    #[error("cannot be sent: {0}")]
    Body(#[from] serde_json::Error),
}

/// A client; clones share their connections.
#[derive(Clone)]
pub struct Client {
    connections: legacy::Client<HttpConnector, Body>,
    /// What `Authorization` says.
    key: Option<HeaderValue>,
}

pub struct Answer {
    from: Uri,
    pub status: StatusCode,
    pub headers: HeaderMap,
    pub body: Bytes,
}

impl Client {
    pub fn new() -> Self {
        let connections = legacy::Client::builder(TokioExecutor::new())
            .pool_idle_timeout(RESTING)
            .pool_timer(TokioTimer::new())
            .build_http();
        Self {
            connections,
            key: None,
        }
    }

    /// A client that shows this key, if it is one.
    pub fn with_key(key: Option<String>) -> Self {
        let key = key.and_then(|key| format!("Bearer {key}").parse().ok());
        Self { key, ..Self::new() }
    }

    pub async fn get(&self, url: &str) -> Result<Answer, ClientError> {
        let request = self.request(Method::GET, url)?;
        self.send(request.body(Body::empty())?).await
    }

    /// The same where the answer is no longer the one of this tag.
    pub async fn get_unless(&self, url: &str, tag: &HeaderValue) -> Result<Answer, ClientError> {
        let request = self.request(Method::GET, url)?;
        let request = request.header(IF_NONE_MATCH, tag);
        self.send(request.body(Body::empty())?).await
    }

    pub async fn post_form(&self, url: &str, form: Form) -> Result<Answer, ClientError> {
        let request = self.request(Method::POST, url)?;
        let request = request.header(CONTENT_TYPE, form.content_type());
        self.send(request.body(Body::from(form.body()))?).await
    }

    pub async fn post_json(&self, url: &str, body: &impl Serialize) -> Result<Answer, ClientError> {
        let request = self.request(Method::POST, url)?;
        let request = request.header(CONTENT_TYPE, "application/json");
        let body = serde_json::to_vec(body)?;
        self.send(request.body(Body::from(body))?).await
    }

    fn request(&self, method: Method, url: &str) -> Result<Builder, ClientError> {
        let uri: Option<Uri> = url.parse().ok();
        let uri = uri.filter(|uri| uri.scheme_str() == Some("http") && uri.host().is_some());
        let uri = uri.ok_or_else(|| ClientError::Address(url.to_owned()))?;
        let request = Request::builder().method(method).uri(uri);
        Ok(match &self.key {
            Some(key) => request.header(AUTHORIZATION, key),
            None => request,
        })
    }

    async fn send(&self, request: Request<Body>) -> Result<Answer, ClientError> {
        let from = request.uri().clone();
        let answer = self.connections.request(request).await;
        let answer = answer.map_err(|error| ClientError::Silent(from.clone(), chain(&error)))?;
        let (head, body) = answer.into_parts();
        let body = to_bytes(Body::new(body), usize::MAX).await;
        let body = body.map_err(|error| ClientError::Incomplete(from.clone(), error))?;
        Ok(Answer {
            from,
            status: head.status,
            headers: head.headers,
            body,
        })
    }
}

impl Answer {
    pub fn json<T: DeserializeOwned>(&self) -> Result<T, ClientError> {
        let read = serde_json::from_slice(&self.body);
        read.map_err(|error| ClientError::Json(self.from.clone(), error))
    }
}

/// An error with all that caused it.
fn chain(mut error: &dyn Error) -> String {
    let mut said = error.to_string();
    while let Some(source) = error.source() {
        said = format!("{said}: {source}");
        error = source;
    }
    said
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[tokio::test]
    async fn what_cannot_be_asked_is_said() {
        let client = Client::new();
        for url in ["https://127.0.0.1:1/", "127.0.0.1:8080", "http:///x", "x"] {
            let error = client.get(url).await.err().unwrap();
            assert!(matches!(error, ClientError::Address(_)), "{url}: {error}");
        }
        let error = client.get("http://127.0.0.1:1/").await.err().unwrap();
        let said = error.to_string();
        assert!(said.contains("Connection refused"), "{said}");
    }
}
