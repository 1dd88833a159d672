//! Parts of one axle's record: models are fitted to some of them and judged on others.

use std::ops::Range;

use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_model::dataset::Dataset;
use veloid_model::fit::shooting::{Shooting, Shot};
use veloid_model::fit::{Effort, Fitter, Point, Unit};

/// Times the steps of a fit to windows that one of the whole record may take, where laws with corners make them small, and the gain of
/// a step (of the squares' half) below which it ends.
const TIMES: usize = 3;
const GAIN: f64 = 1e-3;
/// Parts on which starts are tried.
const TRIED_ON: usize = 10;

/// Windows, each with a start of its own, or blocks of one simulation of the whole record.
pub enum Parts<'a> {
    Windows(Shooting<'a>),
    Blocks(Blocks<'a>),
}

impl Parts<'_> {
    pub fn count(&self) -> usize {
        match self {
            Self::Windows(shooting) => shooting.spans.len(),
            Self::Blocks(blocks) => blocks.spans.len(),
        }
    }

    /// Parts on which starts are tried, spread evenly.
    pub fn some(&self) -> Vec<usize> {
        let all = self.count();
        match all > TRIED_ON {
            true => (0..TRIED_ON).map(|i| i * all / TRIED_ON).collect(),
            false => (0..all).collect(),
        }
    }

    /// Steps of a fit that takes so many to windows.
    pub fn steps(&self, of_windows: usize) -> usize {
        match self {
            Self::Windows(_) => of_windows,
            Self::Blocks(_) => TIMES * of_windows,
        }
    }

    /// Fits from `start` to the given parts.
    pub fn fit(&self, unit: &Unit, start: &Point, parts: &[usize], steps: usize) -> Option<Shot> {
        match self {
            Self::Windows(shooting) => shooting.fit(unit, start, parts, steps),
            Self::Blocks(blocks) => blocks.fit(unit, start, parts, steps),
        }
    }

    /// What a model leaves of parts to which it was not fitted, beside the record's variance.
    pub fn held_out(&self, unit: &Unit, point: &Point, parts: &[usize]) -> Vec<f64> {
        match self {
            Self::Windows(shooting) => shooting.held_out(unit, point, parts),
            Self::Blocks(blocks) => blocks.held_out(unit, point, parts),
        }
    }
}

/// Blocks of a record that is simulated as a whole, from one start.
pub struct Blocks<'a> {
    dataset: &'a Dataset,
    track: usize,
    spans: Vec<Range<usize>>,
    white: Vec<NoiseModel>,
    /// The record's variance (m^2 or N^2).
    variance: f64,
}

impl<'a> Blocks<'a> {
    /// `count` blocks of the record of one axle, whose noise is white.
    pub fn new(dataset: &'a Dataset, track: usize, count: usize, white: NoiseModel) -> Self {
        Self {
            dataset,
            track,
            spans: contiguous(dataset.samples, count).collect(),
            white: vec![white],
            variance: dataset.tracks[track]
                .spread()
                .powi(2)
                .max(f64::MIN_POSITIVE),
        }
    }

    fn fit(&self, unit: &Unit, start: &Point, parts: &[usize], steps: usize) -> Option<Shot> {
        let mut dataset = self.dataset.clone();
        for (part, span) in self.spans.iter().enumerate() {
            if !parts.contains(&part) {
                dataset.tracks[self.track].valid[span.clone()].fill(false);
            }
        }
        let fitter = Fitter {
            dataset: &dataset,
            samples: dataset.samples,
        };
        let effort = Effort {
            iterations: steps,
            gain: GAIN,
            substeps: unit.fine_substeps(&dataset, start),
        };
        let point = (fitter.fit(unit, start.clone(), &self.white, effort)?).point;
        let left = mean(&self.held_out(unit, &point, parts));
        left.is_finite().then_some(Shot { point, left })
    }

    fn held_out(&self, unit: &Unit, point: &Point, parts: &[usize]) -> Vec<f64> {
        let last = parts.iter().copied().max();
        let fitter = Fitter {
            dataset: self.dataset,
            samples: last.map_or(0, |last| self.spans[last].end),
        };
        let substeps = unit.fine_substeps(self.dataset, point);
        let mut residuals = fitter.residuals(unit, point, substeps);
        let residual = residuals.swap_remove(0);
        let valid = &self.dataset.tracks[self.track].valid;
        let of_part = |part: &usize| {
            let own = self.spans[*part].clone().filter(|i| valid[*i]);
            let squares: Vec<f64> = own.map(|i| residual[i] * residual[i]).collect();
            let left = mean(&squares) / self.variance;
            if left.is_nan() { f64::INFINITY } else { left }
        };
        parts.iter().map(of_part).collect()
    }
}

/// So many things in groups of neighbours, alike in size.
pub fn contiguous(things: usize, groups: usize) -> impl Iterator<Item = Range<usize>> {
    (0..groups).map(move |g| g * things / groups..(g + 1) * things / groups)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;

    #[test]
    fn the_first_blocks_are_judged_without_those_after_them() {
        let dataset = example::dataset();
        let fit = &example::model(&dataset, &[]).fits[0];
        let parts = Parts::Blocks(Blocks::new(&dataset, 0, 10, NoiseModel::white(1.0)));
        let all: Vec<usize> = (0..parts.count()).collect();
        let held_out = |of: &[usize]| parts.held_out(&fit.unit, &fit.point, of);
        assert_eq!(held_out(&all[..4]), held_out(&all)[..4]);
    }
}
