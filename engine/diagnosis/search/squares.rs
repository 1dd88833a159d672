//! The search of a record by plain squares: noise that is estimated from what an incomplete model leaves takes weight off the very
//! frequencies that show.

use super::Search;
use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_model::dataset::Dataset;
use veloid_model::fit::{Effort, FINE, Fitted, Fitter, Model, Term};

/// Steps of a fit by plain squares, and its gain (of squares) at which it ends.
const STEPS: usize = 15;
const GAIN: f64 = 1e-2;

/// The record for fits by plain squares.
pub fn of_squares(record: &Dataset) -> Dataset {
    let mut dataset = record.clone();
    dataset.noise_order = 0;
    dataset
}

/// The search of a record `of_squares` for what acts on the tracks that are `asked`; nothing if the plain model has no fit.
pub fn search_by_squares<'s>(
    search: &Search<'s>,
    dataset: &'s Dataset,
    asked: &[bool],
    until: u64,
) -> Option<Search<'s>> {
    let fitter = || Fitter {
        dataset,
        samples: search.fitter.samples,
    };
    Some(Search {
        plain: unweighted(&fitter(), &search.plain)?,
        fitter: fitter(),
        held: search.held.clone(),
        candidates: lasting(search, asked),
        alpha: search.alpha,
        seed: search.seed,
        until,
        budget: search.budget,
        progress: search.progress,
    })
}

/// The candidates for the tracks that are asked which act all the time, and not too slowly to be distinguished from a sensor's own
/// wandering.
fn lasting(search: &Search, asked: &[bool]) -> Vec<Term> {
    let tracks = search.fitter.dataset.tracks.iter().zip(asked);
    let lasts = |t: &&Term| {
        let spec = t.kind.spec();
        let mut asked = tracks.clone().filter(|(_, asked)| **asked);
        !spec.local && !spec.slow && asked.any(|(track, _)| t.acts_on(track.axle))
    };
    search.candidates.iter().filter(lasts).copied().collect()
}

/// The model fitted to the plain squares.
fn unweighted(fitter: &Fitter, model: &Model) -> Option<Model> {
    let effort = Effort {
        iterations: STEPS,
        gain: GAIN,
        substeps: model.substeps(fitter.dataset, FINE),
    };
    let refitted = |fit: &Fitted| {
        let white: Vec<NoiseModel> = (fit.noise_models.iter())
            .map(NoiseModel::bleached)
            .collect();
        fitter.fit(&fit.unit, fit.point.clone(), &white, effort)
    };
    let fits = model.fits.iter().map(refitted).collect::<Option<_>>()?;
    Some(Model::new(model.terms.clone(), fits))
}
