//! Judging what a model leaves on one axle: is it noise, or is a force still missing?

use super::by_parts::Predictions;
use crate::policy;
use crate::residual::omnibus::{Remainder, remainder};
use crate::residual::replicate::{exceeds, is_noisy};
use crate::residual::resonance::{Inputs, Resonance, resonance};
use crate::residual::{bursts, coherence};
use veloid_core::bicycle::PerAxle;
use veloid_core::numerics::finite::finite;
use veloid_core::numerics::spectrum::deviation;
use veloid_core::numerics::statistics::normal_tail;
use veloid_core::plant::Coefficients;
use veloid_core::settings::Settings;
use veloid_methods::output_error::{self, Split, rms_valid};
use veloid_model::dataset::{Dataset, Track};
use veloid_model::fit::{COARSE, Fitter, Model, Motion};
use veloid_report::diagnosis::HeldOut;

/// Judges one track: is anything left, and what was the noise.
pub struct Judged {
    pub remainder: Remainder,
    /// The least p value of all that was asked, as chance gives it when so many are asked.
    pub p_value: f64,
    pub remains: bool,
    /// What noise would leave (m), and the share of the held-out variance above it that the model removed, as far as the
    /// model itself shows: for the verdict, not for the report.
    pub floor: f64,
    pub share: f64,
    pub held_out: HeldOut,
}

impl Judged {
    /// Held-out errors are those in windows.
    pub fn predicts(&mut self, windows: &Predictions) {
        let held = &mut self.held_out;
        held.plain_rms_m = finite(windows.plain);
        held.extended_rms_m = finite(windows.extended);
        held.explained_share = (held.noise_floor_m)
            .and_then(|noise| explained(windows.plain, windows.extended, noise));
        held.horizon_s = Some(windows.horizon);
    }
}

/// A model with its motions, and the same model as it is measured on the record itself, where that is another than was
/// searched.
pub struct Candidate<'a> {
    pub model: &'a Model,
    pub motions: &'a [Motion],
    pub shown: Option<(&'a Dataset, &'a Model)>,
}

pub fn judge(
    fitter: &Fitter,
    fits: &PerAxle<output_error::AxleFit>,
    candidate: &Candidate,
    t: usize,
    split: &Split,
    settings: &Settings,
) -> Judged {
    let Candidate {
        model,
        motions,
        shown,
    } = *candidate;
    let dataset = fitter.dataset;
    let track = &dataset.tracks[t];
    let found = remainder(fitter, model, motions, t, &split.held);
    let named = model.terms.iter().any(|term| term.acts_on(track.axle));
    let plain = fits.get(track.axle).map_or(0.0, |f| f.held_rms);
    let extended = match shown {
        _ if !named => plain,
        Some(shown) => held_rms(shown, t, split),
        None => found.held_before,
    };
    let axle = OnAxle {
        dataset,
        model,
        t,
        mean: fits.get(track.axle).map(|f| (f.plain.kappa, f.plain.beta)),
        seed: settings.seed,
    };
    let resonance = axle.resonance(&found.residual);
    let structured = found.is_structured(settings.alpha);
    let forced = is_forced(&resonance, named)
        && axle.stands_out(resonance.gain, &|residual| axle.resonance(residual).gain);
    let rate = axle.deflection_rate(&motions[t]);
    let comes_and_goes =
        |residual: &[f64]| bursts::score(residual, &rate, &track.valid, dataset.step);
    let bursts = comes_and_goes(&found.residual);
    let bursting = is_bursting(bursts) && axle.stands_out(bursts, &comes_and_goes);
    let driven = coherence::of_track(track, &found.residual);
    let goes_along = driven.is_no_noise();
    // A model that runs away on the held-out part explains nothing.
    let runs_away = !(found.held_before + extended).is_finite();
    let remains = structured || forced || bursting || goes_along || runs_away;
    let known = if goes_along { driven.share } else { 0.0 };
    let floor = if remains {
        let forces = resonance.share.max(known);
        let sensor = deviation(track.sensor_floor, dataset.step);
        floor(extended, forces, found.held_after, sensor)
    } else {
        extended
    };
    let record = shown.map_or(track, |(record, _)| &record.tracks[t]);
    let window_s = [split.held.start, split.held.end].map(|i| dataset.step * i as f64);
    Judged {
        p_value: least_of([
            found.p_value,
            normal_tail(bursts),
            normal_tail(driven.score),
        ]),
        remains,
        floor,
        share: removed(plain, extended, floor),
        held_out: held_out(record, plain, extended, window_s),
        remainder: found,
    }
}

/// The p value of the least of several independent p values (Šidák 1967, doi:10.1080/01621459.1967.10482935).
fn least_of<const N: usize>(p_values: [f64; N]) -> f64 {
    let least = p_values.into_iter().fold(1.0, f64::min);
    -(N as f64 * (-least).ln_1p()).exp_m1()
}

/// Whether a residual's spectrum shows a force that is left, of which something is `named` or nothing.
fn is_forced(resonance: &Resonance, named: bool) -> bool {
    resonance.gain > policy::RESONANT && (named || resonance.share > policy::RESONANT_SHARE)
}

/// Whether a residual comes and goes as no noise of a sensor does.
fn is_bursting(score: f64) -> bool {
    score > policy::BURSTS
}

/// One axle under a model.
struct OnAxle<'a> {
    dataset: &'a Dataset,
    model: &'a Model,
    t: usize,
    /// k/m and B/m of the plain model.
    mean: Option<(f64, f64)>,
    seed: u64,
}

impl OnAxle<'_> {
    fn track(&self) -> &Track {
        &self.dataset.tracks[self.t]
    }

    fn resonance(&self, residual: &[f64]) -> Resonance {
        let track = self.track();
        let (fit, a) = self.model.of_track(self.t);
        let Coefficients {
            kappa,
            beta,
            per_mass,
            ..
        } = fit.point.base[a];
        let inputs = Inputs {
            road: track.road_most,
            force: track.force_most * per_mass * per_mass,
            band: track.band,
        };
        if track.input.prescribed {
            return Resonance::default();
        }
        // What springs named effects add is part of how the axle resonates: on the whole as the plain
        // model's, whose stiffness is the mean one.
        [Some((kappa, beta)), self.mean]
            .into_iter()
            .flatten()
            .map(|(k, b)| resonance(residual, self.dataset.step, k, b, &inputs))
            .min_by(|a, b| a.gain.total_cmp(&b.gain))
            .unwrap_or_default()
    }

    /// Whether a score of the residual is more than the noise of the road makes of it. How that comes through an axle
    /// that is not linear, only replicates show.
    fn stands_out(&self, own: f64, score: &(dyn Fn(&[f64]) -> f64 + Sync)) -> bool {
        !is_noisy(self.track())
            || exceeds(own, &[(self.dataset, self.model)], self.seed, |again| {
                score(&self.on_replicate(&again[0]))
            })
    }

    fn on_replicate(&self, dataset: &Dataset) -> Vec<f64> {
        let again = Fitter {
            dataset,
            samples: dataset.samples,
        };
        let (fit, a) = self.model.of_track(self.t);
        let substeps = self.model.substeps(dataset, COARSE);
        let mut residuals = again.residuals(&fit.unit, &fit.point, substeps);
        residuals.swap_remove(a)
    }

    fn deflection_rate(&self, motion: &Motion) -> Vec<f64> {
        let road = &self.track().input.road_slope;
        road.iter().zip(&motion.w).map(|(u, w)| u - w).collect()
    }
}

/// What noise would leave of the held-out error `extended` (m), of whose square `forces` take a share; no less than the
/// displacement sensor's own noise.
fn floor(extended: f64, forces: f64, held_after: f64, sensor: f64) -> f64 {
    (extended * (1.0 - forces).max(0.0).sqrt())
        .min(held_after)
        .max(sensor)
        .min(extended)
}

/// Share of the held-out variance above the floor that the model removed.
fn removed(plain: f64, extended: f64, floor: f64) -> f64 {
    let explainable = plain * plain - floor * floor;
    let removed = plain * plain - extended * extended;
    if explainable > 1e-4 * plain * plain {
        (removed / explainable).clamp(-1.0, 1.0)
    } else {
        0.0
    }
}

/// Why a record does not show its sensor's noise.
const NO_FLOOR: &str = "what is measured moves up to the end of its spectrum, so that the sensor's noise cannot be distinguished: declare     noise_displacement_m in the bike file, or log faster";

/// The held-out errors as they are reported.
fn held_out(record: &Track, plain: f64, extended: f64, window_s: [f64; 2]) -> HeldOut {
    let noise = record.sensor_noise();
    HeldOut {
        plain_rms_m: finite(plain),
        extended_rms_m: finite(extended),
        noise_floor_m: noise,
        noise_floor_why: noise.is_none().then(|| NO_FLOOR.to_owned()),
        predicted: record.predicted(),
        explained_share: noise.and_then(|noise| explained(plain, extended, noise)),
        window_s,
        horizon_s: None,
    }
}

/// Share of the explainable held-out variance that an extension removed, where a sensor's `noise` (m) was measured and
/// agrees with what is left.
fn explained(plain: f64, extended: f64, noise: f64) -> Option<f64> {
    let explainable = plain * plain - noise * noise;
    let agrees = extended > policy::NOISE_AGREES * noise && explainable > 0.01 * plain * plain;
    let removed = plain * plain - extended * extended;
    finite(removed / explainable)
        .filter(|_| agrees)
        .map(|share| share.clamp(-1.0, 1.0))
}

/// RMS of the valid residuals on the held-out part (m).
pub fn held_rms((dataset, model): (&Dataset, &Model), t: usize, split: &Split) -> f64 {
    let residual = model.residual(dataset, t);
    rms_valid(&residual, &dataset.tracks[t].valid, split.held.clone())
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    #[test]
    fn val_the_least_of_three_uniform_numbers_is_as_rare_as_it_says() {
        let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(1);
        let mut below = 0;
        for _ in 0..10_000 {
            below += usize::from(least_of([0; 3].map(|_| rng.random::<f64>())) < 0.05);
        }
        assert!((450..550).contains(&below), "{below} of 500");
        assert!((least_of([1e-20, 1.0, 1.0]) - 3e-20).abs() < 1e-30);
        assert_eq!(least_of([1.0; 3]), 1.0);
    }

    #[test]
    fn no_share_is_reported_without_room_or_against_the_noise() {
        let share = explained(5e-4, 1e-4, 0.9e-4).unwrap_or_default();
        assert!((share - 0.24 / 0.2419).abs() < 1e-9, "{share}");
        assert_eq!(explained(1e-4, 1e-4, 0.999e-4), None);
        assert_eq!(explained(5e-4, 1e-4, 3e-4), None);
        assert_eq!(explained(f64::INFINITY, 1e-4, 1e-4), None);
        let worse = explained(1e-4, 9e-4, 1e-5).unwrap_or_default();
        assert_eq!(worse, -1.0);
    }

    #[test]
    fn a_share_is_reported_of_what_agrees_with_the_noise() {
        let noise = 1e-4;
        let share = |times: f64| explained(5e-4, times * policy::NOISE_AGREES * noise, noise);
        assert!(share(1.01).is_some() && share(0.99).is_none());
    }

    #[test]
    fn a_force_resonates_by_more_than_noise_and_more_where_nothing_is_named() {
        let forced = |gain: f64, share: f64, named| {
            let gain = gain * policy::RESONANT;
            let share = share * policy::RESONANT_SHARE;
            is_forced(&Resonance { gain, share }, named)
        };
        assert!(forced(1.01, 1.01, false) && forced(1.01, 0.99, true));
        assert!(!forced(1.01, 0.99, false));
        assert!(!forced(0.99, 1.01, false) && !forced(0.99, 1.01, true));
    }

    #[test]
    fn the_noise_of_a_sensor_hardly_comes_and_goes() {
        assert!(is_bursting(1.01 * policy::BURSTS) && !is_bursting(0.99 * policy::BURSTS));
    }
}
