//! What became of a parameter, in words.

use veloid_engine::document::format_number::{Number, Quantity, fixed, powers};

use super::development::{Development, Drift, Step};
use crate::time;

/// From here on (N/m) stiffness is given in kN/m.
const LARGE: f64 = 1000.0;
const MONTH_DAYS: f64 = 30.0;

/// What a parameter is: `k_n_m` as "stiffness".
pub fn quantity(name: &str) -> String {
    match name {
        "k_n_m" => "stiffness".to_owned(),
        "b_n_s_m" => "damping".to_owned(),
        "mass_kg" => "mass".to_owned(),
        name => name.replace('.', ": ").replace('_', " "),
    }
}

/// A parameter of an axle: "front stiffness".
pub fn subject(axle: &str, name: &str) -> String {
    match axle {
        "both" => quantity(name),
        axle => format!("{axle} {}", quantity(name)),
    }
}

/// With a capital, and powers as they are written.
pub fn capital(text: &str) -> String {
    let mut letters = powers(text);
    if let Some(first) = letters.get_mut(..1) {
        first.make_ascii_uppercase();
    }
    letters
}

/// A size with half the width of its 95 % interval, to one digit of it, or two where that is a one: "4.1 ± 0.9 kN/m".
pub fn size(value: f64, margin: f64, unit: &str) -> String {
    let (scale, unit) = match unit {
        "N/m" if value.abs() >= LARGE => (1e-3, "kN/m"),
        unit => (1.0, unit),
    };
    let (value, margin) = (scale * value, scale * margin);
    if !(margin.is_normal() && margin > 0.0) {
        return Quantity::rough(value, 3, unit).to_string();
    }
    let power = margin.log10().floor();
    let leads_with_one = margin / 10f64.powf(power) < 1.95;
    let decimals = -(power as i32) + i32::from(leads_with_one);
    let number = Number {
        value: fixed(value, decimals),
        margin: Some(fixed(margin, decimals)),
        mark: " ± ",
        exponent: None,
    };
    let unit = powers(unit).replace(' ', "\u{a0}");
    Quantity { number, unit }.to_string()
}

/// What became of a parameter: "has been falling by 3 ± 1 kN/m per 30 days since 2 May, and rose by 4.1 ± 0.9 kN/m on 12 June"; none
/// where nothing did.
pub fn became(development: &Development, unit: &str) -> Option<String> {
    let steps = development.steps.iter();
    let mut said: Vec<(&str, String)> = steps
        .map(|step| (step.at.as_str(), stepped(step, unit)))
        .collect();
    let drifts = development.drifts.iter();
    said.extend(drifts.map(|drift| (drift.since.as_str(), drifted(drift, unit))));
    // Times sort as texts.
    said.sort();
    let said: Vec<String> = said.into_iter().map(|(_, said)| said).collect();
    let (last, before) = said.split_last()?;
    Some(match before.is_empty() {
        true => last.clone(),
        false => format!("{}, and {last}", before.join(", ")),
    })
}

fn drifted(drift: &Drift, unit: &str) -> String {
    let [month, margin] = [drift.per_day, drift.margin].map(|x| MONTH_DAYS * x);
    let size = size(month.abs(), margin, unit);
    let since = time::day_in_words(&drift.since);
    let rises = month > 0.0;
    match &drift.until {
        None => {
            let verb = if rises { "rising" } else { "falling" };
            format!("has been {verb} by {size} per 30 days since {since}")
        }
        Some(until) => {
            let verb = if rises { "rose" } else { "fell" };
            let until = time::day_in_words(until);
            format!("{verb} by {size} per 30 days from {since} to {until}")
        }
    }
}

fn stepped(step: &Step, unit: &str) -> String {
    let verb = if step.size > 0.0 { "rose" } else { "fell" };
    let size = size(step.size.abs(), step.margin, unit);
    let day = time::day_in_words(&step.at);
    let event = step.event.as_ref();
    let event = event.map_or_else(String::new, |event| format!(", {event}"));
    format!("{verb} by {size} on {day}{event}")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn sizes_are_told_as_far_as_they_are_known() {
        for (value, margin, unit, expected) in [
            (4123.0, 870.0, "N/m", "4.1 ± 0.9 kN/m"),
            (9012.0, 1230.0, "N/m", "9.0 ± 1.2 kN/m"),
            (512.0, 96.0, "N/m", "510 ± 100 N/m"),
            (0.034, 0.004, "N s/m", "0.034 ± 0.004 N s/m"),
            (13_000.0, 1990.0, "N/m", "13 ± 2 kN/m"),
            (7.0, 0.0, "kg", "7 kg"),
        ] {
            let said = size(value, margin, unit);
            assert_eq!(said.replace('\u{a0}', " "), expected);
        }
    }

    #[test]
    fn what_happened_is_one_sentence() {
        let day = |i: i64| i * 86_400_000;
        let history = |value: fn(i64) -> f64| -> Option<String> {
            let ride = |i: i64| (day(i), 100e3 + value(i) + 100.0 * (i * 7 % 5) as f64, 200.0);
            let rides: Vec<_> = (0..60).map(ride).collect();
            became(&Development::of(&rides, &[]).unwrap(), "N/m")
        };
        assert_eq!(history(|_| 0.0), None);
        let fell = history(|i| if i < 30 { 0.0 } else { -4e3 }).unwrap();
        assert!(
            fell.starts_with("fell by 4.0") && fell.ends_with(" on 31 January 1970"),
            "{fell}"
        );
        let falls = history(|i| -200.0 * (i - 20).max(0) as f64).unwrap();
        assert!(
            falls.starts_with("has been falling by 6.") && falls.contains(" per 30 days since 2"),
            "{falls}"
        );
        let both = history(|i| {
            if i < 40 {
                -200.0 * (i - 20).max(0) as f64
            } else {
                0.0
            }
        })
        .unwrap();
        assert!(
            both.starts_with("fell by 6.") && both.contains(" February 1970, and rose by "),
            "{both}"
        );
    }
}
