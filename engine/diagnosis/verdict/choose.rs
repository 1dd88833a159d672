//! Which of the models that the search found is reported: one that a bicycle can be, and those that explain the ride as well.

use crate::policy;
use crate::search::attempt::Attempt;
use crate::search::offered::Offered;
use crate::search::{Named, Round, Search};
use veloid_core::EngineError;
use veloid_model::fit::physical::is_physical;
use veloid_model::fit::polish::reduce;
use veloid_model::fit::refine::refined;
use veloid_model::fit::{Model, Term};

/// The model that the search led to.
pub struct Chosen {
    pub model: Model,
    pub rounds: Vec<Round>,
    /// Others that explain the ride as well, best first.
    pub tied: Vec<Model>,
    /// What the search was offered at its end.
    pub offered: Option<Offered>,
    /// What was fitted to the end.
    pub attempts: Vec<Attempt>,
    /// Whether the search ended for want of budget.
    pub is_spent: bool,
}

/// Searches, and chooses among what was found.
pub fn choose(search: &Search) -> Result<Chosen, EngineError> {
    let Named {
        model: found,
        rounds,
        mut rivals,
        offered,
        attempts,
    } = search.run()?;
    let is_spent = search.is_spent();
    let possible = |model: &Model| is_physical(search.fitter.dataset, &search.plain, model);
    if !possible(&found) && found.terms.len() > 1 {
        rivals.extend(search.without_each(&found));
        rivals.sort_by(|a, b| b.likelihood.total_cmp(&a.likelihood));
    }
    rivals.retain(possible);
    // A model that no bicycle can have gives way to one that explains the ride nearly as well.
    let model = if possible(&found) {
        found
    } else {
        nearly(search, &found, &rivals).unwrap_or(found)
    };
    let tied = tied(search, &model, rivals);
    let finest = refined(&search.fitter, &model);
    let holds_out = search.held_score(&finest).is_finite();
    Ok(Chosen {
        model: if holds_out { finest } else { model },
        rounds,
        tied,
        offered,
        attempts,
        is_spent,
    })
}

/// The first of the rivals that explain the ride nearly as well as a model that no bicycle can have.
fn nearly(search: &Search, found: &Model, rivals: &[Model]) -> Option<Model> {
    let mut rivals = rivals.iter();
    let near = |r: &&Model| ties(search, found, r, policy::NEARLY_PHYSICAL);
    rivals
        .find(|r| near(r) && stands(search, found, r))
        .cloned()
}

/// Whether an effect that a rival has in another one's place would have been accepted by itself beside the rest.
fn stands(search: &Search, found: &Model, rival: &Model) -> bool {
    let (shared, own): (Vec<Term>, Vec<Term>) =
        (rival.terms.iter()).partition(|t| found.terms.contains(t));
    if shared.is_empty() || own.len() != 1 {
        return true;
    }
    let less = reduce(&search.fitter, rival, &shared, search.thorough(rival));
    less.is_some_and(|less| search.stands(&less, rival, &search.offers(&less, &shared)))
}

/// The first of the rivals that explain the ride as well as a model.
fn tied(search: &Search, model: &Model, rivals: Vec<Model>) -> Vec<Model> {
    let noisy = model.terms.iter().any(|t| search.has_noisy_road(*t));
    // Noise on the road leaves errors that a law of more numbers fits, and that are others on the held-out part.
    let is_ahead = |r: &Model| search.held_score(r) > search.held_score(model);
    let ties = |r: &Model| {
        r.terms != model.terms
            && (ties(search, model, r, policy::TIE)
                || noisy && ties(search, model, r, policy::NOISY_TIE) && is_ahead(r))
    };
    let tied = rivals.into_iter().filter(ties);
    tied.take(policy::MOST_TIES).collect()
}

/// Whether a rival explains the ride as well with no more effects, by fitted and held-out part together
/// and with what its parameters cost.
fn ties(search: &Search, model: &Model, rival: &Model, within: f64) -> bool {
    if rival.terms.len() > model.terms.len() || rival.likelihood < model.likelihood - 2.0 * within {
        return false;
    }
    let behind = search.merit(model) - search.merit(rival) + search.held_score(model)
        - search.held_score(rival);
    behind < within
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;
    use crate::search::criteria::cost;
    use veloid_core::bicycle::Axle;
    use veloid_model::effects::Kind;

    #[test]
    fn as_well_is_within_a_tie_and_the_first_of_them_are_told() {
        let dataset = example::dataset();
        let search = example::search(&dataset);
        // Laws of one number each that do nothing: they move alike and cost alike.
        let none = |kind, axle, behind: f64| {
            let model = example::model(&dataset, &[(example::term(kind, axle), 0.0)]);
            example::likely(model, 100.0 - behind)
        };
        let (cubic, progressive) = (Kind::CubicStiffness, Kind::ProgressiveStiffness);
        let model = none(cubic, Axle::Front, 0.0);
        let count = |rivals: Vec<Model>| tied(&search, &model, rivals).len();
        let rival = |times: f64| none(cubic, Axle::Rear, times * policy::TIE);
        assert_eq!(count(vec![rival(0.99)]), 1);
        assert_eq!(count(vec![rival(1.01)]), 0);
        // It does not tie with itself.
        assert_eq!(count(vec![model.clone()]), 0);
        let many = vec![rival(0.5); policy::MOST_TIES + 1];
        assert_eq!(count(many), policy::MOST_TIES);
        // Nor with a model of more effects.
        let terms = [cubic, progressive].map(|kind| (example::term(kind, Axle::Rear), 0.0));
        let larger = example::likely(example::model(&dataset, &terms), 1e3);
        assert_eq!(count(vec![larger]), 0);
    }

    #[test]
    fn noise_on_the_road_is_no_lead_where_the_held_out_part_sees_none() {
        let front = |kind| example::term(kind, Axle::Front);
        let (cubic, friction) = (front(Kind::CubicStiffness), front(Kind::CoulombFriction));
        let tied = |road_floor: f64, [of_model, of_rival]: [f64; 2], behind: f64| {
            let mut dataset = example::dataset();
            for track in &mut dataset.tracks {
                track.road_floor = road_floor * track.sensor_floor;
            }
            let model = example::model(&dataset, &[(cubic, of_model)]);
            let rival = example::model(&dataset, &[(friction, of_rival)]);
            let rival = example::likely(rival, model.likelihood - behind);
            !tied(&example::search(&dataset), &model, vec![rival]).is_empty()
        };
        // The ride has no cubic spring, so that a model with one errs more on the held-out part.
        let ahead = [1e9, 0.0];
        assert!(tied(1.0, ahead, 1.99 * policy::NOISY_TIE));
        assert!(!tied(1.0, ahead, 2.01 * policy::NOISY_TIE));
        assert!(!tied(0.0, ahead, 1.99 * policy::NOISY_TIE));
        // No further on the held-out part, it is behind by what it is on the fitted one.
        let even = [0.0, 0.0];
        assert!(tied(1.0, even, 0.99 * policy::TIE));
        assert!(!tied(1.0, even, 0.99 * policy::NOISY_TIE));
    }

    #[test]
    fn what_stands_in_for_it_is_no_noise_of_the_road() {
        let [cubic, friction, quadratic] = [
            Kind::CubicStiffness,
            Kind::CoulombFriction,
            Kind::QuadraticDamping,
        ]
        .map(|kind| example::term(kind, Axle::Front));
        // What does nothing shows nothing on the held-out part, which a noisy road asks for.
        let stands_in = |road_floor: f64| {
            let mut dataset = example::dataset();
            for track in &mut dataset.tracks {
                track.road_floor = road_floor * track.sensor_floor;
            }
            let found = example::model(&dataset, &[(cubic, 0.0), (friction, -1e-3)]);
            let rival = example::model(&dataset, &[(cubic, 0.0), (quadratic, 0.0)]);
            nearly(&example::search(&dataset), &found, &[rival]).is_some()
        };
        assert!(stands_in(0.0) && !stands_in(1.0));
    }

    #[test]
    fn what_no_bicycle_can_be_gives_way_within_reach() {
        let dataset = example::dataset();
        let search = example::search(&dataset);
        let friction = example::term(Kind::CoulombFriction, Axle::Front);
        let found = example::model(&dataset, &[(friction, -1e-3)]);
        assert!(!is_physical(&dataset, &search.plain, &found));
        let cubic = example::term(Kind::CubicStiffness, Axle::Front);
        let rival = example::model(&dataset, &[(cubic, 0.0)]);
        // By fitted and held-out part, by what parameters cost, and by what no bicycle can be.
        let held = search.held_score(&found) - search.held_score(&rival);
        let costs = [&found, &rival].map(|m| cost(&m.terms, search.fitter.samples));
        let even = held - costs[0] - policy::CLOSE + costs[1];
        let gives_way = |times: f64| {
            let behind = example::likely(rival.clone(), even - times * policy::NEARLY_PHYSICAL);
            nearly(&search, &found, &[behind]).is_some()
        };
        assert!(gives_way(0.99) && !gives_way(1.01));
    }
}
