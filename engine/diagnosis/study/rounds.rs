//! The search over several rides: the same candidates and gates as for one, each asked of all rides together.

use rayon::prelude::*;

use crate::policy;
use crate::search::Search;
use crate::search::criteria::{cost, has_room, to_repeat};
use crate::search::extend::{is_far, joined};
use crate::search::null::Null;
use crate::search::refit::{HOPE, LEADERS};
use crate::search::score_test::{Along, Signatures, signatures, stands_out};
use veloid_core::EngineError;
use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_model::fit::model::CORNERS;
use veloid_model::fit::physical::is_physical;
use veloid_model::fit::polish::until_still;
use veloid_model::fit::tangent::Tangent;
use veloid_model::fit::together::{Common, Together};
use veloid_model::fit::{COARSE, Effort, FINE, Fitted, Fitter, Model, Point, Term, Unit};
use veloid_report::diagnosis::{Place, SwitchedOff};

/// A model of every ride with the same effects.
#[derive(Clone, Debug)]
pub struct Joint {
    pub models: Vec<Model>,
    /// How often chance gains as much as each effect did when it was found (family-wise).
    pub p_values: Vec<(Term, f64)>,
    /// Effects in which the rides differ: each has its own parameters, and they need not act on every ride.
    pub own: Vec<Term>,
}

impl Joint {
    pub fn likelihood(&self) -> f64 {
        self.models.iter().map(|m| m.likelihood).sum()
    }

    /// The effects that all rides have while they are searched for.
    pub fn terms(&self) -> &[Term] {
        &self.models[0].terms
    }
}

/// What the rides share, and what explains them as well.
pub struct Found {
    pub joint: Joint,
    /// Best first.
    pub tied: Vec<Joint>,
}

/// The search over all rides.
pub struct Rides<'a> {
    pub searches: Vec<Search<'a>>,
    pub alpha: f64,
    pub seed: u64,
}

/// Share of the best predicted gain from which an effect is fitted.
const WORTH: f64 = 0.1;

/// Why a study does not look for an effect.
const OWN_AFFAIR: &str =
    "specific to a single ride (its time, phase or sensors): identify the rides one by one for it";

impl Rides<'_> {
    /// Effects that rides can have in common, and those that they cannot.
    pub fn candidates(&self) -> (Vec<Term>, Vec<SwitchedOff>) {
        let dataset = self.searches[0].fitter.dataset;
        let all = &self.searches[0].candidates;
        let everywhere = |t: &Term| self.searches.iter().all(|s| s.candidates.contains(t));
        let own = |t: &Term| {
            let spec = t.kind.spec();
            spec.local || spec.slow || spec.amplitudes.len() == 2
        };
        let mut off: Vec<SwitchedOff> = Vec::new();
        for term in all.iter().filter(|t| own(t)) {
            let id = term.id(dataset).to_owned();
            if off.iter().all(|known| known.id != id) {
                let why = OWN_AFFAIR.to_owned();
                off.push(SwitchedOff { id, why });
            }
        }
        let common = all.iter().filter(|t| !own(t) && everywhere(t));
        (common.copied().collect(), off)
    }

    /// All rounds from the plain models on.
    pub fn run(&self) -> Result<Found, EngineError> {
        let (candidates, _) = self.candidates();
        let mut found = Found {
            joint: Joint {
                models: self.searches.iter().map(|s| s.plain.clone()).collect(),
                p_values: Vec::new(),
                own: Vec::new(),
            },
            tied: Vec::new(),
        };
        while has_room(found.joint.terms()) {
            self.searches[0].check()?;
            let round = found.joint.terms().len();
            let Some((best, tied)) = self.round(&found.joint, &candidates, round)? else {
                break;
            };
            found = Found { joint: best, tied };
        }
        Ok(found)
    }

    /// The best effect to add, and those that explain the rides as well in its place.
    fn round(
        &self,
        joint: &Joint,
        candidates: &[Term],
        round: usize,
    ) -> Result<Option<(Joint, Vec<Joint>)>, EngineError> {
        let mut offers = self.offers(joint, candidates);
        let null = Null::new(&offers, self.seed, round);
        offers.sort_by(|a, b| b.predicted_gain().total_cmp(&a.predicted_gain()));
        let most = offers.first().map_or(0.0, Signatures::predicted_gain);
        if most <= HOPE * null.bound(self.alpha) {
            return Ok(None);
        }
        offers.truncate(2 * LEADERS);
        offers.retain(|o| o.predicted_gain() > WORTH * most);
        let tried: Vec<Option<Joint>> = (offers.par_iter())
            .map(|offer| self.extended(joint, offer, &null))
            .collect();
        self.searches[0].check()?;
        let mut found: Vec<Joint> = (tried.into_iter().flatten())
            .filter(|larger| self.accepts(joint, larger))
            .collect();
        let merit = |j: &Joint| self.merit(j);
        found.sort_by(|a, b| merit(b).total_cmp(&merit(a)));
        let noisy = |j: &Joint| self.is_road_noise(joint, j);
        let Some(at) = found.iter().position(|j| !noisy(j)) else {
            return Ok(None);
        };
        let best = found.swap_remove(at);
        // As well by what was fitted or by all: the held-out parts alone are few.
        let (best_merit, best_held) = (merit(&best), self.held(&best));
        found.retain(|j| ties([best_merit, best_held], [merit(j), self.held(j)]));
        found.sort_by(|a, b| merit(b).total_cmp(&merit(a)));
        Ok(Some((best, found)))
    }

    /// Signatures of every candidate over all rides.
    fn offers(&self, joint: &Joint, candidates: &[Term]) -> Vec<Signatures> {
        let each = self.searches.iter().zip(&joint.models);
        let tangents: Vec<(Vec<(Place, Tangent)>, usize)> = each
            .map(|(search, model)| {
                let substeps = model.substeps(search.fitter.dataset, COARSE);
                (search.tangents(model, joint.terms()), substeps)
            })
            .collect();
        let along = |term: &Term| -> Option<Signatures> {
            let each = self.searches.iter().zip(&tangents);
            let each = each.map(|(search, (tangents, substeps))| {
                let (_, tangent) = tangents.iter().find(|(place, _)| *place == term.place)?;
                Some(Along {
                    fitter: &search.fitter,
                    tangent,
                    substeps: *substeps,
                })
            });
            let along: Option<Vec<Along>> = each.collect();
            Some(signatures(&along?, *term))
        };
        let open = candidates.iter().filter(|t| !joint.terms().contains(t));
        let offers = open.filter_map(along);
        offers.filter(|s| !s.starts.is_empty()).collect()
    }

    /// The joint fit with an effect more, from the starts that predict most; nothing where chance gains as much.
    fn extended(&self, joint: &Joint, offer: &Signatures, null: &Null) -> Option<Joint> {
        let dataset = self.searches[0].fitter.dataset;
        let unit = joined(dataset, &joint.models[0], offer.term)?;
        let at = unit.terms.iter().position(|t| *t == offer.term)?;
        let each = self.searches.iter().zip(&joint.models);
        let carried = each.map(|(search, model)| {
            let (point, noise_models) = model.carried(&unit);
            // A noise that has taken most of the effect for its own hides it.
            match is_far(search.fitter.dataset, model, &unit) {
                true => (
                    point,
                    noise_models.iter().map(NoiseModel::bleached).collect(),
                ),
                false => (point, noise_models),
            }
        });
        let (points, noise_models): (Vec<Point>, Vec<Vec<NoiseModel>>) = carried.unzip();
        let mut order: Vec<_> = offer.starts.iter().collect();
        order.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        let near = match offer.term.kind.spec().amplitudes.is_empty() {
            true => 3,
            false => 1,
        };
        let together = self.together(vec![unit; self.searches.len()], Common::Effects, &[]);
        let effort = self.effort(joint, &offer.term);
        let fits = order.iter().take(near).filter_map(|predicted_gain| {
            let mut starts = points.clone();
            for start in &mut starts {
                start.values[at] = predicted_gain.values;
            }
            together.fit(&starts, &noise_models, effort)
        });
        let gain = |larger: &Joint| larger.likelihood() - joint.likelihood();
        let best = fits.max_by(|a, b| sum(a).total_cmp(&sum(b)))?;
        // A first fit may end under a noise that is not its own yet.
        if gain(&joint.with(best.clone())) < HOPE * null.bound(self.alpha) {
            return None;
        }
        let mut larger = joint.with(settled(&together, best, effort)?);
        let unresolved = self.searches.iter().map(|s| s.unresolved(offer.term.place));
        let p_value = null.p_value(gain(&larger) - unresolved.sum::<f64>());
        larger.p_values.push((offer.term, p_value));
        (p_value <= self.alpha).then_some(larger)
    }

    /// The fit of an axle, or of both, over all rides.
    pub fn together<'a>(
        &'a self,
        units: Vec<Unit>,
        common: Common,
        own: &'a [Term],
    ) -> Together<'a> {
        Together {
            rides: self.searches.iter().map(|s| &s.fitter).collect(),
            units,
            common,
            own,
        }
    }

    /// How hard a fit with one effect more tries.
    fn effort(&self, joint: &Joint, term: &Term) -> Effort {
        let corners = term.kind.spec().corners;
        Effort {
            iterations: 12,
            gain: 0.02,
            substeps: self.substeps(joint, if corners { CORNERS * FINE } else { FINE }),
        }
    }

    /// Steps of the integrator for each sample that are fine enough for every ride.
    pub fn substeps(&self, joint: &Joint, angle: f64) -> usize {
        let each = self.searches.iter().zip(&joint.models);
        let substeps = each.map(|(s, m)| m.substeps(s.fitter.dataset, angle));
        substeps.max().unwrap_or(1)
    }

    /// Whether what `larger` has beyond `joint` repeats its gain on what was not fitted, can be a bicycle's and, beside others,
    /// is large enough to be reported on some ride.
    fn accepts(&self, joint: &Joint, larger: &Joint) -> bool {
        let gain = larger.likelihood() - joint.likelihood();
        let held: usize = self.searches.iter().map(|s| s.held.len()).sum();
        let share = held as f64 / self.samples() as f64;
        let repeats = self.held(larger) - self.held(joint) > to_repeat(gain, share);
        let first = &self.searches[0];
        let physical = is_physical(first.fitter.dataset, &first.plain, &larger.models[0]);
        let mut each = self.searches.iter().zip(&joint.models).zip(&larger.models);
        let mut counts = || each.any(|((s, before), after)| s.counts(before, after));
        repeats && physical && (joint.terms().is_empty() || counts())
    }

    /// Whether noise of the road channels alone could bring the gain.
    fn is_road_noise(&self, joint: &Joint, larger: &Joint) -> bool {
        let new = larger.terms().iter().find(|t| !joint.terms().contains(t));
        let Some(term) = new.copied() else {
            return false;
        };
        if !self.searches.iter().any(|s| s.has_noisy_road(term)) {
            return false;
        }
        let rides: Vec<(&Fitter, &Model)> = (self.searches.iter().zip(&joint.models))
            .map(|(s, m)| (&s.fitter, m))
            .collect();
        !stands_out(&rides, term, self.seed)
    }

    /// Log score of all held-out parts.
    pub fn held(&self, joint: &Joint) -> f64 {
        let each = self.searches.iter().zip(&joint.models);
        each.map(|(search, model)| search.held_score(model)).sum()
    }

    /// Log likelihood less what the number of common parameters costs (Schwarz's criterion).
    fn merit(&self, joint: &Joint) -> f64 {
        joint.likelihood() - cost(joint.terms(), self.samples())
    }

    /// Fitted samples of all rides.
    pub fn samples(&self) -> usize {
        self.searches.iter().map(|s| s.fitter.samples).sum()
    }
}

impl Joint {
    /// The same with other fits of some axles.
    pub fn with(&self, fits: Vec<Fitted>) -> Joint {
        let each = self.models.iter().zip(fits);
        Joint {
            models: each.map(|(model, fit)| model.with(fit)).collect(),
            p_values: self.p_values.clone(),
            own: self.own.clone(),
        }
    }
}

/// Whether another model's merit and held-out score are as good as the best one's, by what was fitted or by all.
fn ties([best_merit, best_held]: [f64; 2], [merit, held]: [f64; 2]) -> bool {
    let fitted = best_merit - merit;
    fitted.min(fitted + best_held - held) < policy::TIE
}

/// Fits again from where they are, in turns with their own noise, until neither moves.
pub fn settled(together: &Together, fits: Vec<Fitted>, effort: Effort) -> Option<Vec<Fitted>> {
    let again = |fits: &Vec<Fitted>| {
        let points: Vec<_> = fits.iter().map(|f| f.point.clone()).collect();
        let noise_models: Vec<_> = fits.iter().map(|f| f.noise_models.clone()).collect();
        together.fit(&points, &noise_models, effort)
    };
    until_still(fits, |fits| sum(fits), again)
}

pub fn sum(fits: &[Fitted]) -> f64 {
    fits.iter().map(|f| f.likelihood).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;
    use veloid_core::bicycle::Axle;
    use veloid_model::effects::Kind;

    #[test]
    fn a_set_ties_by_what_was_fitted_or_by_all() {
        let behind = |fitted: f64, all: f64| {
            let merit = 100.0 - fitted * policy::TIE;
            let held = 40.0 - (all - fitted) * policy::TIE;
            ties([100.0, 40.0], [merit, held])
        };
        assert!(behind(0.99, 9.0) && behind(9.0, 0.99));
        assert!(!behind(1.01, 1.01));
    }

    #[test]
    fn the_likelihood_of_all_rides_is_the_sum_and_fits_replace_each_ones_own() {
        let dataset = example::dataset();
        let cubic = example::term(Kind::CubicStiffness, Axle::Front);
        let model = |likelihood: f64| {
            let mut model = example::model(&dataset, &[]);
            model.fits[1].likelihood = likelihood;
            Model::new(Vec::new(), model.fits)
        };
        let joint = Joint {
            models: vec![model(3.0), model(4.0)],
            p_values: vec![(cubic, 0.01)],
            own: Vec::new(),
        };
        assert_eq!(joint.likelihood(), 3.0 + 4.0);
        let fit = |likelihood: f64| Fitted {
            likelihood,
            ..example::model(&dataset, &[(cubic, 1.0)]).fits[0].clone()
        };
        let larger = joint.with(vec![fit(10.0), fit(20.0)]);
        assert_eq!(sum(&[fit(10.0), fit(20.0)]), 30.0);
        assert_eq!(larger.terms(), [cubic]);
        let each: Vec<f64> = larger.models.iter().map(|m| m.likelihood).collect();
        assert_eq!(each, [13.0, 24.0]);
        assert_eq!(larger.p_values, joint.p_values);
    }

    #[test]
    fn rides_have_in_common_what_all_may_show_and_is_no_rides_own_affair() {
        let dataset = example::dataset();
        let [cubic, friction, step] = [Kind::CubicStiffness, Kind::CoulombFriction, Kind::MassStep]
            .map(|kind| example::term(kind, Axle::Front));
        let search = |candidates: &[Term]| Search {
            candidates: candidates.to_vec(),
            ..example::search(&dataset)
        };
        let rides = Rides {
            searches: vec![search(&[cubic, friction, step]), search(&[cubic, step])],
            alpha: 0.05,
            seed: 1,
        };
        let (common, off) = rides.candidates();
        assert_eq!(common, [cubic]);
        let ids: Vec<&str> = off.iter().map(|off| off.id.as_str()).collect();
        assert_eq!(ids, [Kind::MassStep.id()]);
        assert_eq!(rides.samples(), 2 * rides.searches[0].fitter.samples);
    }
}
