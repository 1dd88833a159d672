//! A ride that no model explains to within its noise is searched once more, by the squares of the held-out error: what
//! takes off most leads, whatever its frequency. What is found then has to prove itself without any likelihood.

use super::affirm::{self, Claim};
use crate::EngineError;
use crate::bicycle::PerAxle;
use crate::diagnosis::dataset::Scene;
use crate::diagnosis::fit::physical::is_physical;
use crate::diagnosis::fit::{Fitter, Model, Term};
use crate::diagnosis::search::Search;
use crate::diagnosis::search::extend::Reach;

/// Models that are followed up in each round: the best of one alone often stands in for two others.
const WIDTH: usize = 2;
/// Share of the held-out squares that one more effect must take off to be looked at.
const FURTHER: f64 = 0.4;
/// Sets of effects that are examined at most.
const EXAMINED: usize = 2;
/// Effects in a set at most: what needs three laws on an incomplete model may be anything.
const MOST: usize = 2;

/// Effects that are affirmed although something else is left.
pub struct Partly {
    /// The model with these effects and others that do not hold, and the plain one, both fitted to the plain squares.
    pub model: Model,
    pub plain: Model,
    pub claims: Vec<Claim>,
    /// Standard errors of k (N/m) and B (N s/m) by the delete-a-block jackknife.
    pub errors: PerAxle<[f64; 2]>,
}

/// Searches the record again and keeps what holds of that; `remains`: whether anything is left on each track.
pub fn partly(
    search: &Search,
    record: &Scene,
    remains: &[bool],
) -> Result<Option<Partly>, EngineError> {
    let mut scene = record.clone();
    scene.noise_order = 0;
    let fitter = || Fitter {
        scene: &scene,
        samples: search.fitter.samples,
    };
    let Some(plain) = affirm::unweighted(&fitter(), &search.plain) else {
        return Ok(None);
    };
    let again = Search {
        fitter: fitter(),
        plain: plain.clone(),
        held: search.held.clone(),
        candidates: lasting(search, remains),
        alpha: search.alpha,
        seed: search.seed,
        progress: search.progress,
    };
    let rounds = rounds(&again)?;
    let tried: Vec<Model> = rounds.iter().flatten().cloned().collect();
    let mut sets = chosen(&again, &rounds).into_iter();
    let kept = sets.find_map(|model| kept(&again, model, &tried));
    search.check()?;
    Ok(kept.map(|(model, claims)| Partly {
        errors: affirm::base_errors(&again, &model),
        model,
        plain,
        claims,
    }))
}

/// The candidates for the tracks where something remains that act all the time, and not too slowly to be told from a sensor's
/// own wandering.
fn lasting(search: &Search, remains: &[bool]) -> Vec<Term> {
    let tracks = search.fitter.scene.tracks.iter().zip(remains);
    let lasts = |t: &&Term| {
        let spec = t.kind.spec();
        let mut left = tracks.clone().filter(|(_, remains)| **remains);
        !spec.local && !spec.slow && left.any(|(track, _)| t.acts_on(track.axle))
    };
    search.candidates.iter().filter(lasts).copied().collect()
}

/// Sets of one and of two effects, those that leave least first, as long as one more takes a good share off.
fn rounds(search: &Search) -> Result<Vec<Vec<Model>>, EngineError> {
    let mut rounds: Vec<Vec<Model>> = Vec::new();
    let mut front = vec![search.plain.clone()];
    let mut least = 1.0;
    while rounds.len() < MOST {
        search.check()?;
        let reach = match rounds.is_empty() {
            true => Reach::Far,
            false => Reach::Near,
        };
        let refits = |m: &Model| search.refits(m, &search.offers(m, &m.terms), reach);
        let mut found: Vec<(f64, Model)> = (front.iter().flat_map(refits))
            .filter(|m| is_physical(search.fitter.scene, &search.plain, m))
            .map(|m| (left(search, &m), m))
            .filter(|(left, _)| left.is_finite())
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut seen: Vec<Vec<Term>> = Vec::new();
        found.retain(|(_, m)| {
            let new = !seen.contains(&m.terms);
            seen.push(m.terms.clone());
            new
        });
        let Some((best, _)) = found.first() else {
            break;
        };
        if *best > (1.0 - FURTHER) * least {
            break;
        }
        least = *best;
        rounds.push(found.into_iter().map(|(_, m)| m).collect());
        front = rounds
            .iter()
            .next_back()
            .into_iter()
            .flatten()
            .take(WIDTH)
            .cloned()
            .collect();
    }
    Ok(rounds)
}

/// The sets to examine: the best of the last round, with laws that are limits of others in the place of these where they leave
/// nearly as little.
fn chosen(search: &Search, rounds: &[Vec<Model>]) -> Vec<Model> {
    let Some(last) = rounds.last() else {
        return Vec::new();
    };
    let mut chosen: Vec<Model> = Vec::new();
    for model in last.iter().take(EXAMINED) {
        let narrower = last.iter().find(|m| {
            let differ = || m.terms.iter().zip(&model.terms).filter(|(a, b)| a != b);
            differ().count() == 1
                && differ().all(|(a, b)| affirm::is_limit(*a, *b))
                && left(search, m) * affirm::OUTGROWN <= left(search, model)
        });
        let model = narrower.unwrap_or(model);
        if chosen.iter().all(|m| m.terms != model.terms) {
            chosen.push(model.clone());
        }
    }
    chosen
}

/// A model with the claims of all its effects, if any of them holds.
fn kept(search: &Search, model: Model, tried: &[Model]) -> Option<(Model, Vec<Claim>)> {
    let model = affirm::unweighted(&search.fitter, &model)?;
    let claims = affirm::examine(search, &model, tried);
    claims.iter().any(|c| c.holds).then_some((model, claims))
}

/// Product over the axles of the shares of the plain model's held-out squares that a model leaves.
fn left(search: &Search, model: &Model) -> f64 {
    let tracks = search.fitter.scene.tracks.iter();
    tracks.map(|t| search.left(t.axle, model)).product()
}
