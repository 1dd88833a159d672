//! What is known of a bicycle's rides that moves k and B without the bicycle having changed.

use std::collections::BTreeMap;

use super::development::Fact;
use crate::facts::Facts;

/// Share of the rides of which a fact has to be known.
const USUAL: f64 = 0.75;

/// Temperature and rider of each ride, as columns. Pressures are left out: what they do is what is looked for.
pub fn facts(rides: &[Option<&Facts>]) -> Vec<Fact> {
    let mut found = temperature(rides);
    found.extend(riders(rides));
    found
}

fn is_usual(known: usize, rides: usize) -> bool {
    known as f64 >= USUAL * rides as f64
}

/// Its mean stands where it is not known, beside a column that says so.
fn temperature(rides: &[Option<&Facts>]) -> Vec<Fact> {
    let each = || {
        rides
            .iter()
            .map(|facts| facts.and_then(|f| f.temperature_c))
    };
    let known: Vec<f64> = each().flatten().collect();
    if known.is_empty() || !is_usual(known.len(), rides.len()) {
        return Vec::new();
    }
    let mean = known.iter().sum::<f64>() / known.len() as f64;
    let column = |values: Vec<f64>| Fact {
        name: "temperature_c".to_owned(),
        values,
    };
    let off = each().map(|t| t.map_or(0.0, |t| t - mean)).collect();
    let unknown = each().map(|t| f64::from(u8::from(t.is_none()))).collect();
    match known.len() == rides.len() {
        true => vec![column(off)],
        false => vec![column(off), column(unknown)],
    }
}

/// A column for each rider but the most frequent one; nobody is a rider too.
fn riders(rides: &[Option<&Facts>]) -> Vec<Fact> {
    let each = || {
        rides
            .iter()
            .map(|facts| facts.and_then(|f| f.rider.as_deref()))
    };
    if !is_usual(each().flatten().count(), rides.len()) {
        return Vec::new();
    }
    let mut counts: BTreeMap<Option<&str>, usize> = BTreeMap::new();
    each().for_each(|rider| *counts.entry(rider).or_default() += 1);
    let most = counts.iter().max_by_key(|(_, count)| **count);
    let most = most.map(|(rider, _)| *rider);
    let others = counts.keys().filter(|rider| Some(**rider) != most);
    let column = |rider: &Option<&str>| Fact {
        name: "rider".to_owned(),
        values: each()
            .map(|other| f64::from(u8::from(other == *rider)))
            .collect(),
    };
    others.map(column).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_few_rides_say_is_not_used() {
        let of = |temperature_c: Option<f64>, rider: Option<&str>| Facts {
            temperature_c,
            rider: rider.map(str::to_owned),
            ..Facts::default()
        };
        let all = [
            of(Some(10.0), Some("ada")),
            of(Some(20.0), Some("ben")),
            of(Some(15.0), Some("ada")),
            of(None, None),
        ];
        let rides: Vec<Option<&Facts>> = all.iter().map(Some).collect();
        let found = facts(&rides);
        let columns: Vec<&[f64]> = found.iter().map(|fact| &fact.values[..]).collect();
        assert_eq!(columns[0], [-5.0, 5.0, 0.0, 0.0]);
        assert_eq!(columns[1], [0.0, 0.0, 0.0, 1.0]);
        assert_eq!(columns[2], [0.0, 0.0, 0.0, 1.0]);
        assert_eq!(columns[3], [0.0, 1.0, 0.0, 0.0]);
        let names: Vec<&str> = found.iter().map(|fact| fact.name.as_str()).collect();
        assert_eq!(names, ["temperature_c", "temperature_c", "rider", "rider"]);
        assert_eq!(facts(&[rides[0], None]), []);
    }
}
