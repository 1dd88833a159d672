//! The fleet as a whole.

use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;

use super::access::Caller;
use super::extract::Path;
use super::names::EFFECTS;
use super::problem::Problem;
use super::{App, Server};
use crate::fleet::{EffectOnBike, FleetSpread, PooledBike, against_the_fleet, histories, on_bikes};
use crate::store::{bike, parameter};

/// Most bikes.
const BIKES: i64 = 1000;
/// Latest rides of each whose effects are listed.
const RIDES: usize = 20;
/// Latest parameters of an effect.
const PARAMETERS: i64 = 10_000;

/// Comparison of all bicycles.
#[derive(Serialize, ToSchema)]
pub struct Fleet {
    /// Scatter of stiffness and damping over the bikes.
    pub spread: Vec<FleetSpread>,
    /// Each bike's rides since its latest change, pooled, and its distance from the fleet's median.
    pub bikes: Vec<PooledBike>,
}

/// Every bicycle's pooled parameters, and which of them stand out.
#[utoipa::path(get, path = "/v1/fleet", operation_id = "get_fleet", tag = "fleet",
    responses((status = 200, description = "The fleet, by name, at most 1000 bikes", body = Fleet)))]
pub async fn fleet(State(server): App, caller: Caller) -> Result<Json<Fleet>, Problem> {
    Ok(Json(look(&server, &caller.group).await?))
}

/// The bicycles on which an effect was named, over the latest 10 000 of its parameters.
#[utoipa::path(get, path = "/v1/fleet/effects/{effect}", operation_id = "get_effect_across_fleet", tag = "fleet", params(("effect" = String, Path)),
    responses(
        (status = 200, description = "One entry per bicycle and axle, those with most rides first", body = Vec<EffectOnBike>),
        (status = 404, description = "No such effect", body = Problem, content_type = "application/problem+json")))]
pub async fn effect(
    State(server): App,
    caller: Caller,
    Path(effect): Path<String>,
) -> Result<Json<Vec<EffectOnBike>>, Problem> {
    Ok(Json(across(&server, &caller.group, &effect).await?))
}

/// The bicycles on which an effect was named; of a law of one's own too, once a result names it.
pub async fn across(
    server: &Server,
    group: &str,
    effect: &str,
) -> Result<Vec<EffectOnBike>, Problem> {
    let missing = || Problem::not_found("the effect");
    if effect.contains('\0') {
        return Err(missing());
    }
    let rows = parameter::of_effect(&server.db, group, effect, PARAMETERS).await?;
    match rows.is_empty() && !EFFECTS.contains(&effect) {
        true => Err(missing()),
        false => Ok(on_bikes(&rows)),
    }
}

/// The group's bicycles.
pub async fn look(server: &Server, group: &str) -> Result<Fleet, Problem> {
    let bikes = bike::page(&server.db, group, "", BIKES).await?;
    let names: Vec<String> = bikes.into_iter().map(|bike| bike.name).collect();
    let histories = histories(&server.db, group, &names, RIDES).await?;
    let (spread, bikes) = against_the_fleet(&histories);
    Ok(Fleet { spread, bikes })
}
