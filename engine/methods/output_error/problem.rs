//! One axle's part of the fit: what is unknown of it, its cost and sensitivities, and what a fit of it is.

use nalgebra::{SMatrix, SVector};

use super::split::Split;
use super::start::Start;
use crate::simulate::linear::Input;
use crate::simulate::sensitivity::{PARAMETERS, walk};
use veloid_core::EngineError;
use veloid_core::bicycle::{Axle, Bike};
use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_core::numerics::finite::std_error;
use veloid_core::numerics::spline::slopes;
use veloid_core::plant::{Coefficient, Coefficients};
use veloid_report::Estimate;
use veloid_ride::AxleRecord;

pub type Local = SVector<f64, PARAMETERS>;
pub type LocalMatrix = SMatrix<f64, PARAMETERS, PARAMETERS>;

/// The plain model at its best on one axle.
#[derive(Clone, Debug)]
pub struct AxleFit {
    /// Its parameters and initial state.
    pub plain: Coefficients,
    /// z - simulated z (m) at every sample of the ride, held-out part included; of the force (N) where the motion is
    /// prescribed.
    pub residual: Vec<f64>,
    /// Covariance of `Coefficients`'s parameters, from the residual's colour; zero where one is known.
    pub covariance: LocalMatrix,
    /// RMS of the valid residuals on the fitted part (m).
    pub train_rms: f64,
    /// RMS of the valid residuals on the held-out part (m).
    pub held_rms: f64,
    /// Whether the force answers to a prescribed motion, so that no mass is in it.
    pub prescribed: bool,
    /// Why its k and B are none, although they have a covariance.
    pub undetermined: Option<String>,
}

impl AxleFit {
    /// A ride that is the plain model's own, without noise.
    pub fn exact(plain: Coefficients, samples: usize) -> Self {
        Self {
            plain,
            residual: vec![0.0; samples],
            covariance: LocalMatrix::zeros(),
            train_rms: 0.0,
            held_rms: 0.0,
            prescribed: false,
            undetermined: None,
        }
    }
}

pub struct Problem<'a> {
    pub axle: Axle,
    pub record: &'a AxleRecord,
    pub input: Input,
    pub mass: Option<f64>,
    /// Which of [`Coefficients`]'s parameters are unknown.
    pub free: [bool; PARAMETERS],
    /// Ends of k/m (1/s^2) and B/m (1/s), where the user has set them.
    limits: [Option<[f64; 2]>; 2],
    /// Where the record does not show how it starts: height and velocity as recorded, and the weight of each beside a sample's.
    pub unseen: Option<[(f64, f64); 2]>,
}

/// Weight of an unseen start beside a sample: enough to keep it from running away, and nothing beside what a few samples show.
const UNSEEN: f64 = 1e-4;

/// Height and velocity with which a record starts whose first samples are not valid, each with its weight.
fn unseen(record: &AxleRecord, step: f64) -> Option<[(f64, f64); 2]> {
    let z = record.output();
    if record.prescribed || record.valid.first() != Some(&false) {
        return None;
    }
    let steps = z.windows(2).zip(&record.valid).filter(|(_, v)| **v);
    let squares: f64 = steps.map(|(p, _)| ((p[1] - p[0]) / step).powi(2)).sum();
    let height = spread_valid(z, &record.valid, 0..z.len());
    let count = record.valid.iter().filter(|v| **v).count().max(1) as f64;
    let per_velocity = height * height / (squares / count).max(f64::MIN_POSITIVE);
    let velocity = slopes(&z[..z.len().min(8)], step)[0];
    Some([(z[0], UNSEEN), (velocity, UNSEEN * per_velocity)])
}

impl<'a> Problem<'a> {
    pub fn new(
        axle: Axle,
        record: &'a AxleRecord,
        bike: &Bike,
        step: f64,
    ) -> Result<Self, EngineError> {
        let pushed = record.force.is_some();
        let mass = match record.prescribed {
            true => Some(1.0),
            false => bike.mass_or_force(axle, pushed)?,
        };
        let per_mass = mass.map_or(1.0, f64::recip);
        let limits = bike
            .limits(axle)
            .map(|ends| ends.map(|ends| ends.map(|x| x * per_mass)));
        let [k, b] = limits.map(|ends| ends.is_none_or(|[low, high]| low < high));
        let rest_point = pushed || !record.has_road();
        let moves = !record.prescribed && record.at_rest(step).is_none();
        Ok(Self {
            axle,
            record,
            input: Input::of(record, step),
            mass,
            free: [k, b, mass.is_none(), rest_point, moves, moves],
            limits,
            unseen: unseen(record, step).filter(|_| moves),
        })
    }

    /// The nearest coefficients within the user's limits.
    pub fn within(&self, p: Coefficients) -> Coefficients {
        let [kappa, beta] = [(p.kappa, self.limits[0]), (p.beta, self.limits[1])]
            .map(|(x, ends)| ends.map_or(x, |[low, high]| x.clamp(low, high)));
        Coefficients { kappa, beta, ..p }
    }

    /// Holds k/m or B/m at the limit that a fit has left, if it has left one.
    pub fn holds(&mut self, p: &Coefficients) -> bool {
        let inside = self.within(*p);
        let left = [(p.kappa, inside.kappa), (p.beta, inside.beta)];
        let beyond = (0..2).find(|q| self.free[*q] && left[*q].0 != left[*q].1);
        if let Some(q) = beyond {
            self.limits[q] = Some([left[q].1; 2]);
            self.free[q] = false;
        }
        beyond.is_some()
    }

    /// The plain model at a start; where the motion is prescribed it is linear, and any start does.
    pub fn start(&self, s: Option<&Start>) -> Option<Coefficients> {
        if self.record.prescribed {
            return Some(Coefficients {
                kappa: 0.0,
                beta: 0.0,
                per_mass: 1.0,
                ..Coefficients::default()
            });
        }
        let s = s?;
        let z = &self.record.displacement;
        let head = &z[..z.len().min(8)];
        Some(Coefficients {
            kappa: s.kappa,
            beta: s.beta,
            per_mass: self.mass.map_or(s.per_mass, |m| 1.0 / m),
            constant: 0.0,
            height: z[0],
            velocity: if self.free[5] {
                slopes(head, self.input.step)[0]
            } else {
                0.0
            },
        })
    }

    /// Whether samples so far apart could distinguishes the model from one that is rigid or runs away. An answer to a prescribed
    /// motion may have any k and B.
    pub fn can_show(&self, p: &Coefficients, floor: f64) -> bool {
        let [most_kappa, most_beta] = most(self.input.step);
        let within = p.kappa > floor && p.kappa < most_kappa && p.beta.abs() < most_beta;
        self.record.prescribed || within && p.per_mass > 0.0
    }

    /// Cost, gradient (half) and Gauss-Newton matrix over the first `samples` samples.
    pub fn normal(&self, p: &Coefficients, samples: usize) -> (f64, Local, LocalMatrix) {
        let (measured, valid) = (self.record.output(), &self.record.valid);
        let (mut cost, mut slope) = (0.0, [0.0; PARAMETERS]);
        let mut products = [[0.0; PARAMETERS]; PARAMETERS];
        walk(&self.input, p, samples, |i, z, dz| {
            if valid[i] {
                let r = measured[i] - z;
                cost += r * r;
                for a in 0..PARAMETERS {
                    slope[a] += dz[a] * r;
                    for b in 0..=a {
                        products[a][b] += dz[a] * dz[b];
                    }
                }
            }
        });
        let mut g = Local::from(slope);
        let mut h = LocalMatrix::from_fn(|a, b| products[a][b]);
        for (a, (recorded, weight)) in (4..).zip(self.unseen.into_iter().flatten()) {
            let r = recorded - p.get(Coefficient::ALL[a]);
            cost += weight * r * r;
            g[a] += weight * r;
            h[(a, a)] += weight;
        }
        for a in 0..PARAMETERS {
            for b in 0..a {
                h[(b, a)] = h[(a, b)];
            }
        }
        (cost, g, h)
    }

    pub fn finish(&self, plain: Coefficients, split: &Split, bread: &LocalMatrix) -> AxleFit {
        let n = self.record.output().len();
        let mut residual = Vec::with_capacity(n);
        let mut rows: Vec<[f64; PARAMETERS]> = Vec::with_capacity(split.train.len());
        walk(&self.input, &plain, n, |i, z, dz| {
            residual.push(self.record.output()[i] - z);
            if i < split.train.end {
                rows.push(if self.record.valid[i] {
                    *dz
                } else {
                    [0.0; PARAMETERS]
                });
            }
        });
        let masked: Vec<f64> = (0..split.train.end)
            .map(|i| {
                if self.record.valid[i] {
                    residual[i]
                } else {
                    0.0
                }
            })
            .collect();
        let noise_model = NoiseModel::fit(&masked);
        let columns: Vec<Vec<f64>> = (0..PARAMETERS)
            .map(|q| {
                noise_model.noise_model_transposed(&rows.iter().map(|r| r[q]).collect::<Vec<_>>())
            })
            .collect();
        let meat = LocalMatrix::from_fn(|a, b| {
            noise_model.variance
                * columns[a]
                    .iter()
                    .zip(&columns[b])
                    .map(|(a, b)| a * b)
                    .sum::<f64>()
        });
        let rms = |range: std::ops::Range<usize>| rms_valid(&residual, &self.record.valid, range);
        AxleFit {
            plain,
            covariance: bread * meat * bread,
            train_rms: rms(split.train.clone()),
            held_rms: rms(split.held.clone()),
            residual,
            prescribed: self.record.prescribed,
            undetermined: None,
        }
    }
}

/// RMS of `residual` over the valid samples of `range`; NaN-free: 0 where there is none.
pub fn rms_valid(residual: &[f64], valid: &[bool], range: std::ops::Range<usize>) -> f64 {
    let (mut sum, mut count) = (0.0, 0_usize);
    for i in range {
        if valid[i] {
            sum += residual[i] * residual[i];
            count += 1;
        }
    }
    if count == 0 {
        0.0
    } else {
        (sum / count as f64).sqrt()
    }
}

/// Standard deviation of the valid samples of a range.
pub fn spread_valid(x: &[f64], valid: &[bool], range: std::ops::Range<usize>) -> f64 {
    let known = || range.clone().filter(|i| valid[*i]).map(|i| x[i]);
    let count = known().count().max(1) as f64;
    let mean = known().sum::<f64>() / count;
    (known().map(|x| (x - mean).powi(2)).sum::<f64>() / count).sqrt()
}

impl AxleFit {
    /// k, B and m with standard errors by the delta method.
    pub fn estimate(&self, weighed: bool) -> Estimate {
        let p = &self.plain;
        let m = 1.0 / p.per_mass;
        // How k, B and m change with k/m, B/m and 1/m.
        let by = [
            [m, 0.0, -p.kappa * m * m],
            [0.0, m, -p.beta * m * m],
            [0.0, 0.0, -m * m],
        ];
        let covariance = Estimate::propagated(by, |a, b| self.covariance[(a, b)]);
        let error = |q: usize| std_error(covariance?[q][q]);
        let known = |std: Option<f64>| std.filter(|_| self.undetermined.is_none());
        Estimate {
            k_n_m: p.kappa * m,
            b_n_s_m: p.beta * m,
            k_std_n_m: known(error(0)),
            b_std_n_s_m: known(error(1)),
            k_not_identifiable: self.undetermined.clone(),
            b_not_identifiable: self.undetermined.clone(),
            mass_kg: if self.prescribed { 0.0 } else { m },
            mass_std_kg: match weighed || self.prescribed {
                true => None,
                false => error(2),
            },
            covariance,
            ..Estimate::default()
        }
    }
}

/// Largest k/m (1/s^2) and B/m (1/s, either sign) that samples so far apart (s) could show from an axle that is
/// rigid: a swing in each interval, and a decay in a sixth of one.
pub fn most(step: f64) -> [f64; 2] {
    let fastest = std::f64::consts::TAU / step;
    [fastest * fastest, fastest]
}
