//! The fleet as a whole.

use axum::Json;
use axum::extract::State;
use serde::Serialize;
use utoipa::ToSchema;

use super::access::Caller;
use super::problem::Problem;
use super::{App, Server};
use crate::fleet::{FleetSpread, PooledBike, against_the_fleet, histories};
use crate::store::bike;

/// Most bikes.
const BIKES: i64 = 1000;
/// Rides of each that are looked through for a drift or a step, and the last of them, which are pooled.
const RIDES: i64 = 100;
const POOLED: usize = 20;

/// Every bicycle beside every other.
#[derive(Serialize, ToSchema)]
pub struct Fleet {
    /// How stiffness and damping scatter over the bikes.
    pub spread: Vec<FleetSpread>,
    /// Each bike's latest 20 rides, pooled, and its distance from the fleet's median.
    pub bikes: Vec<PooledBike>,
}

/// Every bicycle's pooled parameters, and which of them stand out.
#[utoipa::path(get, path = "/v1/fleet", operation_id = "get_fleet", tag = "fleet",
    responses((status = 200, description = "The fleet, by name, at most 1000 bikes", body = Fleet)))]
pub async fn fleet(State(server): App, caller: Caller) -> Result<Json<Fleet>, Problem> {
    Ok(Json(look(&server, &caller.group).await?))
}

/// The group's bicycles.
pub async fn look(server: &Server, group: &str) -> Result<Fleet, Problem> {
    let bikes = bike::page(&server.db, group, "", BIKES).await?;
    let names: Vec<String> = bikes.into_iter().map(|bike| bike.name).collect();
    let histories = histories(&server.db, group, &names, RIDES, POOLED).await?;
    let (spread, bikes) = against_the_fleet(&histories);
    Ok(Fleet { spread, bikes })
}
