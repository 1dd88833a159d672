//! What every request has to be, whoever sends it.

use axum::extract::Request;
use axum::http::{HeaderMap, Version, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};

use crate::api::problem::{Kind, Problem};
use crate::http::Spare;
use crate::router::security::OPEN;

/// Refuses a request that does not say once which server it is for, and what is no sign of life on a connection that is
/// kept for those.
pub async fn sound(request: Request, next: Next) -> Response {
    match one_host(request.version(), request.headers()).and_then(|()| has_room(&request)) {
        Ok(()) => next.run(request).await,
        Err(problem) => problem.into_response(),
    }
}

/// RFC 9112, 3.2: one `Host`, without which HTTP/1.0 may do.
fn one_host(version: Version, headers: &HeaderMap) -> Result<(), Problem> {
    let hosts: Vec<_> = headers.get_all(header::HOST).iter().collect();
    let detail = match hosts.as_slice() {
        [] if version <= Version::HTTP_10 => return Ok(()),
        [host] if host.to_str().is_ok() => return Ok(()),
        [_] => "the header `Host` is not text, expected a name or an address".to_owned(),
        hosts => format!("{} headers `Host`, expected one", hosts.len()),
    };
    Err(Problem::new(Kind::BadRequest, detail))
}

fn has_room(request: &Request) -> Result<(), Problem> {
    let is_spare = request.extensions().get::<Spare>().is_some();
    if !is_spare || OPEN.contains(&request.uri().path()) {
        return Ok(());
    }
    let detail =
        "all connections of this address, or of the server, are waiting for answers; try again";
    Err(Problem::new(Kind::Unavailable, detail))
}

#[cfg(test)]
mod tests {
    use axum::http::HeaderValue;

    use super::*;

    #[test]
    fn a_request_names_one_server() {
        let status = |version, hosts: &[&'static str]| {
            let mut headers = HeaderMap::new();
            for host in hosts
                .iter()
                .filter_map(|h| HeaderValue::from_bytes(h.as_bytes()).ok())
            {
                headers.append(header::HOST, host);
            }
            one_host(version, &headers)
                .err()
                .map(|problem| problem.status)
        };
        assert_eq!(status(Version::HTTP_11, &["x"]), None);
        assert_eq!(status(Version::HTTP_10, &[]), None);
        for (version, hosts) in [
            (Version::HTTP_11, [].as_slice()),
            (Version::HTTP_11, &["x", "x"]),
            (Version::HTTP_10, &["x", "y"]),
            (Version::HTTP_11, &["\u{fc}"]),
        ] {
            assert_eq!(status(version, hosts), Some(400), "{hosts:?}");
        }
    }
}
