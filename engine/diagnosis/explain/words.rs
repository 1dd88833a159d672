//! The verdict in plain words.

use veloid_core::bicycle::{Axle, PerAxle};
use veloid_core::document::format_number::Quantity;
use veloid_report::diagnosis::{Base, Diagnosis, HeldOut, Place, Verdict};
use veloid_report::windows::Support;

fn at(place: Place) -> &'static str {
    match place {
        Place::Front => "front",
        Place::Rear => "rear",
        Place::Both => "both axles",
    }
}

fn set<'a>(effects: impl Iterator<Item = (&'a String, Place)>) -> String {
    effects
        .map(|(id, place)| format!("{} ({})", id.replace('_', " "), at(place)))
        .collect::<Vec<_>>()
        .join(" with ")
}

fn size(rms: f64, unit: &str) -> Quantity {
    Quantity::rough(rms, 3, unit)
}

/// Times the sensor's noise that what is left may be and still pass for it: noise floors are measured to within a third.
const NOISE: f64 = 1.3;

/// That nothing was found, and what that is worth.
fn nothing_missing(held_out: &PerAxle<HeldOut>) -> String {
    let louder = |(axle, held): (Axle, &HeldOut)| {
        let ([plain, _, floor], unit) = held.errors();
        let (rms, floor) = (plain?, floor?);
        (rms > NOISE * floor).then_some((axle, rms, floor, unit))
    };
    match held_out.iter().find_map(louder) {
        Some((axle, rms, floor, unit)) => format!(
            "This ride shows no effect beyond spring and damper, although they leave an error of {} at the {axle} axle, where the \
             sensor's noise is {}.",
            size(rms, unit),
            size(floor, unit)
        ),
        None => "A spring and a damper explain this ride to within its noise.".to_owned(),
    }
}

/// The verdict in one sentence, two where something else is left. For `cannot_tell` the diagnosis has its sentence already.
pub fn sentence(d: &Diagnosis) -> String {
    let base = match d.base {
        Base::SpringAndDamper => "",
        Base::Damper => "The record shows no spring, so the base model is a damper alone. ",
    };
    base.to_owned() + &verdict(d)
}

fn verdict(d: &Diagnosis) -> String {
    match d.verdict {
        Verdict::NothingMissing => nothing_missing(&d.held_out),
        Verdict::Named => {
            let parts = d.effects.iter().map(|e| e.sentence.as_str());
            improved(&listed(parts), d)
        }
        Verdict::NamedInPart => in_part(d),
        Verdict::CannotTell => d.sentence.clone(),
        Verdict::Ambiguous => ambiguous(d),
        Verdict::Unnamed => unnamed(d),
    }
}

/// What acts, and how far the error falls with it.
fn improved(what: &str, d: &Diagnosis) -> String {
    let gains = gains(d);
    let with = match d.effects.len() {
        1 => "it",
        _ => "them",
    };
    let text = match gains.is_empty() {
        true => format!("{what}."),
        false => format!("{what}; with {with} {gains}."),
    };
    capitalised(&text)
}

fn ambiguous(d: &Diagnosis) -> String {
    let found = set(d.effects.iter().map(|e| (&e.id, e.axle)));
    let others = d.alternatives.iter();
    let others: Vec<String> = others
        .map(|names| set(names.iter().map(|n| (&n.id, n.axle))))
        .collect();
    let next = match &d.next_ride {
        Some(next) => format!("To distinguish them: {}.", next.what),
        None => "None of the rides simulated for this purpose would distinguish them.".to_owned(),
    };
    let gains = gains(d);
    let gains = match gains.is_empty() {
        true => String::new(),
        false => format!(", with either {gains}"),
    };
    format!(
        "The model is missing either {found} or {}, and this ride does not distinguish them{gains}. {next}",
        others.join(" or ")
    )
}

fn unnamed(d: &Diagnosis) -> String {
    let place = |axle: Axle| {
        let location = d.location.get(axle).filter(|l| l.mismatch)?;
        Some(format!("the {axle} axle{}", in_state(&location.states)))
    };
    let places: Vec<String> = Axle::BOTH.into_iter().filter_map(place).collect();
    let found = set(d.effects.iter().map(|e| (&e.id, e.axle)));
    let nearest = match found.is_empty() {
        true => String::new(),
        false => format!(" The nearest is {found}, which does not explain the ride."),
    };
    format!(
        "At {} the model is missing something that no effect in the library explains.{nearest}",
        places.join(" and at ")
    )
}

/// What acts, and how much is left beside it.
fn in_part(d: &Diagnosis) -> String {
    let affirmed = d.effects.iter().filter(|e| e.affirmed);
    let parts: Vec<String> = affirmed
        .map(|e| match &e.support {
            Some(s) => format!("{} ({})", e.sentence, support(s)),
            None => e.sentence.clone(),
        })
        .collect();
    let left = (d.rest.iter())
        .flat_map(PerAxle::iter)
        .filter_map(|(axle, rest)| {
            let share = 100.0 * rest.share?;
            Some(format!(
                "{share:.2} % of the squared held-out error at the {axle} axle{}",
                in_state(&rest.states)
            ))
        });
    let left: Vec<String> = left.collect();
    let left = match left.is_empty() {
        true => String::new(),
        false => format!(" An unnamed part remains: {}.", left.join(" and ")),
    };
    improved(&listed(parts.iter().map(String::as_str)), d) + &left
}

/// How much an effect explains by itself, and how sure that is.
fn support(s: &Support) -> String {
    let share = s.share.map_or(String::new(), |share| {
        format!("{:.0} % of the squared held-out error, ", 100.0 * share)
    });
    format!(
        "{share}support {:.2} in {} parts of the record",
        s.weight, s.windows
    )
}

fn in_state(states: &[String]) -> String {
    states
        .first()
        .map_or(String::new(), |state| format!(" ({state})"))
}

/// How far the error falls on each axle.
fn gains(d: &Diagnosis) -> String {
    let several = d.held_out.iter().count() > 1;
    let gain = |(axle, held): (Axle, &HeldOut)| {
        let ([plain, extended, floor], unit) = held.errors();
        let (plain, extended) = (plain?, extended?);
        if extended >= 0.999 * plain {
            return None;
        }
        let noise = floor.map_or(String::new(), |floor| {
            format!(" (the sensor's noise is {})", size(floor, unit))
        });
        let of = if several {
            format!("{axle} ")
        } else {
            String::new()
        };
        let error = match held.horizon_s {
            Some(horizon) => format!("{of}error {} ahead", Quantity::rough(horizon, 2, "s")),
            None => format!("held-out {of}error"),
        };
        let (before, after) = (size(plain, unit), size(extended, unit));
        Some(format!("the {error} falls from {before} to {after}{noise}"))
    };
    listed(
        d.held_out
            .iter()
            .filter_map(gain)
            .collect::<Vec<_>>()
            .iter()
            .map(String::as_str),
    )
}

fn listed<'a>(parts: impl Iterator<Item = &'a str>) -> String {
    parts.collect::<Vec<_>>().join(" and ")
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use veloid_report::diagnosis::EffectReport;

    fn reported(left: f64, floor: Option<f64>) -> String {
        let held = HeldOut {
            plain_rms_m: Some(left),
            extended_rms_m: Some(left),
            noise_floor_m: floor,
            ..HeldOut::default()
        };
        let held_out = PerAxle {
            front: Some(held),
            rear: None,
        };
        nothing_missing(&held_out).replace('\u{a0}', " ")
    }

    fn effect(sentence: &str) -> EffectReport {
        EffectReport {
            id: "coulomb_friction".to_owned(),
            axle: Place::Front,
            parameters: std::collections::BTreeMap::new(),
            p_value: None,
            separation: None,
            affirmed: true,
            support: None,
            adequate: true,
            material: true,
            sentence: sentence.to_owned(),
        }
    }

    fn said(verdict: Verdict, effects: Vec<EffectReport>) -> String {
        let held = |plain, extended| HeldOut {
            plain_rms_m: Some(plain),
            extended_rms_m: Some(extended),
            ..HeldOut::default()
        };
        let d = Diagnosis {
            verdict,
            effects,
            held_out: PerAxle {
                front: Some(held(4.2e-4, 5e-5)),
                rear: Some(held(5e-5, 5e-5)),
            },
            ..Diagnosis::without_verdict(String::new())
        };
        sentence(&d).replace('\u{a0}', " ")
    }

    #[test]
    fn a_verdict_is_one_sentence_with_what_it_improves() {
        let friction = || effect("dry friction of 15 N at the front axle");
        assert_eq!(
            said(Verdict::Named, vec![friction()]),
            "Dry friction of 15 N at the front axle; with it the held-out front error falls from 0.42 mm to 0.05 mm."
        );
        let two = said(
            Verdict::Named,
            vec![friction(), effect("free play of 1 mm at the rear axle")],
        );
        assert!(
            two.contains(" and free play") && two.contains("; with them the "),
            "{two}"
        );
        let unnamed = said(Verdict::Unnamed, vec![friction()]);
        assert!(
            unnamed.ends_with(
                "The nearest is coulomb friction (front), which does not explain the ride."
            ),
            "{unnamed}"
        );
    }

    #[test]
    fn noise_is_only_what_the_sensor_may_have() {
        assert!(reported(5e-5, Some(5e-5)).contains("to within its noise"));
        assert!(reported(5e-5, None).contains("to within its noise"));
        assert!(reported(NOISE * 1.01e-6, Some(1e-6)).contains("the sensor's noise is 0.001 mm"));
    }
}
