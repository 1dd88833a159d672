//! A ride that no model explains to within its noise is searched once more, by the squares of the held-out error: what
//! takes off most leads, whatever its frequency. What is found then has to prove itself without any likelihood.

use super::affirm::{self, Claim, Jackknife};
use crate::policy;
use crate::search::Search;
use crate::search::criteria::explains_nearly_all;
use crate::search::extend::Reach;
use crate::search::refit::{SOME, first_of_each};
use veloid_core::EngineError;
use veloid_core::bicycle::PerAxle;
use veloid_model::dataset::Dataset;
use veloid_model::fit::physical::is_physical;
use veloid_model::fit::polish::reduce;
use veloid_model::fit::{Fitter, Model, Term};
use veloid_model::law::Family;

/// Models that are followed up in each round: the best of one alone often stands in for two others.
const WIDTH: usize = 2;
/// Sets of effects that are examined at most.
const EXAMINED: usize = 2;

/// Effects that are affirmed although something else is left, or at least are the nearest shape.
pub struct Partly {
    /// The model with these effects and others that do not hold, and the plain one, both fitted to the plain squares.
    pub model: Model,
    pub plain: Model,
    pub claims: Vec<Claim>,
    /// Standard errors by the delete-a-block jackknife: of what is reported of each claim's effect, and of k (N/m) and
    /// B (N s/m).
    pub effect_errors: Vec<Vec<f64>>,
    pub base_errors: PerAxle<[f64; 2]>,
    /// Errors in windows that were not fitted, where these affirm something.
    pub in_windows: PerAxle<Predictions>,
}

/// Errors of predictions over a part of a second window, each from a start of its own.
#[derive(Clone, Copy, Debug)]
pub struct Predictions {
    /// Over how long (s).
    pub horizon: f64,
    /// RMS (m, or N where a force is predicted) of the plain and the extended model.
    pub plain: f64,
    pub extended: f64,
}

/// A set of effects and what it leaves: the product over the axles of the shares of the plain model's held-out squares.
type Left = (f64, Model);

/// What is left on a record that is searched again.
pub struct Rest {
    /// Whether anything is left on each track.
    pub remains: Vec<bool>,
    /// Share of a model's held-out squares that a law wider than one of its names must leave for this to hold.
    pub outgrown: f64,
}

/// Searches the record again and keeps what holds of what makes its `rest`. Where nothing holds, the set that leaves least, if that is clearly less than the model that was `found` by likelihood leaves. No new set is
/// begun once the work done is `until`.
pub fn partly(
    search: &Search,
    record: &Dataset,
    rest: &Rest,
    found: &Model,
    until: u64,
) -> Result<Option<Partly>, EngineError> {
    let dataset = of_squares(record);
    let Some(again) = search_by_squares(search, &dataset, &rest.remains, until) else {
        return Ok(None);
    };
    let holds = |looked: &Examined| looked.claims.iter().any(|c| c.holds);
    let rounds = rounds(&again)?;
    let sets = rounds.last().map_or(Vec::new(), |last| chosen(last));
    let tried: Vec<Model> = rounds.into_iter().flatten().map(|(_, m)| m).collect();
    let mut looked: Vec<Examined> = Vec::new();
    for model in &sets {
        looked.extend(examined(&again, model, &tried, rest.outgrown));
        search.check()?;
        if looked.last().is_some_and(holds) || again.is_spent() {
            break;
        }
    }
    let squares = |m: &Model| again.held_squares(m).into_iter().product::<f64>();
    let nearer = |looked: &Examined| is_nearer(squares(&looked.model), squares(found));
    let place = (looked.iter().position(holds)).or_else(|| looked.iter().position(nearer));
    let kept = place.map(|i| looked.swap_remove(i));
    let kept = kept.map(|wide| as_limit(&again, &wide, &tried, rest.outgrown).unwrap_or(wide));
    Ok(kept.map(|kept| kept.into_partly(&again)))
}

/// What the effects of `core`, which all of several models have that explain the ride as well, take off by themselves; nothing unless
/// every one of them holds and together they take nearly all off what is missing.
pub fn of_core(search: &Search, record: &Dataset, model: &Model, core: &[Term]) -> Option<Partly> {
    let acts_on = |terms: &[Term], axle| terms.iter().any(|t| t.acts_on(axle));
    let remains: Vec<bool> = (search.fitter.dataset.tracks.iter())
        .map(|track| acts_on(&model.terms, track.axle))
        .collect();
    let dataset = of_squares(record);
    let again = search_by_squares(search, &dataset, &remains, search.until)?;
    let core = reduce(&again.fitter, model, core, search.thorough(model))?;
    let core = examined(&again, &core, &[], policy::OUTGROWN)?;
    let explains = (dataset.tracks.iter().zip(&remains))
        .filter(|(_, remains)| **remains)
        .all(|(track, _)| explains_nearly_all(again.left(track.axle, &core.model)));
    let holds = explains && core.claims.iter().all(|c| c.holds);
    holds.then(|| core.into_partly(&again))
}

/// The record for fits by plain squares.
pub fn of_squares(record: &Dataset) -> Dataset {
    let mut dataset = record.clone();
    dataset.noise_order = 0;
    dataset
}

/// The search of a record `of_squares` for what acts on the tracks where something `remains`; nothing if the plain model has no fit.
pub fn search_by_squares<'s>(
    search: &Search<'s>,
    dataset: &'s Dataset,
    remains: &[bool],
    until: u64,
) -> Option<Search<'s>> {
    let fitter = || Fitter {
        dataset,
        samples: search.fitter.samples,
    };
    Some(Search {
        plain: affirm::unweighted(&fitter(), &search.plain)?,
        fitter: fitter(),
        held: search.held.clone(),
        candidates: lasting(search, remains),
        alpha: search.alpha,
        seed: search.seed,
        until,
        budget: search.budget,
        progress: search.progress,
    })
}

/// The candidates for the tracks where something remains that act all the time, and not too slowly to be distinguished from a sensor's
/// own wandering.
fn lasting(search: &Search, remains: &[bool]) -> Vec<Term> {
    let tracks = search.fitter.dataset.tracks.iter().zip(remains);
    let lasts = |t: &&Term| {
        let spec = t.kind.spec();
        let mut left = tracks.clone().filter(|(_, remains)| **remains);
        !spec.local && !spec.slow && left.any(|(track, _)| t.acts_on(track.axle))
    };
    search.candidates.iter().filter(lasts).copied().collect()
}

/// Sets of one and of two effects, those that leave least first, as long as one more takes a good share off.
fn rounds(search: &Search) -> Result<Vec<Vec<Left>>, EngineError> {
    let plain = search.held_squares(&search.plain);
    let left = |m: Model| {
        let squares = search.held_squares(&m).into_iter().zip(&plain);
        (
            squares.map(|(left, plain)| left / plain).product::<f64>(),
            m,
        )
    };
    let mut rounds: Vec<Vec<Left>> = Vec::new();
    let mut front = vec![search.plain.clone()];
    let mut least = 1.0;
    while goes_on(rounds.len()) && !search.is_spent() {
        search.check()?;
        let reach = match rounds.is_empty() {
            true => Reach::Far,
            false => Reach::Near,
        };
        let refits = |m: &Model| search.refits(m, &search.offers(m, &m.terms), reach, SOME);
        let mut found: Vec<Left> = (front.iter().flat_map(refits))
            .filter(|m| is_physical(search.fitter.dataset, &search.plain, m) && !has_limit(m))
            .map(left)
            .filter(|(left, _)| left.is_finite())
            .collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        first_of_each(&mut found, |(_, m)| &m.terms);
        match found.first() {
            Some((best, _)) if takes_further(*best, least) => least = *best,
            _ => break,
        }
        front = found.iter().take(WIDTH).map(|(_, m)| m.clone()).collect();
        rounds.push(found);
    }
    Ok(rounds)
}

/// Whether sets of one effect more are looked at after so many rounds.
fn goes_on(rounds: usize) -> bool {
    rounds < policy::MOST_BESIDE_A_REST
}

/// Whether one more effect, with which the best set leaves `best`, takes a good share off the `least` that was left without.
fn takes_further(best: f64, least: f64) -> bool {
    best <= (1.0 - policy::FURTHER) * least
}

/// Whether a set leaves clearly less squares than another shape.
fn is_nearer(squares: f64, of_another: f64) -> bool {
    squares < policy::NEARER * of_another
}

/// Whether a law and its limit act at once: what the model leaves without one of them says nothing of either.
fn has_limit(model: &Model) -> bool {
    let terms = &model.terms;
    let is_limit = |narrow: &Term| terms.iter().any(|wide| affirm::is_limit(*narrow, *wide));
    terms.iter().any(is_limit)
}

/// The sets to examine: the best of the last round, with laws that are limits of others in the place of these where they leave
/// nearly as little.
fn chosen(last: &[Left]) -> Vec<Model> {
    let mut chosen: Vec<Model> = Vec::new();
    for (least, model) in last.iter().take(EXAMINED) {
        let narrower = last.iter().find(|(left, m)| {
            let differ = || m.terms.iter().zip(&model.terms).filter(|(a, b)| a != b);
            differ().count() == 1
                && differ().all(|(a, b)| affirm::is_limit(*a, *b))
                && left * policy::OUTGROWN <= *least
        });
        let model = narrower.map_or(model, |(_, m)| m);
        if chosen.iter().all(|m| m.terms != model.terms) {
            chosen.push(model.clone());
        }
    }
    chosen
}

/// A model with the claims of all its effects, and what blocks left out in turn say of it.
struct Examined {
    model: Model,
    claims: Vec<Claim>,
    /// Effects that would hold if blocks agreed on their size.
    supported: Vec<Term>,
    jackknife: Jackknife,
}

impl Examined {
    fn into_partly(self, search: &Search) -> Partly {
        let dataset = search.fitter.dataset;
        let of_claim = |claim: &Claim| self.jackknife.effect(dataset, claim.term);
        Partly {
            effect_errors: self.claims.iter().map(of_claim).collect(),
            base_errors: self.jackknife.base(dataset, &self.model),
            model: self.model,
            plain: search.plain.clone(),
            claims: self.claims,
            in_windows: PerAxle::default(),
        }
    }
}

/// A limit of a law that the record supports, where that holds alone: what a model that is not complete gains by the wider law may as
/// well be a part of what it lacks, and where the wider one has no size the limit may have one.
fn as_limit(search: &Search, wide: &Examined, tried: &[Model], outgrown: f64) -> Option<Examined> {
    let of_wide = |term: Term| wide.supported.iter().any(|w| affirm::is_limit(term, *w));
    let is_limit = |m: &&Model| matches!(m.terms[..], [term] if of_wide(term));
    let narrow = tried.iter().find(is_limit)?;
    let mut narrow = examined(search, narrow, tried, outgrown)?;
    narrow
        .claims
        .iter_mut()
        .for_each(|c| c.holds = c.holds_as_limit);
    narrow.claims.iter().any(|c| c.holds).then_some(narrow)
}

fn examined(search: &Search, model: &Model, tried: &[Model], outgrown: f64) -> Option<Examined> {
    let model = affirm::unweighted(&search.fitter, model)?;
    let mut claims = affirm::examine(search, &model, tried, outgrown);
    let supported = claims.iter().filter(|c| c.holds).map(|c| c.term).collect();
    let jackknife = Jackknife::new(&search.fitter, &model);
    for claim in &mut claims {
        let determines = jackknife.determines(&model, claim.term);
        claim.holds &= determines;
        claim.holds_as_limit &= determines;
    }
    without_curves(&mut claims);
    Some(Examined {
        model,
        claims,
        supported,
        jackknife,
    })
}

/// Two springs that draw a curve are not claimed.
fn without_curves(claims: &mut [Claim]) {
    let held = claims.iter().filter(|c| c.holds).map(|c| c.term);
    let held: Vec<Term> = held.collect();
    for claim in claims.iter_mut().filter(|c| c.holds) {
        if affirm::is_part_of_a_curve(claim.term, &held, Family::Spring) {
            (claim.holds, claim.holds_as_limit) = (false, false);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;
    use veloid_core::bicycle::Axle;
    use veloid_model::effects::Kind;
    use veloid_report::diagnosis::Support;

    #[test]
    fn two_springs_alike_in_both_directions_are_a_curve() {
        let claim = |kind, axle| Claim {
            term: example::term(kind, axle),
            support: Support::default(),
            holds: true,
            holds_as_limit: true,
        };
        let hold = |claims: &[(Kind, Axle)]| -> Vec<bool> {
            let mut claims: Vec<Claim> = claims.iter().map(|(k, a)| claim(*k, *a)).collect();
            without_curves(&mut claims);
            claims.iter().map(|c| c.holds).collect()
        };
        let (cubic, stop, friction) = (Kind::CubicStiffness, Kind::BumpStop, Kind::CoulombFriction);
        let front = Axle::Front;
        assert_eq!(
            hold(&[(cubic, front), (stop, front), (friction, front)]),
            [false, false, true]
        );
        assert_eq!(hold(&[(cubic, front), (stop, Axle::Rear)]), [true, true]);
    }

    #[test]
    fn one_more_effect_takes_a_good_share_to_be_looked_at() {
        let takes = |share: f64| takes_further(0.6 * (1.0 - share), 0.6);
        assert!(takes(1.01 * policy::FURTHER) && !takes(0.99 * policy::FURTHER));
    }

    #[test]
    fn sets_beside_a_rest_are_small() {
        assert!(goes_on(policy::MOST_BESIDE_A_REST - 1));
        assert!(!goes_on(policy::MOST_BESIDE_A_REST));
    }

    #[test]
    fn a_shape_gives_way_to_a_clearly_nearer_one() {
        let nearer = |share: f64| is_nearer(share * 3.0, 3.0);
        assert!(nearer(0.99 * policy::NEARER) && !nearer(1.01 * policy::NEARER));
    }

    #[test]
    fn a_limit_that_leaves_nearly_as_little_is_examined_in_the_place_of_its_law() {
        let alone = |kind| {
            let terms = vec![example::term(kind, Axle::Front)];
            Model::new(terms, Vec::new())
        };
        let examined = |left: f64| -> Vec<Kind> {
            let last = [
                (0.2, alone(Kind::Hysteresis)),
                (left, alone(Kind::CoulombFriction)),
            ];
            let first = chosen(&last).into_iter().map(|m| m.terms[0].kind);
            first.collect()
        };
        let bound = 0.2 / policy::OUTGROWN;
        assert_eq!(examined(0.99 * bound), [Kind::CoulombFriction]);
        assert_eq!(
            examined(1.01 * bound),
            [Kind::Hysteresis, Kind::CoulombFriction]
        );
    }

    #[test]
    fn a_law_and_its_limit_do_not_act_at_once() {
        let both = |kinds: [Kind; 2], axle| {
            let [a, b] = kinds;
            let terms = vec![example::term(a, Axle::Front), example::term(b, axle)];
            has_limit(&Model::new(terms, Vec::new()))
        };
        let law_and_limit = [Kind::Hysteresis, Kind::CoulombFriction];
        assert!(both(law_and_limit, Axle::Front) && !both(law_and_limit, Axle::Rear));
        assert!(!both([Kind::Hysteresis, Kind::CubicStiffness], Axle::Front));
    }
}
