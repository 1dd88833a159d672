//! What windows of an axle's record say of each effect: which set of effects leaves least of windows that it was not fitted to.

use rayon::prelude::*;

use super::affirm;
use crate::policy;
use crate::search::Search;
use crate::search::in_windows::{InWindows, Seen};
use veloid_core::EngineError;
use veloid_model::dataset::Windows;
use veloid_model::fit::Term;
use veloid_model::law::{MAX_PARAMETERS, Scale};

/// Single effects that are tried beside others.
const BESIDE: usize = 12;

/// Results of an axle's windows of one length.
pub struct Sight {
    /// Dominant period, and length of a window (s).
    pub period: f64,
    pub length: f64,
    pub plain: Seen,
    /// The model that was found.
    pub found: Seen,
    pub effects: Vec<Supported>,
    /// Single effects, the best first, with what they leave.
    pub single: Vec<(Term, f64)>,
}

/// An effect of the model that windows found.
#[derive(Clone)]
pub struct Supported {
    pub term: Term,
    /// Share that it takes off the model without it, and loud blocks: all, and those in which it leads.
    pub share: f64,
    pub blocks: [usize; 2],
    /// The effect that comes nearest in its place with as few parameters, and what it leaves beside this one's.
    pub rival: Option<(Term, f64)>,
    /// The same blocks where neither fits nor the search saw them ([`outer`](super::outer)); nothing where that was not asked.
    pub unseen: Option<[usize; 2]>,
}

impl Supported {
    /// Whether that is enough to affirm it.
    pub fn holds(&self) -> bool {
        let [all, led] = self.blocks;
        self.share >= policy::TAKE
            && affirm::leads_in_most(led, all)
            && self.rival.is_none_or(|(_, ratio)| ratio >= policy::MARGIN)
    }

    /// Whether it leads in most blocks that nothing was fitted to or chosen by, where these were asked.
    pub fn is_proved(&self) -> bool {
        let leads = |[all, led]: [usize; 2]| affirm::leads_in_most(led, all);
        self.unseen.is_none_or(leads)
    }

    /// Whether that holds in ordinary windows, where no other effect may come near.
    pub fn leads(&self) -> bool {
        self.holds() && self.rival.is_none_or(|(_, ratio)| ratio >= policy::AHEAD)
    }
}

/// The effects that were found, come nearest to one that was, or are among so many of the best single ones.
pub fn shortlist(first: &Sight, single: usize) -> Vec<Term> {
    let single = first.single.iter().take(single).map(|(term, _)| *term);
    let rivals = first.effects.iter().filter_map(|e| Some(e.rival?.0));
    let near = single
        .chain(rivals)
        .chain(first.found.terms().iter().copied());
    let mut terms: Vec<Term> = near.collect();
    terms.sort();
    terms.dedup();
    terms
}

/// What windows of one length say of an axle; nothing where the budget is spent.
pub fn look(
    search: &Search,
    axle: &InWindows,
    windows: &Windows,
) -> Result<Option<Sight>, EngineError> {
    let Some(led) = find(search, axle)? else {
        return Ok(None);
    };
    let effects = led.supported();
    let single =
        (led.tables.first().into_iter().flatten()).map(|seen| (seen.terms()[0], seen.left()));
    Ok(Some(Sight {
        period: windows.period,
        length: windows.length() as f64 * search.fitter.dataset.step,
        single: single.collect(),
        effects,
        plain: led.plain,
        found: led.found,
    }))
}

/// The model that windows of one length lead to; nothing where the budget is spent.
pub fn find<'a>(search: &Search, axle: &'a InWindows<'a>) -> Result<Option<Led<'a>>, EngineError> {
    let Some(plain) = axle.plain() else {
        return Ok(None);
    };
    let mut led = Led {
        axle,
        found: plain.clone(),
        plain,
        tables: Vec::new(),
    };
    while has_room(led.found.terms()) {
        search.check()?;
        if search.is_spent() {
            return Ok(None);
        }
        let table = led.table(&led.found);
        let next = next(&led.plain, &led.found, &table).cloned();
        led.tables.push(table);
        match next {
            Some(next) => led.found = next,
            None => break,
        }
    }
    Ok(Some(led))
}

/// Whether one more effect may be looked for beside these.
fn has_room(terms: &[Term]) -> bool {
    terms.len() < policy::MOST_BY_WINDOWS
}

/// The simplest of the best of those models, those that leave least first, that take enough off what was `found` and lead.
fn next<'t>(plain: &Seen, found: &Seen, table: &'t [Seen]) -> Option<&'t Seen> {
    let enough = |s: &&Seen| {
        let taken = found.left() - s.left();
        taken >= policy::TAKE * found.left()
            && taken >= policy::OF_THE_RECORD * plain.left()
            && leads(s, found)
    };
    let best = table.iter().find(enough)?.left();
    let near = table
        .iter()
        .filter(enough)
        .filter(|s| s.left() < policy::MARGIN * best);
    near.min_by_key(|s| parameters(s.terms()))
}

/// Where a search by windows has come to.
pub struct Led<'a> {
    axle: &'a InWindows<'a>,
    pub plain: Seen,
    /// The model that was found.
    pub found: Seen,
    /// By round all models with one effect more, the best first.
    tables: Vec<Vec<Seen>>,
}

impl Led<'_> {
    /// All models with one effect more, those that leave least first.
    fn table(&self, found: &Seen) -> Vec<Seen> {
        let candidates: Vec<Term> = match found.terms().is_empty() {
            true => self.axle.candidates.clone(),
            false => (self.tables.first().into_iter().flatten().take(BESIDE))
                .map(|seen| seen.terms()[0])
                .filter(|term| !found.terms().contains(term))
                .collect(),
        };
        let with = |term: &Term| {
            let seen = self.axle.with(found, *term);
            seen.filter(|seen| self.axle.is_physical(seen))
        };
        let mut table: Vec<Seen> = candidates.par_iter().filter_map(with).collect();
        table.sort_by(|a, b| a.left().total_cmp(&b.left()));
        table
    }

    /// Each effect of a model with what speaks for it.
    fn supported(&self) -> Vec<Supported> {
        let (found, tables) = (&self.found, &self.tables);
        let of_term = |term: &Term| {
            let rest: Vec<Term> = found
                .terms()
                .iter()
                .filter(|t| *t != term)
                .copied()
                .collect();
            let known = (tables.iter().flatten()).find(|s| s.terms() == rest);
            let less = match (rest.is_empty(), known) {
                (true, _) => self.plain.clone(),
                (false, Some(known)) => known.clone(),
                (false, None) => self.axle.with(&self.plain, rest[0])?,
            };
            let others: Vec<Seen> = match tables
                .iter()
                .find(|t| t.iter().any(|s| s.terms() == found.terms()))
            {
                Some(table)
                    if table
                        .iter()
                        .all(|s| rest.iter().all(|r| s.terms().contains(r))) =>
                {
                    table.clone()
                }
                _ => self.table(&less),
            };
            let own = parameters(std::slice::from_ref(term));
            let rival = (others.iter())
                .filter(|s| !s.terms().contains(term))
                .filter_map(|s| Some((*s.terms().iter().find(|t| !rest.contains(t))?, s.left())))
                .filter(|(other, _)| parameters(&[*other]) <= own)
                .min_by(|a, b| a.1.total_cmp(&b.1));
            Some(Supported {
                term: *term,
                share: 1.0 - found.left() / less.left(),
                blocks: led(&found.errors, &less.errors),
                unseen: None,
                rival: rival.map(|(other, left)| (other, left / found.left())),
            })
        };
        found.terms().iter().filter_map(of_term).collect()
    }
}

/// Coefficients that are reported of effects: what only shapes a corner does not count.
pub fn parameters(terms: &[Term]) -> usize {
    let reported = |t: &Term| (t.kind.spec().report)(&[0.0; MAX_PARAMETERS], &Scale::TYPICAL).len();
    terms.iter().map(reported).sum()
}

/// Loud blocks of windows, and in how many of them one model errs less than another.
pub fn led(with: &[f64], without: &[f64]) -> [usize; 2] {
    let [with, without] = [with, without].map(blocks);
    let mean = without.iter().sum::<f64>() / without.len().max(1) as f64;
    let pairs = with.iter().zip(&without);
    let loud = pairs.filter(|(_, without)| **without >= policy::SILENT * mean);
    let led = loud.clone().filter(|(with, without)| with < without);
    [loud.count(), led.count()]
}

fn leads(with: &Seen, without: &Seen) -> bool {
    let [all, led] = led(&with.errors, &without.errors);
    affirm::leads_in_most(led, all)
}

/// Sums over blocks of neighbouring windows.
fn blocks(errors: &[f64]) -> Vec<f64> {
    affirm::blocks(errors.len(), policy::BLOCKS.min(errors.len()))
        .map(|block| errors[block].iter().sum())
        .collect()
}

#[cfg(test)]
pub mod example {
    use super::*;
    use veloid_model::effects::Kind;
    use veloid_model::fit::{Point, Unit};
    use veloid_report::diagnosis::Place;

    pub fn term(kind: Kind) -> Term {
        Term {
            kind,
            place: Place::Front,
        }
    }

    /// What single effects leave of a plain model that leaves 1.
    pub fn sight(single: &[(Kind, f64)]) -> Sight {
        let point = Point {
            base: vec![veloid_core::plant::Coefficients::default()],
            values: Vec::new(),
            initial: Vec::new(),
        };
        let plain = Seen {
            unit: Unit {
                tracks: vec![0],
                terms: Vec::new(),
            },
            folds: [point.clone(), point.clone()],
            point,
            errors: vec![1.0; 4],
        };
        Sight {
            period: 1.0,
            length: 1.0,
            found: plain.clone(),
            plain,
            effects: Vec::new(),
            single: single
                .iter()
                .map(|(kind, left)| (term(*kind), *left))
                .collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::example::{sight, term};
    use super::*;
    use veloid_model::effects::Kind;

    /// What a model with some effects leaves of each of ten windows.
    fn seen(kinds: &[Kind], errors: [f64; 10]) -> Seen {
        let mut seen = sight(&[]).plain;
        seen.unit.terms = kinds.iter().map(|kind| term(*kind)).collect();
        seen.errors = errors.into();
        seen
    }

    #[test]
    fn an_effect_holds_that_takes_enough_leads_and_is_ahead_of_its_rival() {
        let supported = |share: f64, led: usize, ratio: f64| Supported {
            term: term(Kind::CubicStiffness),
            share: share * policy::TAKE,
            blocks: [1000, led],
            rival: Some((term(Kind::CoulombFriction), ratio)),
            unseen: None,
        };
        let led = |times: f64| (times * policy::LEAD * 1000.0) as usize;
        let holds = |share, led, ratio| supported(share, led, ratio * policy::MARGIN).holds();
        assert!(holds(1.01, led(1.01), 1.01));
        assert!(!holds(0.99, led(1.01), 1.01));
        assert!(!holds(1.01, led(0.99), 1.01));
        assert!(!holds(1.01, led(1.01), 0.99));
        let leads = |ratio: f64| supported(1.01, 1000, ratio * policy::AHEAD).leads();
        assert!(leads(1.01) && !leads(0.99));
        let alone = Supported {
            rival: None,
            ..supported(1.01, 1000, 0.0)
        };
        assert!(alone.holds() && alone.leads());
    }

    #[test]
    fn the_next_effect_takes_enough_of_what_is_left_and_of_the_record() {
        let plain = seen(&[], [1.0; 10]);
        let found = |left: f64, taken: f64| {
            let before = seen(&[], [left; 10]);
            let table = [seen(&[Kind::CubicStiffness], [left - taken; 10])];
            next(&plain, &before, &table).is_some()
        };
        let enough = policy::TAKE;
        assert!(found(1.0, 1.01 * enough) && !found(1.0, 0.99 * enough));
        // Half of what is left, where that is hardly anything of the record.
        let little = policy::OF_THE_RECORD;
        assert!(found(2.02 * little, 1.01 * little) && !found(1.98 * little, 0.99 * little));
    }

    #[test]
    fn of_models_as_good_the_simplest_comes_next() {
        let plain = seen(&[], [1.0; 10]);
        let best = 0.2;
        let kind = |times: f64| {
            let table = [
                seen(&[Kind::SprungMass], [best; 10]),
                seen(&[Kind::CubicStiffness], [times * policy::MARGIN * best; 10]),
            ];
            next(&plain, &plain, &table).map(|s| s.terms()[0].kind)
        };
        assert_eq!(kind(0.99), Some(Kind::CubicStiffness));
        assert_eq!(kind(1.01), Some(Kind::SprungMass));
    }

    #[test]
    fn an_effect_that_does_not_lead_in_most_windows_is_not_next() {
        let plain = seen(&[], [1.0; 10]);
        // It takes all of some windows and errs a little more in the rest.
        let led = |windows: usize| {
            let errors = std::array::from_fn(|w| if w < windows { 0.0 } else { 1.01 });
            let table = [seen(&[Kind::CubicStiffness], errors)];
            next(&plain, &plain, &table).is_some()
        };
        let least = (policy::LEAD * policy::BLOCKS as f64).ceil() as usize;
        assert!(led(least) && !led(least - 1));
    }

    #[test]
    fn windows_are_compared_in_so_many_blocks_and_silent_ones_say_nothing() {
        let mut errors = vec![1.0; 4 * policy::BLOCKS];
        assert_eq!(blocks(&errors), vec![4.0; policy::BLOCKS]);
        assert_eq!(blocks(&errors[..3]), [1.0; 3]);
        // One block is at the limit of silence beside the mean of all, itself among them.
        let others = (policy::BLOCKS - 1) as f64;
        let limit = policy::SILENT * others / (policy::BLOCKS as f64 - policy::SILENT);
        let loud = |errors: &[f64]| {
            let mut plain = seen(&[], [0.0; 10]);
            plain.errors = errors.to_vec();
            led(&plain.errors, &plain.errors)[0]
        };
        errors[..4].fill(1.01 * limit);
        assert_eq!(loud(&errors), policy::BLOCKS);
        errors[..4].fill(0.99 * limit);
        assert_eq!(loud(&errors), policy::BLOCKS - 1);
    }

    #[test]
    fn windows_find_so_many_effects_on_an_axle() {
        let term = term(Kind::CubicStiffness);
        assert!(has_room(&[term; policy::MOST_BY_WINDOWS - 1]));
        assert!(!has_room(&[term; policy::MOST_BY_WINDOWS]));
    }
}
