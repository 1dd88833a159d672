use nalgebra::{DMatrix, DVector};
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};
use utoipa::ToSchema;

use super::Data;
use super::confounding::varies_within;
use super::reml::{Problem, State};

/// Fewest rides beyond the number of coefficients.
const SPARE: usize = 3;

/// A fitted regression. Facts are centred on their means and scaled to a standard deviation of one inside, so that bars
/// and days weigh alike.
pub struct Fit {
    /// In the order of the columns.
    pub slopes: Vec<Coefficient>,
    /// The value where every fact has its mean.
    pub level: Coefficient,
    /// Standard deviation of rides beyond their own errors.
    pub between_rides: f64,
    /// Standard deviation of bicycles, where there are several with several rides.
    pub between_bikes: Option<f64>,
    pub means: Vec<f64>,
    /// What each ride is above what is fitted, its bicycle's level taken out too.
    pub residuals: Vec<f64>,
    /// Covariance of level and slopes.
    covariance: DMatrix<f64>,
    /// Degrees of freedom of the level.
    freedom: f64,
}

/// A coefficient in the units of what it belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct Coefficient {
    pub value: f64,
    pub std_error: f64,
    /// 95 % interval by Student's t.
    pub low: f64,
    pub high: f64,
    /// Chance of as much if there were nothing.
    pub p_value: f64,
}

/// What is expected of a ride.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct Prediction {
    pub value: f64,
    /// Of the value that is expected on average.
    pub std_error: f64,
    /// Its 95 % interval.
    pub low: f64,
    pub high: f64,
    /// Standard deviation of a single ride about it, that of the average and of bicycles included.
    pub single_ride: f64,
}

impl Coefficient {
    fn new(value: f64, std_error: f64, freedom: f64) -> Self {
        let student = StudentsT::new(0.0, 1.0, freedom).ok();
        let wide = student.map_or(f64::NAN, |t| t.inverse_cdf(0.975));
        Self {
            value,
            std_error,
            low: value - wide * std_error,
            high: value + wide * std_error,
            p_value: student.map_or(1.0, |t| (2.0 * t.sf((value / std_error).abs())).min(1.0)),
        }
    }

    /// Half of the interval's width.
    pub fn margin(&self) -> f64 {
        0.5 * (self.high - self.low)
    }
}

/// What was done to the data before they were fitted, and what is to be undone.
pub struct Scales {
    /// Mean and standard deviation of the values.
    values: (f64, f64),
    /// Of the facts.
    facts: Vec<(f64, f64)>,
    /// Degrees of freedom of the level and the slopes.
    level: f64,
    slopes: Vec<f64>,
}

/// The data with means of nothing and standard deviations of one.
pub fn standardised(data: &Data) -> Option<(Problem<'_>, Scales)> {
    let (rides, bicycles, facts) = (data.rides(), data.bicycles(), data.facts.ncols());
    let levels = bicycles > 1 && rides > bicycles;
    let between: Vec<bool> = (0..facts)
        .map(|i| levels && !varies_within(data, i))
        .collect();
    let constant = between.iter().filter(|b| **b).count();
    let used = 1 + facts + if levels { bicycles - 1 } else { 0 } - constant;
    if rides < used + SPARE || levels && bicycles < constant + 2 {
        return None;
    }
    let values = spread(&data.values)?;
    let columns = data.facts.column_iter();
    let columns: Option<Vec<(f64, f64)>> = columns.map(|c| spread(&c.into_owned())).collect();
    let columns = columns?;
    let mut design = DMatrix::from_element(rides, facts + 1, 1.0);
    for (i, (mean, deviation)) in columns.iter().enumerate() {
        let column = data.facts.column(i).map(|x| (x - mean) / deviation);
        design.set_column(i + 1, &column);
    }
    let problem = Problem {
        bikes: &data.bikes,
        bicycles,
        design,
        values: data.values.map(|y| (y - values.0) / values.1),
        known: data.errors.map(|e| (e / values.1).powi(2)),
        levels,
    };
    let within = (rides - used) as f64;
    let level = if levels {
        (bicycles - 1 - constant) as f64
    } else {
        within
    };
    let slopes = between.iter().map(|b| if *b { level } else { within });
    let scales = Scales {
        values,
        facts: columns,
        level,
        slopes: slopes.collect(),
    };
    Some((problem, scales))
}

impl Fit {
    /// Nothing where the rides are too few or all alike. What goes with other facts is to be left out before (`Confounding`).
    pub fn of(data: &Data) -> Option<Self> {
        let (problem, scales) = standardised(data)?;
        let state = problem.solve()?;
        Some(Self::in_units(&problem, &state, scales))
    }

    fn in_units(problem: &Problem, state: &State, scales: Scales) -> Self {
        let (centre, scale) = scales.values;
        let of_facts = scales.facts.iter().map(|(_, deviation)| scale / deviation);
        let units = DVector::from_vec([scale].into_iter().chain(of_facts).collect());
        let covariance = state
            .information
            .inverse()
            .component_mul(&(&units * units.transpose()));
        let values = state.coefficients.component_mul(&units);
        let coefficient = |i: usize, value: f64, freedom: f64| {
            Coefficient::new(value, covariance[(i, i)].sqrt(), freedom)
        };
        // Each bicycle's level is guessed: their variance times the sum of what is left, weighed.
        let of_bikes = state.variances[1] * problem.sums(&state.weighted);
        let left =
            &problem.values - &problem.design * &state.coefficients - problem.spread(&of_bikes);
        let slopes = scales.slopes.iter().enumerate();
        Self {
            slopes: slopes
                .map(|(i, f)| coefficient(i + 1, values[i + 1], *f))
                .collect(),
            level: coefficient(0, centre + values[0], scales.level),
            between_rides: scale * state.variances[0].sqrt(),
            between_bikes: problem.levels.then(|| scale * state.variances[1].sqrt()),
            means: scales.facts.into_iter().map(|(mean, _)| mean).collect(),
            residuals: left.iter().map(|r| scale * r).collect(),
            covariance,
            freedom: scales.level,
        }
    }

    /// What is expected at these facts.
    pub fn at(&self, facts: &[f64]) -> Prediction {
        let off = facts.iter().zip(&self.means).map(|(x, mean)| x - mean);
        let place = DVector::from_iterator(facts.len() + 1, [1.0].into_iter().chain(off));
        let slopes = self.slopes.iter().map(|slope| slope.value);
        let all = DVector::from_iterator(
            facts.len() + 1,
            [self.level.value].into_iter().chain(slopes),
        );
        let variance = (&self.covariance * &place).dot(&place);
        let Coefficient {
            value,
            std_error,
            low,
            high,
            ..
        } = Coefficient::new(all.dot(&place), variance.sqrt(), self.freedom);
        let single_ride = std_error
            .hypot(self.between_rides)
            .hypot(self.between_bikes.unwrap_or(0.0));
        Prediction {
            value,
            std_error,
            low,
            high,
            single_ride,
        }
    }
}

/// Mean and standard deviation; nothing where all are alike.
fn spread(values: &DVector<f64>) -> Option<(f64, f64)> {
    let (mean, deviation) = (values.mean(), values.variance().sqrt());
    let alike = !(deviation > 1e-12 * values.amax()) || !deviation.is_normal();
    (!alike).then_some((mean, deviation))
}
