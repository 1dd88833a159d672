//! Sets of effects, exactly fitted.

use super::fitter::{Fitted, Fitter};
use super::unit::{Point, Term, Unit};
use crate::dataset::Dataset;
use crate::law::{AT_REST, MAX_PARAMETERS, STABLE};
use veloid_core::numerics::autoregressive::NoiseModel;

/// Largest angle (rad) that the stiffest axle turns through in one step of the integrator, while
/// searching and in the end.
pub const COARSE: f64 = 0.45;
pub const FINE: f64 = 0.3;
/// Damping ratio below which the last fits of a study take shorter steps. A step that turns by θ lowers k by θ⁴ / 60 and raises B by
/// θ⁵ / (144 ζ) of their values (the integrator's modified equation), while k's standard error falls about as ζ² with less damping: with a
/// step as sqrt(ζ) the ratio of the two stays.
pub const LIGHT: f64 = 0.1;
/// What a corner takes off the angle of a step, since the error at one falls with its square only.
pub const CORNERS: f64 = 0.4;

/// A set of effects, exactly fitted.
#[derive(Clone, Debug)]
pub struct Model {
    pub terms: Vec<Term>,
    pub fits: Vec<Fitted>,
    /// Sum of the units' profile log likelihoods.
    pub likelihood: f64,
}

impl Model {
    pub fn new(mut terms: Vec<Term>, fits: Vec<Fitted>) -> Self {
        terms.sort();
        let likelihood = fits.iter().map(|f| f.likelihood).sum();
        Self {
            terms,
            fits,
            likelihood,
        }
    }

    /// The same with another fit of some tracks.
    pub fn with(&self, fit: Fitted) -> Self {
        let apart = |f: &&Fitted| f.unit.tracks.iter().all(|t| !fit.unit.tracks.contains(t));
        let others: Vec<Fitted> = self.fits.iter().filter(apart).cloned().collect();
        let fits: Vec<Fitted> = std::iter::once(fit).chain(others).collect();
        let terms = fits.iter().flat_map(|f| f.unit.terms.iter().copied());
        Self::new(terms.collect(), fits)
    }

    /// Steps of the integrator for each sample, so that the stiffest axle turns by no more than `angle`
    /// (rad) in one, or by less where a force has corners.
    pub fn substeps(&self, dataset: &Dataset, angle: f64) -> usize {
        let angle = if self.terms.iter().any(|t| t.kind.spec().corners) {
            CORNERS * angle
        } else {
            angle
        };
        let of_fit = |f: &Fitted| f.unit.substeps(dataset, &f.point, angle);
        self.fits.iter().map(of_fit).max().unwrap_or(1)
    }

    /// Measured minus simulated on one track along the whole ride (m, or N where a force is predicted); zero where not valid.
    pub fn residual(&self, dataset: &Dataset, track: usize) -> Vec<f64> {
        let whole = Fitter {
            dataset,
            samples: dataset.samples,
        };
        let (fit, a) = self.of_track(track);
        let substeps = self.substeps(dataset, FINE);
        let mut residuals = whole.residuals(&fit.unit, &fit.point, substeps);
        residuals.swap_remove(a)
    }

    /// Noise of one track's residual.
    pub fn noise_model(&self, track: usize) -> &NoiseModel {
        let (fit, a) = self.of_track(track);
        &fit.noise_models[a]
    }

    /// The fit that a track belongs to, and which of its axles it is.
    pub fn of_track(&self, track: usize) -> (&Fitted, usize) {
        self.fits
            .iter()
            .find_map(|f| {
                f.unit
                    .tracks
                    .iter()
                    .position(|t| *t == track)
                    .map(|a| (f, a))
            })
            .unwrap_or((&self.fits[0], 0))
    }

    /// Where a fit of `unit` starts when this model is what is known: new terms at zero, and without those
    /// that it leaves out.
    pub fn carried(&self, unit: &Unit) -> (Point, Vec<NoiseModel>) {
        let mut point = Point {
            base: Vec::new(),
            values: Vec::new(),
            initial: Vec::new(),
        };
        let mut noise_models = Vec::new();
        for t in &unit.tracks {
            let (fit, a) = self.of_track(*t);
            let mut base = fit.point.base[a];
            for (term, values) in fit.unit.terms.iter().zip(&fit.point.values) {
                if !unit.terms.contains(term) {
                    [base.kappa, base.beta] =
                        (term.kind.spec().alone)([base.kappa, base.beta], values);
                }
            }
            point.base.push(base);
            noise_models.push(fit.noise_models[a].clone());
        }
        for term in &unit.terms {
            let known = self
                .fits
                .iter()
                .find_map(|f| f.unit.terms.iter().position(|t| t == term).map(|i| (f, i)));
            point
                .values
                .push(known.map_or([0.0; MAX_PARAMETERS], |(f, i)| f.point.values[i]));
            point
                .initial
                .push(known.map_or(AT_REST, |(f, i)| f.point.initial[i]));
        }
        (point, noise_models)
    }
}

impl Unit {
    /// The same of a last fit of this unit alone.
    pub fn fine_substeps(&self, dataset: &Dataset, point: &Point) -> usize {
        let corners = self.terms.iter().any(|t| t.kind.spec().corners);
        self.substeps(dataset, point, if corners { CORNERS * FINE } else { FINE })
    }

    /// Steps of the integrator for each sample of a last fit whose k and B are to be as accurate as the record allows on lightly
    /// damped axles too.
    pub fn accurate_substeps(&self, dataset: &Dataset, point: &Point) -> usize {
        let ratios = self.tracks.iter().zip(&point.base).map(|(t, base)| {
            match dataset.tracks[*t].input.prescribed || base.kappa <= 0.0 {
                true => LIGHT,
                false => base.beta.abs() / (2.0 * base.kappa.sqrt()),
            }
        });
        let least = ratios.fold(LIGHT, f64::min);
        let angle = FINE * (least / LIGHT).sqrt().max(f64::MIN_POSITIVE);
        self.substeps(dataset, point, angle)
            .max(self.fine_substeps(dataset, point))
    }

    /// Steps of the integrator for each sample, so that the stiffest axle turns by no more than `angle` (rad) in one.
    pub fn substeps(&self, dataset: &Dataset, point: &Point, angle: f64) -> usize {
        let turns = (self.fastest(dataset, point) * dataset.step / angle).ceil() as usize;
        turns
            .max(stable_substeps(dataset, self.decay(dataset, point)))
            .clamp(1, 20)
    }
}

/// Steps of the integrator for each sample that a damping of B/m = `beta` (1/s) bears.
pub fn stable_substeps(dataset: &Dataset, beta: f64) -> usize {
    (beta.abs() * dataset.step / STABLE).ceil() as usize
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::effects::Kind;
    use crate::example;
    use crate::fit::Slot;
    use crate::law::padded;
    use veloid_core::bicycle::Axle;

    #[test]
    fn another_fit_of_an_axle_takes_the_place_of_its_own() {
        let dataset = example::dataset();
        let [cubic, gain] =
            [Kind::CubicStiffness, Kind::SensorGain].map(|kind| example::term(kind, Axle::Front));
        let rear = example::term(Kind::CubicStiffness, Axle::Rear);
        let mut known = example::model(&dataset, &[(cubic, 1.0), (rear, 2.0)]);
        known.fits[0].likelihood = 7.0;
        known.fits[1].likelihood = 20.0;
        let mut other = example::model(&dataset, &[(gain, 0.1)]).fits.swap_remove(0);
        other.likelihood = 100.0;
        let joined = known.with(other);
        let mut terms = vec![gain, rear];
        terms.sort();
        assert_eq!(joined.terms, terms);
        assert_eq!(joined.likelihood, 100.0 + 20.0);
        // Whatever the order of the fits, every track has its own.
        for (track, term) in [(0, gain), (1, rear)] {
            let (fit, axle) = joined.of_track(track);
            assert_eq!((fit.unit.terms.as_slice(), axle), (&[term][..], 0));
        }
    }

    #[test]
    fn a_fit_starts_from_what_is_known_and_new_terms_at_zero() {
        let dataset = example::dataset();
        let [cubic, gain, friction] = [
            Kind::CubicStiffness,
            Kind::SensorGain,
            Kind::CoulombFriction,
        ]
        .map(|kind| example::term(kind, Axle::Front));
        let known = example::model(&dataset, &[(cubic, 1e9), (gain, 0.1)]);
        let mut terms = vec![cubic, friction];
        terms.sort();
        let unit = Unit {
            tracks: vec![0],
            terms,
        };
        let (point, noise_models) = known.carried(&unit);
        for (term, values) in unit.terms.iter().zip(&point.values) {
            let expected = if *term == cubic { 1e9 } else { 0.0 };
            assert_eq!(*values, padded([expected]));
        }
        assert_eq!(point.base, known.fits[0].point.base);
        assert_eq!(noise_models[0].variance, example::NOISE.powi(2));
    }

    #[test]
    fn a_dropped_second_mass_leaves_the_axle_that_moves_like_it_slowly() {
        let dataset = example::dataset();
        let mass = example::term(Kind::UnsprungMass, Axle::Front);
        let known = example::model(&dataset, &[(mass, 0.3)]);
        let unit = Unit {
            tracks: vec![0],
            terms: Vec::new(),
        };
        let (point, _) = known.carried(&unit);
        let slots = [
            Slot::Base(0, veloid_core::plant::Coefficient::Kappa),
            Slot::Base(0, veloid_core::plant::Coefficient::Beta),
        ];
        let before = slots.map(|slot| known.fits[0].point.get(slot));
        let alone = (mass.kind.spec().alone)(before, &known.fits[0].point.values[0]);
        assert_eq!(slots.map(|slot| point.get(slot)), alone);
        assert_ne!(alone, before);
    }

    #[test]
    fn lightly_damped_axles_get_shorter_steps() {
        let dataset = example::dataset();
        let plain = example::model(&dataset, &[]);
        let front = plain.fits.iter().find(|f| f.unit.tracks == [0]).unwrap();
        let substeps = |ratio: f64| {
            let mut point = front.point.clone();
            point.base[0].beta = 2.0 * ratio * point.base[0].kappa.sqrt();
            front.unit.accurate_substeps(&dataset, &point)
        };
        let usual = front.unit.fine_substeps(&dataset, &front.point);
        let turn = front.unit.fastest(&dataset, &front.point) * dataset.step;
        for (ratio, steps) in [
            (1.01 * LIGHT, usual),
            (LIGHT / 16.0, (4.0 * turn / FINE).ceil() as usize),
            (0.0, 20),
        ] {
            assert_eq!(substeps(ratio), steps.max(usual), "{ratio}");
        }
    }

    #[test]
    fn steps_are_as_short_as_the_stiffest_axle_turns() {
        let dataset = example::dataset();
        let plain = example::model(&dataset, &[]);
        // The lighter front axle turns faster.
        let turn = (example::K / example::FRONT).sqrt() * dataset.step;
        for angle in [0.05, 0.1, FINE] {
            let steps = (turn / angle).ceil() as usize;
            assert_eq!(plain.substeps(&dataset, angle), steps);
        }
        // A corner takes a part off the angle.
        let friction = example::term(Kind::CoulombFriction, Axle::Front);
        let cornered = example::model(&dataset, &[(friction, 0.0)]);
        assert_eq!(
            cornered.substeps(&dataset, 0.1),
            (turn / (CORNERS * 0.1)).ceil() as usize
        );
    }

    #[test]
    fn a_damping_is_borne_by_steps_in_which_it_decays_no_further() {
        let dataset = example::dataset();
        for steps in [1, 3, 8] {
            let most = f64::from(steps) * STABLE / dataset.step;
            assert_eq!(stable_substeps(&dataset, 0.999 * most), steps as usize);
            assert_eq!(stable_substeps(&dataset, -1.001 * most), steps as usize + 1);
        }
    }

    #[test]
    fn the_model_that_made_a_ride_leaves_nothing_of_it() {
        let dataset = example::dataset();
        let plain = example::model(&dataset, &[]);
        for t in 0..dataset.tracks.len() {
            let track = &dataset.tracks[t];
            let most = plain
                .residual(&dataset, t)
                .iter()
                .fold(0.0, |most, r| r.abs().max(most));
            assert!(most < 0.01 * track.spread(), "{most}");
        }
    }
}
