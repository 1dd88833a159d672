//! What was found, in words.

use std::collections::BTreeMap;

use veloid_engine::document::format_number::{Number, Quantity, fixed};

use super::variables::{DATE, label, unit};
use super::view::{Categories, Category, Dependence, Influence, OwnSlope};
use crate::fleet::regression::{Coefficient, Prediction};
use crate::fleet::words::{capital, size, subject};
use crate::time;

/// A p-value below which a fact is said to matter.
const SURE: f64 = 0.05;
const DAY_MS: f64 = 86_400_000.0;

/// Everything in a few sentences.
pub fn of(found: &Dependence) -> String {
    let subject = subject(&found.axle, &found.name);
    let Some(level) = found.level else {
        return cannot(found, &subject);
    };
    let mut said = slopes(found, &capital(&subject));
    said.extend(found.facts.iter().flat_map(|fact| own(found, fact)));
    said.extend(
        found
            .categories
            .iter()
            .flat_map(|fact| effects(found, fact)),
    );
    let none = |fact: &Influence| fact.slope.is_none() && fact.own.is_empty();
    if found.facts.iter().all(none) && found.categories.iter().all(|fact| fact.reason.is_some()) {
        let value = size(level.value, level.margin(), &found.unit);
        said.push(format!("{} is {value}.", capital(&subject)));
    }
    for step in &found.steps {
        let verb = if step.size.value > 0.0 {
            "rose"
        } else {
            "fell"
        };
        let size = magnitude(&step.size, &found.unit);
        let day = time::day_in_words(&step.at);
        said.push(format!("On {} it {verb} by {size} on {day}.", step.bike));
    }
    if found
        .development
        .as_ref()
        .is_some_and(|d| d.drifts().is_some())
    {
        said.push("What is left drifts: add the date to the facts.".to_owned());
    }
    said.extend(unfitted(found));
    said.push(basis(found));
    said.join(" ")
}

/// What one fact does, if it is sure: "rises by 9 ± 1 kN/m per bar".
pub fn influence(fact: &Influence, unit: &str) -> Option<String> {
    let slope = fact.slope.filter(|slope| slope.p_value < SURE)?;
    Some(moves(&slope, unit, &per(fact)))
}

fn moves(slope: &Coefficient, unit: &str, per: &str) -> String {
    let verb = if slope.value > 0.0 { "rises" } else { "falls" };
    format!("{verb} by {} per {per}", magnitude(slope, unit))
}

fn slopes(found: &Dependence, subject: &str) -> Vec<String> {
    let mut said = Vec::new();
    let mut unsure = Vec::new();
    for fact in &found.facts {
        let Some(slope) = fact.slope else { continue };
        let who = if said.is_empty() { subject } else { "It" };
        match influence(fact, &found.unit) {
            Some(_) => said.push(format!(
                "{who} {}.",
                moves(&slope, &found.unit, &per_fact(fact))
            )),
            None => {
                let slope = size(slope.value, slope.margin(), &found.unit);
                unsure.push(format!("{} ({slope} per {})", label(&fact.name), per(fact)));
            }
        }
    }
    if !unsure.is_empty() {
        let who = if said.is_empty() { subject } else { "It" };
        said.push(format!(
            "{who} shows no dependence on {}.",
            unsure.join(", ")
        ));
    }
    said
}

/// The bicycles that differ from the others.
fn own(found: &Dependence, fact: &Influence) -> Option<String> {
    let each = |own: &OwnSlope| moves(&own.slope, &found.unit, &per_fact(fact));
    let named = |own: &OwnSlope| format!("{} {}", own.bike, each(own));
    let all = || fact.own.iter().map(named).collect::<Vec<_>>().join(", ");
    match (fact.own.as_slice(), fact.slope) {
        ([], _) => None,
        ([one], Some(_)) => Some(format!("{} differs: it {}.", one.bike, each(one))),
        (several, Some(_)) => Some(format!("{} bicycles differ: {}.", several.len(), all())),
        (_, None) => {
            let fact = label(&fact.name);
            Some(format!(
                "The bicycles have no common dependence on {fact}: {}.",
                all()
            ))
        }
    }
}

fn effects(found: &Dependence, fact: &Categories) -> Vec<String> {
    let effect = |category: &Category| {
        let effect = category.effect?;
        let side = if effect.value > 0.0 { "above" } else { "below" };
        let far = magnitude(&effect, &found.unit);
        let sure = if effect.p_value < SURE {
            ""
        } else {
            " (not significant)"
        };
        Some(format!("'{}' is {far} {side}{sure}", category.name))
    };
    let told: Vec<String> = fact.categories.iter().filter_map(effect).collect();
    match told.is_empty() {
        true => Vec::new(),
        false => vec![format!(
            "{} compared with '{}': {}.",
            capital(&label(&fact.fact)),
            fact.reference,
            told.join(", ")
        )],
    }
}

/// The facts that are not fitted, and why.
fn unfitted(found: &Dependence) -> Vec<String> {
    let numbers = found.facts.iter().filter(|fact| fact.own.is_empty());
    let numbers = numbers.filter_map(|fact| {
        let reason = fact.reason.as_ref()?;
        let correlation = fact
            .correlation
            .map_or_else(String::new, |r| format!(" (correlation {})", fixed(r, 2)));
        let name = capital(&label(&fact.name));
        Some(format!("{name} is not fitted: {reason}{correlation}."))
    });
    let words = found.categories.iter().filter_map(|fact| {
        let reason = fact.reason.as_ref()?;
        Some(format!(
            "{} is not fitted: {reason}.",
            capital(&label(&fact.fact))
        ))
    });
    numbers.chain(words).collect()
}

/// "Front stiffness at 2.5 bar (front tyre pressure): 118 ± 3 kN/m".
pub fn predicted(
    found: &Dependence,
    at: &BTreeMap<String, f64>,
    prediction: &Prediction,
    beyond: &[String],
) -> String {
    let place = |(name, value): (&String, &f64)| match name.as_str() {
        DATE => day(*value),
        name => {
            let unit = Some(unit(name)).filter(|unit| !unit.is_empty());
            let unit = unit.map_or_else(String::new, |unit| format!("\u{a0}{unit}"));
            format!("{}{unit} ({})", Number::rough(*value, 4), label(name))
        }
    };
    let places: Vec<String> = at.iter().map(place).collect();
    let margin = 0.5 * (prediction.high - prediction.low);
    let value = size(prediction.value, margin, &found.unit);
    let mut said = format!(
        "{} at {}: {value}",
        capital(&subject(&found.axle, &found.name)),
        places.join(", ")
    );
    if !beyond.is_empty() {
        let names: Vec<String> = beyond.iter().map(|name| label(name)).collect();
        said.push_str(&format!(
            "; outside the range of the rides in {}, where the line may bend",
            names.join(", ")
        ));
    }
    said
}

fn cannot(found: &Dependence, subject: &str) -> String {
    let without = match found.left_out {
        0 => String::new(),
        n => format!(", {} lack one of them", rides(n)),
    };
    let with = rides(found.rides);
    format!(
        "{with} with {subject} and these facts{without}: too few, or all alike, to fit anything."
    )
}

fn basis(found: &Dependence) -> String {
    let plain = |x: f64| size_alone(x, &found.unit);
    let of = match found.bikes {
        1 => "of one bicycle".to_owned(),
        n => format!("of {n} bicycles"),
    };
    let mut said = format!("From {} {of}", rides(found.rides));
    if let Some(between) = found.between_rides {
        said.push_str(&format!(
            "; rides scatter by {} beyond this and their own errors",
            plain(between)
        ));
    }
    if let Some(between) = found.between_bikes {
        said.push_str(&format!("; bicycles differ by {}", plain(between)));
    }
    if found.left_out > 0 {
        said.push_str(&format!("; {} left out", rides(found.left_out)));
    }
    said + "."
}

fn size_alone(value: f64, unit: &str) -> String {
    Quantity::rough(value, 2, unit).to_string()
}

fn magnitude(coefficient: &Coefficient, unit: &str) -> String {
    size(coefficient.value.abs(), coefficient.margin(), unit)
}

fn per(fact: &Influence) -> String {
    match (fact.name.as_str(), fact.unit.as_str()) {
        (DATE, _) => "day".to_owned(),
        (_, "") => "unit".to_owned(),
        (_, unit) => unit.to_owned(),
    }
}

fn rides(count: usize) -> String {
    match count {
        1 => "1 ride".to_owned(),
        n => format!("{n} rides"),
    }
}

/// "bar of front tyre pressure".
fn per_fact(fact: &Influence) -> String {
    match fact.name.as_str() {
        DATE => per(fact),
        name => format!("{} of {}", per(fact), label(name)),
    }
}

fn day(days: f64) -> String {
    let text = time::text((days * DAY_MS) as i64);
    text.get(..10).unwrap_or(&text).to_owned()
}
