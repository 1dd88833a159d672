//! What windows of an axle's record say of each effect: which set of effects leaves least of windows that it was not fitted to.

use rayon::prelude::*;

use super::affirm::{self, is_material};
use crate::EngineError;
use crate::diagnosis::dataset::{Track, Windows};
use crate::diagnosis::effects::Kind;
use crate::diagnosis::fit::shooting::Prediction;
use crate::diagnosis::fit::{Fitted, Term};
use crate::diagnosis::law::Family;
use crate::diagnosis::law::{MAX_PARAMETERS, Scale};
use crate::diagnosis::policy;
use crate::diagnosis::search::Search;
use crate::diagnosis::search::in_windows::{InWindows, Seen};

/// Single effects that are tried again in other windows, and beside others.
const AGAIN: usize = 6;
const BESIDE: usize = 12;

/// What windows of one length say of an axle.
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
}

impl Supported {
    /// Whether that is enough to affirm it.
    pub fn holds(&self) -> bool {
        let [all, led] = self.blocks;
        self.share >= policy::TAKE
            && affirm::leads_in_most(led, all)
            && self.rival.is_none_or(|(_, ratio)| ratio >= policy::MARGIN)
    }
}

impl Supported {
    /// Whether that holds in ordinary windows, where no other effect may come near.
    fn leads(&self) -> bool {
        self.holds() && self.rival.is_none_or(|(_, ratio)| ratio >= policy::AHEAD)
    }
}

/// What windows of two lengths say of an axle.
pub struct Sights {
    pub of_length: Vec<Sight>,
    /// Effects that both lengths support, as the longer windows see them.
    pub agreed: Vec<Supported>,
    /// The model with these effects alone, by length.
    pub models: Vec<Seen>,
    /// The first of these on each of its windows.
    pub predictions: Vec<Prediction>,
    /// A model that is known, by length.
    pub known: Vec<Seen>,
}

impl Sights {
    /// Whether windows of both lengths say that another effect acts than `terms`: one with no more parameters, which is no wider law of
    /// theirs, takes enough of what the plain model leaves, and leaves clearly less than any of these.
    pub fn contradict(&self, terms: &[Term]) -> bool {
        let of_another = |term: &Term| {
            let is_wider = |own: &Term| affirm::is_limit(*own, *term);
            !terms.contains(term)
                && !terms.iter().any(is_wider)
                && parameters(&[*term]) <= parameters(terms)
        };
        self.of_length.iter().all(|sight| {
            let least = |some: &dyn Fn(&Term) -> bool| {
                let some = sight.single.iter().filter(|(term, _)| some(term));
                some.map(|(_, left)| *left).fold(f64::INFINITY, f64::min)
            };
            let other = least(&of_another);
            other <= (1.0 - policy::TAKE) * sight.plain.left()
                && least(&|term| terms.contains(term)) > policy::MARGIN * other
        })
    }
}

/// Looks for effects on one axle in windows of two lengths, or where the record has room for one in others of the same, and what
/// a `known` model leaves there; nothing where it has too few. `missed`: share of the force that the plain model misses.
pub fn look_twice(
    search: &Search,
    track: usize,
    missed: Option<f64>,
    known: Option<&Fitted>,
) -> Result<Option<Sights>, EngineError> {
    let dataset = search.fitter.dataset;
    if missed.is_some_and(is_little) {
        return Ok(None);
    }
    let Some(divided) = divided(&dataset.tracks[track], dataset.samples) else {
        return Ok(None);
    };
    let mut axles = divided
        .each_ref()
        .map(|windows| InWindows::new(search, track, windows));
    let mut sights = Vec::new();
    for (axle, windows) in axles.iter_mut().zip(&divided) {
        if let Some(first) = sights.first() {
            axle.candidates.retain(|term| is_near(first, *term));
        }
        sights.extend(look(search, axle, windows)?);
    }
    let [first, second] = &sights[..] else {
        return Ok(None);
    };
    let in_both = |e: &&Supported| {
        let mut again = second.effects.iter().filter(|o| o.term == e.term);
        let alone = first.effects.len() == 1;
        e.leads() && again.any(Supported::holds) && (alone || !is_of_sensor(e.term))
    };
    let agreed: Vec<Supported> = first.effects.iter().filter(in_both).cloned().collect();
    let agreed = upheld(&axles[0], first, agreed, noise(&dataset.tracks[track]));
    let terms: Vec<Term> = agreed.iter().map(|e| e.term).collect();
    let model = |(axle, sight): (&InWindows, &Sight)| match sight.found.terms() == terms {
        true => Some(sight.found.clone()),
        false => axle.of_set(&sight.plain, &terms),
    };
    let models: Option<Vec<Seen>> = axles.iter().zip(&sights).map(model).collect();
    let of_known = |fit: &Fitted| axles.iter().map(|axle| axle.known(fit)).collect();
    let known: Option<Vec<Seen>> = known.and_then(of_known);
    Ok(models.map(|models| Sights {
        predictions: match agreed.is_empty() {
            true => Vec::new(),
            false => axles[0].predictions(&models[0]),
        },
        known: known.unwrap_or_default(),
        of_length: sights,
        agreed,
        models,
    }))
}

/// Whether a plain model that misses such a share of the force lacks nothing that is physics of the record.
pub fn is_little(missed: f64) -> bool {
    missed < policy::MISSES_LITTLE
}

/// A record in ordinary windows and in others: shorter ones, or where it has no room for these, between the ordinary ones.
fn divided(track: &Track, samples: usize) -> Option<[Windows; 2]> {
    let of_length = |times| Windows::of(track, samples, times);
    let ordinary = of_length(1.0)?;
    let shorter = of_length(policy::SHORTER).filter(|w| w.length() < ordinary.length());
    let others = shorter.or_else(|| ordinary.between(samples))?;
    Some([ordinary, others])
}

/// The effects that explain most together and are no parts of a curve without a name, which a general law in their place may be too.
fn upheld(
    axle: &InWindows,
    sight: &Sight,
    mut agreed: Vec<Supported>,
    noise: f64,
) -> Vec<Supported> {
    // Two odd laws of one variable on an axle draw a curve that has no name; one of them beside a law that differs between the directions
    // does not, since a curve has one odd and one even part.
    for family in [Family::Spring, Family::Damper] {
        let is_one = |e: &Supported| e.term.kind.is_named(family) && e.term.kind.spec().is_odd;
        if agreed.iter().filter(|e| is_one(e)).count() > 1 {
            agreed.retain(|e| !is_one(e));
        }
    }
    let set = |terms: &[Term]| axle.of_set(&sight.plain, terms).map(|seen| seen.left());
    let all: Vec<Term> = agreed.iter().map(|e| e.term).collect();
    let nearest = (agreed.iter().filter_map(|e| e.rival))
        .map(|(_, ratio)| ratio)
        .reduce(f64::min);
    let material = |left: &f64| {
        let removed = 1.0 - left / sight.plain.left();
        agreed.iter().all(|e| is_material(removed, nearest, e.term))
    };
    let Some(left) = set(&all).filter(material) else {
        return Vec::new();
    };
    let outgrown = |replaced: &dyn Fn(&Term) -> bool, law: Kind| {
        let mut terms: Vec<Term> = all.iter().filter(|t| !replaced(t)).copied().collect();
        terms.extend(all.first().map(|t| Term { kind: law, ..*t }));
        set(&terms).is_some_and(|general| takes_more(general, left, noise))
    };
    let damps = |term: &Term| term.kind.is_named(Family::Damper);
    let is_curve =
        all.iter().any(damps) && Kind::general(Family::Damper).any(|law| outgrown(&damps, law));
    agreed.retain(|e| {
        let wider = e.term.kind.case_of();
        let is_part = is_curve && damps(&e.term);
        !(is_part || wider.is_some_and(|law| outgrown(&|t| *t == e.term, law)))
    });
    agreed
}

/// Whether a general law leaves so much less than named ones that it acts, where noise leaves something of any model.
fn takes_more(general: f64, left: f64, noise: f64) -> bool {
    let room = (left - noise).max(0.0);
    general < left - (1.0 - policy::OUTGROWN) * room
}

/// What the displacement sensor's noise leaves of any model at least, beside the record's variance; none where it is not known.
fn noise(track: &Track) -> f64 {
    let noise = track.sensor_noise().unwrap_or_default();
    (noise / track.spread().max(f64::MIN_POSITIVE)).powi(2)
}

/// Whether an effect belongs to a sensor. Beside another effect windows do not affirm it: what a sensor does to the phase of one law is
/// another law, and the first half of a window, which gives the starting state, takes its share.
fn is_of_sensor(term: Term) -> bool {
    term.kind.spec().on_sensor
}

/// Whether an effect was found, comes nearest to one that was, or is among the best single ones.
fn is_near(first: &Sight, term: Term) -> bool {
    let single = first.single.iter().take(AGAIN).map(|(term, _)| *term);
    let rivals = first.effects.iter().filter_map(|e| Some(e.rival?.0));
    let mut near = single
        .chain(rivals)
        .chain(first.found.terms().iter().copied());
    near.any(|other| other == term)
}

fn look(
    search: &Search,
    axle: &InWindows,
    windows: &Windows,
) -> Result<Option<Sight>, EngineError> {
    let Some(plain) = axle.plain() else {
        return Ok(None);
    };
    let mut look = Look {
        axle,
        plain: plain.clone(),
        single: Vec::new(),
    };
    let mut found = plain.clone();
    let mut tables: Vec<Vec<Seen>> = Vec::new();
    while has_room(found.terms()) {
        search.check()?;
        if search.is_spent() {
            return Ok(None);
        }
        let table = look.table(&found);
        if tables.is_empty() {
            look.single = table.iter().map(|s| (s.terms()[0], s.left())).collect();
        }
        let next = next(&look.plain, &found, &table).cloned();
        tables.push(table);
        match next {
            Some(next) => found = next,
            None => break,
        }
    }
    let effects = look.supported(&found, &tables);
    Ok(Some(Sight {
        period: windows.period,
        length: windows.length() as f64 * search.fitter.dataset.step,
        plain,
        effects,
        found,
        single: look.single,
    }))
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

struct Look<'a> {
    axle: &'a InWindows<'a>,
    plain: Seen,
    single: Vec<(Term, f64)>,
}

impl Look<'_> {
    /// All models with one effect more, those that leave least first.
    fn table(&self, found: &Seen) -> Vec<Seen> {
        let candidates: Vec<Term> = match found.terms().is_empty() {
            true => self.axle.candidates.clone(),
            false => (self.single.iter().take(BESIDE).map(|(term, _)| *term))
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
    fn supported(&self, found: &Seen, tables: &[Vec<Seen>]) -> Vec<Supported> {
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
                blocks: led(found, &less),
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

/// Loud blocks, and in how many of them one model leaves less than another.
fn led(with: &Seen, without: &Seen) -> [usize; 2] {
    let [with, without] = [with, without].map(|seen| blocks(&seen.errors));
    let mean = without.iter().sum::<f64>() / without.len().max(1) as f64;
    let pairs = with.iter().zip(&without);
    let loud = pairs.filter(|(_, without)| **without >= policy::SILENT * mean);
    let led = loud.clone().filter(|(with, without)| with < without);
    [loud.count(), led.count()]
}

fn leads(with: &Seen, without: &Seen) -> bool {
    let [all, led] = led(with, without);
    affirm::leads_in_most(led, all)
}

/// Sums over blocks of neighbouring windows.
fn blocks(errors: &[f64]) -> Vec<f64> {
    affirm::blocks(errors.len(), policy::BLOCKS.min(errors.len()))
        .map(|block| errors[block].iter().sum())
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::diagnosis::fit::{Point, Unit};
    use crate::report::diagnosis::Place;

    fn term(kind: Kind) -> Term {
        Term {
            kind,
            place: Place::Front,
        }
    }

    /// What single effects leave of a plain model that leaves 1.
    fn sight(single: &[(Kind, f64)]) -> Sight {
        let point = Point {
            base: vec![crate::plant::Coefficients::default()],
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

    #[test]
    fn another_effect_contradicts_at_both_lengths_alone() {
        let (cubic, friction) = (Kind::CubicStiffness, Kind::CoulombFriction);
        let ahead = [(cubic, 0.2), (friction, 1.01 * policy::MARGIN * 0.2)];
        let near = [(cubic, 0.2), (friction, 0.99 * policy::MARGIN * 0.2)];
        let contradict = |of_length: [&[(Kind, f64)]; 2], own: Kind| {
            let sights = Sights {
                of_length: of_length.map(sight).into(),
                agreed: Vec::new(),
                models: Vec::new(),
                predictions: Vec::new(),
                known: Vec::new(),
            };
            sights.contradict(&[term(own)])
        };
        assert!(contradict([&ahead, &ahead], friction));
        assert!(!contradict([&ahead, &near], friction));
        assert!(!contradict([&ahead, &ahead], cubic));
        // Neither what takes too little, nor a wider law, nor one with more numbers.
        let little = [(cubic, 1.01 * (1.0 - policy::TAKE)), (friction, 1.0)];
        assert!(!contradict([&little, &little], friction));
        let wider = [(Kind::Hysteresis, 0.1), (friction, 0.5)];
        assert!(!contradict([&wider, &wider], friction));
        let larger = [(Kind::SprungMass, 0.1), (friction, 0.5)];
        assert!(!contradict([&larger, &larger], friction));
    }

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
            led(&plain, &plain)[0]
        };
        errors[..4].fill(1.01 * limit);
        assert_eq!(loud(&errors), policy::BLOCKS);
        errors[..4].fill(0.99 * limit);
        assert_eq!(loud(&errors), policy::BLOCKS - 1);
    }

    #[test]
    fn a_plain_model_that_misses_little_of_the_force_lacks_nothing() {
        assert!(is_little(0.99 * policy::MISSES_LITTLE));
        assert!(!is_little(1.01 * policy::MISSES_LITTLE));
    }

    #[test]
    fn a_general_law_takes_more_of_what_is_above_the_noise() {
        let (left, noise) = (0.5, 0.1);
        let general = |times: f64| noise + times * policy::OUTGROWN * (left - noise);
        assert!(takes_more(general(0.99), left, noise));
        assert!(!takes_more(general(1.01), left, noise));
        // Where noise is all that is left there is no room for any.
        assert!(!takes_more(left, left, 2.0 * left));
    }

    #[test]
    fn windows_find_so_many_effects_on_an_axle() {
        let term = term(Kind::CubicStiffness);
        assert!(has_room(&[term; policy::MOST_BY_WINDOWS - 1]));
        assert!(!has_room(&[term; policy::MOST_BY_WINDOWS]));
    }

    #[test]
    fn the_second_windows_are_shorter_or_lie_between() {
        let mut track = crate::diagnosis::example::dataset().tracks[0].clone();
        let swing = |samples: u32| -> Vec<f64> {
            let at = |i| (std::f64::consts::TAU * f64::from(i) / 50.0).sin();
            (0..samples).map(at).collect()
        };
        let mut of = |samples: u32| {
            track.set_road(&vec![0.0; samples as usize]);
            track.has_road = false;
            track.plant = &crate::plant::Damper::MOVING;
            track.measured = swing(samples);
            track.valid = vec![true; samples as usize];
            divided(&track, samples as usize).unwrap()
        };
        let [ordinary, shorter] = of(6000).map(|w| w.length() as f64);
        assert!((shorter - policy::SHORTER * ordinary).abs() <= 1.0);
        // Six windows of 80 samples fill this record, and shorter ones would be of 100.
        let [ordinary, between] = of(480);
        assert_eq!(ordinary.length(), between.length());
        assert_eq!(
            between.spans[0].start,
            ordinary.spans[0].start + ordinary.length() / 2
        );
    }
}
