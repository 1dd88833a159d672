//! Every identified parameter of every finished job: the fleet's memory.

use sqlx::types::Json;
use sqlx::{FromRow, QueryBuilder};
use uuid::Uuid;
use veloid_engine::report::Method;

use super::{Db, Tx, now_ms};
use crate::facts::Facts;

pub const AXLES: [&str; 3] = ["front", "rear", "both"];
/// Method of the rows that are a report's `result`.
pub const RESULT: &str = "result";
/// Method of the rows that come of fitting a ride again, with effects that other rides of its bicycle name.
pub const COURSE: &str = "course";
/// Method of the rows of several rides that were identified as one.
pub const STUDY: &str = "study";
/// The result, then every method, then the ride fitted again and several rides as one.
pub const METHODS: [&str; 9] = {
    let [a, b, c, d, e, f] = Method::NAMES;
    [RESULT, a, b, c, d, e, f, COURSE, STUDY]
};

#[derive(Clone, Debug, FromRow)]
pub struct ParameterRow {
    pub job_id: Uuid,
    pub method: String,
    pub axle: String,
    pub name: String,
    pub bike: String,
    pub value: f64,
    pub std_error: Option<f64>,
    pub unit: String,
    pub verdict: Option<String>,
    pub version: String,
    pub identified_at: i64,
    pub ride_id: Uuid,
    /// Name of the ride's file.
    pub file: String,
    /// What is known of the ride.
    pub facts: Option<Json<Facts>>,
}

/// A parameter before it is stored.
#[derive(Debug, PartialEq)]
pub struct Parameter {
    pub method: &'static str,
    pub axle: &'static str,
    pub name: String,
    pub value: f64,
    pub std_error: Option<f64>,
    pub unit: String,
}

/// Which parameters of a group a list holds; absent means any.
#[derive(Default)]
pub struct Filter<'a> {
    pub group: &'a str,
    pub bike: Option<&'a str>,
    pub method: Option<&'a str>,
    pub axle: Option<&'a str>,
    pub name: Option<&'a str>,
    /// Any parameter of this effect.
    pub effect: Option<&'a str>,
    pub verdict: Option<&'a str>,
    pub job: Option<Uuid>,
    /// Only of the newest job of each ride and bicycle.
    pub newest: bool,
    pub from_ms: Option<i64>,
    pub to_ms: Option<i64>,
    /// The key of the last row of the page before.
    pub after: Option<Key>,
    /// The key of the last row that may be in it.
    pub through: Option<Key>,
}

/// Primary key of a row.
#[derive(Clone, Debug, PartialEq, FromRow)]
pub struct Key {
    pub job_id: Uuid,
    pub method: String,
    pub axle: String,
    pub name: String,
}

impl ParameterRow {
    pub fn key(&self) -> Key {
        Key {
            job_id: self.job_id,
            method: self.method.clone(),
            axle: self.axle.clone(),
            name: self.name.clone(),
        }
    }
}

/// Drops what was identified by a job.
pub async fn delete(tx: &mut Tx, job: Uuid) -> sqlx::Result<()> {
    const SQL: &str = "DELETE FROM parameter WHERE job_id = $1";
    on!(tx, t => sqlx::query(SQL).bind(job).execute(&mut **t).await.map(drop))
}

pub async fn insert(
    tx: &mut Tx,
    job: Uuid,
    group: &str,
    bike: &str,
    verdict: Option<&str>,
    parameters: &[Parameter],
) -> sqlx::Result<()> {
    const SQL: &str = "\
        INSERT INTO parameter (job_id, method, axle, name, bike, value, std_error, unit, verdict, \
                               version, identified_at, group_name) ";
    if parameters.is_empty() {
        return Ok(());
    }
    let now = now_ms();
    on!(tx, t => QueryBuilder::new(SQL)
        .push_values(parameters, |mut row, parameter| {
            row.push_bind(job)
                .push_bind(parameter.method)
                .push_bind(parameter.axle)
                .push_bind(&parameter.name)
                .push_bind(bike)
                .push_bind(parameter.value)
                .push_bind(parameter.std_error)
                .push_bind(&parameter.unit)
                .push_bind(verdict)
                .push_bind(env!("CARGO_PKG_VERSION"))
                .push_bind(now)
                .push_bind(group);
        })
        .build()
        .execute(&mut **t)
        .await
        .map(drop))
}

/// Parameters of jobs that are not deleted; `job_deleted` is an index of few.
macro_rules! of_group {
    () => {
        "WHERE NOT EXISTS (SELECT 1 FROM job WHERE job.id = job_id AND job.deleted_at IS NOT NULL) \
           AND group_name = "
    };
}

/// Adds the conditions that are asked for, and only those, so that the database can choose an index.
macro_rules! conditions {
    ($query:ident, $filter:ident) => {
        for (column, value) in [
            (" AND bike = ", $filter.bike),
            (" AND name = ", $filter.name),
            (" AND verdict = ", $filter.verdict),
        ] {
            if let Some(value) = value {
                $query.push(column).push_bind(value);
            }
        }
        if let Some(method) = $filter.method {
            $query.push(" AND method = ").push_bind(method);
        }
        // As a literal it lets the index of the rare ones serve.
        match $filter.axle {
            Some("both") => $query.push(" AND axle = 'both'"),
            Some(axle) => $query.push(" AND axle = ").push_bind(axle),
            None => &mut $query,
        };
        if let Some(effect) = $filter.effect {
            // `/` follows `.`, so this is every name that begins with the effect's.
            $query.push(" AND name >= ").push_bind(format!("{effect}."));
            $query.push(" AND name < ").push_bind(format!("{effect}/"));
        }
        if let Some(job) = $filter.job {
            $query.push(" AND job_id = ").push_bind(job);
        }
        if $filter.newest {
            $query.push(concat!(
                " AND EXISTS (SELECT 1 FROM job WHERE job.id = job_id AND ",
                newest_of_ride!(),
                ")"
            ));
        }
        if let Some(from) = $filter.from_ms {
            $query.push(" AND identified_at >= ").push_bind(from);
        }
        if let Some(to) = $filter.to_ms {
            $query.push(" AND identified_at < ").push_bind(to);
            // What was identified before was queued before, and ids begin with that time.
            $query.push(" AND job_id < ").push_bind(first_id_at(to));
        }
        for (bound, key) in [(" < (", &$filter.after), (" >= (", &$filter.through)] {
            let Some(key) = key else { continue };
            $query.push(" AND (job_id, method, axle, name)").push(bound);
            let mut values = $query.separated(", ");
            values.push_bind(key.job_id).push_bind(&key.method);
            values.push_bind(&key.axle).push_bind(&key.name);
            $query.push(")");
        }
    };
}

/// Newest job first, then by method, axle and name backwards.
pub async fn page(db: &Db, filter: &Filter<'_>, limit: i64) -> sqlx::Result<Vec<ParameterRow>> {
    // The rides of the page alone are looked up.
    const PAGE: &str = concat!(
        "SELECT page.*, ride.id AS ride_id, ride.name AS file, ride.facts FROM ( \
            SELECT job_id, method, axle, name, bike, value, std_error, unit, verdict, version, identified_at \
            FROM parameter ",
        of_group!()
    );
    const RIDES: &str = ") AS page \
        JOIN job ON job.id = page.job_id JOIN ride ON ride.id = job.ride_id \
        ORDER BY page.job_id DESC, method DESC, axle DESC, page.name DESC";
    on!(read db, p => {
        let mut query = QueryBuilder::new(PAGE);
        query.push_bind(filter.group);
        conditions!(query, filter);
        query.push(" ORDER BY job_id DESC, method DESC, axle DESC, name DESC LIMIT ");
        query.push_bind(limit).push(RIDES);
        query.build_query_as().fetch_all(p).await
    })
}

/// The row with which a list of so many ends, if it holds more; what it is filtered by decides how long that takes.
pub async fn last_of(db: &Db, filter: &Filter<'_>, rows: i64) -> sqlx::Result<Option<Key>> {
    macro_rules! query {
        ($pool:expr) => {{
            let mut query = QueryBuilder::new(concat!(
                "SELECT job_id, method, axle, name FROM parameter ",
                of_group!()
            ));
            query.push_bind(filter.group);
            conditions!(query, filter);
            query.push(" ORDER BY job_id DESC, method DESC, axle DESC, name DESC LIMIT 2 OFFSET ");
            let query = query.push_bind(rows - 1).build_query_as();
            let mut found: Vec<Key> = query.fetch_all($pool).await?;
            // The second one is of the next page.
            Ok(found.pop().and_then(|_| found.pop()))
        }};
    }
    on!(read db, p => query!(p))
}

/// The smallest UUIDv7 of a time.
fn first_id_at(epoch_ms: i64) -> Uuid {
    let ms = epoch_ms.clamp(0, (1 << 48) - 1).cast_unsigned();
    Uuid::from_u128(u128::from(ms) << 80)
}

/// Job, axle and name of every effect's parameter that was identified by these jobs.
pub async fn effects(db: &Db, jobs: &[Uuid]) -> sqlx::Result<Vec<(Uuid, String, String)>> {
    if jobs.is_empty() {
        return Ok(Vec::new());
    }
    on!(read db, p => {
        let mut query = QueryBuilder::new(
            "SELECT job_id, axle, name FROM parameter WHERE method IN ('extended', 'study') AND name LIKE '%.%' AND job_id IN (",
        );
        let mut list = query.separated(", ");
        for job in jobs {
            list.push_bind(*job);
        }
        query.push(")").build_query_as().fetch_all(p).await
    })
}

/// Stiffness and damping of these jobs.
pub async fn results(db: &Db, jobs: &[Uuid]) -> sqlx::Result<Vec<JobResult>> {
    if jobs.is_empty() {
        return Ok(Vec::new());
    }
    on!(read db, p => {
        let mut query = QueryBuilder::new(
            "SELECT job_id, axle, name, value, std_error, unit FROM parameter \
             WHERE method IN ('result', 'study') AND name IN ('k_n_m', 'b_n_s_m') AND job_id IN (",
        );
        let mut list = query.separated(", ");
        for job in jobs {
            list.push_bind(*job);
        }
        query.push(")").build_query_as().fetch_all(p).await
    })
}

/// Stiffness or damping that a job found.
#[derive(Clone, Debug, FromRow)]
pub struct JobResult {
    pub job_id: Uuid,
    pub axle: String,
    pub name: String,
    pub value: f64,
    pub std_error: Option<f64>,
    pub unit: String,
}

/// An effect's parameter that a job named, and with which effects the ride was fitted again; of a job that names nothing, axle and name
/// are null.
#[derive(Clone, Debug, FromRow)]
pub struct NamedRow {
    pub job_id: Uuid,
    pub refitted: Option<String>,
    pub axle: Option<String>,
    pub name: Option<String>,
}

/// What was named on the rides of a bike that were ridden last, newest first, each ride's by its newest job, but for those without a
/// result.
pub async fn named_on_bike(
    db: &Db,
    group: &str,
    bike: &str,
    rides: i64,
) -> sqlx::Result<Vec<NamedRow>> {
    const SQL: &str = concat!(
        "SELECT latest.id AS job_id, refitted, axle, parameter.name \
         FROM (SELECT id, dated_at, refitted FROM job \
               WHERE group_name = $3 AND bike = $1 AND state = 'succeeded' AND deleted_at IS NULL AND no_result IS NULL AND ",
        newest_of_ride!(),
        " ORDER BY dated_at DESC, id DESC LIMIT $2) AS latest \
         LEFT JOIN parameter ON job_id = latest.id AND method = 'extended' AND parameter.name LIKE '%.%' \
         ORDER BY dated_at DESC, latest.id DESC, axle, parameter.name"
    );
    on!(read db, p => sqlx::query_as(SQL).bind(bike).bind(rides).bind(group).fetch_all(p).await)
}

/// Stores what came of fitting a job's ride again with these effects; none where it is fitted so no longer.
pub async fn put_refitted(
    tx: &mut Tx,
    (job, group, bike): (Uuid, &str, &str),
    verdict: Option<&str>,
    effects: Option<&str>,
    parameters: &[Parameter],
) -> sqlx::Result<()> {
    const DROP: &str = "DELETE FROM parameter WHERE job_id = $1 AND method = 'course'";
    const NOTE: &str = "UPDATE job SET refitted = $2 WHERE id = $1";
    on!(tx, t => sqlx::query(DROP).bind(job).execute(&mut **t).await.map(drop))?;
    on!(tx, t => sqlx::query(NOTE).bind(job).bind(effects).execute(&mut **t).await.map(drop))?;
    insert(tx, job, group, bike, verdict, parameters).await
}

/// What rides that were ridden last say of an effect.
pub async fn of_effect(
    db: &Db,
    group: &str,
    effect: &str,
    most: i64,
) -> sqlx::Result<Vec<EffectRow>> {
    const SQL: &str = concat!(
        "SELECT parameter.job_id, method, parameter.bike, axle, parameter.name, value, std_error, unit, dated_at \
         FROM parameter JOIN job ON job.id = parameter.job_id \
         WHERE parameter.group_name = $1 AND method IN ('extended', 'course') AND parameter.name >= $2 AND parameter.name < $3 \
           AND job.deleted_at IS NULL AND ",
        newest_of_ride!(),
        " ORDER BY parameter.job_id DESC LIMIT $4"
    );
    let (from, to) = (format!("{effect}."), format!("{effect}/"));
    on!(read db, p => sqlx::query_as(SQL).bind(group).bind(from).bind(to).bind(most).fetch_all(p).await)
}

/// What a ride says of an effect's parameter.
#[derive(Clone, Debug, FromRow)]
pub struct EffectRow {
    pub job_id: Uuid,
    /// [`COURSE`] where another ride names it.
    pub method: String,
    pub bike: String,
    pub axle: String,
    pub name: String,
    pub value: f64,
    pub std_error: Option<f64>,
    pub unit: String,
    pub dated_at: i64,
}

/// What a ride says of a parameter that is followed.
#[derive(Clone, Debug, FromRow)]
pub struct ResultRow {
    pub job_id: Uuid,
    /// [`RESULT`], `extended` (an effect's size) or [`COURSE`].
    pub method: String,
    pub axle: String,
    pub name: String,
    pub value: f64,
    pub std_error: Option<f64>,
    pub unit: String,
    pub verdict: Option<String>,
    pub identified_at: i64,
    /// When it was ridden or, where that is not known, uploaded.
    pub dated_at: i64,
    /// What is known of the ride.
    pub facts: Option<Json<Facts>>,
}

/// Stiffness, damping and effects' sizes of the rides of a bike that were ridden last, each ride's by its newest job.
pub async fn results_of_bike(
    db: &Db,
    group: &str,
    bike: &str,
    rides: i64,
) -> sqlx::Result<Vec<ResultRow>> {
    // CROSS JOIN keeps SQLite from walking all that was ever identified of the bike.
    const SQL: &str = concat!(
        "SELECT job_id, method, axle, parameter.name, value, std_error, unit, verdict, identified_at, dated_at, facts \
         FROM (SELECT id, ride_id, dated_at FROM job \
               WHERE group_name = $3 AND bike = $1 AND state = 'succeeded' AND deleted_at IS NULL AND ",
        newest_of_ride!(),
        " ORDER BY dated_at DESC, id DESC LIMIT $2) AS latest \
         CROSS JOIN parameter JOIN ride ON ride.id = latest.ride_id \
         WHERE job_id = latest.id AND ((method = 'result' AND parameter.name IN ('k_n_m', 'b_n_s_m')) \
            OR method = 'course' OR (method = 'extended' AND parameter.name LIKE '%.%')) \
         ORDER BY job_id, axle, parameter.name"
    );
    on!(read db, p => sqlx::query_as(SQL).bind(bike).bind(rides).bind(group).fetch_all(p).await)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_of_earlier_times_are_smaller() {
        let now = Uuid::now_v7();
        assert!(first_id_at(now_ms() - 60_000) < now && now < first_id_at(now_ms() + 60_000));
        assert_eq!(first_id_at(-1), Uuid::nil());
    }
}
