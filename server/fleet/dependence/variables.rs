//! The numbers that are known of a ride.

use std::collections::BTreeMap;

use crate::facts::NUMBERS;
use crate::store::dependence::RideRow;

/// The day on which it was ridden, counted from 1970-01-01.
pub const DATE: &str = "date";
const FRONT: &str = "load_front_kg";
const REAR: &str = "load_rear_kg";
const DAY_MS: f64 = 86_400_000.0;
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
pub fn of(row: &RideRow) -> BTreeMap<String, f64> {
    let mut numbers = BTreeMap::new();
    let loads = [(FRONT, row.front_kg), (REAR, row.rear_kg)];
    numbers.extend(
        loads
            .into_iter()
            .filter_map(|(name, load)| Some((name.to_owned(), load?))),
    );
    if let Some(facts) = &row.facts {
        let mut facts = facts.0.clone();
        for (name, ..) in NUMBERS {
            let value = facts.number(name).and_then(|value| *value);
            numbers.extend(value.map(|value| (name.to_owned(), value)));
        }
        numbers.extend(facts.more);
    }
    numbers.insert(DATE.to_owned(), row.dated_at as f64 / DAY_MS);
    numbers
}

/// The unit of a fact, reported by its name; empty where it is not.
pub fn unit(name: &str) -> &'static str {
    match name {
        DATE => "day",
        name => end(name).map_or("", |(_, unit)| unit),
    }
}

/// The name of a fact in words, without its unit.
pub fn label(name: &str) -> String {
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
            ("pressure_front_bar", "pressure front", "bar"),
            ("temperature_c", "temperature", "°C"),
            ("speed_m_s", "speed", "m/s"),
            ("load_rear_kg", "load rear", "kg"),
            (DATE, "date", "day"),
            ("gain", "gain", ""),
            ("_c", " c", ""),
        ] {
            assert_eq!((label(name).as_str(), unit(name)), (bare, of), "{name}");
        }
    }
}
