//! One axle of the model beside the ride's measurement.

use super::carried::Carried;
use super::parameters::parameters;
use super::simulated::{Simulated, beginning};
use super::words;
use crate::explain::evidence::{excerpt, residual_spectrum};
use crate::explain::locate;
use crate::explain::show;
use veloid_core::bicycle::PerAxle;
use veloid_model::dataset::{Dataset, Track};
use veloid_model::fit::{Fitted, Model};
use veloid_report::IdentifiedModel;
use veloid_report::diagnosis::EffectName;
use veloid_report::model_on_ride::{AxleOnRide, FitOnRide, SeriesOnRide, SpectrumOnRide};

/// Times what the model leaves that a fit to the ride may leave, since it weighs frequencies by what is left there.
const WORSE: f64 = 1.05;

/// Axles that move together, to be compared.
pub struct Compared<'a> {
    pub model: &'a IdentifiedModel,
    pub carried: &'a Carried,
    pub simulated: &'a Simulated,
    /// The model without effects.
    pub plain: &'a [Simulated],
    pub alpha: f64,
}

impl Compared<'_> {
    /// The comparisons of these axles, beside those of others.
    pub fn axles(&self, mut axles: PerAxle<AxleOnRide>) -> PerAxle<AxleOnRide> {
        let dataset = &self.carried.dataset;
        let refitted = self.simulated.refitted(dataset);
        let refitted = refitted.filter(|fitted| self.is_better(fitted));
        for (a, t) in self.simulated.unit.tracks.iter().enumerate() {
            axles.set(dataset.tracks[*t].axle, self.axle(a, *t, refitted.as_ref()));
        }
        axles
    }

    /// Whether a fit to the ride leaves no more than the model, by its noise's colour apart: where it does, what is left is no noise, and
    /// neither its numbers nor their errors mean anything.
    fn is_better(&self, (compared, model): &(Dataset, Model)) -> bool {
        let Simulated { from, .. } = *self.simulated;
        let tracks = self.simulated.unit.tracks.iter().enumerate();
        let mut left = tracks.map(|(a, t)| {
            let track = &compared.tracks[*t];
            let rms = |residual: &[f64]| fit(track, &behind(residual, from), &track.valid).rms;
            (
                rms(&model.residual(compared, *t)),
                rms(&self.simulated.residuals[a]),
            )
        });
        left.all(|(fitted, carried)| fitted < WORSE * carried)
    }

    fn axle(&self, a: usize, t: usize, refitted: Option<&(Dataset, Model)>) -> AxleOnRide {
        let Simulated { from, .. } = *self.simulated;
        let track = &self.carried.dataset.tracks[t];
        let step = track.input.step;
        let residual = behind(&self.simulated.residuals[a], from);
        let left = refitted.map(|(compared, model)| behind(&model.residual(compared, t), from));
        let left = left.as_ref().unwrap_or(&residual);
        let valid = behind_valid(track, from);
        let parameters = refitted.map_or_else(Vec::new, |(compared, model)| {
            let carried = self.as_model(model);
            parameters(self.model, compared, [&carried, model], t, self.alpha)
        });
        let judged = parameters.iter().filter_map(|p| p.differs);
        let differs = judged.fold(None, |any, one| Some(any.unwrap_or(false) || one));
        let effects = self.simulated.unit.terms.iter();
        let effects = effects.filter(|term| term.acts_on(track.axle));
        let effects = effects.map(|term| show::name(&self.carried.dataset, term));
        let effects: Vec<EffectName> = effects.collect();
        let mut found = AxleOnRide {
            predicted: track.predicted(),
            start_s: [0.0, beginning(track) as f64 * step],
            compared_s: [from as f64 * step, (track.valid.len() - 1) as f64 * step],
            spread: spread(&track.measured, &valid),
            model: fit(track, &residual, &valid),
            plain: (self.plain_residual(t))
                .filter(|_| !effects.is_empty())
                .map(|r| fit(track, &behind(r, from), &valid)),
            refitted: refitted.map(|_| fit(track, left, &valid)),
            noise: track.sensor_noise(),
            effects,
            parameters,
            differs,
            windows_s: locate::windows(&residual, left, &valid, &self.carried.dataset, self.alpha),
            bands_hz: locate::bands(&residual[from..], &left[from..], step, self.alpha),
            sentence: String::new(),
            worst: worst(
                track,
                &self.simulated.residuals[a],
                refitted
                    .map(|(compared, model)| model.residual(compared, t))
                    .as_ref()
                    .unwrap_or(&self.simulated.residuals[a]),
            ),
            spectrum: spectrum(track, &residual[from..], &left[from..]),
        };
        found.sentence = words::axle(track.axle, &found);
        found
    }

    fn plain_residual(&self, track: usize) -> Option<&[f64]> {
        self.plain.iter().find_map(|plain| {
            let a = plain.unit.tracks.iter().position(|t| *t == track)?;
            Some(plain.residuals[a].as_slice())
        })
    }

    /// The model as it was carried over, in the shape of the one that was fitted.
    fn as_model(&self, refitted: &Model) -> Model {
        let fits = refitted.fits.iter().map(|fit| Fitted {
            point: self.simulated.point.clone(),
            ..fit.clone()
        });
        Model::new(refitted.terms.clone(), fits.collect())
    }
}

/// A residual without the part that the start was fitted to.
fn behind(residual: &[f64], from: usize) -> Vec<f64> {
    let mut left = residual.to_vec();
    left[..from].fill(0.0);
    left
}

fn behind_valid(track: &Track, from: usize) -> Vec<bool> {
    let mut valid = track.valid.clone();
    valid[..from].fill(false);
    valid
}

fn spread(x: &[f64], valid: &[bool]) -> f64 {
    let known: Vec<f64> = (x.iter().zip(valid))
        .filter(|(_, v)| **v)
        .map(|(x, _)| *x)
        .collect();
    veloid_core::numerics::statistics::variance(&known).sqrt()
}

fn fit(track: &Track, residual: &[f64], valid: &[bool]) -> FitOnRide {
    let known = || {
        residual
            .iter()
            .zip(valid)
            .filter(|(_, v)| **v)
            .map(|(r, _)| *r)
    };
    let square = known().map(|r| r * r).sum::<f64>() / known().count().max(1) as f64;
    let share = square.sqrt() / spread(&track.measured, valid).max(f64::MIN_POSITIVE);
    FitOnRide {
        rms: square.sqrt(),
        largest: known().fold(0.0, |most, r| most.max(r.abs())),
        fit_percent: 100.0 * (1.0 - share),
        explained_percent: 100.0 * (1.0 - share * share),
    }
}

fn worst(track: &Track, residual: &[f64], left: &[f64]) -> SeriesOnRide {
    let found = excerpt(track, residual, left);
    SeriesOnRide {
        t_s: found.t_s,
        measured: found.measured_m,
        model: found.plain_m,
        refitted: found.extended_m,
    }
}

fn spectrum(track: &Track, residual: &[f64], left: &[f64]) -> SpectrumOnRide {
    let found = residual_spectrum(track, residual, left);
    SpectrumOnRide {
        frequency_hz: found.frequency_hz,
        model: found.plain_m2_hz,
        refitted: found.extended_m2_hz,
    }
}
