//! A bicycle's stiffness and damping, ride by ride.

use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use super::change::Change;
use super::pool::Pooled;
use super::trend::Trend;
use crate::api::time;
use crate::store::Db;
use crate::store::parameter::{self, ParameterRow};

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
}

/// One parameter's course.
#[derive(Debug, Serialize, ToSchema)]
pub struct Course {
    pub axle: String,
    pub name: String,
    pub unit: String,
    /// Oldest first; by the extended model where the diagnosis found effects, else by output error.
    pub points: Vec<Point>,
    pub pooled: Option<Pooled>,
    pub trend: Option<Trend>,
    pub change: Option<Change>,
}

/// What one ride says.
#[derive(Debug, Serialize, ToSchema)]
pub struct Point {
    #[serde(skip)]
    epoch_ms: i64,
    pub job: Uuid,
    #[schema(format = DateTime)]
    pub identified_at: String,
    pub value: f64,
    pub std_error: f64,
    pub verdict: Option<String>,
}

/// The history of one bicycle of the group.
pub async fn history(db: &Db, group: &str, bike: &str, rides: i64) -> sqlx::Result<BikeHistory> {
    let rows = parameter::best_of_bike(db, group, bike, rides).await?;
    let mut history = of(bike, &rows);
    history.test();
    Ok(history)
}

/// The histories of several, over their latest `rides`, pooled but not tested for change.
pub async fn histories(
    db: &Db,
    group: &str,
    bikes: &[String],
    rides: i64,
) -> sqlx::Result<Vec<BikeHistory>> {
    let mut found = Vec::new();
    for bike in bikes {
        let rows = parameter::best_of_bike(db, group, bike, rides).await?;
        found.push(of(bike, &rows));
    }
    Ok(found)
}

impl BikeHistory {
    /// Looks for trends and steps.
    fn test(&mut self) {
        for course in &mut self.courses {
            let between = course
                .pooled
                .as_ref()
                .map_or(0.0, |pooled| pooled.between_rides);
            let points: Vec<_> = course
                .points
                .iter()
                .map(|p| (p.epoch_ms, p.value, p.std_error.hypot(between)))
                .collect();
            course.trend = Trend::of(&points);
            course.change = Change::of(&points);
        }
    }
}

fn of(bike: &str, rows: &[ParameterRow]) -> BikeHistory {
    let course = |(axle, name): (&str, &str)| {
        let mut rows: Vec<&ParameterRow> = rows
            .iter()
            .filter(|row| {
                let weighs = row.std_error.is_some_and(|e| e.powi(-2).is_normal());
                row.axle == axle && row.name == name && weighs
            })
            .collect();
        rows.sort_by_key(|row| (row.identified_at, row.job_id));
        let unit = rows.first()?.unit.clone();
        let values: Vec<(f64, f64)> = rows
            .iter()
            .map(|row| (row.value, row.std_error.unwrap_or(0.0)))
            .collect();
        let pooled = Pooled::of(&values)?;
        Some(Course {
            axle: axle.to_owned(),
            name: name.to_owned(),
            unit,
            pooled: Some(pooled),
            trend: None,
            change: None,
            points: rows
                .iter()
                .zip(&values)
                .map(|(row, (value, std_error))| Point {
                    epoch_ms: row.identified_at,
                    job: row.job_id,
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
    }
}
