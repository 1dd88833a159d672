//! A bicycle's stiffness and damping, ride by ride.

use std::collections::HashMap;

use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use super::change::Change;
use super::development::Development;
use super::event::{self, BikeEvent};
use super::pool::Pooled;
use super::trend::Trend;
use crate::store::Db;
use crate::store::bike_event::{self, EventRow};
use crate::store::parameter::{self, ResultRow};
use crate::time;

/// What is followed: axle and parameter.
pub const FOLLOWED: [(&str, &str); 4] = [
    ("front", "k_n_m"),
    ("front", "b_n_s_m"),
    ("rear", "k_n_m"),
    ("rear", "b_n_s_m"),
];

/// Stiffness and damping of one bicycle over its rides.
#[derive(Debug, Serialize, ToSchema)]
pub struct BikeHistory {
    pub bike: String,
    /// One per axle and parameter that was identified.
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
    /// Oldest first; each ride's result.
    pub points: Vec<Point>,
    pub pooled: Option<Pooled>,
    pub trend: Option<Trend>,
    pub change: Option<Change>,
    /// Nothing, a drift, a step or both, as one choice; null of fewer than eight rides.
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

/// The history of one bicycle of the group.
pub async fn history(db: &Db, group: &str, bike: &str, rides: i64) -> sqlx::Result<BikeHistory> {
    let rows = parameter::results_of_bike(db, group, bike, rides).await?;
    let mut history = of(bike, &rows, usize::MAX);
    let events = bike_event::of_bike(db, group, bike).await?;
    history.events = events.into_iter().map(BikeEvent::from).collect();
    for course in &mut history.courses {
        let points = course.weighed();
        course.trend = Trend::of(&points);
        course.change = Change::of(&points);
        course.development = event::beside(Development::of(&points), &history.events);
    }
    Ok(history)
}

/// The histories of several: what became of them over their latest `rides`, and the last `pooled` of these joined.
pub async fn histories(
    db: &Db,
    group: &str,
    bikes: &[String],
    rides: i64,
    pooled: usize,
) -> sqlx::Result<Vec<BikeHistory>> {
    let mut found = Vec::new();
    let mut events = of_bikes(bike_event::of_group(db, group).await?);
    for bike in bikes {
        let rows = parameter::results_of_bike(db, group, bike, rides).await?;
        let mut history = of(bike, &rows, pooled);
        history.events = events.remove(bike).unwrap_or_default();
        for course in &mut history.courses {
            let development = Development::of(&course.weighed());
            course.development = event::beside(development, &history.events);
        }
        found.push(history);
    }
    name_effects(db, &mut found, pooled).await?;
    Ok(found)
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
    /// Time, value and standard deviation of each ride, that between rides included.
    fn weighed(&self) -> Vec<(i64, f64, f64)> {
        let pooled = self.pooled.as_ref();
        let between = pooled.map_or(0.0, |pooled| pooled.between_rides);
        let points = self.points.iter();
        points
            .map(|p| (p.epoch_ms, p.value, p.std_error.hypot(between)))
            .collect()
    }
}

/// The last `pooled` rides are joined.
fn of(bike: &str, rows: &[ResultRow], pooled: usize) -> BikeHistory {
    let course = |(axle, name): (&str, &str)| {
        let mut rows: Vec<&ResultRow> = rows
            .iter()
            .filter(|row| {
                let weighs = row.std_error.is_some_and(|e| e.powi(-2).is_normal());
                row.axle == axle && row.name == name && weighs
            })
            .collect();
        rows.sort_by_key(|row| (row.dated_at, row.job_id));
        let unit = rows.first()?.unit.clone();
        let values: Vec<(f64, f64)> = rows
            .iter()
            .map(|row| (row.value, row.std_error.unwrap_or(0.0)))
            .collect();
        let last = values.len().saturating_sub(pooled);
        let pooled = Pooled::of(&values[last..])?;
        Some(Course {
            axle: axle.to_owned(),
            name: name.to_owned(),
            unit,
            pooled: Some(pooled),
            trend: None,
            change: None,
            development: None,
            points: rows
                .iter()
                .zip(&values)
                .map(|(row, (value, std_error))| Point {
                    epoch_ms: row.dated_at,
                    job: row.job_id,
                    dated_at: time::text(row.dated_at),
                    identified_at: time::text(row.identified_at),
                    value: *value,
                    std_error: *std_error,
                    verdict: row.verdict.clone(),
                })
                .collect(),
        })
    };
    BikeHistory {
        bike: bike.to_owned(),
        courses: FOLLOWED.into_iter().filter_map(course).collect(),
        events: Vec::new(),
        effects: Vec::new(),
    }
}
