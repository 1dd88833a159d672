//! Which of the models that the search found is reported: one that a bicycle can be, and those that explain the ride as well.

use crate::EngineError;
use crate::diagnosis::fit::Model;
use crate::diagnosis::fit::physical::is_physical;
use crate::diagnosis::fit::refine::refined;
use crate::diagnosis::policy;
use crate::diagnosis::search::{Named, Round, Search};

/// The model that the search led to.
pub struct Chosen {
    pub model: Model,
    pub rounds: Vec<Round>,
    /// Others that explain the ride as well, best first.
    pub tied: Vec<Model>,
    /// Whether the search ended for want of budget.
    pub is_spent: bool,
}

/// Searches, and chooses among what was found.
pub fn choose(search: &Search) -> Result<Chosen, EngineError> {
    let Named {
        model: found,
        rounds,
        mut rivals,
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
        let near = rivals
            .iter()
            .find(|r| ties(search, &found, r, policy::NEARLY_PHYSICAL));
        near.cloned().unwrap_or(found)
    };
    let tied = rivals
        .into_iter()
        .filter(|r| r.terms != model.terms && ties(search, &model, r, policy::TIE))
        .take(policy::MOST_TIES)
        .collect();
    let finest = refined(&search.fitter, &model);
    let holds_out = search.held_score(&finest).is_finite();
    Ok(Chosen {
        model: if holds_out { finest } else { model },
        rounds,
        tied,
        is_spent,
    })
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
