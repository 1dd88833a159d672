//! A bicycle's stiffness, damping and effects' sizes, ride by ride.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::io;

use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use super::beside;
use super::development::Development;
use super::event::{self, BikeEvent};
use super::pool::Pooled;
use crate::facts::Facts;
use crate::store::Db;
use crate::store::bike_event::{self, EventRow};
use crate::store::parameter::{self, COURSE, ResultRow};
use crate::time;

/// Rides of a bicycle that are followed, the latest, wherever its course is shown.
pub const RIDES: i64 = 200;

/// What is followed: axle and parameter.
pub const FOLLOWED: [(&str, &str); 4] = [
    ("front", "k_n_m"),
    ("front", "b_n_s_m"),
    ("rear", "k_n_m"),
    ("rear", "b_n_s_m"),
];

/// Stiffness, damping and the sizes of effects of one bicycle over its rides.
#[derive(Debug, Serialize, ToSchema)]
pub struct BikeHistory {
    pub bike: String,
    /// One per axle and parameter that was identified: `k_n_m`, `b_n_s_m`, and those of effects that two rides or more have a size of, as
    /// `coulomb_friction.friction`. Such an effect is fitted to the rides that do not name it too, and stiffness and damping are those
    /// beside it.
    pub courses: Vec<Course>,
    /// What was done to the bicycle, oldest first.
    pub events: Vec<BikeEvent>,
    /// Effects that its last rides name, where they were asked for.
    #[serde(skip)]
    pub effects: Vec<String>,
}

impl BikeHistory {
    /// When it was ridden last.
    pub fn last_ride_at(&self) -> Option<String> {
        let last = self
            .courses
            .iter()
            .filter_map(|course| course.points.last());
        let last = last.max_by_key(|point| point.epoch_ms);
        last.map(|point| point.dated_at.clone())
    }

    /// Its last rides, at most so many.
    fn last_jobs(&self, most: usize) -> Vec<Uuid> {
        let points = self.courses.iter().flat_map(|course| &course.points);
        let mut jobs: Vec<(i64, Uuid)> = points.map(|p| (p.epoch_ms, p.job)).collect();
        jobs.sort_unstable_by(|a, b| b.cmp(a));
        jobs.dedup();
        jobs.into_iter().take(most).map(|(_, job)| job).collect()
    }
}

/// One parameter's course.
#[derive(Debug, Serialize, ToSchema)]
pub struct Course {
    pub axle: String,
    pub name: String,
    pub unit: String,
    /// Oldest first; what each ride's newest job says.
    pub points: Vec<Point>,
    /// Rides since the latest step, or since a drift began or ended.
    pub pooled: Option<Pooled>,
    /// What became of it; null of fewer than two rides.
    pub development: Option<Development>,
}

/// What one ride says.
#[derive(Debug, Serialize, ToSchema)]
pub struct Point {
    #[serde(skip)]
    epoch_ms: i64,
    pub job: Uuid,
    /// When it was ridden or, where that is not known, uploaded.
    #[schema(format = DateTime)]
    pub dated_at: String,
    #[schema(format = DateTime)]
    pub identified_at: String,
    pub value: f64,
    pub std_error: f64,
    pub verdict: Option<String>,
}

/// The history of one bicycle of the group over its latest 200 rides.
pub async fn history(db: &Db, group: &str, bike: &str) -> sqlx::Result<BikeHistory> {
    let events = bike_event::of_bike(db, group, bike).await?;
    let events = events.into_iter().map(BikeEvent::from).collect();
    of_bike(db, group, bike, events).await
}

/// The histories of several, with the effects that their latest `rides` name.
pub async fn histories(
    db: &Db,
    group: &str,
    bikes: &[String],
    rides: usize,
) -> sqlx::Result<Vec<BikeHistory>> {
    let mut found = Vec::new();
    let mut events = of_bikes(bike_event::of_group(db, group).await?);
    for bike in bikes {
        let events = events.remove(bike).unwrap_or_default();
        found.push(of_bike(db, group, bike, events).await?);
    }
    name_effects(db, &mut found, rides).await?;
    Ok(found)
}

async fn of_bike(
    db: &Db,
    group: &str,
    bike: &str,
    events: Vec<BikeEvent>,
) -> sqlx::Result<BikeHistory> {
    let rows = parameter::results_of_bike(db, group, bike, RIDES).await?;
    let bike = bike.to_owned();
    // Courses of 200 rides take some ten milliseconds each.
    let found = tokio::task::spawn_blocking(move || {
        let course = |followed: (&str, &str)| Course::of(&rows, followed, &events);
        let sizes = sizes(&rows);
        let followed = FOLLOWED.into_iter().chain(sizes);
        BikeHistory {
            bike,
            courses: followed.filter_map(course).collect(),
            events,
            effects: Vec::new(),
        }
    });
    found.await.map_err(|error| io::Error::other(error).into())
}

/// Axle and name of the effects' numbers that several rides have.
fn sizes(rows: &[ResultRow]) -> BTreeSet<(&str, &str)> {
    let mut rides: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for row in rows.iter().filter(|row| row.name.contains('.')) {
        *rides.entry((&row.axle, &row.name)).or_default() += 1;
    }
    let several = rides.into_iter().filter(|(_, rides)| *rides > 1);
    several.map(|(name, _)| name).collect()
}

fn of_bikes(rows: Vec<EventRow>) -> HashMap<String, Vec<BikeEvent>> {
    let mut events: HashMap<String, Vec<BikeEvent>> = HashMap::new();
    for row in rows {
        let own = events.entry(row.bike.clone()).or_default();
        own.push(BikeEvent::from(row));
    }
    events
}

/// Jobs that are asked after at once.
const AT_ONCE: usize = 1000;

/// Adds the effects that each bicycle's last rides name.
async fn name_effects(db: &Db, found: &mut [BikeHistory], rides: usize) -> sqlx::Result<()> {
    let mut bikes = HashMap::new();
    for (bike, history) in found.iter().enumerate() {
        bikes.extend(history.last_jobs(rides).into_iter().map(|job| (job, bike)));
    }
    let jobs: Vec<Uuid> = bikes.keys().copied().collect();
    for jobs in jobs.chunks(AT_ONCE) {
        for (job, _, name) in parameter::effects(db, jobs).await? {
            let effect = name.split('.').next().unwrap_or_default();
            let history = bikes.get(&job).and_then(|bike| found.get_mut(*bike));
            if let Some(history) = history.filter(|h| h.effects.iter().all(|e| e != effect)) {
                history.effects.push(effect.to_owned());
            }
        }
    }
    for history in found {
        history.effects.sort_unstable();
    }
    Ok(())
}

impl Course {
    fn of(rows: &[ResultRow], (axle, name): (&str, &str), events: &[BikeEvent]) -> Option<Self> {
        let weighs = |row: &&ResultRow| row.std_error.is_some_and(|e| e.powi(-2).is_normal());
        let own = rows
            .iter()
            .filter(|row| row.axle == axle && row.name == name);
        let mut rows: Vec<&ResultRow> = own.filter(weighs).collect();
        // The ride fitted again comes before its result.
        rows.sort_by_key(|row| (row.dated_at, row.job_id, row.method != COURSE));
        rows.dedup_by_key(|row| row.job_id);
        let points: Vec<Point> = rows.iter().map(|row| Point::of(row)).collect();
        let facts: Vec<Option<&Facts>> = rows
            .iter()
            .map(|row| row.facts.as_ref().map(|facts| &facts.0))
            .collect();
        let rides: Vec<(i64, f64, f64)> = points
            .iter()
            .map(|p| (p.epoch_ms, p.value, p.std_error))
            .collect();
        let development = Development::of(&rides, &beside::facts(&facts));
        let settled = development.as_ref().map_or(rides.len(), |d| d.settled);
        let latest = rides[rides.len() - settled..].iter();
        let latest: Vec<(f64, f64)> = latest.map(|(_, value, error)| (*value, *error)).collect();
        Some(Self {
            axle: axle.to_owned(),
            name: name.to_owned(),
            unit: rows.first()?.unit.clone(),
            pooled: Some(Pooled::of(&latest)?),
            development: event::beside(development, events),
            points,
        })
    }
}

impl Point {
    fn of(row: &ResultRow) -> Self {
        Self {
            epoch_ms: row.dated_at,
            job: row.job_id,
            dated_at: time::text(row.dated_at),
            identified_at: time::text(row.identified_at),
            value: row.value,
            std_error: row.std_error.unwrap_or(0.0),
            verdict: row.verdict.clone(),
        }
    }
}
