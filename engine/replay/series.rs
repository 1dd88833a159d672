//! What was measured and what the identified models make of it, sample by sample: the data of the
//! paper's figures 8 to 10.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::motion::simulated;
use super::wheel_load::loads;
use veloid_core::bicycle::{Axle, PerAxle};
use veloid_methods::observer::differentiate;
use veloid_report::Method;
use veloid_report::{Estimate, Report};
use veloid_ride::{AxleRecord, Ride};

/// Quantity of a series.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// z (m).
    #[default]
    Displacement,
    /// Central difference D z (m/s), of the measurement and of the models.
    Velocity,
    /// Central difference D^2 z (m/s^2), of the measurement and of the models.
    Acceleration,
    /// Wheel load (N) of the models, paper eq. (2), where there is a road and a static load.
    Load,
    /// Force (N) that a rig measured and the models answer with where it prescribes the motion; the applied force elsewhere.
    Force,
}

impl Quantity {
    /// SI unit of the values.
    pub fn unit(self) -> &'static str {
        match self {
            Quantity::Displacement => "m",
            Quantity::Velocity => "m/s",
            Quantity::Acceleration => "m/s^2",
            Quantity::Load | Quantity::Force => "N",
        }
    }

    /// Applies the central difference once per derivative; the ends have none.
    fn of(self, mut values: Vec<f64>, step: f64) -> Vec<f64> {
        let derivatives = match self {
            Quantity::Displacement | Quantity::Load | Quantity::Force => 0,
            Quantity::Velocity => 1,
            Quantity::Acceleration => 2,
        };
        for _ in 0..derivatives {
            let difference = |i: usize| match (i.checked_sub(1), values.get(i + 1)) {
                (Some(before), Some(after)) => (after - values[before]) / (2.0 * step),
                _ => f64::NAN,
            };
            values = (0..values.len()).map(difference).collect();
        }
        values
    }
}

/// One curve over the whole ride; NaN where there is no value.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// `measured`, `least_squares`, `swarm`, `plain` (output error), `residual` (measured - plain) or
    /// `observer` (the observer's own state), `logged` (the accelerometer's).
    pub name: &'static str,
    /// One value per sample of the ride, in the series' unit.
    pub values: Vec<f64>,
}

/// The curves of both axles on the ride's clock.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// Quantity of the curves.
    pub quantity: Quantity,
    /// Time of the first sample (s).
    pub start_s: f64,
    /// Sample interval (s).
    pub step_s: f64,
    /// Number of samples, the same in every curve.
    pub samples: usize,
    /// Curves of each axle.
    pub axles: PerAxle<Vec<Curve>>,
}

impl Series {
    /// Simulates the models of the report along the ride.
    pub fn of(ride: &Ride, report: &Report, quantity: Quantity) -> Self {
        Self {
            quantity,
            start_s: ride.start_s,
            step_s: ride.step_s,
            samples: ride.samples,
            axles: ride.axles.map(|axle, record| {
                let swarm = match axle {
                    Axle::Front => report.swarm.front.as_ref(),
                    Axle::Rear => report.swarm.rear.as_ref(),
                };
                let models = [
                    (Method::LeastSquares.name(), report.least_squares.get(axle)),
                    (Method::Swarm.name(), swarm),
                    ("plain", report.output_error.get(axle)),
                ];
                if quantity == Quantity::Load {
                    let found = loads(record, ride.step_s, &models, report.bike.static_load(axle));
                    return found
                        .into_iter()
                        .map(|(name, values)| Curve { name, values })
                        .collect();
                }
                let mut curves = curves(record, ride.step_s, &models, quantity);
                let observer = report.observer.get(axle);
                if let Some(observer) = observer.filter(|_| quantity != Quantity::Force) {
                    curves.push(observed(
                        record,
                        ride.step_s,
                        observer.jerk_bound_m_s3,
                        quantity,
                    ));
                }
                curves
            }),
        }
    }

    /// The part from `t0` to `t1` (s), thinned to at most about `points` per curve. Thinning keeps the
    /// smallest and the largest value of every stretch, in the order in which they came.
    pub fn window(&self, t0: Option<f64>, t1: Option<f64>, points: usize) -> Window {
        let sample = |t: f64| ((t - self.start_s) / self.step_s).clamp(0.0, self.samples as f64);
        // A time that is given to a few digits still means the sample at it.
        let near = 1e-6;
        let from = t0.map_or(0, |t| (sample(t) - near).ceil() as usize);
        let to = t1.map_or(self.samples, |t| {
            ((sample(t) + near).floor() as usize).saturating_add(1)
        });
        let (from, to) = (from.min(self.samples), to.min(self.samples));
        let stretch = (2 * to.saturating_sub(from)).div_ceil(points.max(2)).max(1);
        let thinned = stretch > 2;
        let time = |i: usize| self.start_s + i as f64 * self.step_s;
        let t_s = if thinned {
            let middle = |i: usize| (i + stretch / 2).min(to - 1);
            let pair = |i: usize| [time(i), time(middle(i))];
            (from..to).step_by(stretch).flat_map(pair).collect()
        } else {
            (from..to).map(time).collect()
        };
        let cut = |curve: &Curve| {
            let part = curve.values.get(from..to).unwrap_or_default();
            let values: Vec<f64> = if thinned {
                part.chunks(stretch).flat_map(extremes).collect()
            } else {
                part.to_vec()
            };
            let known = values.into_iter().map(|v| v.is_finite().then_some(v));
            (curve.name.to_owned(), known.collect())
        };
        Window {
            quantity: self.quantity,
            unit: self.quantity.unit().to_owned(),
            thinned,
            t_s,
            axles: self.axles.map(|_, curves| curves.iter().map(cut).collect()),
        }
    }
}

/// Smallest and largest value in the order in which they came; NaN where there is none.
fn extremes(values: &[f64]) -> [f64; 2] {
    let finite = || values.iter().enumerate().filter(|(_, v)| v.is_finite());
    let smallest = finite().min_by(|a, b| a.1.total_cmp(b.1));
    let largest = finite().max_by(|a, b| a.1.total_cmp(b.1));
    match (smallest, largest) {
        (Some((i, low)), Some((j, high))) if i <= j => [*low, *high],
        (Some((_, low)), Some((_, high))) => [*high, *low],
        _ => [f64::NAN; 2],
    }
}

/// Part of a [`Series`], thinned for plotting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Window {
    /// Quantity of the curves.
    pub quantity: Quantity,
    /// SI unit of the curves.
    pub unit: String,
    /// Whether the curves are thinned to the smallest and largest value of each stretch of samples.
    pub thinned: bool,
    /// Time of the values of every curve (s).
    pub t_s: Vec<f64>,
    /// Curves by name: `measured`, `least_squares`, `swarm`, `plain` (output error), `residual`
    /// (measured - plain), `observer` (the observer's own state), `logged` (the accelerometer's); null where there is no value.
    pub axles: PerAxle<BTreeMap<String, Vec<Option<f64>>>>,
}

fn curves(
    record: &AxleRecord,
    step: f64,
    models: &[(&'static str, Option<&Estimate>)],
    quantity: Quantity,
) -> Vec<Curve> {
    let shown = match quantity {
        Quantity::Force => record.force.as_deref().unwrap_or_default(),
        _ => &record.displacement,
    };
    let trusted = shown.iter().zip(&record.valid);
    let measured = trusted.map(|(z, valid)| if *valid { *z } else { f64::NAN });
    let measured = quantity.of(measured.collect(), step);
    let mut curves = Vec::new();
    let predicted = record.prescribed == (quantity == Quantity::Force);
    for (name, estimate) in models {
        let Some(estimate) = estimate.filter(|_| predicted) else {
            continue;
        };
        let values = quantity.of(simulated(record, step, estimate), step);
        if *name == "plain" {
            let pairs = measured.iter().zip(&values);
            curves.push(Curve {
                name: "residual",
                values: pairs.map(|(z, model)| z - model).collect(),
            });
        }
        curves.push(Curve { name, values });
    }
    curves.push(Curve {
        name: "measured",
        values: measured,
    });
    let accelerometer =
        (record.acceleration.as_ref()).filter(|_| quantity == Quantity::Acceleration);
    curves.extend(accelerometer.map(|logged| Curve {
        name: "logged",
        values: logged.clone(),
    }));
    curves
}

/// The observer's state, paper eq. (12): figures 4 and 5.
fn observed(record: &AxleRecord, step: f64, jerk_bound: f64, quantity: Quantity) -> Curve {
    let [states] = differentiate([record.displacement.as_slice()], [jerk_bound], step);
    Curve {
        name: "observer",
        values: match quantity {
            Quantity::Displacement | Quantity::Load | Quantity::Force => states.position,
            Quantity::Velocity => states.velocity,
            Quantity::Acceleration => states.acceleration,
        },
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn differences_are_those_of_a_parabola() {
        let parabola: Vec<f64> = (0..9).map(|i| 3.0 * f64::from(i * i)).collect();
        let velocity = Quantity::Velocity.of(parabola.clone(), 0.5);
        assert!(velocity[0].is_nan() && velocity[8].is_nan());
        assert!((velocity[4] - 48.0).abs() < 1e-12, "2 * 3 * 4 / 0.5");
        let acceleration = Quantity::Acceleration.of(parabola, 0.5);
        assert!(acceleration[1].is_nan());
        assert!((acceleration[2] - 24.0).abs() < 1e-12, "2 * 3 / 0.5^2");
    }

    fn truth() -> Estimate {
        Estimate {
            k_n_m: 110e3,
            b_n_s_m: 1150.0,
            mass_kg: 23.0,
            ..Estimate::default()
        }
    }

    fn series(quantity: Quantity) -> Series {
        let mut ride = veloid_methods::simulate::simulated_ride::SimulatedRide {
            duration_s: 5.0,
            ..Default::default()
        }
        .ride();
        let front = ride.axles.front.as_mut().unwrap();
        front.valid[100] = false;
        let mut axles = PerAxle::default();
        let models = [("plain", Some(&truth())), ("swarm", None)];
        axles.set(Axle::Front, curves(front, ride.step_s, &models, quantity));
        Series {
            quantity,
            start_s: ride.start_s,
            step_s: ride.step_s,
            samples: ride.samples,
            axles,
        }
    }

    #[test]
    fn the_true_model_leaves_no_residual_and_a_gap_stays_a_gap() {
        let window = series(Quantity::Displacement).window(None, None, 10_000);
        let front = window.axles.front.unwrap();
        let names: Vec<&str> = front.keys().map(String::as_str).collect();
        assert_eq!(names, ["measured", "plain", "residual"]);
        let residual = &front["residual"];
        assert!(front["measured"][100].is_none() && residual[100].is_none());
        assert!(residual.iter().flatten().all(|r| r.abs() < 1e-5));
        assert_eq!(window.t_s.len(), residual.len());
    }

    #[test]
    fn a_window_is_cut_and_thinned_to_what_was_asked() {
        let series = series(Quantity::Velocity);
        let window = series.window(Some(1.0), Some(2.0), 1000);
        assert!(!window.thinned);
        assert_eq!((window.t_s[0], window.t_s.len()), (1.0, 101));
        let all = series.window(None, None, 100);
        assert!(all.thinned && all.t_s.len() <= 102);
        let thin = &all.axles.front.as_ref().unwrap()["plain"];
        assert_eq!(thin.len(), all.t_s.len());
        let full = series.window(None, None, 1 << 20).axles.front.unwrap();
        let largest =
            |values: &[Option<f64>]| values.iter().flatten().copied().fold(f64::MIN, f64::max);
        assert_eq!(largest(thin), largest(&full["plain"]));
        for (t0, t1) in [(9.0, 8.0), (-5.0, -4.0), (f64::NAN, 1.0)] {
            assert!(series.window(Some(t0), Some(t1), 10).t_s.len() <= 101);
        }
    }
}
