//! A set of effects fitted again: with fewer terms, or until nothing moves.

use rayon::prelude::*;

use super::damped::Effort;
use super::fitter::{Fitted, Fitter};
use super::model::Model;
use super::unit::{Term, Unit};

/// Fits the model with fewer terms than `known` has, starting from there; units that do not change
/// are kept.
pub fn reduce(fitter: &Fitter, known: &Model, terms: &[Term], effort: Effort) -> Option<Model> {
    let fits = Unit::all(fitter.dataset, terms)
        .into_iter()
        .map(|unit| match known.fits.iter().find(|f| f.unit == unit) {
            Some(same) => Some(same.clone()),
            None => {
                let (point, noise_models) = known.carried(&unit);
                fitter.fit(&unit, point, &noise_models, effort)
            }
        })
        .collect::<Option<Vec<_>>>()?;
    Some(Model::new(terms.to_vec(), fits))
}

/// Fits every unit again from where it is, in turns with its own noise model, until neither moves.
pub fn polish(fitter: &Fitter, model: &Model, effort: Effort) -> Option<Model> {
    let fits = model
        .fits
        .par_iter()
        .map(|f| {
            let again = |f: &Fitted| fitter.fit(&f.unit, f.point.clone(), &f.noise_models, effort);
            until_still(f.clone(), |f| f.likelihood, again)
        })
        .collect::<Option<Vec<_>>>()?;
    Some(Model::new(model.terms.clone(), fits))
}

/// Fits again from where a fit is until its likelihood does not move; the likeliest of all.
pub fn until_still<T>(
    mut best: T,
    likelihood: impl Fn(&T) -> f64,
    again: impl Fn(&T) -> Option<T>,
) -> Option<T> {
    for _ in 0..5 {
        let next = again(&best)?;
        let gained = likelihood(&next) - likelihood(&best);
        if gained > 0.0 {
            best = next;
        }
        if gained < 0.1 {
            break;
        }
    }
    Some(best)
}
