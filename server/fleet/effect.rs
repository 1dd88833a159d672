//! One effect across the fleet.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use super::development::Development;
use super::pool::Pooled;
use crate::store::parameter::{COURSE, EffectRow};
use crate::time;

/// A bicycle on which an effect was named.
#[derive(Debug, Serialize, ToSchema)]
pub struct EffectOnBike {
    pub bike: String,
    pub axle: String,
    /// Rides on which it was named.
    pub rides: usize,
    /// The job of the one that was ridden last, and when that was.
    pub last_job: Uuid,
    #[schema(format = DateTime)]
    pub last_at: String,
    pub parameters: Vec<EffectSize>,
}

/// A parameter of an effect, pooled over the bicycle's rides since the latest step, or since a drift began or ended, that determine it with
/// a standard error, whether they name the effect or were fitted with it since others do.
#[derive(Debug, Serialize, ToSchema)]
pub struct EffectSize {
    pub name: String,
    pub unit: String,
    pub pooled: Option<Pooled>,
}

/// The bicycles of these rows, those with most rides first.
pub fn on_bikes(rows: &[EffectRow]) -> Vec<EffectOnBike> {
    let mut bikes: BTreeMap<(&str, &str), Vec<&EffectRow>> = BTreeMap::new();
    for row in rows {
        bikes.entry((&row.bike, &row.axle)).or_default().push(row);
    }
    let mut found: Vec<EffectOnBike> = bikes
        .into_iter()
        .filter_map(|((bike, axle), rows)| {
            let named = || rows.iter().filter(|row| row.method != COURSE);
            let last = named().max_by_key(|row| (row.dated_at, row.job_id))?;
            let rides: BTreeSet<Uuid> = named().map(|row| row.job_id).collect();
            Some(EffectOnBike {
                bike: bike.to_owned(),
                axle: axle.to_owned(),
                rides: rides.len(),
                last_job: last.job_id,
                last_at: time::text(last.dated_at),
                parameters: sizes(&rows),
            })
        })
        .collect();
    found.sort_by_key(|bike| std::cmp::Reverse(bike.rides));
    found
}

fn sizes(rows: &[&EffectRow]) -> Vec<EffectSize> {
    let mut by_name: BTreeMap<&str, Vec<&EffectRow>> = BTreeMap::new();
    for row in rows {
        by_name.entry(&row.name).or_default().push(row);
    }
    let size = |(name, rows): (&str, Vec<&EffectRow>)| {
        let known = rows.iter().filter_map(|row| {
            let error = row.std_error.filter(|error| error.powi(-2).is_normal())?;
            Some((row.dated_at, row.value, error))
        });
        let mut known: Vec<(i64, f64, f64)> = known.collect();
        known.sort_by_key(|(at, ..)| *at);
        let settled = Development::of(&known, &[]).map_or(known.len(), |d| d.settled);
        let latest = known[known.len() - settled..].iter();
        let latest: Vec<(f64, f64)> = latest.map(|(_, value, error)| (*value, *error)).collect();
        EffectSize {
            name: name
                .split_once('.')
                .map_or(name, |(_, parameter)| parameter)
                .to_owned(),
            unit: rows
                .first()
                .map_or_else(String::new, |row| row.unit.clone()),
            pooled: Pooled::of(&latest),
        }
    };
    by_name.into_iter().map(size).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bicycles_with_most_rides_come_first_and_values_without_errors_are_not_pooled() {
        let row = |job: u128, bike: &str, std_error| EffectRow {
            job_id: Uuid::from_u128(job),
            method: if job == 4 { COURSE } else { "extended" }.to_owned(),
            bike: bike.to_owned(),
            axle: "front".to_owned(),
            name: "coulomb_friction.friction".to_owned(),
            value: 20.0,
            std_error,
            unit: "N".to_owned(),
            dated_at: job as i64,
        };
        let found = on_bikes(&[
            row(1, "a", None),
            row(2, "b", Some(1.0)),
            row(3, "b", Some(1.0)),
            row(4, "b", Some(1.0)),
        ]);
        let reported: Vec<_> = found
            .iter()
            .map(|bike| (bike.bike.as_str(), bike.rides))
            .collect();
        assert_eq!(reported, [("b", 2), ("a", 1)]);
        assert_eq!(found[0].last_job, Uuid::from_u128(3));
        let size = &found[0].parameters[0];
        assert_eq!(
            (size.name.as_str(), size.pooled.as_ref().map(|p| p.rides)),
            ("friction", Some(3))
        );
        assert_eq!(found[1].parameters[0].pooled, None);
    }
}
