use std::sync::Arc;

use axum::Json;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderName, StatusCode, header};
use axum::response::IntoResponse;
use utoipa::ToSchema;

use super::receive::receive;
use super::refused::{self, Refused};
use super::submit::{Submitted, submit};
use crate::api::access::Caller;
use crate::api::jobs::view::JobView;
use crate::api::problem::{Kind, Problem};
use crate::api::{App, Server};
use crate::bicycle::{Given, Way};
use crate::metrics::METRICS;

const KNOWN: HeaderName = HeaderName::from_static("veloid-known");

/// A ride with its bike and its options.
#[derive(ToSchema)]
#[expect(
    dead_code,
    reason = "describes the form; `receive` reads it as a stream"
)]
pub struct Upload {
    /// The ride: CSV (also gzip or zstd) or MATLAB v4 to v7. Several parts `file` with different names are one ride, each on its
    /// own clock.
    #[schema(value_type = String, format = Binary, content_media_type = "application/octet-stream")]
    file: Vec<u8>,
    /// The bike file (JSON), or the name of a bike of the fleet. Alternatively each key of a bike file except `roll` may be a
    /// separate part, with the name as `bike_name` and `wheelbase_m` instead of one or both lengths.
    bike: Option<String>,
    /// Name of a bike of the fleet, as selected in a form; `bike` has priority.
    fleet: Option<String>,
    /// Which way of giving the bicycle applies, where the form's fields for several are filled.
    bicycle: Option<Way>,
    /// File name, instead of the one sent with the only file.
    name: Option<String>,
    /// Settings and reading options (JSON object); each may also be a separate part.
    options: Option<crate::options::Options>,
    /// Facts about the ride (JSON object); each named fact may also be a separate part, and further numbers may be given as
    /// lines `name: number` of the part `more`.
    facts: Option<crate::facts::Facts>,
    /// Identify again even if a job exists for the same file, bike and options.
    again: Option<bool>,
}

/// Uploads a ride and queues its identification.
///
/// As a form with the parts `file`, `bike` and `options`, or as the raw file with `bike` and options in the query or in the
/// headers `Veloid-Bike` and `Veloid-Options`. The file is checked at once; the answer 202 is sent when it is safe on disk and
/// the job is committed. The same file, bike and options return the same job unless `again` is set. Every part and every option
/// may be given once, `map` once for each channel, `layout` once for each key (`layout=header_row=3`), `missing` once for each word, `file` once for each file of the ride; an
/// option for a single file begins with its name, such as `rate_hz=laser.csv:30`.
#[utoipa::path(post, path = "/v1/rides", operation_id = "upload_ride", tag = "rides",
    params(
        ("Idempotency-Key" = Option<String>, Header,
            description = "The same key with the same content returns the same job"),
        ("bike" = Option<String>, Query, description = "Bike file (JSON) or name, with a raw body"),
        ("name" = Option<String>, Query, description = "File name, with a raw body"),
        ("options" = Option<String>, Query, description = "Options (JSON), with a raw body; each may be a separate parameter"),
        ("facts" = Option<String>, Query, description = "Facts about the ride (JSON), with a raw body; each may be a separate parameter"),
        ("again" = Option<bool>, Query, description = "Identify again")),
    request_body(content((Upload = "multipart/form-data"), (String = "text/csv"), (Vec<u8> = "application/octet-stream"))),
    responses(
        (status = 202, description = "Queued", body = JobView, headers(
            ("Location" = String, description = "Address of the job"),
            ("Veloid-Known" = bool, description = "Whether the same was uploaded before and the existing job is returned"),
            ("Retry-After" = u32, description = "Seconds to wait before the next request"))),
        (status = 400, description = "Malformed request", body = Problem, content_type = "application/problem+json"),
        (status = 408, description = "The body was too slow", body = Problem, content_type = "application/problem+json"),
        (status = 413, description = "Too large", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "Ride, bike or options cannot be used", body = Problem, content_type = "application/problem+json"),
        (status = 501, description = "The server is built without spreadsheets", body = Problem, content_type = "application/problem+json"),
        (status = 503, description = "The queue is full, too many requests of the group wait for files to be read, the process that read the ride was killed from outside, or the database or the raw files are damaged or were exchanged", body = Problem, content_type = "application/problem+json", headers(("Retry-After" = u32)))))]
pub async fn upload(
    State(server): App,
    caller: Caller,
    request: Request,
) -> Result<impl IntoResponse, Problem> {
    let submitted = submit_upload(&server, &caller, request).await;
    let Submitted { job, known } = submitted.map_err(|refused| refused.problem)?;
    let job = JobView::from(job);
    let headers: [(HeaderName, String); 3] = [
        (header::LOCATION, job.links.job.clone()),
        (header::RETRY_AFTER, "1".to_owned()),
        (KNOWN, known.to_string()),
    ];
    Ok((StatusCode::ACCEPTED, headers, Json(job)))
}

/// Receives, checks, keeps and queues an upload; gives its job. Refusals are listed ([`refused::note`]).
pub async fn submit_upload(
    server: &Arc<Server>,
    caller: &Caller,
    request: Request,
) -> Result<Submitted, Refused> {
    let key = idempotency_key(request.headers());
    let (mut bicycle, mut file) = (Given::default(), None);
    let outcome = async {
        let received = receive(server, caller, request).await?;
        // Now the client listens.
        let key = key?;
        bicycle.clone_from(&received.bicycle);
        file = Some(received.name());
        METRICS.upload_sizes.record(received.bytes() as f64, []);
        submit(server, caller, received, key.as_deref()).await
    }
    .await;
    let label = if outcome.is_ok() {
        "accepted"
    } else {
        "refused"
    };
    METRICS.uploads.add(1, [("outcome", label.into())]);
    match outcome {
        Ok(submitted) => Ok(submitted),
        Err(problem) => {
            let refused = Refused {
                problem,
                bicycle,
                file,
            };
            refused::note(server, caller, &refused).await;
            Err(refused)
        }
    }
}

/// Most characters of an idempotency key.
const LONGEST_KEY: usize = 200;

/// The key without the quotes that the draft asks for and few send.
fn idempotency_key(headers: &HeaderMap) -> Result<Option<String>, Problem> {
    let Some(value) = headers.get("idempotency-key") else {
        return Ok(None);
    };
    let expected = format!("Idempotency-Key: expected 1 to {LONGEST_KEY} ASCII characters");
    let key = value.to_str().map(|text| text.trim_matches('"'));
    match key {
        Ok(key) if (1..=LONGEST_KEY).contains(&key.len()) => Ok(Some(key.to_owned())),
        Ok(key) => Err(Problem::new(
            Kind::BadRequest,
            format!("{expected}, not {}", key.len()),
        )),
        Err(_) => Err(Problem::new(Kind::BadRequest, expected)),
    }
}
