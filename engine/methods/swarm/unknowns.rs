//! The swarm's coordinates X, paper eq. (24): which physical quantities a position stands for.

use super::search::{Axis, CostCurve};
use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_report::{Estimate, Parameters, Trial};

/// What is searched for.
///
/// Per axle k/m (1/s^2), B/m (1/s) and, where the mass is unknown, 1/m (1/kg); with equal axles one
/// k (N/m) and one B (N s/m).
#[derive(Clone, Debug)]
pub struct Unknowns {
    axles: Vec<Searched>,
    shared: bool,
}

#[derive(Clone, Debug)]
struct Searched {
    axle: Axle,
    mass: Option<f64>,
    /// k/m, B/m, 1/m to search around.
    around: [f64; 3],
}

impl Unknowns {
    /// `estimates` lie in the middle of the box.
    pub fn new(bike: &Bike, estimates: &PerAxle<Estimate>) -> Self {
        let axles = estimates
            .iter()
            .map(|(axle, e)| Searched {
                axle,
                mass: bike.mass(axle),
                around: [e.k_n_m / e.mass_kg, e.b_n_s_m / e.mass_kg, 1.0 / e.mass_kg],
            })
            .collect::<Vec<_>>();
        Self {
            shared: bike.shares_axles() && axles.len() == 2,
            axles,
        }
    }

    /// The search box: `factor` both ways around the estimates; where these are not physical, all
    /// oscillators that the ride can show: from one swing in all of it to one in four samples.
    pub fn axes(&self, factor: f64, step: f64, samples: usize) -> Vec<Axis> {
        let around = |value: f64| Axis::Log {
            low: value / factor,
            high: value * factor,
        };
        let mut axes = Vec::new();
        for a in &self.axles {
            let [kappa, beta, per_mass] = a.around;
            let scale = if self.shared { 1.0 / per_mass } else { 1.0 };
            if a.around.iter().all(|x| x.is_finite() && *x > 0.0) {
                axes.extend([around(kappa * scale), around(beta * scale)]);
            } else {
                let slow = std::f64::consts::TAU / (samples as f64 * step);
                let fast = std::f64::consts::PI / (2.0 * step);
                axes.push(Axis::Log {
                    low: slow * slow * scale,
                    high: fast * fast * scale,
                });
                axes.push(Axis::Log {
                    low: 0.01 * slow * scale,
                    high: 2.0 * fast * scale,
                });
            }
            if self.shared {
                break;
            }
            if a.mass.is_none() {
                axes.push(around(if per_mass > 0.0 { per_mass } else { 1.0 }));
            }
        }
        axes
    }

    /// How many coordinates belong to each axle: the cost is a sum over axles, and unless they share
    /// their parameters no coordinate enters the cost of both.
    pub fn groups(&self) -> Vec<usize> {
        if self.shared {
            return vec![2];
        }
        let width = |a: &Searched| if a.mass.is_some() { 2 } else { 3 };
        self.axles.iter().map(width).collect()
    }

    /// k/m, B/m and 1/m of one axle at position `x`.
    pub fn theta(&self, axle: Axle, x: &[f64]) -> [f64; 3] {
        let mut rest = x;
        for a in &self.axles {
            let known = a.mass.map(f64::recip);
            if a.axle == axle {
                let per_mass = known.unwrap_or_else(|| rest[2]);
                let scale = if self.shared { per_mass } else { 1.0 };
                return [rest[0] * scale, rest[1] * scale, per_mass];
            }
            if !self.shared {
                rest = &rest[if known.is_some() { 2 } else { 3 }..];
            }
        }
        [f64::NAN; 3]
    }

    /// The report of a trial that took `course`.
    pub fn trial(&self, seed: u64, course: CostCurve) -> Trial {
        let end = course.best_position.last().cloned().unwrap_or_default();
        let of = |axle: Axle| {
            self.axles.iter().any(|a| a.axle == axle).then(|| {
                let [kappa, beta, per_mass] = self.theta(axle, &end);
                Parameters {
                    k_n_m: kappa / per_mass,
                    b_n_s_m: beta / per_mass,
                }
            })
        };
        Trial {
            seed,
            front: of(Axle::Front),
            rear: of(Axle::Rear),
            best_cost: course.best_cost,
            best_position: course.best_position,
        }
    }
}
