//! What became of a parameter over a bicycle's rides (crate `veloid-courses`), with dates.

use serde::Serialize;
use utoipa::ToSchema;
use veloid_courses::{Ride, Rides};

use crate::memo::Memo;
use crate::time;

const DAY_MS: f64 = 86_400_000.0;

/// Developments of courses: four or more of each of a group's bicycles.
static KNOWN: Memo<Option<Development>> = Memo::new(10_000);

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = DevelopmentKind)]
pub enum Kind {
    None,
    Drift,
    Step,
    Both,
}

/// What became of a parameter. A change is reported once its evidence exceeds a threshold that 1 % of unchanged bicycles exceed within 200
/// rides.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Development {
    /// `step`: one or several; `drift`: one or several, over or not; `both`: drifts and steps.
    pub kind: Kind,
    /// Change per day of the drift that goes on, in the parameter's unit; 0 without one.
    pub per_day: f64,
    /// Its standard error; 0 without one.
    pub per_day_std_error: f64,
    /// Every drift, oldest first.
    pub drifts: Vec<Drift>,
    /// Time of the first ride after the latest step.
    #[schema(format = DateTime)]
    pub at: Option<String>,
    /// Height of the latest step, in the parameter's unit; 0 without one.
    pub step: f64,
    /// Every step, oldest first.
    pub steps: Vec<Step>,
    /// The level on the last ride, and its standard error.
    pub now: f64,
    pub now_std_error: f64,
    /// Standard deviation between rides beyond their own errors and these changes.
    pub between_rides: f64,
    /// Facts of the rides that were held constant.
    pub beside: Vec<String>,
    /// How many of the latest rides nothing has changed on, but for a drift that goes on.
    #[serde(skip)]
    pub settled: usize,
}

/// A sudden change of a parameter between two rides.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = DevelopmentStep)]
pub struct Step {
    /// Time of the first ride after it.
    #[schema(format = DateTime)]
    pub at: String,
    /// Time of the last ride before it.
    #[schema(format = DateTime)]
    pub since: String,
    /// Height beside drifts, in the parameter's unit.
    pub size: f64,
    /// Its standard error, given where the changes are.
    pub std_error: f64,
    /// The bicycle's event that lies nearest, in words: "the day after 'new tyre'"; null where none is near.
    pub event: Option<String>,
    /// Half the width of its 95 % interval, by Student's t.
    #[serde(skip)]
    pub margin: f64,
}

/// A slow change of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = DevelopmentDrift)]
pub struct Drift {
    /// Time of the last ride before it.
    #[schema(format = DateTime)]
    pub since: String,
    /// Time of its last ride; null where it goes on.
    #[schema(format = DateTime)]
    pub until: Option<String>,
    /// Change per day, in the parameter's unit.
    pub per_day: f64,
    /// Its standard error, given where the changes are.
    pub std_error: f64,
    /// Half the width of its 95 % interval, by Student's t.
    #[serde(skip)]
    pub margin: f64,
}

/// A fact of each ride that is not to pass for a change.
#[derive(Clone, Debug, PartialEq)]
pub struct Fact {
    pub name: String,
    pub values: Vec<f64>,
}

impl Development {
    /// `points`: time (epoch ms), value, standard error, oldest first. None where they are too few or all alike.
    pub fn of(points: &[(i64, f64, f64)], facts: &[Fact]) -> Option<Self> {
        let bytes = |(ms, value, error): &(i64, f64, f64)| {
            [ms.to_le_bytes(), value.to_le_bytes(), error.to_le_bytes()]
        };
        let mut asked: Vec<u8> = points.iter().flat_map(bytes).flatten().collect();
        for fact in facts {
            asked.extend(fact.name.as_bytes());
            asked.extend(fact.values.iter().flat_map(|x| x.to_le_bytes()));
        }
        KNOWN.get(&asked, || Self::followed(points, facts))
    }

    fn followed(points: &[(i64, f64, f64)], facts: &[Fact]) -> Option<Self> {
        let first = points.first()?.0;
        let ride = |(ms, value, std_error): &(i64, f64, f64)| Ride {
            day: (ms - first) as f64 / DAY_MS,
            value: *value,
            std_error: *std_error,
        };
        let rides: Vec<Ride> = points.iter().map(ride).collect();
        let columns: Vec<Vec<f64>> = facts.iter().map(|fact| fact.values.clone()).collect();
        let found = veloid_courses::Development::of(Rides {
            rides: &rides,
            facts: &columns,
        })?;
        let at = |ride: usize| time::text(points[ride].0);
        let steps = found.steps.iter().map(|step| Step {
            at: at(step.ride),
            since: at(step.ride - 1),
            size: step.size.value,
            std_error: step.size.std_error,
            event: None,
            margin: step.size.margin,
        });
        let drifts = found.drifts.iter().map(|drift| Drift {
            since: at(drift.from),
            until: drift.to.map(at),
            per_day: drift.per_day.value,
            std_error: drift.per_day.std_error,
            margin: drift.per_day.margin,
        });
        let (steps, drifts): (Vec<Step>, Vec<Drift>) = (steps.collect(), drifts.collect());
        let mut names: Vec<String> = facts.iter().map(|fact| fact.name.clone()).collect();
        names.dedup();
        let latest = steps.last();
        let ongoing = drifts.last().filter(|drift| drift.until.is_none());
        Some(Self {
            kind: match (drifts.is_empty(), steps.is_empty()) {
                (true, true) => Kind::None,
                (false, true) => Kind::Drift,
                (true, false) => Kind::Step,
                (false, false) => Kind::Both,
            },
            per_day: ongoing.map_or(0.0, |drift| drift.per_day),
            per_day_std_error: ongoing.map_or(0.0, |drift| drift.std_error),
            at: latest.map(|step| step.at.clone()),
            step: latest.map_or(0.0, |step| step.size),
            now: found.now.value,
            now_std_error: found.now.std_error,
            between_rides: found.between_rides,
            settled: points.len() - found.since,
            beside: names,
            drifts,
            steps,
        })
    }

    /// The drift that goes on.
    pub fn drifts(&self) -> Option<&Drift> {
        self.drifts.last().filter(|drift| drift.until.is_none())
    }
}
