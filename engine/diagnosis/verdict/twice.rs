//! What windows of two lengths say of an axle together.

use super::affirm::{self, is_material};
use super::outer;
use super::windows::{Sight, Supported, look, parameters, shortlist};
use crate::policy;
use crate::search::Search;
use crate::search::in_windows::{InWindows, Seen};
use veloid_core::EngineError;
use veloid_model::dataset::{Track, Windows};
use veloid_model::effects::Kind;
use veloid_model::fit::shooting::Prediction;
use veloid_model::fit::{Fitted, Term};
use veloid_model::law::Family;

/// Single effects that are tried again in other windows.
const AGAIN: usize = 6;

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
            let near = shortlist(first, AGAIN);
            axle.candidates.retain(|term| near.contains(term));
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
    let agreed = proved(search, track, (first, &divided[0]), agreed)?;
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

/// Those of the effects that lead in windows which neither fits nor the search saw, as far as the record has room for such.
fn proved(
    search: &Search,
    track: usize,
    first: (&Sight, &Windows),
    mut agreed: Vec<Supported>,
) -> Result<Vec<Supported>, EngineError> {
    let terms: Vec<Term> = agreed.iter().map(|e| e.term).collect();
    if let Some(proof) = outer::proof(search, track, first, &terms)? {
        let both = agreed.iter_mut().zip(proof);
        both.for_each(|(effect, unseen)| effect.unseen = Some(unseen));
    }
    agreed.retain(Supported::is_proved);
    Ok(agreed)
}

/// Whether a plain model that misses such a share of the force lacks nothing that is physics of the record.
pub fn is_little(missed: f64) -> bool {
    missed < policy::MISSES_LITTLE
}

/// A record in ordinary windows and in others: shorter ones, or where it has no room for these, between the ordinary ones.
pub fn divided(track: &Track, samples: usize) -> Option<[Windows; 2]> {
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
    let found: Vec<Term> = agreed.iter().map(|e| e.term).collect();
    for family in [Family::Spring, Family::Damper] {
        agreed.retain(|e| !affirm::is_part_of_a_curve(e.term, &found, family));
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::super::windows::example::{sight, term};
    use super::*;

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
    fn the_second_windows_are_shorter_or_lie_between() {
        let mut track = crate::example::dataset().tracks[0].clone();
        let swing = |samples: u32| -> Vec<f64> {
            let at = |i| (std::f64::consts::TAU * f64::from(i) / 50.0).sin();
            (0..samples).map(at).collect()
        };
        let mut of = |samples: u32| {
            track.set_road(&vec![0.0; samples as usize]);
            track.has_road = false;
            track.plant = &veloid_core::plant::Damper::MOVING;
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
