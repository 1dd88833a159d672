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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::effects::Kind;
    use crate::example;
    use veloid_core::bicycle::Axle;

    #[test]
    fn a_fit_goes_on_until_it_hardly_gains_and_ends_at_its_best() {
        let goes = |gains: &'static [f64]| {
            let tried = std::cell::Cell::new(0);
            let again = |best: &f64| {
                let gain = gains.get(tried.replace(tried.get() + 1));
                gain.map(|gain| best + gain)
            };
            (until_still(10.0, |x| *x, again), tried.get())
        };
        assert_eq!(goes(&[4.0, 1.0, 0.0625, 9.0]), (Some(15.0625), 3));
        assert_eq!(goes(&[4.0, -3.0, 9.0]), (Some(14.0), 2));
        // It ends in any case, and without a fit there is none.
        assert_eq!(goes(&[1.0; 9]), (Some(15.0), 5));
        assert_eq!(goes(&[1.0]), (None, 2));
    }

    #[test]
    fn axles_whose_effects_stay_keep_their_fits() {
        let dataset = example::dataset();
        let fitter = example::fitter(&dataset);
        let [front, rear] =
            [Axle::Front, Axle::Rear].map(|axle| example::term(Kind::CubicStiffness, axle));
        let mut known = example::model(&dataset, &[(front, 1e8), (rear, 1e8)]);
        known.fits[0].likelihood = 123.0;
        let effort = Effort {
            iterations: 3,
            gain: 0.1,
            substeps: 2,
        };
        let less = reduce(&fitter, &known, &[front], effort).unwrap();
        assert_eq!(less.terms, [front]);
        assert_eq!(less.fits[0].likelihood, 123.0);
        assert!(less.fits[1].unit.terms.is_empty());
        // What made the rear axle move is the plain model, which leaves nothing.
        let rms = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
        assert!(rms(&less.fits[1].residuals[0]) < 0.01 * dataset.tracks[1].spread());
    }
}
