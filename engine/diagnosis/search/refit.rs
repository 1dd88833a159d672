//! Exact refits of what the signatures predict to gain.

use rayon::prelude::*;

use super::criteria::{Search, added};
use super::extend::{Reach, extend, is_far, joined, unstopped};
use super::null::Null;
use super::score_test::{Along, Signatures, signatures};
use crate::residual::omnibus::remainder;
use veloid_model::effects::Kind;
use veloid_model::fit::physical::is_physical;
use veloid_model::fit::polish::polish;
use veloid_model::fit::tangent::{Tangent, tangent_for};
use veloid_model::fit::{COARSE, Fitted, Model, Term, Unit, motions};
use veloid_report::diagnosis::Place;

/// Share of a significant gain below which a linear prediction is not followed up.
pub const HOPE: f64 = 0.4;
/// Gain (nats) above which one is where no significant gain is known, and share of the best prediction in any case.
pub const SOME: f64 = 2.0;
const LITTLE: f64 = 0.02;
/// Refits between which the budget is looked at.
const GROUP: usize = 16;
/// Share of the best candidate's gain from which one is fitted to the end: none is chosen with less than half of it, but first fits are
/// no more than near. (With 0.2 the rivals of a cogging drive's friction were unfitted.)
const WORTH: f64 = 0.05;
/// Candidates that are fitted to the end in every round.
pub const LEADERS: usize = 6;

impl Search<'_> {
    /// Signatures of every candidate outside `taken`.
    pub fn offers(&self, model: &Model, taken: &[Term]) -> Vec<Signatures> {
        self.offers_along(&self.tangents(model, taken), model, taken)
    }

    /// Signatures of every candidate outside `taken`, by the tangents of their places.
    pub fn offers_along(
        &self,
        tangents: &[(Place, Tangent)],
        model: &Model,
        taken: &[Term],
    ) -> Vec<Signatures> {
        let substeps = model.substeps(self.fitter.dataset, COARSE);
        self.open(taken)
            .par_iter()
            .filter_map(|term| {
                let (_, tangent) = tangents.iter().find(|(p, _)| *p == term.place)?;
                let along = Along {
                    fitter: &self.fitter,
                    tangent,
                    substeps,
                };
                Some(signatures(&[along], *term))
            })
            .filter(|s| !s.starts.is_empty())
            .collect()
    }

    fn open(&self, taken: &[Term]) -> Vec<Term> {
        let open = self.candidates.iter().filter(|t| !taken.contains(t));
        open.copied().collect()
    }

    /// The tangents of the places where candidates outside `taken` act.
    pub fn tangents(&self, model: &Model, taken: &[Term]) -> Vec<(Place, Tangent)> {
        let open = self.open(taken);
        let substeps = model.substeps(self.fitter.dataset, COARSE);
        [Place::Front, Place::Rear, Place::Both]
            .par_iter()
            .filter_map(|place| {
                let term = open.iter().find(|t| t.place == *place)?;
                Some((*place, tangent_for(&self.fitter, model, *term, substeps)))
            })
            .collect()
    }

    /// Whether any offer may turn out significant: its linear prediction comes near to that, or the model
    /// is too far from the ride for linear predictions to mean anything.
    pub fn promising(&self, model: &Model, offers: &[Signatures], null: &Null) -> bool {
        let most = offers
            .iter()
            .map(Signatures::predicted_gain)
            .fold(0.0, f64::max);
        most > HOPE * null.bound(self.alpha)
            || offers.iter().any(|o| o.term.kind.spec().slow)
            || self.is_far_anywhere(model)
    }

    /// Whether the model is far from the ride on any axle.
    pub fn is_far_anywhere(&self, model: &Model) -> bool {
        let far = |f: &Fitted| is_far(self.fitter.dataset, model, &f.unit);
        model.fits.iter().any(far)
    }

    /// Exact refits of the offers that predict more than a `least` gain, best first.
    pub fn refits(
        &self,
        model: &Model,
        offers: &[Signatures],
        reach: Reach,
        least: f64,
    ) -> Vec<Model> {
        let dataset = self.fitter.dataset;
        let most = offers
            .iter()
            .map(Signatures::predicted_gain)
            .fold(0.0, f64::max);
        let least = least.max(LITTLE * most);
        let near = |s: &Signatures| s.term.kind.spec().slow || s.predicted_gain() > least;
        let fitted = |s: &Signatures, reach: Reach| {
            if self.progress.cancelled() {
                return None;
            }
            extend(&self.fitter, model, s, self.quick(model), reach)
        };
        let mut found = self.in_groups(offers, near, |s| fitted(s, Reach::Near));
        // Where no start close to the model comes near to what an axle did, all are tried from afar there.
        let lost = |t: usize| reach == Reach::Far && !self.arrives(model, &found, t);
        let lost: Vec<bool> = (0..dataset.tracks.len()).map(lost).collect();
        let far = |s: &Signatures| {
            joined(dataset, model, s.term)
                .is_some_and(|u| is_far(dataset, model, &u) && u.tracks.iter().any(|t| lost[*t]))
        };
        found.extend(self.in_groups(offers, far, |s| fitted(s, Reach::Far)));
        found.sort_by(|a, b| b.likelihood.total_cmp(&a.likelihood));
        first_of_each(&mut found, |m| &m.terms);
        // The leaders once more, to the end and each under its own noise.
        let gain = |m: &Model| m.likelihood - model.likelihood;
        let most = found.first().map_or(0.0, gain);
        // Where none has gained yet, under a noise that has taken what is missing for its own, every one may.
        let leads = |m: &&Model| most <= 0.0 || gain(m) >= WORTH * most;
        let leaders = found.iter().take(LEADERS).take_while(leads).count();
        let rest = found.split_off(leaders);
        let near: Vec<Model> = found.into_par_iter().map(|m| self.polished(m)).collect();
        let mut found = match reach {
            Reach::Near => near,
            Reach::Far => self.settled(model, near, offers),
        };
        found.extend(rest);
        self.unstop(&mut found);
        found.sort_by(|a, b| b.likelihood.total_cmp(&a.likelihood));
        found
    }

    /// Refits the offers that are wanted, the most promising ones first, until the budget is spent; some of them in any case.
    fn in_groups(
        &self,
        offers: &[Signatures],
        wanted: impl Fn(&Signatures) -> bool,
        refit: impl Fn(&Signatures) -> Option<Model> + Sync,
    ) -> Vec<Model> {
        let mut order: Vec<&Signatures> = offers.iter().filter(|s| wanted(s)).collect();
        order.sort_by(|a, b| b.predicted_gain().total_cmp(&a.predicted_gain()));
        let mut found: Vec<Model> = Vec::new();
        for group in order.chunks(GROUP) {
            if self.is_spent() && !found.is_empty() {
                break;
            }
            found.par_extend(group.par_iter().filter_map(|s| refit(s)));
            self.report_progress();
        }
        found
    }

    /// Whether one of the models `found` comes near to what an axle did, or the best of them leaves nothing but noise.
    fn arrives(&self, model: &Model, found: &[Model], track: usize) -> bool {
        let on_track = |m: &&Model| new_units(model, m).any(|u| u.tracks.contains(&track));
        let near = |m: &Model| new_units(model, m).all(|u| !is_far(self.fitter.dataset, m, u));
        let all = || found.iter().filter(on_track);
        let best = all().max_by(|a, b| a.likelihood.total_cmp(&b.likelihood));
        all().any(near) || best.is_some_and(|m| self.explains(model, m))
    }

    /// Whether nothing but noise is left, however large, of the axles on which `larger` has something that
    /// `model` has not.
    fn explains(&self, model: &Model, larger: &Model) -> bool {
        let left = self.structured(larger);
        let mut tracks = new_units(model, larger).flat_map(|u| &u.tracks);
        tracks.all(|t| !left[*t])
    }

    /// Free play is the limit of stops on both sides with a soft spring between them: fits it from there where its own fit missed it.
    fn unstop(&self, found: &mut [Model]) {
        let of = |found: &[Model], kind: Kind, place: Place| {
            let has = |m: &Model| m.terms.contains(&Term { kind, place });
            found.iter().position(has)
        };
        for place in [Place::Front, Place::Rear] {
            let (Some(stop), Some(play)) = (
                of(found, Kind::BumpStop, place),
                of(found, Kind::FreePlay, place),
            ) else {
                continue;
            };
            let play_term = Term {
                kind: Kind::FreePlay,
                place,
            };
            let better = unstopped(
                &self.fitter,
                &found[stop],
                play_term,
                self.thorough(&found[stop]),
            );
            if let Some(better) = better
                && better.likelihood > found[play].likelihood
                && better.terms == found[play].terms
            {
                found[play] = better;
            }
        }
    }

    fn polished(&self, found: Model) -> Model {
        polish(&self.fitter, &found, self.quick(&found)).unwrap_or(found)
    }

    /// Candidates fitted from afar too where no bicycle can be what was found, or where the likelihood of a force with corners has many
    /// peaks, as long as more than noise is left to be found.
    fn settled(&self, model: &Model, near: Vec<Model>, offers: &[Signatures]) -> Vec<Model> {
        let doubtful = |m: &Model| {
            added(model, m).kind.spec().peaks || !is_physical(self.fitter.dataset, &self.plain, m)
        };
        let doubts: Vec<bool> = near.iter().map(doubtful).collect();
        if !doubts.contains(&true) {
            return near;
        }
        let left = self.structured(model);
        let again = |(near, doubt): (Model, bool)| {
            let term = added(model, &near);
            let misses = |m: &Model| {
                new_units(model, m)
                    .flat_map(|u| &u.tracks)
                    .any(|t| left[*t])
            };
            if !doubt || !misses(&near) {
                return near;
            }
            (offers.iter().find(|o| o.term == term))
                .and_then(|o| extend(&self.fitter, model, o, self.quick(model), Reach::Far))
                .map(|far| self.polished(far))
                .filter(|far| self.merit(far) > self.merit(&near))
                .unwrap_or(near)
        };
        near.into_par_iter().zip(doubts).map(again).collect()
    }

    /// Whether a model leaves more than noise, by track.
    fn structured(&self, model: &Model) -> Vec<bool> {
        let motions = motions(self.fitter.dataset, model);
        let of_track =
            |t| remainder(&self.fitter, model, &motions, t, &self.held).is_structured(self.alpha);
        let tracks = 0..self.fitter.dataset.tracks.len();
        tracks.into_par_iter().map(of_track).collect()
    }
}

/// Keeps the first of all that have the same terms.
pub fn first_of_each<T>(found: &mut Vec<T>, terms: impl Fn(&T) -> &Vec<Term>) {
    let mut seen: Vec<Vec<Term>> = Vec::new();
    found.retain(|one| {
        let new = !seen.contains(terms(one));
        seen.push(terms(one).clone());
        new
    });
}

/// The units of `larger` that are not the model's.
fn new_units<'m>(model: &'m Model, larger: &'m Model) -> impl Iterator<Item = &'m Unit> {
    let known = |u: &&Unit| model.fits.iter().any(|f| f.unit == **u);
    larger
        .fits
        .iter()
        .map(|f| &f.unit)
        .filter(move |u| !known(u))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;
    use veloid_core::bicycle::Axle;
    use veloid_core::numerics::autoregressive::NoiseModel;

    #[test]
    fn an_axle_is_reached_by_candidates_of_its_own_only() {
        let dataset = example::dataset();
        let search = example::search(&dataset);
        let with = |axle, k3| {
            let term = example::term(Kind::CubicStiffness, axle);
            example::model(&dataset, &[(term, k3)])
        };
        let plain = example::model(&dataset, &[]);
        let mut lost = with(Axle::Front, 1e11);
        lost.fits[0].noise_models = vec![NoiseModel::white(dataset.tracks[0].scale.d_rms.powi(2))];
        let found = [lost, with(Axle::Rear, 0.0)];
        assert!(!search.arrives(&plain, &found, 0));
        assert!(search.arrives(&plain, &found, 1));
        assert!(search.arrives(&plain, &[with(Axle::Front, 0.0)], 0));
    }
}
