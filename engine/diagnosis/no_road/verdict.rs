//! From a ride with two accelerometers to a verdict.

use super::evidence::{Evidence, evidence};
use super::fit::Fit;
use super::gates;
use super::judged::Judged;
use super::late::Late;
use super::model::{Model, Sizes, axle_of, scale};
use super::nuisance::Course;
use super::predict::Predictor;
use super::record::Record;
use super::report::report;
use super::roles::{Role, is_linear, role};
use super::search::{Found, Search};
use super::settle::settled;
use super::spectral::Shifted;
use super::turned::Turned;
use crate::judge::numbers::Numbers;
use crate::judge::table::{Judgement, Rule, judge};
use crate::policy;
use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_core::{EngineError, Progress};
use veloid_model::effects::{ALL, Kind};
use veloid_model::fit::Term;
use veloid_model::law::{Scale, Values};
use veloid_report::diagnosis::{Diagnosis, Place, Verdict};
use veloid_ride::Ride;

const NO_PAIR: &str = "no pair of axles on one road follows the accelerations";

/// What physics a ride without a road shows. `unidentified`: why the spectra gave neither k nor B, which is said where nothing else is.
///
/// # Errors
/// Cancellation.
pub fn diagnose(
    ride: &Ride,
    bike: &Bike,
    unidentified: Option<&str>,
    progress: &dyn Progress,
) -> Result<Diagnosis, EngineError> {
    let examined = Examination {
        ride,
        bike,
        progress,
    }
    .run()?;
    Ok(examined.unwrap_or_else(|why| {
        Diagnosis::without_verdict(match unidentified {
            Some(unidentified) => format!("No result: {unidentified}."),
            None => format!("No verdict: {why}."),
        })
    }))
}

struct Examination<'a> {
    ride: &'a Ride,
    bike: &'a Bike,
    progress: &'a dyn Progress,
}

impl Examination<'_> {
    fn run(&self) -> Result<Result<Diagnosis, String>, EngineError> {
        let Some(wheelbase) = self.bike.wheelbase() else {
            return Ok(Err(
                "the bike file has no wheelbase (l_front_m, l_rear_m)".to_owned()
            ));
        };
        let record = match Record::new(self.ride, wheelbase, Axle::Front) {
            Ok(record) => record,
            Err(why) => return Ok(Err(why)),
        };
        let sizes = PerAxle {
            front: Some(sizes(self.bike, Axle::Front)),
            rear: Some(sizes(self.bike, Axle::Rear)),
        };
        let Some(begun) = begun(&record, &sizes) else {
            return Ok(Err(NO_PAIR.to_owned()));
        };
        self.check()?;
        if let Some(why) = gates::alike(&begun.fit) {
            return Ok(Err(why));
        }
        let candidates = candidates(self.ride, &begun.scales);
        let search = Search {
            record: &record,
            scales: &begun.scales,
            candidates: &candidates,
            linear: &begun.linear,
            progress: self.progress,
        };
        let Some(found) = search.run(begun.fit, begun.courses)? else {
            return Ok(Err(NO_PAIR.to_owned()));
        };
        let Some(evidence) = evidence(&search, &found) else {
            return Ok(Err(NO_PAIR.to_owned()));
        };
        self.check()?;
        if let Some(why) = gates::own_road(evidence.left) {
            return Ok(Err(why));
        }
        let judgement = judge(&evidence.scores, &Numbers::without_road());
        let late = Late::of(&record, &found.courses);
        let tied = tied(&found, &evidence);
        let detected = gained(&found, &evidence) >= wanted(&found.best.model.terms());
        let turned = match detected {
            true => self.turned(wheelbase, &begun.scales, &found),
            false => None,
        };
        let best = &found.best.model;
        let is_confirmed = |turned: &Turned| turned.gained() >= wanted(&best.terms());
        let is_sure = turned.as_ref().is_some_and(is_confirmed)
            && !is_rounded_off(best, record.rate_hz, &begun.scales);
        let judged = Judged {
            bike: self.bike,
            record: &record,
            scales: &begun.scales,
            candidates: &candidates,
            verdict: match (detected, late) {
                (true, _) if !is_sure => Verdict::Unnamed,
                (true, _) => verdict(&found, &evidence, &judgement, !tied.is_empty()),
                (false, Some(_)) => Verdict::Named,
                (false, None) => Verdict::NothingMissing,
            },
            best: if detected { &found.best } else { &found.plain },
            found: &found,
            evidence: &evidence,
            judgement: &judgement,
            late,
            tied,
            turned: turned.as_ref(),
        };
        Ok(Ok(report(&judged)))
    }

    fn turned(&self, wheelbase: f64, scales: &PerAxle<Scale>, found: &Found) -> Option<Turned> {
        let models = [&found.plain.model, &found.best.model];
        Turned::new(
            self.ride,
            wheelbase,
            scales,
            models,
            nuisances(&found.courses),
        )
    }

    fn check(&self) -> Result<(), EngineError> {
        match self.progress.cancelled() {
            true => Err(EngineError::Cancelled),
            false => Ok(()),
        }
    }
}

/// Where a search begins.
struct Begun {
    fit: Fit,
    courses: Vec<Course>,
    scales: PerAxle<Scale>,
    /// Pairs with a second mass, by their spectra.
    linear: Vec<Model>,
}

fn begun(record: &Record, sizes: &PerAxle<Sizes>) -> Option<Begun> {
    let shifted = Shifted::new(record);
    let starts = shifted.plain();
    let start = starts.first()?;
    let rough = sizes.map(|_, sizes| scale(record, sizes, [0.0, 0.0], &[]));
    let (fit, courses) = settled(record, &rough, &start.model(record), start.nuisances())?;
    let predictor = Predictor {
        record,
        scales: &rough,
        courses: &courses,
    };
    let moments = predictor.moments(&fit.model);
    let mut scales = rough.clone();
    for axle in Axle::BOTH {
        if let (Some(sizes), Some(moments)) = (sizes.get(axle), moments.get(axle)) {
            scales.set(axle, scale(record, sizes, fit.model.base(axle), moments));
        }
    }
    let linear = shifted.with_second_mass(start);
    let linear = linear.iter().map(|pair| pair.model(record)).collect();
    Some(Begun {
        fit,
        courses,
        scales,
        linear,
    })
}

/// Mean delay (s) and gain of the other axle's sensor.
fn nuisances(courses: &[Course]) -> [f64; 2] {
    let mean = |of: &dyn Fn(&Course) -> f64| {
        courses.iter().map(of).sum::<f64>() / courses.len().max(1) as f64
    };
    let late = |c: &Course| c.knots.iter().sum::<f64>() / c.knots.len().max(1) as f64;
    [mean(&late), mean(&|c| c.gain)]
}

fn sizes(bike: &Bike, axle: Axle) -> Sizes {
    Sizes {
        mass: bike.mass(axle).unwrap_or(1.0),
        static_load: bike.static_load(axle).unwrap_or(f64::NAN),
        wheel_radius: bike.wheel_radius(axle).unwrap_or(f64::NAN),
    }
}

/// What is looked for, and general laws that compete.
fn candidates(ride: &Ride, scales: &PerAxle<Scale>) -> Vec<Term> {
    let pedals = ride
        .cadence
        .as_ref()
        .is_some_and(|c| c.iter().any(|c| *c > 5.0));
    let has = |kind: Kind, axle: Axle| match kind {
        Kind::PedallingForce => pedals,
        Kind::WheelOutOfRound => scales.get(axle).is_some_and(|s| s.wheel_radius.is_finite()),
        _ => true,
    };
    let kinds = ALL.iter().filter(|kind| role(**kind) == Role::LookedFor);
    kinds
        .flat_map(|kind| {
            let axles = Axle::BOTH.into_iter().filter(|axle| has(*kind, *axle));
            axles.map(|axle| Term {
                kind: *kind,
                place: Place::from(axle),
            })
        })
        .collect()
}

/// Effects that differ so little here that they are one answer: a sprung mass held by its damper is a relaxing spring, and either axle's
/// line explains what the other's does.
fn is_twin(a: &Term, b: &Term) -> bool {
    (is_linear(a.kind) && is_linear(b.kind) && a.place == b.place)
        || (super::lines::has_line(a.kind) && a.kind == b.kind)
}

/// Whether a friction is none: its sign changes over a width that the logger would have shown to be sharp.
fn is_rounded_off(model: &Model, rate_hz: f64, scales: &PerAxle<Scale>) -> bool {
    let width = |(term, values): &(Term, Values)| {
        let scale = scales.get(axle_of(term)).unwrap_or(&Scale::TYPICAL);
        values[1] / scale.w_rms
    };
    let mut friction =
        (model.effects.iter()).filter(|(term, _)| term.kind == Kind::CoulombFriction);
    rate_hz > policy::SHARP_HZ && friction.any(|effect| width(effect) > policy::SHARP)
}

/// Whether a model that is so far behind explains the ride as well.
fn is_near(behind: f64) -> bool {
    behind < policy::BEHIND
}

/// Whether what one more effect would gain takes the names that lead by so much.
fn outweighs(left: f64, lead: f64) -> bool {
    left > policy::LEADS * lead
}

/// Sets with a twin in the place of one effect of the best that come near it.
fn tied(found: &Found, evidence: &Evidence) -> Vec<Vec<Term>> {
    let best = found.best.model.terms();
    let Some(least) = evidence.cost(&best) else {
        return Vec::new();
    };
    let is_tied = |terms: &Vec<Term>| {
        let other: Vec<&Term> = terms.iter().filter(|t| !best.contains(t)).collect();
        let gone: Vec<&Term> = best.iter().filter(|t| !terms.contains(t)).collect();
        match (&other[..], &gone[..]) {
            ([a], [b]) => is_twin(a, b) && evidence.cost(terms).is_some_and(|c| is_near(c - least)),
            _ => false,
        }
    };
    let sets = evidence.fits.iter().map(|fit| fit.model.terms());
    sets.filter(is_tied).collect()
}

/// Of effects that were detected.
fn verdict(found: &Found, evidence: &Evidence, judgement: &Judgement, is_tied: bool) -> Verdict {
    let best = &found.best.model;
    let named: Vec<Term> = judgement.named.iter().map(|e| evidence.terms[*e]).collect();
    let all_named = best.terms().iter().all(|term| named.contains(term));
    let is_general = best.effects.iter().any(|(t, _)| t.kind.spec().is_general);
    match judgement.rule {
        _ if is_general || outweighs(found.left, ahead(found, evidence)) => Verdict::Unnamed,
        _ if is_tied => Verdict::Ambiguous,
        Rule::Supported if all_named => Verdict::Named,
        _ => Verdict::Unnamed,
    }
}

/// What the best model gains over the plain one, both with the nuisances that suit the best one.
fn gained(found: &Found, evidence: &Evidence) -> f64 {
    let best = evidence.cost(&found.best.model.terms());
    let both = evidence.cost(&[]).zip(best);
    both.map_or(0.0, |(plain, best)| plain - best)
}

/// What effects must gain: of those that are linear as the axles are, patches and tracks that differ make something too.
fn wanted(terms: &[Term]) -> f64 {
    match terms.iter().all(|t| is_linear(t.kind)) {
        true => policy::LINEAR_DETECTED,
        false => policy::DETECTED,
    }
}

/// By how much the best model leads every one that lacks one of its effects, and is no twin.
fn ahead(found: &Found, evidence: &Evidence) -> f64 {
    let best = found.best.model.terms();
    let least = evidence.cost(&best).unwrap_or(f64::INFINITY);
    let twins = |terms: &[Term]| {
        best.iter()
            .all(|b| terms.iter().any(|t| t == b || is_twin(t, b)))
    };
    let sets = evidence.fits.iter().zip(&evidence.charged);
    let others = sets.filter(|(fit, _)| !twins(&fit.model.terms()));
    others
        .map(|(_, cost)| cost - least)
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_model::law::padded;

    #[test]
    fn twins_share_an_axle_or_a_line() {
        let term = |kind, place| Term { kind, place };
        let rider = term(Kind::SprungMass, Place::Rear);
        assert!(is_twin(&rider, &term(Kind::ViscoelasticTyre, Place::Rear)));
        assert!(!is_twin(
            &rider,
            &term(Kind::ViscoelasticTyre, Place::Front)
        ));
        let wheel = term(Kind::WheelOutOfRound, Place::Front);
        assert!(is_twin(&wheel, &term(Kind::WheelOutOfRound, Place::Rear)));
        assert!(!is_twin(&wheel, &term(Kind::PedallingForce, Place::Front)));
    }

    #[test]
    fn friction_is_sharp_where_the_logger_is_fast() {
        let term = Term {
            kind: Kind::CoulombFriction,
            place: Place::Rear,
        };
        let scales = PerAxle {
            front: None,
            rear: Some(Scale::TYPICAL),
        };
        let off = |width: f64, rate_hz| {
            let values = padded([30.0, width * Scale::TYPICAL.w_rms]);
            let model = Model::new([8.0, 3.0], [7.0, 2.0]).with(term, values);
            is_rounded_off(&model, rate_hz, &scales)
        };
        let fast = 1.01 * policy::SHARP_HZ;
        assert!(off(1.01 * policy::SHARP, fast) && !off(0.99 * policy::SHARP, fast));
        assert!(!off(1.01 * policy::SHARP, 0.99 * policy::SHARP_HZ));
    }

    #[test]
    fn linear_effects_must_gain_more() {
        let term = |kind| Term {
            kind,
            place: Place::Rear,
        };
        assert_eq!(wanted(&[term(Kind::SprungMass)]), policy::LINEAR_DETECTED);
        let both = [term(Kind::SprungMass), term(Kind::CoulombFriction)];
        assert_eq!(wanted(&both), policy::DETECTED);
    }

    #[test]
    fn names_stand_while_they_lead_by_more_than_is_left() {
        assert!(!outweighs(99.0 * policy::LEADS, 100.0) && outweighs(101.0 * policy::LEADS, 100.0));
        assert!(is_near(0.99 * policy::BEHIND) && !is_near(1.01 * policy::BEHIND));
    }
}
