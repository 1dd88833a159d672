//! Each axle is judged whatever happens on the other: where no model explains the ride, what the library names on one axle alone is
//! asked again with the other as it is.

use crate::EngineError;
use crate::diagnosis::decide::{Decision, by_likelihood, is_swallowed};
use crate::diagnosis::fit::{Fitter, Term};
use crate::diagnosis::prepare::Prepared;
use crate::diagnosis::search::Search;
use crate::diagnosis::verdict::choose::choose;
use crate::report::diagnosis::{Place, Verdict};
use crate::settings::Settings;

/// Tracks on which the likelihood alone names what is missing, each with its decision; none where all or nothing is explained.
pub fn named(
    first: &Decision,
    prepared: &Prepared,
    search: &Search,
    settings: &Settings,
) -> Result<Vec<(usize, Decision)>, EngineError> {
    let mut found = Vec::new();
    if first.judged.len() < 2 {
        return Ok(found);
    }
    for (t, track) in prepared.scene.tracks.iter().enumerate() {
        let axle = track.axle;
        let alone = on_axle(search, |term| {
            term.acts_on(axle) && term.place != Place::Both
        });
        let own = by_likelihood(prepared, &alone, choose(&alone)?, &[t], settings)?;
        if own.verdict == Verdict::Named && !is_swallowed(&alone, &own, prepared.record()) {
            found.push((t, own));
        }
    }
    Ok(found)
}

/// The search among some candidates, with a budget of its own.
fn on_axle<'s>(search: &Search<'s>, is_candidate: impl Fn(&Term) -> bool) -> Search<'s> {
    let scene = search.fitter.scene;
    Search {
        fitter: Fitter {
            scene,
            samples: search.fitter.samples,
        },
        plain: search.plain.clone(),
        held: search.held.clone(),
        candidates: (search.candidates.iter().copied())
            .filter(is_candidate)
            .collect(),
        until: scene.work.done() + search.budget.first,
        ..*search
    }
}
