use axum::Json;
use axum::body::Body;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use utoipa::IntoParams;
use uuid::Uuid;

use super::view::{FileView, no_such_ride, views};
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract::{Path, Query, matches, not_modified, tagged};
use crate::api::problem::Problem;
use crate::jobs::Purpose;
use crate::store::ride;

/// Which of a ride's files is meant.
#[derive(Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// Name of the file, where the ride has several.
    name: Option<String>,
}

/// The bytes that were uploaded.
///
/// Of a ride in several files the one that `name` names; without it the list of all of them.
#[utoipa::path(get, path = "/v1/rides/{id}/file", operation_id = "download_ride", tag = "rides",
    params(("id" = Uuid, Path), Params),
    responses(
        (status = 200, description = "The file", body = Vec<u8>, content_type = "application/octet-stream"),
        (status = 300, description = "The ride has several files: their list", body = Vec<FileView>),
        (status = 304, description = "Not changed"),
        (status = 400, description = "Malformed query", body = Problem, content_type = "application/problem+json"),
        (status = 404, description = "No such ride", body = Problem, content_type = "application/problem+json"),
        (status = 410, description = "The stored file is missing or was altered", body = Problem, content_type = "application/problem+json"),
        (status = 503, description = "Too many requests of the group wait for files to be read; try again", body = Problem, content_type = "application/problem+json")))]
pub async fn file(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
    Query(params): Query<Params>,
    headers: HeaderMap,
) -> Result<Response, Problem> {
    ride::find(&server.db, &caller.group, id)
        .await?
        .filter(|ride| ride.deleted_at.is_none())
        .ok_or_else(no_such_ride)?;
    let mut files = ride::files(&server.db, id).await?;
    let wanted = params.name.as_deref();
    if wanted.is_none() && files.len() > 1 {
        return Ok((StatusCode::MULTIPLE_CHOICES, Json(views(id, files))).into_response());
    }
    files.retain(|file| wanted.is_none_or(|name| file.name == name));
    let [file] = &files[..] else {
        return Err(Problem::not_found("the file"));
    };
    let etag = format!("\"{}\"", file.sha256);
    if matches(&headers, &etag) {
        return Ok(not_modified(&etag));
    }
    let bytes = file.bytes.unsigned_abs();
    let turn = (server.readers).turn(&caller.group, bytes, Purpose::Request);
    let reader = turn.await?;
    server.files.verify(&file.sha256).await?;
    drop(reader);
    let body = Body::from_stream(server.files.stream(&file.sha256).await?);
    let headers = [
        (header::CONTENT_TYPE, "application/octet-stream".to_owned()),
        (header::CONTENT_LENGTH, file.bytes.to_string()),
        (header::CONTENT_DISPOSITION, attachment(&file.name)),
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
