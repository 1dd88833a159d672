use axum::body::Body;
use axum::extract::State;
use axum::http::{HeaderMap, header};
use axum::response::{IntoResponse, Response};
use uuid::Uuid;

use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::{Path, matches, not_modified, tagged};
use crate::api::jobs::report::MADE_UP;
use crate::api::problem::{Kind, Problem};
use crate::store::ride::{self, TOLD};

/// The bytes that were uploaded.
#[utoipa::path(get, path = "/v1/rides/{id}/file", operation_id = "download_ride", tag = "rides", params(("id" = Uuid, Path)),
    responses(
        (status = 200, description = "The file", body = Vec<u8>, content_type = "application/octet-stream"),
        (status = 304, description = "The client has it"),
        (status = 404, description = "No such ride", body = Problem, content_type = "application/problem+json")))]
pub async fn file(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    let ride = ride::find(&server.db, &caller.group, id)
        .await?
        .ok_or_else(|| Problem::not_found("the ride"))?;
    if ride.sha256 == TOLD {
        return Err(Problem::new(Kind::NotFound, MADE_UP));
    }
    let etag = format!("\"{}\"", ride.sha256);
    if matches(&headers, &etag) {
        return Ok(not_modified(&etag));
    }
    let body = Body::from_stream(server.files.stream(&ride.sha256).await?);
    let headers = [
        (header::CONTENT_TYPE, "application/octet-stream".to_owned()),
        (header::CONTENT_LENGTH, ride.bytes.to_string()),
        (header::CONTENT_DISPOSITION, attachment(&ride.name)),
    ];
    Ok(tagged(&etag, (headers, body).into_response()))
}

/// RFC 6266: the name percent-encoded, so that it can hold anything.
fn attachment(name: &str) -> String {
    use std::fmt::Write;
    let mut text = "attachment; filename*=UTF-8''".to_owned();
    for byte in name.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~".contains(&byte) {
            text.push(byte.into());
        } else {
            let _ = write!(text, "%{byte:02X}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::attachment;

    #[test]
    fn any_name_is_a_safe_header() {
        assert_eq!(
            attachment("ä\"; x.csv"),
            "attachment; filename*=UTF-8''%C3%A4%22%3B%20x.csv"
        );
    }
}
