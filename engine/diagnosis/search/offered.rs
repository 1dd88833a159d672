//! The effects that a model does not hold, along it.

use super::Search;
use super::null::Null;
use super::score_test::Signatures;
use super::sign_flips::{self, Scores};
use crate::policy;
use veloid_model::dataset::Track;
use veloid_model::fit::tangent::Tangent;
use veloid_model::fit::{Model, Term};
use veloid_report::diagnosis::Place;

/// The effects that a model does not hold, along it.
pub struct Offered {
    /// The effects that it does hold.
    taken: Vec<Term>,
    tangents: Vec<(Place, Tangent)>,
    pub offers: Vec<Signatures>,
    /// How each block of the residual scores them, by place.
    scores: Vec<(Place, Vec<Scores>)>,
    /// Gain (nats) that noise alone exceeds with probability `alpha` among all of them.
    by_chance: f64,
}

impl Offered {
    pub fn of(search: &Search, model: &Model) -> Self {
        Self::with_null(search, model, model, policy::MOST_TERMS + 1).0
    }

    /// Of `model`, along it or along the same model with other noise, with the null that this round of a search draws.
    pub fn with_null(search: &Search, model: &Model, along: &Model, round: usize) -> (Self, Null) {
        let tangents = search.tangents(along, &model.terms);
        let offers = search.offers_along(&tangents, along, &model.terms);
        let null = Null::new(&offers, search.seed, round);
        let scores = (tangents.iter())
            .map(|(place, tangent)| (*place, sign_flips::scores(&offers, (*place, tangent))))
            .collect();
        let by_chance = null.bound(search.alpha);
        let offered = Self {
            taken: model.terms.clone(),
            tangents,
            offers,
            scores,
            by_chance,
        };
        (offered, null)
    }

    /// Without the directions of its starts, which take most of the memory and are needed by refits alone.
    pub fn kept(mut self) -> Self {
        let starts = self.offers.iter_mut().flat_map(|offer| &mut offer.starts);
        starts.for_each(|start| start.basis = Vec::new());
        self
    }

    /// Whether these are what a model with the same effects is offered, however finely it was fitted since.
    pub fn is_beside(&self, model: &Model) -> bool {
        self.taken == model.terms
    }

    pub fn places(&self) -> impl Iterator<Item = Place> {
        self.tangents.iter().map(|(place, _)| *place)
    }

    pub fn tangent(&self, place: Place) -> Option<&Tangent> {
        let mut tangents = self.tangents.iter();
        tangents.find(|(p, _)| *p == place).map(|(_, t)| t)
    }

    /// Standard deviations that a score must reach to be significant among all of them.
    pub fn score_bound(&self) -> f64 {
        (2.0 * self.by_chance).sqrt()
    }

    /// p value (0 to 1) of the largest score of these effects on an axle.
    pub fn chance(&self, track: &Track, seed: u64) -> Option<f64> {
        let place = Place::from(track.axle);
        let (_, scores) = self.scores.iter().find(|(p, _)| *p == place)?;
        sign_flips::chance(scores, track.beyond_lifting, seed)
    }
}
