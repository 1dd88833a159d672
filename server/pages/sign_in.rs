//! A browser signs in with a key and gets a session, whose token it keeps as a cookie that scripts cannot read
//! and that no other site's page makes it send.

use askama::Template;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{Html, IntoResponse, Redirect, Response};
use axum::{Extension, Form};
use serde::Deserialize;

use super::layout::{Fault, Query, html};
use crate::api::App;
use crate::api::access::{self, COOKIE};
use crate::http::Peer;

/// Time that a browser stays signed in (s).
const LASTS_S: i64 = 12 * 3600;

#[derive(Template)]
#[template(path = "sign_in.html")]
struct SignIn {
    next: String,
    refused: bool,
}

impl SignIn {
    fn here(&self) -> &'static str {
        ""
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    next: Option<String>,
}

#[derive(Deserialize)]
pub struct Filled {
    key: String,
    next: Option<String>,
}

pub async fn form(Query(params): Query<Params>) -> Result<Html<String>, Fault> {
    html(&SignIn {
        next: own(params.next),
        refused: false,
    })
}

pub async fn sign_in(
    State(server): App,
    Extension(Peer(address)): Extension<Peer>,
    headers: HeaderMap,
    Form(filled): Form<Filled>,
) -> Result<Response, Fault> {
    let (key, next) = (filled.key.trim(), own(filled.next));
    server.access.attempt(address)?;
    let Some(row) = server.access.key(&server.db, key).await? else {
        let page = html(&SignIn {
            next,
            refused: true,
        })?;
        return Ok((StatusCode::UNAUTHORIZED, page).into_response());
    };
    let token = access::sign_in(&server.db, &headers, row.id, LASTS_S * 1000).await?;
    let cookie = [(header::SET_COOKIE, cookie(&headers, &token.0, LASTS_S))];
    Ok((cookie, Redirect::to(&next)).into_response())
}

pub async fn sign_out(State(server): App, headers: HeaderMap) -> Result<Response, Fault> {
    access::sign_out(&server.db, &headers).await?;
    let cookie = [(header::SET_COOKIE, cookie(&headers, "", 0))];
    Ok((cookie, Redirect::to("/sign-in")).into_response())
}

/// Only sent over TLS where a proxy says that this is how the browser came.
fn cookie(headers: &HeaderMap, token: &str, lasts_s: i64) -> String {
    let https = headers
        .get("x-forwarded-proto")
        .is_some_and(|proto| proto == "https");
    let secure = if https { "; Secure" } else { "" };
    format!("{COOKIE}={token}; Path=/; Max-Age={lasts_s}; HttpOnly; SameSite=Strict{secure}")
}

/// An address of this server to go on to.
fn own(next: Option<String>) -> String {
    next.filter(|next| {
        let mut characters = next.chars();
        characters.next() == Some('/')
            && !matches!(characters.next(), Some('/' | '\\'))
            && !next.contains(char::is_control)
    })
    .unwrap_or_else(|| "/".to_owned())
}

#[cfg(test)]
mod tests {
    use super::own;

    #[test]
    fn no_address_leads_elsewhere() {
        assert_eq!(own(Some("/jobs?state=failed".into())), "/jobs?state=failed");
        for next in [
            "//evil.example",
            "/\\evil.example",
            "https://evil.example",
            "",
            "/\t/evil.example",
        ] {
            assert_eq!(own(Some(next.into())), "/", "{next}");
        }
    }
}
