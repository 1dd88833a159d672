//! Rides that the reports of a bicycle's rides propose next, and whether such rides have settled what was open.

use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;

use crate::store::Db;
use crate::store::proposal::{self, ProposalRow, StudyRow};

/// Proposals and studies of a bicycle that are looked at, the latest.
const LATEST: i64 = 50;

/// A ride that a report proposes, because several sets of effects explain its ride equally.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct ProposedRide {
    /// The job whose report proposes it.
    pub job: Uuid,
    /// Name of that job's ride.
    pub ride: String,
    /// What is open.
    pub why: String,
    /// What to record.
    pub what: String,
    /// Duration of all planned rides together (s).
    pub duration_s: Option<f64>,
    /// Latest study of that ride together with others.
    pub study: Option<Uuid>,
    /// Rides of that study.
    pub rides: usize,
    /// Verdict of that study, once it has one.
    pub verdict: Option<String>,
    /// Whether the question is settled: the study's verdict is `named` or `nothing_missing`.
    pub settled: bool,
}

/// What the reports of a bicycle's rides propose, the latest ride's first.
pub async fn proposals(db: &Db, group: &str, bike: &str) -> sqlx::Result<Vec<ProposedRide>> {
    let rows = proposal::of_bike(db, group, bike, LATEST).await?;
    if rows.is_empty() {
        return Ok(Vec::new());
    }
    let studies = proposal::studies(db, group, bike, LATEST).await?;
    Ok(rows
        .into_iter()
        .map(|row| proposed(row, &studies))
        .collect())
}

fn proposed(row: ProposalRow, studies: &[StudyRow]) -> ProposedRide {
    let study = StudyRow::newest_with(studies, row.job_id);
    ProposedRide {
        job: row.job_id,
        ride: row.ride_name,
        duration_s: row.next_ride.plan.as_ref().map(|plan| plan.duration_s),
        why: row.next_ride.0.why,
        what: row.next_ride.0.what,
        study: study.map(|study| study.id),
        rides: study.map_or(0, |study| study.study.len()),
        verdict: study.and_then(|study| study.verdict.clone()),
        settled: study.is_some_and(StudyRow::is_settled),
    }
}

#[cfg(test)]
mod tests {
    use sqlx::types::Json;
    use veloid_engine::report::diagnosis::NextRide;

    use super::*;

    #[test]
    fn the_latest_study_with_the_ride_settles_it_or_not() {
        let [ride, other] = [1, 2].map(Uuid::from_u128);
        let row = || ProposalRow {
            job_id: ride,
            ride_name: "ride.csv".to_owned(),
            next_ride: Json(NextRide {
                why: "two sets".to_owned(),
                what: "ride twice as fast".to_owned(),
                predicted_separation: 20.0,
                plan: None,
            }),
        };
        let study = |id, verdict: Option<&str>, rides: &[Uuid]| StudyRow {
            id: Uuid::from_u128(id),
            state: "succeeded".to_owned(),
            verdict: verdict.map(str::to_owned),
            study: Json(rides.to_vec()),
        };
        let open = proposed(row(), &[study(9, Some("named"), &[other])]);
        assert_eq!((open.study, open.rides, open.settled), (None, 0, false));
        let failed = StudyRow {
            state: "failed".to_owned(),
            ..study(9, None, &[ride, other])
        };
        assert_eq!(proposed(row(), &[failed]).study, None);
        for (verdict, settled) in [
            (None, false),
            (Some("ambiguous"), false),
            (Some("named"), true),
            (Some("nothing_missing"), true),
        ] {
            let studies = [
                study(9, verdict, &[other, ride]),
                study(8, Some("named"), &[ride, other]),
            ];
            let found = proposed(row(), &studies);
            assert_eq!((found.study, found.rides), (Some(Uuid::from_u128(9)), 2));
            assert_eq!(found.settled, settled, "{verdict:?}");
        }
    }
}
