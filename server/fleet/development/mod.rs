//! What became of a parameter over a bicycle's rides: nothing, a drift, steps or both, as one choice by the Bayesian information
//! criterion (Schwarz 1978), since each of a drift and a step alone also explains much of the other.

mod model;
mod search;
mod sums;
#[cfg(test)]
mod tests;

use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};
use utoipa::ToSchema;

use crate::memo::Memo;
use crate::time;
use model::{Estimate, Model};

/// Developments of courses: four of each of a group's bicycles.
static KNOWN: Memo<Option<Development>> = Memo::new(10_000);

/// Fewest rides.
const LEAST: usize = 8;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = DevelopmentKind)]
pub enum Kind {
    None,
    Drift,
    Step,
    Both,
}

/// What became of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Development {
    /// `step`: one or several; `both`: a drift and one or several steps.
    pub kind: Kind,
    /// Change per day, in the parameter's unit; 0 without a drift.
    pub per_day: f64,
    /// Its standard error; 0 without a drift.
    pub per_day_std_error: f64,
    /// Half the width of its 95 % interval, by Student's t.
    #[serde(skip)]
    pub per_day_margin: f64,
    /// Time of the first ride after the latest step.
    #[schema(format = DateTime)]
    pub at: Option<String>,
    /// Height of the latest step beside the drift, in the parameter's unit; 0 without a step.
    pub step: f64,
    /// Every step, oldest first; at most 4.
    pub steps: Vec<Step>,
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
    /// Height beside the drift, in the parameter's unit.
    pub size: f64,
    /// Its standard error, given where the steps are.
    pub std_error: f64,
    /// The bicycle's event that lies nearest, in words: "the day after 'new tyre'"; null where none is near.
    pub event: Option<String>,
    /// Half the width of its 95 % interval, by Student's t.
    #[serde(skip)]
    pub margin: f64,
}

impl Development {
    /// `points`: time (epoch ms), value, standard deviation, oldest first. None where there are too few, or all alike.
    pub fn of(points: &[(i64, f64, f64)]) -> Option<Self> {
        if points.len() < LEAST {
            return None;
        }
        let bytes = |(ms, value, deviation): &(i64, f64, f64)| {
            [
                ms.to_le_bytes(),
                value.to_le_bytes(),
                deviation.to_le_bytes(),
            ]
        };
        let asked: Vec<u8> = points.iter().flat_map(bytes).flatten().collect();
        KNOWN.get(&asked, || {
            let rides = search::Rides::new(points)?;
            Some(Self::told(points, &rides.best()))
        })
    }

    fn told(points: &[(i64, f64, f64)], model: &Model) -> Self {
        let wide =
            StudentsT::new(0.0, 1.0, model.freedom).map_or(f64::NAN, |t| t.inverse_cdf(0.975));
        let steps = model.splits.iter().zip(&model.steps);
        let step = |(split, size): (&usize, &Estimate)| Step {
            at: time::text(points[*split].0),
            since: time::text(points[split - 1].0),
            size: size.value,
            std_error: size.std_error,
            event: None,
            margin: wide * size.std_error,
        };
        let steps: Vec<Step> = steps.map(step).collect();
        let latest = steps.last();
        Self {
            kind: match (model.drifts, steps.is_empty()) {
                (false, true) => Kind::None,
                (true, true) => Kind::Drift,
                (false, false) => Kind::Step,
                (true, false) => Kind::Both,
            },
            per_day: model.slope.value,
            per_day_std_error: model.slope.std_error,
            per_day_margin: wide * model.slope.std_error,
            at: latest.map(|step| step.at.clone()),
            step: latest.map_or(0.0, |step| step.size),
            steps,
        }
    }

    pub fn drifts(&self) -> bool {
        matches!(self.kind, Kind::Drift | Kind::Both)
    }
}
