//! Sequentially thresholded least squares (SINDy) on the differentiated recording, the threshold cross-validated.

use super::cross::{Validated, validated};
use super::design::Design;
use super::gram::{Gram, Model};

/// Share of the target's rms that a term must carry; the first lets none pass.
const THRESHOLDS: [f64; 7] = [f64::INFINITY, 0.4, 0.2, 0.1, 0.05, 0.02, 0.01];
const ROUNDS: usize = 12;

pub fn choose(design: &Design) -> Option<Validated> {
    let library = library(design);
    validated(design, |gram| {
        let fit = |threshold: &f64| threshold_fit(gram, design.plain(), &library, *threshold);
        THRESHOLDS.iter().map_while(fit).collect()
    })
}

/// Columns of one candidate per kind: of those with inner parameters the one that by itself leaves least.
fn library(design: &Design) -> Vec<usize> {
    let gram = Gram::without(&design.blocks, None);
    let plain = design.plain();
    let left = |group: usize| {
        let model = gram.fit(&design.with(&plain, group));
        model.map_or(f64::INFINITY, |model| gram.error(&model))
    };
    let all: Vec<f64> = (0..design.groups.len()).map(left).collect();
    let is_best = |&group: &usize| {
        let rivals = (0..all.len()).filter(|&g| design.groups[g].kind == design.groups[group].kind);
        let best = rivals.min_by(|a, b| all[*a].total_cmp(&all[*b]));
        best == Some(group)
    };
    let best = (0..all.len()).filter(is_best);
    best.flat_map(|group| design.with(&[], group)).collect()
}

/// Keeps the plain terms always; drops what carries less than the threshold until nothing changes.
fn threshold_fit(
    gram: &Gram,
    plain: Vec<usize>,
    library: &[usize],
    threshold: f64,
) -> Option<Model> {
    let least = threshold * gram.square().sqrt();
    let base = plain.len();
    let mut model = gram.fit(&[&plain[..], library].concat())?;
    for _ in 0..ROUNDS {
        let terms = model.subset.iter().zip(&model.coefficients);
        let carries = |(column, a): &(&usize, &f64)| **column < base || a.abs() >= least;
        let kept: Vec<usize> = terms.filter(carries).map(|(column, _)| *column).collect();
        if kept.len() == model.subset.len() {
            break;
        }
        model = gram.fit(&kept)?;
    }
    Some(model)
}
