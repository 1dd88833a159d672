use axum::Json;
use axum::body::{Body, to_bytes};
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;
use veloid_engine::bicycle::Bike;

use super::bicycle::looked_at;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::problem::{Kind, Problem};
use crate::bicycle::{Fault, Given, Way};
use crate::options::OptionsError;
use crate::unique::shown;

/// Most that the parts may hold (bytes): three times a bike file, whose every byte may be written in three.
const MOST: usize = 192 << 10;

/// The parts of an upload that describe its bicycle.
#[derive(ToSchema)]
#[expect(dead_code, reason = "describes the form; `told` reads it")]
pub struct BikeParts {
    /// The bike file (JSON), or the name of a bike of the fleet.
    bike: Option<String>,
    /// Name of a bike of the fleet.
    fleet: Option<String>,
    /// Which of the ways applies.
    #[schema(nullable = false)]
    bicycle: Option<Way>,
    /// Name of the bicycle; this and the following fields describe it.
    bike_name: Option<String>,
    #[schema(nullable = false)]
    equal_axles: Option<bool>,
    mass_front_kg: Option<String>,
    mass_front_std_kg: Option<String>,
    mass_rear_kg: Option<String>,
    mass_rear_std_kg: Option<String>,
    /// Wheelbase (m), from which missing lengths are computed by the static loads or else the masses.
    wheelbase_m: Option<String>,
    l_front_m: Option<String>,
    l_rear_m: Option<String>,
    wheel_radius_front_m: Option<String>,
    wheel_radius_rear_m: Option<String>,
    static_load_front_n: Option<String>,
    static_load_rear_n: Option<String>,
    noise_displacement_m: Option<String>,
    noise_road_m: Option<String>,
}

/// How a bicycle would be read.
#[derive(Serialize, ToSchema)]
pub struct BikePreview {
    /// The bike file; absent where something is wrong.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(nullable = false)]
    bike: Option<Bike>,
    /// What is wrong, part by part.
    faults: Vec<Fault>,
}

/// Reports how a bicycle would be read, without storing it.
///
/// Accepts the parts of `POST /v1/rides` that describe the bicycle; only the field's own unit is accepted, and none is
/// converted.
#[utoipa::path(post, path = "/v1/rides/preview/bike", operation_id = "preview_bike", tag = "rides",
    request_body(content = BikeParts, content_type = "application/x-www-form-urlencoded"),
    responses(
        (status = 200, description = "How the bicycle would be read, or what is wrong with each part", body = BikePreview),
        (status = 400, description = "Malformed request", body = Problem, content_type = "application/problem+json"),
        (status = 413, description = "Too large", body = Problem, content_type = "application/problem+json"),
        (status = 422, description = "No bicycle is given, two ways are used at once, or a part is unknown", body = Problem, content_type = "application/problem+json")))]
pub async fn preview_bike(
    State(server): App,
    caller: Caller,
    body: Body,
) -> Result<Json<BikePreview>, Problem> {
    let body = to_bytes(body, MOST).await.map_err(|error| {
        let detail = format!("{error}: expected at most {MOST} bytes");
        Problem::new(Kind::TooLarge, detail)
    })?;
    let given = given(&body)?;
    let looked_at = looked_at(&server, &caller, &given).await?;
    Ok(Json(match looked_at {
        Ok(bike) => BikePreview {
            bike: Some(bike),
            faults: Vec::new(),
        },
        Err(faults) => BikePreview { bike: None, faults },
    }))
}

fn given(body: &[u8]) -> Result<Given, Problem> {
    let mut given = Given::default();
    for (part, text) in form_urlencoded::parse(body) {
        if !Given::names().any(|name| name == part) {
            let known: Vec<&str> = Given::names().collect();
            let known = known.join("`, `");
            let detail = format!("unknown part `{}`, expected `{known}`", shown(&part));
            return Err(Problem::new(Kind::BadOption, detail));
        }
        let text = text.trim();
        if text.is_empty() {
            continue;
        }
        let fresh = given.add(&part, text);
        if !fresh.map_err(|detail| Problem::new(Kind::BadBike, detail))? {
            return Err(OptionsError::Twice(part.into_owned()).into());
        }
    }
    Ok(given)
}
