use axum::Json;
use axum::extract::{self, State};
use serde::Serialize;
use utoipa::ToSchema;
use veloid_engine::bicycle::Bike;
use veloid_engine::ride::Preview;

use super::bicycle::the_bike;
use super::receive::receive;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::problem::Problem;
use crate::columns::{Guess, guesses};
use crate::jobs::Purpose;
use crate::options::Options;
use crate::store::job::Request;

/// How a ride would be read, and guesses for its other columns.
#[derive(Serialize, ToSchema)]
pub struct RidePreview {
    #[serde(flatten)]
    read: Preview,
    /// Guesses from the headers of columns without a recognised channel. They are used only through `map`.
    guesses: Vec<Guess>,
}

/// Reports how a ride file would be read, without storing it.
///
/// Accepts the same as `POST /v1/rides`; the bike is optional.
#[utoipa::path(post, path = "/v1/rides/preview", operation_id = "preview_ride", tag = "rides",
    params(
        ("bike" = Option<String>, Query, description = "Bike file, or the name of a bike of the fleet: checked for the masses that the ride needs"),
        ("name" = Option<String>, Query, description = "File name, with a raw body"),
        ("options" = Option<String>, Query, description = "Options (JSON), with a raw body; each may be a separate parameter"),
        ("facts" = Option<String>, Query, description = "Ignored"),
        ("again" = Option<bool>, Query, description = "Ignored")),
    request_body(content((super::upload::Upload = "multipart/form-data"), (String = "text/csv"), (Vec<u8> = "application/octet-stream"))),
    responses(
        (status = 200, description = "How the file would be read", body = RidePreview),
        (status = 400, description = "Malformed request", body = Problem, content_type = "application/problem+json"),
        (status = 408, description = "The body was too slow", body = Problem, content_type = "application/problem+json"),
        (status = 413, description = "Too large", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "The file is not a table, or an option is not allowed", body = Problem, content_type = "application/problem+json"),
        (status = 501, description = "The server is built without spreadsheets", body = Problem, content_type = "application/problem+json"),
        (status = 503, description = "Too many requests of the group wait for files to be read, or the process that read the ride was killed from outside; try again", body = Problem, content_type = "application/problem+json")))]
pub async fn preview(
    State(server): App,
    caller: Caller,
    request: extract::Request,
) -> Result<Json<RidePreview>, Problem> {
    let mut received = receive(&server, &caller, request).await?;
    let options = Options::try_from(std::mem::take(&mut received.options))?;
    // A bike that is still being typed is no reason to show nothing.
    let bike = the_bike(&server, &caller, &received.bicycle).await;
    let sources = received.sources().await?;
    // It is read without the bike.
    let request = Request {
        bike: Bike::default(),
        options,
    };
    let reader = (server.readers)
        .turn(&caller.group, received.bytes(), Purpose::Request)
        .await?;
    let mut read = reader.preview(sources, request).await?;
    if let Ok(bike) = bike {
        read = read.with_bike(&bike);
    }
    let guesses = guesses(&read.tables);
    Ok(Json(RidePreview { read, guesses }))
}
