//! Where a request holds its key or session.

use axum::http::{HeaderMap, header};

/// Name of the cookie that holds a browser's session.
pub const COOKIE: &str = "veloid_session";

pub fn bearer(headers: &HeaderMap) -> Option<&str> {
    let value = headers.get(header::AUTHORIZATION)?.to_str().ok()?;
    let (scheme, token) = value.split_once(' ')?;
    scheme.eq_ignore_ascii_case("bearer").then(|| token.trim())
}

pub fn cookie(headers: &HeaderMap) -> Option<&str> {
    headers
        .get_all(header::COOKIE)
        .iter()
        .filter_map(|value| value.to_str().ok())
        .flat_map(|text| text.split(';'))
        .find_map(|pair| pair.trim().strip_prefix(COOKIE)?.strip_prefix('='))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn tokens_are_found_in_headers() {
        let mut headers = HeaderMap::new();
        headers.insert(header::COOKIE, "a=b; veloid_session=abc".parse().unwrap());
        assert_eq!((bearer(&headers), cookie(&headers)), (None, Some("abc")));
        headers.insert(header::AUTHORIZATION, "bearer  xyz".parse().unwrap());
        assert_eq!(bearer(&headers), Some("xyz"));
        headers.insert(header::AUTHORIZATION, "Basic xyz".parse().unwrap());
        headers.insert(header::COOKIE, "veloid_sessions=abc".parse().unwrap());
        assert_eq!((bearer(&headers), cookie(&headers)), (None, None));
    }
}
