//! Proof apart from selection: the search by windows is repeated without some of them, and what it then finds is judged on those.
//!
//! Outer folds of interleaved windows, as in nested cross-validation (Stone 1974, doi:10.1111/j.2517-6161.1974.tb00994.x; Varma &
//! Simon 2006, doi:10.1186/1471-2105-7-91).

use std::ops::Range;

use super::windows::{Led, Sight, find, led, shortlist};
use crate::policy;
use crate::search::Search;
use crate::search::in_windows::{InWindows, Seen};
use veloid_core::EngineError;
use veloid_model::dataset::Windows;
use veloid_model::fit::Term;

/// Single effects that the search is repeated among, beside what was found and its rivals.
const AGAIN: usize = 3;

/// For each of some effects the loud blocks of windows that neither fits nor the search saw, and in how many of them it leads;
/// nothing where the record has too few windows, or the budget is spent. In a fold in which the search does not find an effect
/// again, it leads nowhere.
pub fn proof(
    search: &Search,
    track: usize,
    (sight, windows): (&Sight, &Windows),
    terms: &[Term],
) -> Result<Option<Vec<[usize; 2]>>, EngineError> {
    if terms.is_empty() || !are_enough(&windows.spans) {
        return Ok(None);
    }
    let whole = InWindows::new(search, track, windows);
    let count = windows.spans.len();
    let mut errors = vec![[vec![0.0; count], vec![0.0; count]]; terms.len()];
    for fold in 0..policy::OUTER_FOLDS {
        let (held, fitted) = parts(count, fold);
        let inner = Windows {
            spans: fitted.iter().map(|w| windows.spans[*w].clone()).collect(),
            ..*windows
        };
        let mut axle = InWindows::new(search, track, &inner);
        axle.candidates = shortlist(sight, AGAIN);
        let Some(again) = find(search, &axle)? else {
            return Ok(None);
        };
        for (term, errors) in terms.iter().zip(&mut errors) {
            for (errors, model) in errors.iter_mut().zip(compared(&axle, &again, *term)) {
                let judged = whole.held_out(&model, &held);
                (held.iter().zip(judged)).for_each(|(w, error)| errors[*w] = error);
            }
        }
    }
    Ok(Some(
        errors
            .iter()
            .map(|[with, without]| led(with, without))
            .collect(),
    ))
}

/// The model that was found and the same without an effect; twice the same where the effect is not in it.
fn compared(axle: &InWindows, again: &Led, term: Term) -> [Seen; 2] {
    let found = &again.found;
    let others: Vec<Term> = (found.terms().iter().copied())
        .filter(|other| *other != term)
        .collect();
    let less = match others.len() < found.terms().len() {
        true => axle.of_set(&again.plain, &others),
        false => None,
    };
    [found.clone(), less.unwrap_or_else(|| found.clone())]
}

/// Whether windows share no samples, and are so many that each fold leaves enough of them to a search.
fn are_enough(spans: &[Range<usize>]) -> bool {
    let apart = spans.windows(2).all(|pair| pair[0].end <= pair[1].start);
    apart
        && (0..policy::OUTER_FOLDS)
            .all(|fold| parts(spans.len(), fold).1.len() >= policy::FEWEST_WINDOWS)
}

/// The windows that a fold holds out, every so many, and those to which it fits: of many windows the neighbours of those held out are
/// in neither part.
fn parts(count: usize, fold: usize) -> (Vec<usize>, Vec<usize>) {
    let is_held = |w: usize| w % policy::OUTER_FOLDS == fold;
    let many = count >= policy::MANY_WINDOWS;
    let is_near =
        |w: usize| w.checked_sub(1).is_some_and(is_held) || (w + 1 < count && is_held(w + 1));
    let fitted = (0..count).filter(|w| !(is_held(*w) || many && is_near(*w)));
    (
        (0..count).filter(|w| is_held(*w)).collect(),
        fitted.collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_window_is_held_out_once_and_many_have_no_neighbours_among_the_fitted() {
        for count in [policy::MANY_WINDOWS - 1, policy::MANY_WINDOWS] {
            let mut held_out = vec![0; count];
            for fold in 0..policy::OUTER_FOLDS {
                let (held, fitted) = parts(count, fold);
                held.iter().for_each(|w| held_out[*w] += 1);
                let touches = |w: &usize| held.iter().any(|h| h.abs_diff(*w) <= 1);
                assert!(fitted.iter().all(|w| !held.contains(w)));
                assert_eq!(fitted.iter().any(touches), count < policy::MANY_WINDOWS);
            }
            assert!(held_out.iter().all(|times| *times == 1));
        }
    }

    #[test]
    fn folds_leave_as_many_windows_as_a_search_needs() {
        let apart = |count: usize| -> Vec<Range<usize>> {
            (0..count).map(|w| 10 * w..10 * w + 10).collect()
        };
        let least = (0..)
            .find(|count| are_enough(&apart(*count)))
            .unwrap_or_default();
        let left = |count: usize| {
            (0..policy::OUTER_FOLDS)
                .map(|fold| parts(count, fold).1.len())
                .min()
        };
        assert_eq!(left(least), Some(policy::FEWEST_WINDOWS));
        assert!(are_enough(&apart(policy::MANY_WINDOWS)));
        let overlapping: Vec<Range<usize>> = (0..least).map(|w| 5 * w..5 * w + 10).collect();
        assert!(!are_enough(&overlapping));
    }
}
