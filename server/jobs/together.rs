//! Studies that the server queues by itself: of a ride and those that its report proposed, and of a bicycle's latest rides.

use tracing::warn;
use uuid::Uuid;
use veloid_engine::report::diagnosis::RidePlan;
use veloid_engine::ride::{AxleRecord, Ride};

use super::fault::Fault;
use super::work::Work;
use crate::store::job::{self, JobRow};
use crate::store::parameter;
use crate::store::proposal::{self, StudyRow};

/// Latest rides of a bicycle that a study has where no number is given.
pub const USUAL: usize = 12;
/// Proposals of a bicycle that a ride is compared with: each reads a file.
const PROPOSALS: i64 = 3;
/// Studies that are looked through for one with the ride that proposes.
const STUDIES: i64 = 50;
/// Logarithms of the ratios of speeds and of roughnesses up to which two rides are alike: half the steps between the rides that
/// reports propose, a quarter faster and twice as rough (`engine/diagnosis/explain/next_ride.rs`).
const PACE: f64 = 0.112;
const ROUGH: f64 = 0.347;

impl Work {
    /// The jobs whose rides are to be identified as one, now that this one has ended, if any are.
    pub(super) async fn due_study(&self, job: &JobRow) -> Result<Option<Vec<Uuid>>, Fault> {
        let wanted = self.study_after > 0 && job.request.options.settings.diagnosis;
        if !wanted || job.study.is_some() {
            return Ok(None);
        }
        let (db, group, bike) = (&self.db, job.group_name.as_str(), job.bike.as_str());
        let studies = proposal::studies(db, group, bike, STUDIES).await?;
        if let Some(rides) = self.answered(job, &studies).await? {
            return Ok(Some(rides));
        }
        // The last of many uploads queues one study of all.
        if proposal::unfinished(db, group, bike).await? > 0 {
            return Ok(None);
        }
        let rows = parameter::named_on_bike(db, group, bike, USUAL as i64).await?;
        let mut latest: Vec<Uuid> = rows.into_iter().map(|row| row.job_id).collect();
        latest.dedup();
        let before = studies.iter().flat_map(|study| &study.study.0);
        let before: Vec<&Uuid> = before.collect();
        let new = latest.iter().filter(|id| !before.contains(id)).count();
        Ok((new >= self.study_after && latest.len() > 1).then_some(latest))
    }

    /// A ride whose report proposed one like this job's, those that were judged with it before, and this one.
    async fn answered(
        &self,
        job: &JobRow,
        studies: &[StudyRow],
    ) -> Result<Option<Vec<Uuid>>, Fault> {
        let (group, bike) = (job.group_name.as_str(), job.bike.as_str());
        let asked = proposal::of_bike(&self.db, group, bike, PROPOSALS).await?;
        for row in asked {
            let Some(plan) = row.next_ride.0.plan.filter(|_| row.job_id != job.id) else {
                continue;
            };
            let Some(asking) = job::load(&self.db, row.job_id).await? else {
                continue;
            };
            let Some(rides) = judged_with(&plan, [asking.id, job.id], studies) else {
                continue;
            };
            match self.is_planned(&plan, &asking, job).await {
                Ok(true) => return Ok(Some(rides)),
                Ok(false) => {}
                Err(fault) if fault.is_outage() => return Err(fault),
                Err(fault) => {
                    warn!(job = %job.id, %fault, "a ride is not compared with a proposed one");
                }
            }
        }
        Ok(None)
    }

    async fn is_planned(
        &self,
        plan: &RidePlan,
        asking: &JobRow,
        job: &JobRow,
    ) -> Result<bool, Fault> {
        let before = self.rides.get(asking).await?;
        let ride = self.rides.get(job).await?;
        Ok(is_planned(plan, &before, &ride))
    }
}

/// The rides that are judged as one when another one is as planned: the one that asked, those judged with it before, and this one. None
/// where the question is settled, or not settled by twice as many rides as were planned.
fn judged_with(
    plan: &RidePlan,
    [asking, job]: [Uuid; 2],
    studies: &[StudyRow],
) -> Option<Vec<Uuid>> {
    let study = StudyRow::newest_with(studies, asking);
    if study.is_some_and(StudyRow::is_settled) {
        return None;
    }
    let mut rides = study.map_or_else(|| vec![asking], |study| study.study.0.clone());
    if !rides.contains(&job) {
        rides.push(job);
    }
    (rides.len() <= 1 + 2 * plan.times as usize).then_some(rides)
}

/// Whether a ride is as planned, relative to the one before. A channel that one of them lacks decides only what cannot be without it.
fn is_planned(plan: &RidePlan, before: &Ride, ride: &Ride) -> bool {
    let pace = match (mean_of(&before.speed), mean_of(&ride.speed)) {
        (Some(a), Some(b)) if a > 0.0 && b > 0.0 => Some((b / a).ln()),
        _ => None,
    };
    let paced = pace.map_or(plan.faster == 1.0, |pace| {
        (pace - plan.faster.ln()).abs() < PACE
    });
    let rough = roughness(before, ride, pace.unwrap_or_default());
    let rough = rough.is_some_and(|rough| (rough - plan.rougher.ln()).abs() < ROUGH);
    let swings = plan.swing == 0.0 || swing(&ride.speed) > 0.5 * plan.swing;
    let coasts = !plan.coasting
        || match (mean_of(&before.cadence), mean_of(&ride.cadence)) {
            (Some(a), Some(b)) => b < 0.5 * a,
            _ => false,
        };
    paced && rough && swings && coasts
}

fn mean_of(channel: &Option<Vec<f64>>) -> Option<f64> {
    let values = channel.as_ref().filter(|values| !values.is_empty())?;
    Some(mean(values))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Standard deviation.
fn deviation(values: &[f64]) -> f64 {
    let mean = mean(values);
    let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    (squares / values.len() as f64).sqrt()
}

/// Amplitude of a sinusoidal speed with this scatter, as a share of its mean.
fn swing(speed: &Option<Vec<f64>>) -> f64 {
    let swing = |v: &Vec<f64>| 2f64.sqrt() * deviation(v) / mean(v);
    speed.as_ref().filter(|v| !v.is_empty()).map_or(0.0, swing)
}

/// Logarithm of the ratio of what drives the axles: the road's slope, the force, or the deflection that an axle is released from.
fn roughness(before: &Ride, ride: &Ride, pace: f64) -> Option<f64> {
    let ratios = before.axles.iter().filter_map(|(axle, a)| {
        let b = ride.axles.get(axle)?;
        let ratio = match (a.has_road() && b.has_road(), a.is_pushed() && b.is_pushed()) {
            (true, _) => (rate(&b.road, ride.step_s) / rate(&a.road, before.step_s)).ln() - pace,
            (_, true) => (deviation(b.force.as_ref()?) / deviation(a.force.as_ref()?)).ln(),
            _ => (span(b) / span(a)).ln(),
        };
        ratio.is_finite().then_some(ratio)
    });
    let ratios: Vec<f64> = ratios.collect();
    (!ratios.is_empty()).then(|| ratios.iter().sum::<f64>() / ratios.len() as f64)
}

/// RMS of how fast a channel changes (1/s).
fn rate(values: &[f64], step_s: f64) -> f64 {
    let square: f64 = values.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum();
    (square / values.len() as f64).sqrt() / step_s
}

fn span(record: &AxleRecord) -> f64 {
    let z = record.displacement.iter();
    let [low, high] = z.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| {
        [low.min(*z), high.max(*z)]
    });
    high - low
}

#[cfg(test)]
mod tests {
    use sqlx::types::Json;
    use veloid_engine::simulate::simulated_ride::SimulatedRide;

    use super::*;

    const AGAIN: RidePlan = RidePlan {
        times: 1,
        duration_s: 20.0,
        rougher: 1.0,
        faster: 1.0,
        swing: 0.0,
        coasting: false,
    };

    fn ride(seed: u64, faster: f64, rougher: f64) -> Ride {
        let base = SimulatedRide::default();
        let mut ride = SimulatedRide {
            duration_s: 20.0,
            seed,
            speed_m_s: faster * base.speed_m_s,
            ..base
        }
        .ride();
        for axle in [&mut ride.axles.front, &mut ride.axles.rear] {
            let road = axle.iter_mut().flat_map(|record| &mut record.road);
            road.for_each(|u| *u *= rougher);
        }
        ride
    }

    #[test]
    fn rides_fit_the_plan_that_they_are_nearest_to() {
        let before = ride(1, 1.0, 1.0);
        let plans = [
            (1.0, 1.0),
            (0.75, 1.0),
            (1.25, 1.0),
            (1.5, 1.0),
            (1.0, 0.5),
            (1.0, 2.0),
        ];
        for (i, (faster, rougher)) in plans.into_iter().enumerate() {
            for error in [0.97, 1.0, 1.03] {
                let next = ride(2 + i as u64, error * faster, rougher);
                let fits = plans.map(|(faster, rougher)| {
                    let plan = RidePlan {
                        faster,
                        rougher,
                        ..AGAIN
                    };
                    is_planned(&plan, &before, &next)
                });
                let expected: [bool; 6] = std::array::from_fn(|j| i == j);
                assert_eq!(
                    fits, expected,
                    "{faster} times as fast, {rougher} times as rough"
                );
            }
        }
    }

    #[test]
    fn bounds_part_rides_from_one_another() {
        let before = ride(1, 1.0, 1.0);
        let at = |faster: f64, rougher: f64| {
            let mut next = before.clone();
            let speed = next.speed.iter_mut().flatten();
            speed.for_each(|v| *v *= faster.exp());
            let roads = [&mut next.axles.front, &mut next.axles.rear];
            let roads = roads.into_iter().flatten();
            // Heights change as slopes do, and slopes are passed over faster.
            let heights = roads.flat_map(|record| &mut record.road);
            heights.for_each(|u| *u *= (faster + rougher).exp());
            is_planned(&AGAIN, &before, &next)
        };
        assert!(at(0.99 * PACE, 0.0) && !at(1.01 * PACE, 0.0));
        assert!(at(0.0, 0.99 * ROUGH) && !at(0.0, 1.01 * ROUGH));
    }

    #[test]
    fn a_question_is_asked_until_it_is_settled_or_twice_the_planned_rides_are_in() {
        let id = Uuid::from_u128;
        let study = |verdict: &str, rides: u128| StudyRow {
            id: id(99),
            state: "succeeded".to_owned(),
            verdict: Some(verdict.to_owned()),
            study: Json((1..=rides).map(id).collect()),
        };
        let judged = |studies: &[StudyRow]| judged_with(&AGAIN, [id(1), id(50)], studies);
        assert_eq!(judged(&[]), Some(vec![id(1), id(50)]));
        assert_eq!(
            judged(&[study("ambiguous", 2)]),
            Some(vec![id(1), id(2), id(50)])
        );
        assert_eq!(judged(&[study("named", 2)]), None);
        assert_eq!(judged(&[study("ambiguous", 3)]), None);
        let again = judged_with(&AGAIN, [id(1), id(2)], &[study("ambiguous", 3)]);
        assert_eq!(again.map(|rides| rides.len()), Some(3), "one that is in it");
    }

    #[test]
    fn a_plan_needs_what_it_speaks_of() {
        let before = ride(1, 1.0, 1.0);
        let mut next = ride(2, 1.0, 1.0);
        let swinging = RidePlan {
            swing: 0.3,
            ..AGAIN
        };
        let coasting = RidePlan {
            coasting: true,
            ..AGAIN
        };
        assert!(is_planned(&AGAIN, &before, &next));
        assert!(!is_planned(&swinging, &before, &next) && !is_planned(&coasting, &before, &next));
        let speed = next.speed.iter_mut().flatten().enumerate();
        speed.for_each(|(i, v)| *v *= 1.0 + 0.3 * (i as f64 * 0.01).sin());
        assert!(is_planned(&swinging, &before, &next));
        next.speed = None;
        let faster = RidePlan {
            faster: 1.25,
            ..AGAIN
        };
        assert!(is_planned(&AGAIN, &before, &next) && !is_planned(&faster, &before, &next));
    }
}
