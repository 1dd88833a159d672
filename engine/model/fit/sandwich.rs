//! Standard errors that do not rest on the noise model: where blocks of the record pull at the parameters harder than the likelihood says,
//! its covariance is widened (White 1982, doi:10.2307/1912526; sums over blocks as Newey & West 1987, doi:10.2307/1913610, need them).

use nalgebra::DMatrix;

use super::fitter::{Fitted, Fitter};
use super::model::{FINE, Model};
use super::normal_equations::Equations;

/// Contiguous blocks of the fitted part.
const BLOCKS: usize = 20;

/// A model with errors no smaller than blocks of the record say of the same model as it was `searched`.
pub fn widened(fitter: &Fitter, searched: &Model, model: Model) -> Model {
    let substeps = searched.substeps(fitter.dataset, FINE);
    let fits = searched.fits.iter().zip(model.fits).map(|(searched, fit)| {
        let factors = factors(
            &searched.covariance,
            &between_blocks(fitter, searched, substeps),
        );
        Fitted {
            covariance: wider(&fit.covariance, &factors),
            ..fit
        }
    });
    Model::new(model.terms, fits.collect())
}

/// Covariance of the parameters from what each block pulls at them.
fn between_blocks(fitter: &Fitter, fit: &Fitted, substeps: usize) -> DMatrix<f64> {
    let slots = fit.unit.slots(fitter.dataset);
    let equations = Equations {
        dataset: fitter.dataset,
        samples: fitter.samples,
        unit: &fit.unit,
        slots: &slots,
        point: &fit.point,
        noise_models: &fit.noise_models,
        substeps,
    };
    let mut squares = DMatrix::zeros(slots.len(), slots.len());
    for score in equations.scores(BLOCKS) {
        squares += &score * score.transpose();
    }
    let few = BLOCKS as f64 / (BLOCKS - 1) as f64;
    &fit.covariance * squares * &fit.covariance * few
}

/// How much larger the standard errors of another covariance are, 1 where they are not.
fn factors(covariance: &DMatrix<f64>, other: &DMatrix<f64>) -> Vec<f64> {
    let factor = |i: usize| {
        let ratio = other[(i, i)] / covariance[(i, i)];
        match ratio.is_finite() {
            true => ratio.max(1.0).sqrt(),
            false => 1.0,
        }
    };
    (0..covariance.nrows()).map(factor).collect()
}

/// A covariance with its correlations, and standard errors so many times larger.
fn wider(covariance: &DMatrix<f64>, factors: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(covariance.nrows(), covariance.ncols(), |i, j| {
        covariance[(i, j)] * factors[i] * factors[j]
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use rand::SeedableRng;

    use super::*;
    use crate::example;
    use crate::fit::Slot;
    use crate::fit::damped::inverse;
    use veloid_core::numerics::random::normal;
    use veloid_core::plant::Coefficient;

    /// White noise as loud as the model says scatters as its likelihood says, and noise three times as loud three times as much.
    #[test]
    fn val_blocks_scatter_as_the_noise_does() {
        let mut dataset = example::dataset();
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(2);
        let noise: Vec<f64> = (0..dataset.samples)
            .map(|_| example::NOISE * normal(&mut rng))
            .collect();
        let exact = dataset.tracks[0].measured.clone();
        let mut ratio = |loud: f64| {
            let noisy = exact.iter().zip(&noise).map(|(z, noise)| z + loud * noise);
            dataset.tracks[0].measured = noisy.collect();
            let fitter = example::fitter(&dataset);
            let model = example::model(&dataset, &[]);
            let mut fit = model.fits[0].clone();
            let slots = fit.unit.slots(&dataset);
            let substeps = model.substeps(&dataset, FINE);
            let normal = fitter.normal(&fit.unit, &slots, &fit.point, &fit.noise_models, substeps);
            fit.covariance = inverse(&normal.unwrap().matrix).unwrap();
            let found = between_blocks(&fitter, &fit, substeps);
            let kappa = slots
                .iter()
                .position(|s| *s == Slot::Base(0, Coefficient::Kappa))
                .unwrap();
            (found[(kappa, kappa)] / fit.covariance[(kappa, kappa)]).sqrt()
        };
        let [quiet, loud] = [ratio(1.0), ratio(3.0)];
        assert!((0.6..1.5).contains(&quiet), "{quiet}");
        assert!((loud / quiet - 3.0).abs() < 0.05, "{loud} {quiet}");
    }

    #[test]
    fn variances_grow_and_correlations_stay() {
        let own = DMatrix::from_row_slice(2, 2, &[1.0, 0.5, 0.5, 4.0]);
        let other = DMatrix::from_row_slice(2, 2, &[9.0, 0.0, 0.0, 1.0]);
        let found = wider(&own, &factors(&own, &other));
        assert_eq!(found, DMatrix::from_row_slice(2, 2, &[9.0, 1.5, 1.5, 4.0]));
        let none = DMatrix::from_element(2, 2, f64::NAN);
        assert_eq!(wider(&own, &factors(&own, &none)), own);
    }
}
