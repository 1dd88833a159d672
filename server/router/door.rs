//! The door that every request goes through.

use std::net::IpAddr;

use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, Method, Uri, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Redirect, Response};

use super::stay::while_admitted;
use crate::api::access::credentials::cookie;
use crate::api::access::{Caller, Mode};
use crate::api::problem::{Kind, Problem, Suspicion};
use crate::api::{App, Server};
use crate::metrics::{Label, METRICS};
use crate::pages::layout::Fault;
use crate::shorten::shortened;
use crate::store::key::Scope;

/// Lets a request in, with its [`Caller`] where the address is not open to all.
pub async fn enter(State(server): App, mut request: Request, next: Next) -> Response {
    let asked = Asked::of(&request);
    let answer = match scope(&server, &request) {
        Ok(None) => Ok(next.run(request).await),
        Ok(Some(scope)) => match admit(&server, request.headers(), scope).await {
            Ok(caller) => {
                request.extensions_mut().insert(caller.clone());
                while_admitted(&server, caller, next.run(request)).await
            }
            Err(problem) => Err(problem),
        },
        Err(problem) => Err(problem),
    };
    let response = answer.unwrap_or_else(|problem| {
        METRICS
            .refused
            .add(1, [("status", Label::Status(problem.status))]);
        asked.refuse(problem)
    });
    if let Some(Suspicion(why)) = response.extensions().get() {
        server.db.condition().suspect(why);
    }
    response
}

/// The scope that a request needs, if any, unless it must not come in at all.
fn scope(server: &Server, request: &Request) -> Result<Option<Scope>, Problem> {
    own_site(request)?;
    if server.access.mode == Mode::Local {
        own_name(request)?;
    }
    Ok(needed(request.method(), request.uri().path()))
}

async fn admit(server: &Server, headers: &HeaderMap, scope: Scope) -> Result<Caller, Problem> {
    let caller = server.access.caller(&server.db, headers).await?;
    server.access.spend(&caller)?;
    caller.needs(scope)?;
    Ok(caller)
}

/// The scope that a request needs; none for what is open to all.
fn needed(method: &Method, path: &str) -> Option<Scope> {
    let open = ["/docs", "/assets/"].iter().any(|p| path.starts_with(p));
    match path {
        "/healthz" | "/readyz" | "/openapi.json" | "/favicon.ico" | "/sign-in" | "/sign-out" => {
            None
        }
        _ if open => None,
        "/metrics" | "/v1/audit" => Some(Scope::Admin),
        // Nothing is stored.
        "/v1/validations" => Some(Scope::Read),
        _ if path.starts_with("/v1/webhooks") => Some(Scope::Admin),
        _ if method.is_safe() => Some(Scope::Read),
        _ => Some(Scope::Upload),
    }
}

/// Refuses what a page of another site makes a browser do.
fn own_site(request: &Request) -> Result<(), Problem> {
    if request.method().is_safe() || is_of_own_page(request.headers()) {
        return Ok(());
    }
    let detail = "changes are accepted only from this server's own pages";
    Err(Problem::new(Kind::Foreign, detail))
}

/// Browsers say where a request comes from: to servers with TLS and on the same machine by `Sec-Fetch-Site`, to all
/// by `Origin`. Whoever says neither is no browser, and has no cookie.
fn is_of_own_page(headers: &HeaderMap) -> bool {
    let text = |name: &str| headers.get(name).map(HeaderValue::as_bytes);
    if let Some(site) = text("sec-fetch-site") {
        return site == b"same-origin" || site == b"none";
    }
    let Some(origin) = text("origin") else {
        return cookie(headers).is_none();
    };
    let page = (origin.strip_prefix(b"http://")).or_else(|| origin.strip_prefix(b"https://"));
    // A proxy may have put a name of its own in place of the one that the browser asked for.
    let names = [text("host"), text("x-forwarded-host")];
    page.is_some_and(|page| {
        names
            .into_iter()
            .flatten()
            .any(|n| n.eq_ignore_ascii_case(page))
    })
}

/// A server that asks for no keys answers to this machine's names only. Else another site could have
/// its own name lead here, and its pages would count as this server's.
fn own_name(request: &Request) -> Result<(), Problem> {
    let host = request.headers().get(header::HOST);
    let Some(host) = host.and_then(|host| host.to_str().ok()) else {
        return Ok(());
    };
    if is_own(host) {
        return Ok(());
    }
    Err(Problem::new(
        Kind::Foreign,
        format!(
            "'{}' is not a name of this machine; behind a proxy the server needs `--keys` or `--open`",
            shortened(host)
        ),
    ))
}

fn is_own(host: &str) -> bool {
    let name = match host.rsplit_once(':') {
        Some((name, port)) if port.bytes().all(|b| b.is_ascii_digit()) => name,
        _ => host,
    };
    let address = name.trim_start_matches('[').trim_end_matches(']');
    // A name without a dot is none that another site could own.
    !name.contains('.') || address.parse::<IpAddr>().is_ok()
}

/// What decides how a refusal looks.
struct Asked {
    method: Method,
    uri: Uri,
    /// Whether a page is wanted.
    html: bool,
}

impl Asked {
    fn of(request: &Request) -> Self {
        let accept = request.headers().get(header::ACCEPT);
        let html = |value: &HeaderValue| value.to_str().is_ok_and(|t| t.contains("text/html"));
        Self {
            method: request.method().clone(),
            uri: request.uri().clone(),
            html: accept.is_some_and(html),
        }
    }

    /// A browser is led to where it signs in, or shown a page; others get the problem.
    fn refuse(&self, problem: Problem) -> Response {
        let path = self.uri.path();
        if !self.html || path.starts_with("/v1/") {
            return problem.into_response();
        }
        if problem.kind == Kind::Unauthorized && self.method == Method::GET {
            let here = self.uri.path_and_query().map_or(path, |p| p.as_str());
            let next: String = form_urlencoded::byte_serialize(here.as_bytes()).collect();
            return Redirect::to(&format!("/sign-in?next={next}")).into_response();
        }
        Fault(problem).into_response()
    }
}

#[cfg(test)]
mod tests {
    use axum::http::HeaderName;

    use super::*;

    #[test]
    fn only_names_that_no_other_site_can_have_are_own() {
        for host in [
            "localhost",
            "LOCALHOST:8080",
            "127.0.0.1:80",
            "[::1]:80",
            "bench:80",
        ] {
            assert!(is_own(host), "{host}");
        }
        for host in [
            "evil.example",
            "localhost.evil.example:80",
            "127.0.0.1.evil.example",
        ] {
            assert!(!is_own(host), "{host}");
        }
    }

    #[test]
    fn only_own_pages_and_programs_may_change_something() {
        let own = |fields: &[(&'static str, &'static str)]| {
            let fields = fields.iter().map(|(name, value)| {
                (
                    HeaderName::from_static(name),
                    HeaderValue::from_static(value),
                )
            });
            is_of_own_page(&fields.collect())
        };
        let cookie = ("cookie", "veloid_session=abc");
        let host = ("host", "bench.lan:8080");
        assert!(own(&[host]), "a program");
        assert!(own(&[host, cookie, ("origin", "http://bench.lan:8080")]));
        assert!(own(&[
            ("host", "10.0.0.2:80"),
            ("x-forwarded-host", "veloid.example"),
            ("origin", "https://veloid.example")
        ]));
        assert!(own(&[host, cookie, ("sec-fetch-site", "same-origin")]));
        assert!(own(&[host, cookie, ("sec-fetch-site", "none")]));
        assert!(!own(&[host, cookie]), "no browser leaves out both");
        for origin in [
            "http://evil.example",
            "http://bench.lan",
            "http://bench.lan:8081",
            "null",
            "",
        ] {
            assert!(!own(&[host, ("origin", origin)]), "{origin}");
        }
        assert!(!own(&[
            host,
            ("sec-fetch-site", "cross-site"),
            ("origin", "http://bench.lan:8080")
        ]));
    }

    #[test]
    fn every_address_that_is_not_named_open_needs_a_scope() {
        assert_eq!(needed(&Method::GET, "/v1/jobs"), Some(Scope::Read));
        assert_eq!(needed(&Method::DELETE, "/v1/jobs/x"), Some(Scope::Upload));
        assert_eq!(needed(&Method::GET, "/"), Some(Scope::Read));
        assert_eq!(needed(&Method::POST, "/"), Some(Scope::Upload));
        assert_eq!(needed(&Method::GET, "/metrics"), Some(Scope::Admin));
        assert_eq!(needed(&Method::GET, "/v1/webhooks"), Some(Scope::Admin));
        assert_eq!(needed(&Method::GET, "/healthz"), None);
    }
}
