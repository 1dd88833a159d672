//! The likelihood of what a model leaves, in bands of unknown noise, and its maximum.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::model::{Model, Slot};
use super::nuisance::{Corrections, Course, Nuisance, column, columns, whitened};
use super::predict::{Predictor, Spectra};
use super::record::Record;
use veloid_core::bicycle::PerAxle;
use veloid_fourier::Complex;
use veloid_model::law::Scale;

/// Steps of a slot for its derivative, and at most in one iteration.
const DIFFERENCE: f64 = 1e-3;
const OF_SIZE: f64 = 0.01;
const FURTHEST: f64 = 0.3;
const SIZES: f64 = 3.0;
/// Damping (Levenberg-Marquardt) at the beginning, and what is tried at once in one iteration.
const DAMPING: f64 = 1e-3;
const TRIED: [f64; 4] = [1e-4, 1e-2, 1.0, 100.0];
/// Iterations between which the noise is estimated anew.
const INNER: usize = 3;

/// Under one noise, with the nuisances where they were last settled.
#[derive(Clone)]
pub struct Frame<'a> {
    pub predictor: Predictor<'a>,
    pub noise: Vec<f64>,
    nuisances: Vec<Nuisance>,
}

/// A fitted model.
#[derive(Clone, Debug)]
pub struct Fit {
    pub model: Model,
    /// -2 ln L, less what the prior charges.
    pub cost: f64,
    /// Covariance of the slots, in their sizes.
    pub covariance: DMatrix<f64>,
}

/// What a model leaves by segment, without what the nuisances explain.
pub struct Left {
    pub residuals: Spectra,
    pub cost: f64,
}

impl<'a> Frame<'a> {
    /// Around a model: the noise is what it leaves.
    pub fn around(
        record: &'a Record,
        scales: &'a PerAxle<Scale>,
        courses: &'a [Course],
        model: &Model,
    ) -> Option<Self> {
        let predictor = Predictor {
            record,
            scales,
            courses,
        };
        let mut predicted = Vec::new();
        let mut nuisances_of = Vec::new();
        for (s, segment) in record.segments.iter().enumerate() {
            let a = predictor.ridden(std::slice::from_ref(model), s).other.a;
            predicted.push(predictor.spectrum_of(segment, &a, 0));
            let a: Vec<f64> = a.iter().map(|a| a.0[0]).collect();
            nuisances_of.push(Arc::new(columns(record, segment, &a)));
        }
        let noise = noise(record, &predictor.residuals(&predicted))?;
        let nuisances = (nuisances_of.into_iter().zip(&record.segments).zip(courses))
            .map(|((columns, segment), course)| Nuisance::new(columns, segment, course, &noise));
        let mut frame = Frame {
            predictor,
            nuisances: nuisances.collect::<Option<Vec<_>>>()?,
            noise,
        };
        // What the nuisances explain is no noise, which the first estimate of it contains.
        for _ in 0..2 {
            let residuals = frame.left(&predicted).residuals;
            frame.renewed(&residuals)?;
        }
        Some(frame)
    }

    fn record(&self) -> &Record {
        self.predictor.record
    }

    /// The same under the noise that a model leaves.
    fn renewed(&mut self, residuals: &Spectra) -> Option<()> {
        let noise = noise(self.record(), residuals)?;
        let segments = self.record().segments.iter();
        let nuisances = (self
            .nuisances
            .iter()
            .zip(segments)
            .zip(self.predictor.courses))
        .map(|((nuisance, segment), course)| nuisance.under(segment, course, &noise));
        self.nuisances = nuisances.collect::<Option<Vec<_>>>()?;
        self.noise = noise;
        Some(())
    }

    /// What a prediction leaves.
    pub fn left(&self, predicted: &Spectra) -> Left {
        let raw = self.predictor.residuals(predicted);
        let mut charged = 0.0;
        let mut residuals = Vec::new();
        for (s, residual) in raw.iter().enumerate() {
            let (corrections, charge) = self.corrections(s, residual);
            charged += charge;
            residuals.push(self.nuisances[s].without(
                residual,
                &corrections,
                &self.predictor.courses[s],
            ));
        }
        Left {
            cost: level(self.record(), &residuals) + charged,
            residuals,
        }
    }

    fn corrections(&self, s: usize, residual: &[Complex<f64>]) -> (Corrections, f64) {
        self.nuisances[s].corrections(&whitened(residual, &self.noise))
    }

    /// Courses that follow what a model wants.
    pub fn settled(&self, model: &Model) -> Option<Vec<Course>> {
        let predicted = self.predictor.spectra(std::slice::from_ref(model)).pop()?;
        let raw = self.predictor.residuals(&predicted);
        let mut courses = self.predictor.courses.to_vec();
        for (s, residual) in raw.iter().enumerate() {
            let (corrections, _) = self.corrections(s, residual);
            let segment = &self.record().segments[s];
            self.nuisances[s].settle(&mut courses[s], segment, &corrections);
        }
        Some(courses)
    }

    /// Whitened differences of predictions to a first one, without what the nuisances do, one column each.
    pub fn directions(&self, first: &Spectra, others: &[Spectra], steps: &[f64]) -> DMatrix<f64> {
        let lines = self.record().lines.len();
        let rows = 2 * lines;
        let mut all = DMatrix::zeros(rows * first.len(), others.len());
        for (s, own) in first.iter().enumerate() {
            let gain = self.predictor.courses[s].gain;
            let column = |(other, step): (&Spectra, &f64)| {
                let moved: Vec<Complex<f64>> = (other[s].iter().zip(own))
                    .map(|(b, a)| (b - a) * (gain / step))
                    .collect();
                whitened(&moved, &self.noise)
            };
            let columns: Vec<DVector<f64>> = others.iter().zip(steps).map(column).collect();
            let projected = self.nuisances[s].project(&DMatrix::from_columns(&columns));
            all.view_mut((s * rows, 0), (rows, others.len()))
                .copy_from(&projected);
        }
        all
    }

    /// Residuals as one whitened column.
    pub fn column(&self, residuals: &Spectra) -> DVector<f64> {
        column(residuals, &self.noise)
    }

    /// Each slot moved a little, with the steps that were taken.
    pub fn varied(&self, model: &Model) -> (Vec<Slot>, Vec<Model>, Vec<f64>) {
        let slots = model.slots();
        let scales = self.predictor.scales;
        let step = |slot: &Slot| match slot {
            Slot::Base(..) => DIFFERENCE,
            Slot::Value(..) => OF_SIZE,
        };
        let mut steps = Vec::new();
        let mut models = Vec::new();
        for slot in &slots {
            let ahead = model.moved(*slot, step(slot), scales);
            // At its upper limit a number only moves back.
            let (other, taken) = match ahead == *model {
                true => (model.moved(*slot, -step(slot), scales), -step(slot)),
                false => (ahead, step(slot)),
            };
            models.push(other);
            steps.push(taken);
        }
        (slots, models, steps)
    }

    /// The most likely model from a start.
    pub fn fit(&self, start: &Model, iterations: usize, enough: f64) -> Option<Fit> {
        let mut frame = self.clone();
        frame.fitted(start, iterations, enough)
    }

    fn fitted(&mut self, start: &Model, iterations: usize, enough: f64) -> Option<Fit> {
        let mut model = start.clone();
        let mut damping = DAMPING;
        let predicted = self.predictor.spectra(std::slice::from_ref(&model)).pop()?;
        let mut left = self.left(&predicted);
        self.renewed(&left.residuals)?;
        left = self.left(&predicted);
        let mut predicted = predicted;
        let mut covariance = DMatrix::zeros(0, 0);
        for iteration in 0..iterations {
            if iteration > 0 && iteration % INNER == 0 {
                self.renewed(&left.residuals)?;
                left = self.left(&predicted);
            }
            let (slots, models, steps) = self.varied(&model);
            let others = self.predictor.spectra(&models);
            let jacobian = self.directions(&predicted, &others, &steps);
            let normal = jacobian.tr_mul(&jacobian);
            let gradient = jacobian.tr_mul(&self.column(&left.residuals));
            covariance = inverse_of(&normal);
            let tried = TRIED.iter().filter_map(|tried| {
                let step = damped(&normal, &gradient, damping * tried / TRIED[0])?;
                Some(self.stepped(&model, &slots, &step))
            });
            let mut models: Vec<Model> = tried.collect();
            let tried = self.predictor.spectra(&models);
            let found: Vec<Left> = tried.iter().map(|p| self.left(p)).collect();
            let leads = (0..found.len()).filter(|i| found[*i].cost.is_finite());
            let Some(best) = leads.min_by(|a, b| found[*a].cost.total_cmp(&found[*b].cost)) else {
                break;
            };
            let gained = left.cost - found[best].cost;
            if gained <= 0.0 {
                break;
            }
            damping = (damping * TRIED[best] / TRIED[0] / 10.0).clamp(1e-6, 1e3);
            model = models.swap_remove(best);
            predicted = tried.into_iter().nth(best)?;
            left = found.into_iter().nth(best)?;
            if gained < enough && iteration + 1 >= INNER {
                break;
            }
        }
        self.renewed(&left.residuals)?;
        let left = self.left(&predicted);
        left.cost.is_finite().then_some(Fit {
            model,
            cost: left.cost,
            covariance,
        })
    }

    fn stepped(&self, model: &Model, slots: &[Slot], step: &DVector<f64>) -> Model {
        let mut next = model.clone();
        for (slot, by) in slots.iter().zip(step.iter()) {
            let most = match slot {
                Slot::Base(..) => FURTHEST,
                Slot::Value(..) => SIZES,
            };
            next = next.moved(*slot, by.clamp(-most, most), self.predictor.scales);
        }
        next
    }
}

impl Predictor<'_> {
    fn residuals(&self, predicted: &Spectra) -> Spectra {
        let of = |(s, p): (usize, &Vec<Complex<f64>>)| {
            self.courses[s].residual(&self.record.segments[s].measured, p)
        };
        predicted.iter().enumerate().map(of).collect()
    }
}

/// Power in each band, at every line; nothing where there is none.
pub fn noise(record: &Record, residuals: &Spectra) -> Option<Vec<f64>> {
    let mut noise = vec![0.0; record.lines.len()];
    for band in &record.bands {
        let power = power(residuals, band);
        if !(power.is_finite() && power > 0.0) {
            return None;
        }
        noise[band.clone()].fill(power);
    }
    Some(noise)
}

fn power(residuals: &Spectra, band: &std::ops::Range<usize>) -> f64 {
    let of = |r: &Vec<Complex<f64>>| r[band.clone()].iter().map(|x| x.norm_sqr()).sum::<f64>();
    residuals.iter().map(of).sum::<f64>() / (residuals.len() * band.len()) as f64
}

/// -2 ln L of residuals whose power in each band is unknown.
pub fn level(record: &Record, residuals: &Spectra) -> f64 {
    let of = |band: &std::ops::Range<usize>| {
        let count = (residuals.len() * band.len()) as f64;
        2.0 * count * power(residuals, band).ln()
    };
    record.bands.iter().map(of).sum()
}

fn damped(normal: &DMatrix<f64>, gradient: &DVector<f64>, damping: f64) -> Option<DVector<f64>> {
    let mut matrix = normal.clone();
    for i in 0..matrix.nrows() {
        matrix[(i, i)] += damping * (matrix[(i, i)] + 1e-9);
    }
    Some(matrix.cholesky()?.solve(gradient))
}

/// Infinite where the numbers are not determined.
fn inverse_of(normal: &DMatrix<f64>) -> DMatrix<f64> {
    let size = normal.nrows();
    let inverse = normal.clone().cholesky().map(|c| c.inverse());
    inverse.unwrap_or_else(|| DMatrix::from_diagonal_element(size, size, f64::INFINITY))
}
