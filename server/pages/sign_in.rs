//! A browser signs in with a key, which it then keeps as a cookie that scripts cannot read and that
//! no other site's page makes it send.

use askama::Template;
use axum::Form;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{Html, IntoResponse, Redirect, Response};
use serde::Deserialize;

use super::layout::{Fault, Query, html};
use crate::api::App;
use crate::api::access::COOKIE;

/// Time that a browser stays signed in (s).
const LASTS_S: u32 = 12 * 3600;

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
    headers: HeaderMap,
    Form(filled): Form<Filled>,
) -> Result<Response, Fault> {
    let (key, next) = (filled.key.trim(), own(filled.next));
    if server.access.key(&server.db, key).await?.is_none() {
        let page = html(&SignIn {
            next,
            refused: true,
        })?;
        return Ok((StatusCode::UNAUTHORIZED, page).into_response());
    }
    let cookie = [(header::SET_COOKIE, cookie(&headers, key, LASTS_S))];
    Ok((cookie, Redirect::to(&next)).into_response())
}

pub async fn sign_out(headers: HeaderMap) -> impl IntoResponse {
    let cookie = [(header::SET_COOKIE, cookie(&headers, "", 0))];
    (cookie, Redirect::to("/sign-in"))
}

/// Only sent over TLS where a proxy says that this is how the browser came.
fn cookie(headers: &HeaderMap, key: &str, lasts_s: u32) -> String {
    let https = headers
        .get("x-forwarded-proto")
        .is_some_and(|proto| proto == "https");
    let secure = if https { "; Secure" } else { "" };
    format!("{COOKIE}={key}; Path=/; Max-Age={lasts_s}; HttpOnly; SameSite=Strict{secure}")
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
