//! Pairs of axles by the ratio of their spectra: plain ones, and with a second mass on one of them.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::fit::{level, noise};
use super::model::{BETA, Base, KAPPA, Model};
use super::nuisance::{Course, column};
use super::predict::Spectra;
use super::record::{Record, Segment, spectrum};
use veloid_core::bicycle::Axle;
use veloid_core::numerics::lanes::Lanes;
use veloid_fourier::Complex;
use veloid_model::effects::Kind;
use veloid_model::fit::Term;
use veloid_model::law::padded;
use veloid_report::diagnosis::Place;

/// k/m (1/s^2) and B/m (1/s) of starts: light wheels and heavy ones on soft and hard tyres.
const STARTS: [[f64; 4]; 6] = [
    [4000.0, 30.0, 1500.0, 10.0],
    [2500.0, 15.0, 1000.0, 5.0],
    [6500.0, 50.0, 2500.0, 18.0],
    [4000.0, 15.0, 2500.0, 18.0],
    [2500.0, 40.0, 1500.0, 5.0],
    [1500.0, 12.0, 4000.0, 30.0],
];
/// Delays (s) that starts are tried with.
const DELAYS: [f64; 3] = [0.0, -6e-3, 6e-3];
/// Limits of the delay (s) and the gain.
const MOST_DELAY: f64 = 0.03;
const GAINS: [f64; 2] = [0.8, 1.2];
const ITERATIONS: usize = 40;
/// Starts of a second mass: its share, its frequency (Hz) and its damping ratio; and their limits.
const MASSES: [[f64; 3]; 3] = [[0.4, 2.5, 0.3], [0.4, 5.0, 0.3], [0.2, 12.0, 0.1]];
const OF_MASS: [[f64; 2]; 3] = [[1e-3, 0.9], [0.3, 40.0], [0.01, 2.0]];
/// Plain starts beside which a second mass is started: a soft pair, a hard one, and one with a light rear wheel.
const BESIDE: [usize; 3] = [0, 2, 5];

/// Logarithms of k/m, B/m of the leading and the other axle, delay (s), gain, logarithms of the second mass's numbers.
type Unknowns = [f64; 9];

/// A pair that fits the spectra.
#[derive(Clone, Debug)]
pub struct Pair {
    pub cost: f64,
    /// Whether the leading axle bears a second mass, or the other one does.
    second_on_lead: Option<bool>,
    x: Unknowns,
}

impl Pair {
    /// Delay (s) and ratio of the gains.
    pub fn nuisances(&self) -> [f64; 2] {
        [self.x[4], self.x[5]]
    }

    pub fn model(&self, record: &Record) -> Model {
        let base = |at: usize| -> Base { [self.x[at], self.x[at + 1]] };
        let (lead, other) = (base(0), base(2));
        let plain = match record.lead {
            Axle::Front => Model::new(lead, other),
            Axle::Rear => Model::new(other, lead),
        };
        let axle = match self.second_on_lead {
            Some(true) => record.lead,
            Some(false) => record.other(),
            None => return plain,
        };
        let term = Term {
            kind: Kind::SprungMass,
            place: Place::from(axle),
        };
        let [share, hertz, damping] = self.second();
        plain.with(term, padded([share, hertz, damping]))
    }

    /// Share, frequency (Hz) and damping ratio of the second mass.
    fn second(&self) -> [f64; 3] {
        [6, 7, 8].map(|i| self.x[i].exp())
    }

    fn unknowns(&self) -> usize {
        match self.second_on_lead {
            None => 6,
            Some(_) => 9,
        }
    }

    fn limited(mut self) -> Self {
        for i in 0..4 {
            let [low, high] = if i % 2 == 0 { KAPPA } else { BETA };
            self.x[i] = self.x[i].clamp(low.ln(), high.ln());
        }
        self.x[4] = self.x[4].clamp(-MOST_DELAY, MOST_DELAY);
        self.x[5] = self.x[5].clamp(GAINS[0], GAINS[1]);
        for (x, [low, high]) in self.x[6..].iter_mut().zip(OF_MASS) {
            *x = x.clamp(low.ln(), high.ln());
        }
        self
    }
}

/// z/u of an axle, with a second mass of a share, a frequency (Hz) and a damping ratio.
fn transfer(w: f64, [kappa, beta]: [f64; 2], second: Option<[f64; 3]>) -> Complex<f64> {
    let force = Complex::new(kappa, w * beta);
    let inertia = match second {
        None => Complex::new(1.0, 0.0),
        Some([share, hertz, damping]) => {
            let own = TAU * hertz;
            let pull = Complex::new(own * own, 2.0 * damping * own * w);
            pull / (pull - w * w) * share + (1.0 - share)
        }
    };
    force / (force - inertia * (w * w))
}

/// The leading axle's spectra brought to the other's time.
pub struct Shifted<'a> {
    record: &'a Record,
    spectra: Spectra,
}

impl<'a> Shifted<'a> {
    pub fn new(record: &'a Record) -> Self {
        let shifted = |segment: &Segment| {
            let course = Course::new(segment, record.lines.len());
            let a: Vec<Lanes> = segment.lead.a.iter().map(|a| Lanes::all(*a)).collect();
            // An acceleration goes with the square of the speeds' ratio, a rate with the ratio.
            let under = course.with_ratio(course.under(&a));
            let values = under.iter().zip(&segment.window).map(|(a, w)| a.0[0] * w);
            spectrum(
                &*record.fourier,
                values.collect(),
                &record.lines,
                segment.over,
            )
        };
        Self {
            record,
            spectra: record.segments.iter().map(shifted).collect(),
        }
    }

    /// Plain pairs, the best first.
    pub fn plain(&self) -> Vec<Pair> {
        let delayed = |pair: Pair| {
            DELAYS.map(|delay| {
                let mut pair = pair.clone();
                pair.x[4] = delay;
                pair
            })
        };
        let starts = STARTS.iter().map(|s| self.begun(s));
        self.sorted(starts.flat_map(delayed).collect())
    }

    /// The best pair with a second mass on either axle. Its k and B may be far from those of the best plain pair.
    pub fn with_second_mass(&self, plain: &Pair) -> Vec<Pair> {
        let best = |on_lead: bool| {
            let bases = BESIDE.iter().map(|i| self.begun(&STARTS[*i]));
            let with = |pair: Pair| {
                MASSES.map(|second| {
                    let mut pair = pair.clone();
                    pair.second_on_lead = Some(on_lead);
                    pair.x[6..].copy_from_slice(&second.map(f64::ln));
                    pair
                })
            };
            let starts = std::iter::once(plain.clone()).chain(bases).flat_map(with);
            self.sorted(starts.collect()).into_iter().next()
        };
        [true, false].into_iter().filter_map(best).collect()
    }

    fn begun(&self, start: &[f64; 4]) -> Pair {
        let [a, b, c, d] = start.map(f64::ln);
        let base = match self.record.lead {
            Axle::Front => [a, b, c, d],
            Axle::Rear => [c, d, a, b],
        };
        let mut x = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];
        x[..4].copy_from_slice(&base);
        Pair {
            cost: f64::INFINITY,
            second_on_lead: None,
            x,
        }
    }

    fn sorted(&self, starts: Vec<Pair>) -> Vec<Pair> {
        let fitted = starts.into_par_iter().map(|start| self.fitted(start));
        let mut found: Vec<Pair> = fitted.filter(|pair| pair.cost.is_finite()).collect();
        found.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        found
    }

    fn left(&self, pair: &Pair) -> Spectra {
        let record = self.record;
        let x = &pair.x;
        let [lead, other] = [[x[0].exp(), x[1].exp()], [x[2].exp(), x[3].exp()]];
        let second = |on_lead| (pair.second_on_lead == Some(on_lead)).then(|| pair.second());
        let filter: Vec<Complex<f64>> = (0..record.lines.len())
            .map(|k| {
                let w = TAU * record.hz(k);
                let turn = Complex::new(0.0, -w * x[4]).exp();
                transfer(w, other, second(false)) / transfer(w, lead, second(true)) * turn * x[5]
            })
            .collect();
        (record.segments.iter().zip(&self.spectra))
            .map(|(segment, shifted)| {
                (segment.measured.iter().zip(shifted).zip(&filter))
                    .map(|((m, s), f)| m - s * f)
                    .collect()
            })
            .collect()
    }

    fn fitted(&self, start: Pair) -> Pair {
        let mut pair = start.limited();
        let mut residuals = self.left(&pair);
        pair.cost = level(self.record, &residuals);
        let mut damping = 1e-2;
        for _ in 0..ITERATIONS {
            let Some((normal, gradient)) = self.gradient(&pair, &residuals) else {
                break;
            };
            let mut better = None;
            for _ in 0..4 {
                let mut matrix = normal.clone();
                for i in 0..matrix.nrows() {
                    matrix[(i, i)] += damping * (matrix[(i, i)] + 1e-9);
                }
                let Some(step) = matrix.cholesky().map(|c| c.solve(&gradient)) else {
                    break;
                };
                let mut next = pair.clone();
                for (x, step) in next.x.iter_mut().zip(step.iter()) {
                    *x += step.clamp(-0.5, 0.5);
                }
                next = next.limited();
                let trial = self.left(&next);
                next.cost = level(self.record, &trial);
                if next.cost < pair.cost {
                    better = Some((next, trial));
                    break;
                }
                damping *= 10.0;
            }
            let Some((next, trial)) = better else {
                break;
            };
            let gained = pair.cost - next.cost;
            (pair, residuals) = (next, trial);
            damping = f64::max(damping / 10.0, 1e-5);
            if gained < 0.05 {
                break;
            }
        }
        pair
    }

    fn gradient(&self, pair: &Pair, residuals: &Spectra) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let noise = noise(self.record, residuals)?;
        let r = column(residuals, &noise);
        let columns: Vec<DVector<f64>> = (0..pair.unknowns())
            .map(|i| {
                let mut moved = pair.clone();
                moved.x[i] += 1e-5;
                (&r - column(&self.left(&moved), &noise)) / 1e-5
            })
            .collect();
        let jacobian = DMatrix::from_columns(&columns);
        Some((jacobian.tr_mul(&jacobian), jacobian.tr_mul(&r)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Far below its own frequency a second mass moves along, far above it does not move.
    #[test]
    fn a_second_mass_counts_below_its_frequency() {
        let axle = [4000.0, 20.0];
        let with = |w| transfer(w, axle, Some([0.4, 5.0, 0.2]));
        let slow = with(0.5) - transfer(0.5, axle, None);
        assert!(slow.norm() < 1e-4, "{slow}");
        let lighter = transfer(5000.0, axle.map(|x| x / 0.6), None);
        assert!((with(5000.0) / lighter - 1.0).norm() < 1e-2);
    }
}
