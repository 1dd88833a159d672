//! What one axle's simulated motion is compared with: the measured side of paper eqs. (25), (26).

use std::ops::Range;

use crate::observer::{States, differentiate, jerk_bound};
use crate::simulate::linear::Input;
use crate::simulate::start::start;
use veloid_core::bicycle::Axle;
use veloid_core::settings::{Objective, Settings};
use veloid_core::{EngineError, RideProblem};
use veloid_ride::{AxleRecord, Ride};

/// The measured motion of one axle and how its errors are weighted.
#[derive(Clone, Debug)]
pub struct Target {
    pub objective: Objective,
    pub input: Input,
    /// State of the model at the first sample: z (m), z' (m/s).
    pub initial: [f64; 2],
    /// x1 (m), x2 (m/s), x3 (m/s^2), from which a rest point is taken away.
    pub position: Vec<f64>,
    pub velocity: Vec<f64>,
    pub acceleration: Vec<f64>,
    /// Runs of samples to compare at. The consistent objective needs the neighbours of a sample, so
    /// it leaves out one (velocity) and two (acceleration) at both ends of each.
    pub runs: Vec<Range<usize>>,
    /// W of eq. (25) over the number of samples: for x1, x2, x3.
    pub weights: [f64; 3],
}

/// Time (s) from the ride's first sample to t1 of eq. (25).
const T1_S: f64 = 1.0;
/// Least samples in a run.
const LEAST_RUN: usize = 5;

impl Target {
    /// `theta`: parameters from which the initial state and the rest point are found.
    ///
    /// # Errors
    /// No five valid samples in a row; a signal without variation.
    pub fn new(
        axle: Axle,
        record: &AxleRecord,
        ride: &Ride,
        settings: &Settings,
        theta: [f64; 3],
    ) -> Result<Self, EngineError> {
        let step = ride.step_s;
        let objective = settings.objective;
        let input = Input::of(record, step);
        let driven = record.has_road();
        let rest_point = record.force.is_some() || !driven;
        let from = start(
            &input,
            theta,
            &record.displacement,
            &record.valid,
            rest_point,
        );
        let offset = from.constant / theta[0];
        let position: Vec<f64> = record.displacement.iter().map(|z| z - offset).collect();
        let literal = objective == Objective::Gradient;
        let (velocity, acceleration) = match objective {
            Objective::Paper => {
                let f = settings
                    .jerk_bound_m_s3
                    .unwrap_or_else(|| jerk_bound(&record.displacement, &record.valid, step));
                let [
                    States {
                        velocity,
                        acceleration,
                        ..
                    },
                ] = differentiate([record.displacement.as_slice()], [f], step);
                (velocity, acceleration)
            }
            Objective::Consistent | Objective::Gradient => {
                let velocity = gradient(&position, step);
                let acceleration = gradient(&velocity, step);
                (velocity, acceleration)
            }
        };
        let first = if literal {
            0
        } else {
            ((T1_S / step).round() as usize).min(position.len() / 10)
        };
        let mut target = Self {
            objective,
            input,
            initial: if literal && driven {
                [0.0; 2]
            } else {
                [from.initial[0] - offset, from.initial[1]]
            },
            position,
            velocity,
            acceleration,
            runs: runs(&record.valid, first),
            weights: [0.0; 3],
        };
        for (d, weight) in settings.weights.into_iter().enumerate() {
            target.weights[d] = weight / target.sum_of_squares(axle, d)?;
        }
        Ok(target)
    }

    /// Samples left out at both ends of a run for x1, x2, x3.
    pub fn margins(&self) -> [usize; 3] {
        match self.objective {
            Objective::Consistent => [0, 1, 2],
            Objective::Paper | Objective::Gradient => [0; 3],
        }
    }

    /// Number of samples times variance of x1, x2 or x3 over the runs.
    fn sum_of_squares(&self, axle: Axle, d: usize) -> Result<f64, EngineError> {
        let (signal, name) = match d {
            0 => (&self.position, "displacement"),
            1 => (&self.velocity, "velocity"),
            _ => (&self.acceleration, "acceleration"),
        };
        let margin = self.margins()[d];
        let inner = || {
            self.runs
                .iter()
                .flat_map(|run| signal[run.start + margin..run.end - margin].iter())
        };
        let count = inner().count() as f64;
        let mean = inner().sum::<f64>() / count;
        let sum: f64 = inner().map(|x| (x - mean) * (x - mean)).sum();
        if sum > 0.0 && sum.is_finite() {
            return Ok(sum);
        }
        Err(EngineError::Ride {
            axle,
            problem: RideProblem::NoVariation { signal: name },
        })
    }
}

/// The runs of at least [`LEAST_RUN`] valid samples from `first` on.
fn runs(valid: &[bool], first: usize) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    let mut begin = first;
    for i in first..=valid.len() {
        if i == valid.len() || !valid[i] {
            if i >= begin + LEAST_RUN {
                runs.push(begin..i);
            }
            begin = i + 1;
        }
    }
    runs
}

/// Central differences; one-sided at the ends.
pub fn gradient(x: &[f64], step: f64) -> Vec<f64> {
    let n = x.len();
    (0..n)
        .map(|i| match i {
            0 => (x[1] - x[0]) / step,
            i if i + 1 == n => (x[i] - x[i - 1]) / step,
            i => (x[i + 1] - x[i - 1]) / (2.0 * step),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_skip_what_is_short_or_not_valid() {
        let mut valid = vec![true; 40];
        for i in [3, 12, 15, 22] {
            valid[i] = false;
        }
        assert_eq!(runs(&valid, 5), vec![5..12, 16..22, 23..40]);
        assert!(runs(&valid[..4], 0).is_empty());
    }

    #[test]
    fn gradient_is_exact_for_lines_and_central_inside() {
        let x: Vec<f64> = (0..10).map(|i| 2.0 * i as f64).collect();
        assert_eq!(gradient(&x, 0.5), vec![4.0; 10]);
        assert_eq!(gradient(&[0.0, 1.0, 4.0], 1.0), vec![1.0, 2.0, 3.0]);
    }
}
