//! What sets of effects leave of blocks of the ride to which they were not fitted: the judge's evidence.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::fit::{Fit, Frame};
use super::lines::lines;
use super::model::Model;
use super::record::Record;
use super::search::{Found, Search};
use crate::judge::scores::{ScoredLength, ScoredSet, Scores};
use crate::policy;
use crate::search::parts::contiguous;
use veloid_core::bicycle::PerAxle;
use veloid_fourier::{Complex, inverse};
use veloid_model::fit::Term;
use veloid_model::law::Scale;

/// Iterations of a fit from where another frame has led it.
const ITERATIONS: usize = 4;
const EXACT: f64 = 0.1;
/// Rivals that are tried in the place of each of several effects.
const RIVALS: usize = 3;

/// Every set of effects that was tried, and what is left of it.
pub struct Evidence {
    pub scores: Scores,
    /// The effects of `scores`.
    pub terms: Vec<Term>,
    /// The sets of `scores`.
    pub fits: Vec<Fit>,
    /// Share of the other axle's acceleration (squares) that the best of them leaves.
    pub left: f64,
    /// Cost of each set, with what its parameters cost.
    pub charged: Vec<f64>,
}

impl Evidence {
    /// What a set of effects costs, if it was tried.
    pub fn cost(&self, terms: &[Term]) -> Option<f64> {
        let at = self
            .fits
            .iter()
            .position(|fit| fit.model.terms() == terms)?;
        Some(self.charged[at])
    }
}

pub fn evidence(search: &Search, found: &Found) -> Option<Evidence> {
    let (record, scales) = (search.record, search.scales);
    let frame = search.frame(&found.courses, &found.best.model)?;
    let fit = |model: &Model| frame.fit(model, ITERATIONS, EXACT);
    let fits: Vec<Fit> = sets(found).par_iter().filter_map(fit).collect();
    let mut terms: Vec<Term> = fits.iter().flat_map(|fit| fit.model.terms()).collect();
    terms.sort();
    terms.dedup();
    let blocks: Vec<Vec<f64>> = (fits.par_iter())
        .map(|fit| {
            let share = (lines(&frame, &fit.model) / record.values() as f64).exp();
            let blocks = held_out(&frame, &fit.model).unwrap_or_default();
            blocks.iter().map(|b| b * share).collect()
        })
        .collect();
    let (fits, blocks): (Vec<Fit>, Vec<Vec<f64>>) = (fits.into_iter().zip(blocks))
        .filter(|(_, blocks)| blocks.iter().all(|b| b.is_finite()) && !blocks.is_empty())
        .unzip();
    let left = share_left(&frame, &found.best.model)?;
    let is_general = |fit: &Fit| {
        fit.model
            .effects
            .iter()
            .any(|(t, _)| t.kind.spec().is_general)
    };
    let mean = |blocks: &Vec<f64>| blocks.iter().sum::<f64>() / blocks.len() as f64;
    let least = |general: bool| {
        let of = fits
            .iter()
            .zip(&blocks)
            .filter(|(fit, _)| is_general(fit) == general);
        of.map(|(_, blocks)| mean(blocks))
            .fold(f64::INFINITY, f64::min)
    };
    let plain = fits
        .iter()
        .zip(&blocks)
        .find(|(fit, _)| fit.model.effects.is_empty());
    let plain = plain.map_or(f64::INFINITY, |(_, blocks)| mean(blocks));
    for (fit, blocks) in fits.iter().zip(&blocks) {
        tracing::debug!(terms = ?fit.model.terms(), charged = search.charged(fit), left = mean(blocks), "tried");
    }
    // A general law that is ahead by little, or by little beside what it explains, is a name's.
    let cost = |general: bool| {
        let of = fits.iter().filter(|fit| is_general(fit) == general);
        of.map(|fit| search.charged(fit))
            .fold(f64::INFINITY, f64::min)
    };
    let outgrows = least(false) - least(true) >= policy::OUTGROWS * (plain - least(true))
        && cost(false) - cost(true) >= policy::BEHIND;
    let (fits, blocks): (Vec<Fit>, Vec<Vec<f64>>) = (fits.into_iter().zip(blocks))
        .filter(|(fit, _)| outgrows || !is_general(fit))
        .unzip();
    let set = |(fit, blocks): (&Fit, &Vec<f64>)| {
        let own = fit.model.terms();
        ScoredSet {
            effects: (0..terms.len())
                .filter(|t| own.contains(&terms[*t]))
                .collect(),
            parameters: fit.model.slots().len() - fit.model.base.iter().count() * 2,
            is_general: own.iter().any(|term| term.kind.spec().is_general),
            is_physical: is_physical(&fit.model, scales),
            left: vec![blocks.iter().map(|b| b * left).collect()],
        }
    };
    Some(Evidence {
        scores: Scores {
            lengths: vec![ScoredLength {
                length_s: record.segments.iter().map(|s| s.duration()).sum(),
                parts: policy::BLOCKS,
                samples: record.values(),
                noise: 0.0,
            }],
            missed_force: None,
            effects: terms.iter().map(|term| term.kind.id().to_owned()).collect(),
            sets: fits.iter().zip(&blocks).map(set).collect(),
        },
        terms,
        charged: fits
            .iter()
            .map(|fit| search.charged(fit) + lines(&frame, &fit.model))
            .collect(),
        fits,
        left,
    })
}

/// Models that compete: all that were fitted, and the best one without each of its effects, and with others in their places.
fn sets(found: &Found) -> Vec<Model> {
    let mut models = vec![found.plain.model.clone(), found.best.model.clone()];
    models.extend(found.fits.iter().map(|fit| fit.model.clone()));
    let best = &found.best.model;
    if best.effects.len() > 1 {
        for place in 0..best.effects.len() {
            let mut rest = best.clone();
            rest.effects.remove(place);
            let singles = found.fits.iter().filter(|f| f.model.effects.len() == 1);
            let rivals = singles.map(|f| f.model.effects[0]);
            let others = rivals.filter(|(term, _)| !best.terms().contains(term));
            models.extend(
                others
                    .take(RIVALS)
                    .map(|(term, values)| rest.with(term, values)),
            );
            models.push(rest);
        }
    }
    let mut kept: Vec<Model> = Vec::new();
    for model in models {
        if kept.iter().all(|other| other.terms() != model.terms()) {
            kept.push(model);
        }
    }
    kept
}

pub fn is_physical(model: &Model, scales: &PerAxle<Scale>) -> bool {
    model.effects.iter().all(|(term, values)| {
        let scale = scales.get(super::model::axle_of(term));
        scale.is_some_and(|scale| {
            (term.kind.spec().report)(values, scale)
                .iter()
                .all(|p| p.physical)
        })
    })
}

/// Mean square of each block, to which the model was not fitted, in units of the noise: of the fit without a block the first step from
/// the whole fit is taken, which is exact where the model is linear in its numbers.
fn held_out(frame: &Frame, model: &Model) -> Option<Vec<f64>> {
    let record = frame.predictor.record;
    let predicted = frame.predictor.spectra(std::slice::from_ref(model)).pop()?;
    let (_, models, steps) = frame.varied(model);
    let others = frame.predictor.spectra(&models);
    let jacobian = frame.directions(&predicted, &others, &steps);
    let residual = frame.column(&frame.left(&predicted).residuals);
    let mut columns: Vec<DVector<f64>> = vec![along(record, &residual)];
    columns.extend(
        jacobian
            .column_iter()
            .map(|c| along(record, &c.into_owned())),
    );
    let samples = columns[0].len();
    let blocks: Vec<Range<usize>> = contiguous(samples, policy::BLOCKS).collect();
    let part =
        |of: &DVector<f64>, block: &Range<usize>| of.rows(block.start, block.len()).into_owned();
    let own: Vec<(DMatrix<f64>, DVector<f64>)> = (blocks.iter())
        .map(|block| {
            let j: Vec<DVector<f64>> = columns[1..].iter().map(|c| part(c, block)).collect();
            (DMatrix::from_columns(&j), part(&columns[0], block))
        })
        .collect();
    let normal = |(j, _): &(DMatrix<f64>, DVector<f64>)| j.tr_mul(j);
    let all = own.iter().map(normal).reduce(|a, b| a + b)?;
    let toward = |(j, r): &(DMatrix<f64>, DVector<f64>)| j.tr_mul(r);
    let gradient = own.iter().map(toward).reduce(|a, b| a + b)?;
    let scale = window_share(record);
    own.iter()
        .map(|block| {
            let mut rest = &all - normal(block);
            for i in 0..rest.nrows() {
                rest[(i, i)] += 1e-6 * (all[(i, i)] + 1e-9);
            }
            // Where the whole fit has not come to its end, the step of the whole is not counted.
            let start = (all.clone() + DMatrix::identity(all.nrows(), all.nrows()) * 1e-9)
                .cholesky()?
                .solve(&gradient);
            let step = rest.cholesky()?.solve(&(&gradient - toward(block))) - start;
            let left = &block.1 - &block.0 * step;
            Some(left.norm_squared() / (block.1.len() as f64 * scale))
        })
        .collect()
}

/// Part of a segment's time that its window lets through.
fn window_share(record: &Record) -> f64 {
    let of = |s: &super::record::Segment| {
        s.window.iter().map(|w| w * w).sum::<f64>() / s.window.len() as f64
    };
    record.segments.iter().map(of).sum::<f64>() / record.segments.len() as f64
}

/// A whitened column along the ride: the lines of each segment, brought down to zero, as a record of twice their number.
fn along(record: &Record, column: &DVector<f64>) -> DVector<f64> {
    let lines = record.lines.len();
    let length = 2 * lines + 2;
    let back = inverse(length);
    let mut all = Vec::with_capacity(record.segments.len() * length);
    for s in 0..record.segments.len() {
        let mut spectrum = back.make_input_vec();
        let first = s * 2 * lines;
        for k in 0..lines {
            spectrum[k + 1] = Complex::new(column[first + k], column[first + lines + k]);
        }
        if let Some(last) = spectrum.last_mut() {
            last.im = 0.0;
        }
        let mut out = back.make_output_vec();
        if back.process(&mut spectrum, &mut out).is_err() {
            out.fill(f64::NAN);
        }
        // Of unit variance as the lines are.
        let scale = 1.0 / (2.0 * lines as f64).sqrt() / std::f64::consts::SQRT_2;
        all.extend(out.iter().map(|x| x * scale));
    }
    DVector::from_vec(all)
}

/// Share of the acceleration (squares) that a model leaves.
fn share_left(frame: &Frame, model: &Model) -> Option<f64> {
    let predicted = frame.predictor.spectra(std::slice::from_ref(model)).pop()?;
    let left = frame.left(&predicted).residuals;
    let power = |x: &[Complex<f64>]| x.iter().map(|x| x.norm_sqr()).sum::<f64>();
    let all: f64 = frame
        .predictor
        .record
        .segments
        .iter()
        .map(|s| power(&s.measured))
        .sum();
    let rest: f64 = left.iter().map(|x| power(x)).sum();
    Some(rest / all.max(f64::MIN_POSITIVE))
}
