//! What was found, in words.

use std::collections::BTreeMap;

use veloid_engine::document::format_number::{Number, Quantity, WIDE, fixed, powers};

use super::variables::{DATE, label, unit};
use super::view::{Dependence, Influence};
use crate::fleet::development::Kind;
use crate::fleet::regression::{Coefficient, Prediction};
use crate::time;

/// Chance below which a fact is said to matter.
const SURE: f64 = 0.05;
const DAY_MS: f64 = 86_400_000.0;

/// Everything in a few sentences.
pub fn of(found: &Dependence) -> String {
    let subject = subject(found);
    let Some(level) = found.level else {
        return cannot(found, &subject);
    };
    let mut reported: Vec<String> = Vec::new();
    let fitted: Vec<(&Influence, Coefficient)> = found
        .facts
        .iter()
        .filter_map(|f| Some((f, f.slope?)))
        .collect();
    let (sure, unsure): (Vec<_>, Vec<_>) = fitted
        .into_iter()
        .partition(|(_, slope)| slope.p_value < SURE);
    for (i, (fact, slope)) in sure.iter().enumerate() {
        let who = if i == 0 {
            capital(&subject)
        } else {
            "It".to_owned()
        };
        let verb = if slope.value > 0.0 { "rises" } else { "falls" };
        let size = margin(slope.value.abs(), slope, &found.unit);
        reported.push(format!("{who} {verb} by {size} per {}.", per(fact)));
    }
    if !unsure.is_empty() {
        let names: Vec<String> = unsure
            .iter()
            .map(|(fact, slope)| {
                format!(
                    "{} ({} per {})",
                    label(&fact.name),
                    margin(slope.value, slope, &found.unit),
                    per_unit(fact)
                )
            })
            .collect();
        let who = if sure.is_empty() {
            capital(&subject)
        } else {
            "It".to_owned()
        };
        reported.push(format!(
            "{who} shows no dependence on {}.",
            names.join(", ")
        ));
    }
    if found.facts.iter().all(|fact| fact.slope.is_none()) {
        reported.push(format!(
            "{} is {}.",
            capital(&subject),
            margin(level.value, &level, &found.unit)
        ));
    }
    for step in &found.steps {
        let verb = if step.size.value > 0.0 { "up" } else { "down" };
        let size = margin(step.size.value.abs(), &step.size, &found.unit);
        let at = step.at.get(..10).unwrap_or(&step.at);
        reported.push(format!("{} stepped {verb} by {size} at {at}.", step.bike));
    }
    if (found.development.as_ref()).is_some_and(|d| matches!(d.kind, Kind::Drift | Kind::Both)) {
        reported.push("Beside this it drifts: the date is to be one of the facts.".to_owned());
    }
    for fact in &found.facts {
        if let Some(reason) = &fact.reason {
            reported.push(format!(
                "{} is not fitted: {reason}{}.",
                capital(&label(&fact.name)),
                correlation(fact)
            ));
        }
    }
    reported.push(basis(found));
    reported.join(" ")
}

/// "Front k at 2.5 bar (pressure front): 118 000 ± 3000 N/m".
pub fn predicted(
    found: &Dependence,
    at: &BTreeMap<String, f64>,
    prediction: &Prediction,
    beyond: &[String],
) -> String {
    let places: Vec<String> = at
        .iter()
        .map(|(name, value)| match name.as_str() {
            DATE => day(*value),
            name => {
                let unit = unit(name);
                let unit = if unit.is_empty() {
                    String::new()
                } else {
                    format!("\u{a0}{unit}")
                };
                format!("{}{unit} ({})", Number::rough(*value, 4), label(name))
            }
        })
        .collect();
    let error = 0.5 * (prediction.high - prediction.low) / WIDE;
    let value = Quantity::new(prediction.value, error, &found.unit);
    let mut reported = format!(
        "{} at {}: {value}",
        capital(&subject(found)),
        places.join(", ")
    );
    if !beyond.is_empty() {
        let names: Vec<String> = beyond.iter().map(|name| label(name)).collect();
        reported.push_str(&format!(
            "; no ride comes near in {}, and the line may bend",
            names.join(", ")
        ));
    }
    reported
}

fn cannot(found: &Dependence, subject: &str) -> String {
    let (rides, left_out) = (found.rides, found.left_out);
    let without = match left_out {
        0 => String::new(),
        n => format!(", {n} more lack one of the facts"),
    };
    format!(
        "{rides} rides tell {subject} and these facts{without}: too few, or all alike, to fit anything."
    )
}

fn basis(found: &Dependence) -> String {
    let plain = |x: f64| Quantity::rough(x, 2, &found.unit).to_string();
    let rides = found.rides;
    let of = match found.bikes {
        1 => "of one bicycle".to_owned(),
        n => format!("of {n} bicycles"),
    };
    let mut reported = format!("Over {rides} rides {of}");
    if let Some(between) = found.between_rides {
        reported.push_str(&format!(
            ", which differ by {} beyond this and their own errors",
            plain(between)
        ));
    }
    if let Some(between) = found.between_bikes {
        reported.push_str(&format!("; bicycles differ by {}", plain(between)));
    }
    if found.left_out > 0 {
        reported.push_str(&format!(
            "; {} more rides lack one of the facts",
            found.left_out
        ));
    }
    reported + "."
}

/// `k_n_m` of the front axle as "front k".
fn subject(found: &Dependence) -> String {
    let name = match found.name.as_str() {
        "k_n_m" => "k".to_owned(),
        "b_n_s_m" => "B".to_owned(),
        "mass_kg" => "mass".to_owned(),
        name => name.replace('.', ": ").replace('_', " "),
    };
    match found.axle.as_str() {
        "both" => name,
        axle => format!("{axle} {name}"),
    }
}

fn margin(value: f64, coefficient: &Coefficient, unit: &str) -> String {
    Quantity::new(value, coefficient.margin() / WIDE, unit).to_string()
}

fn per(fact: &Influence) -> String {
    match (fact.name.as_str(), fact.unit.as_str()) {
        (DATE, _) => "day".to_owned(),
        (name, "") => label(name),
        (name, unit) => format!("{unit} of {}", label(name)),
    }
}

fn per_unit(fact: &Influence) -> &str {
    if fact.unit.is_empty() {
        "unit"
    } else {
        &fact.unit
    }
}

fn correlation(fact: &Influence) -> String {
    fact.correlation
        .map_or_else(String::new, |r| format!(" (correlation {})", fixed(r, 2)))
}

fn day(days: f64) -> String {
    let text = time::text((days * DAY_MS) as i64);
    text.get(..10).unwrap_or(&text).to_owned()
}

fn capital(text: &str) -> String {
    let mut letters = powers(text);
    if let Some(first) = letters.get_mut(..1) {
        first.make_ascii_uppercase();
    }
    letters
}
