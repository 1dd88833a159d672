//! What is known of a ride: numbers, and facts in words.

use std::collections::BTreeMap;

use crate::facts::NUMBERS;
use crate::store::dependence::RideRow;

/// The day on which it was ridden, counted from 1970-01-01.
pub const DATE: &str = "date";
const FRONT: &str = "load_front_kg";
const REAR: &str = "load_rear_kg";
const DAY_MS: f64 = 86_400_000.0;
/// Names whose words stand in another order.
const WORDS: [(&str, &str); 5] = [
    ("pressure_front_bar", "front tyre pressure"),
    ("pressure_rear_bar", "rear tyre pressure"),
    ("rider_mass_kg", "rider's mass"),
    (FRONT, "front load"),
    (REAR, "rear load"),
];
/// Units by the ends of names, longer ends first.
const ENDS: [(&str, &str); 14] = [
    ("_km_h", "km/h"),
    ("_m_s2", "m/s²"),
    ("_m_s", "m/s"),
    ("_n_m", "N/m"),
    ("_bar", "bar"),
    ("_deg", "°"),
    ("_kg", "kg"),
    ("_km", "km"),
    ("_mm", "mm"),
    ("_hz", "Hz"),
    ("_h", "h"),
    ("_c", "°C"),
    ("_m", "m"),
    ("_s", "s"),
];

/// Facts that are numbers, the date, and the loads of the bike file.
pub fn numbers(row: &RideRow) -> BTreeMap<String, f64> {
    let mut numbers = BTreeMap::new();
    let loads = [(FRONT, row.front_kg), (REAR, row.rear_kg)];
    numbers.extend(
        loads
            .into_iter()
            .filter_map(|(name, load)| Some((name.to_owned(), load?))),
    );
    if let Some(facts) = &row.facts {
        let facts = &facts.0;
        for (name, ..) in NUMBERS {
            numbers.extend(facts.value(name).map(|value| (name.to_owned(), value)));
        }
        numbers.extend(facts.more.clone());
    }
    numbers.insert(DATE.to_owned(), row.dated_at as f64 / DAY_MS);
    numbers
}

/// Facts in words that rides can be grouped by.
pub fn texts(row: &RideRow) -> BTreeMap<&'static str, String> {
    let facts = row.facts.iter().flat_map(|facts| facts.0.groups());
    facts.map(|(name, text)| (name, text.to_owned())).collect()
}

/// The unit of a fact by its name; empty where the name has none.
pub fn unit(name: &str) -> &'static str {
    match name {
        DATE => "day",
        name => end(name).map_or("", |(_, unit)| unit),
    }
}

/// The name of a fact in words, without its unit.
pub fn label(name: &str) -> String {
    if let Some((_, words)) = WORDS.iter().find(|(known, _)| *known == name) {
        return (*words).to_owned();
    }
    let bare = end(name).and_then(|(end, _)| name.strip_suffix(end));
    bare.unwrap_or(name).replace('_', " ")
}

fn end(name: &str) -> Option<(&'static str, &'static str)> {
    ENDS.into_iter()
        .find(|(end, _)| name.len() > end.len() && name.ends_with(end))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_units() {
        for (name, bare, of) in [
            ("pressure_front_bar", "front tyre pressure", "bar"),
            ("pressure_third_bar", "pressure third", "bar"),
            ("temperature_c", "temperature", "°C"),
            ("speed_m_s", "speed", "m/s"),
            ("load_rear_kg", "rear load", "kg"),
            (DATE, "date", "day"),
            ("gain", "gain", ""),
            ("_c", " c", ""),
        ] {
            assert_eq!((label(name).as_str(), unit(name)), (bare, of), "{name}");
        }
    }
}
