//! What rides say of one parameter, beside what is known of them.

use sqlx::types::Json;
use sqlx::{FromRow, QueryBuilder};
use uuid::Uuid;

use veloid_engine::report::Method;

use super::Db;
use super::parameter::{COURSE, RESULT};
use crate::facts::Facts;

/// What a ride says of a parameter, and what is known of it.
#[derive(Clone, Debug, FromRow)]
pub struct RideRow {
    pub job_id: Uuid,
    pub bike: String,
    pub value: f64,
    pub std_error: Option<f64>,
    pub unit: String,
    /// When it was ridden or, where that is not known, uploaded.
    pub dated_at: i64,
    pub facts: Option<Json<Facts>>,
    /// Masses on the axles, as the bike file of the ride has them (kg).
    pub front_kg: Option<f64>,
    pub rear_kg: Option<f64>,
}

impl RideRow {
    /// A number that is known of the ride besides its file.
    pub fn number(&self, name: &str) -> Option<f64> {
        let facts = &self.facts.as_ref()?.0;
        facts.value(name).or_else(|| facts.more.get(name).copied())
    }
}

/// Whose rides, and of which parameter.
pub struct DependenceQuery<'a> {
    pub group: &'a str,
    /// All bicycles of the group where it is absent.
    pub bike: Option<&'a str>,
    pub axle: &'a str,
    pub name: &'a str,
    pub from_ms: Option<i64>,
    pub to_ms: Option<i64>,
}

/// One row for each of the rides that were ridden last: the result of its latest job.
pub async fn rides(db: &Db, asked: &DependenceQuery<'_>, most: i64) -> sqlx::Result<Vec<RideRow>> {
    // CROSS JOIN keeps SQLite from walking all that was ever identified.
    const SQLITE: &str = "\
        SELECT parameter.job_id, latest.bike, value, std_error, unit, dated_at, facts, \
               request ->> '$.bike.mass_front_kg' AS front_kg, request ->> '$.bike.mass_rear_kg' AS rear_kg ";
    const POSTGRES: &str = "\
        SELECT parameter.job_id, latest.bike, value, std_error, unit, dated_at, facts, \
               (request #>> '{bike,mass_front_kg}')::float8 AS front_kg, \
               (request #>> '{bike,mass_rear_kg}')::float8 AS rear_kg ";
    const JOBS: &str = concat!(
        "FROM (SELECT id, ride_id, bike, dated_at, request FROM job \
               WHERE state = 'succeeded' AND deleted_at IS NULL AND ",
        newest_of_ride!(),
        " AND group_name = "
    );
    const PARAMETERS: &str = ") AS latest CROSS JOIN parameter JOIN ride ON ride.id = ride_id \
        WHERE job_id = latest.id AND method IN (";
    // Sizes of effects are beside stiffness and damping, not in the result.
    let methods: &[&str] = match asked.name.contains('.') {
        true => &[Method::Extended.name(), COURSE],
        false => &[RESULT],
    };
    let columns = db.spelt(SQLITE, POSTGRES);
    on!(read db, p => {
        let mut query = QueryBuilder::new(columns);
        query.push(JOBS).push_bind(asked.group);
        if let Some(bike) = asked.bike {
            query.push(" AND bike = ").push_bind(bike);
        }
        for (condition, time) in [(" AND dated_at >= ", asked.from_ms), (" AND dated_at < ", asked.to_ms)] {
            if let Some(time) = time {
                query.push(condition).push_bind(time);
            }
        }
        query.push(" ORDER BY dated_at DESC, id DESC LIMIT ").push_bind(most);
        let mut list = query.push(PARAMETERS).separated(", ");
        for method in methods {
            list.push_bind(*method);
        }
        query.push(") AND axle = ").push_bind(asked.axle);
        query.push(" AND parameter.name = ").push_bind(asked.name);
        query.push(" ORDER BY latest.bike, ride_id, job_id DESC");
        query.build_query_as().fetch_all(p).await
    })
}
