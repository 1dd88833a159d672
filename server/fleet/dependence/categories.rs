//! Facts in words: what rides of each category are above those of the most frequent one.

use std::collections::BTreeMap;

use super::rides::{Column, Ride};
use super::view::{Categories, Category, KnownCategories};

/// Fewest rides of a category that has an effect.
const RIDES: usize = 3;
/// Most categories of a fact.
const MOST: usize = 12;

impl Categories {
    /// The categories of a fact, the most frequent one first, without effects yet.
    pub fn of(fact: &str, rides: &[Ride]) -> Self {
        let mut categories: Vec<Category> = counts(fact, rides)
            .into_iter()
            .map(|(name, rides)| Category {
                reason: (rides < RIDES)
                    .then(|| format!("it has fewer than {RIDES} rides, which are left out")),
                name: name.to_owned(),
                rides,
                effect: None,
            })
            .collect();
        categories.sort_by(|a, b| b.rides.cmp(&a.rides).then_with(|| a.name.cmp(&b.name)));
        let reason = match categories.iter().filter(|c| c.rides >= RIDES).count() {
            0 | 1 => Some(format!(
                "fewer than two of its categories have {RIDES} rides"
            )),
            n if n > MOST => Some(format!(
                "it has {n} categories, of which {MOST} at most are fitted"
            )),
            _ => None,
        };
        Self {
            fact: fact.to_owned(),
            reference: categories
                .first()
                .map_or_else(String::new, |c| c.name.clone()),
            categories,
            reason,
        }
    }

    /// The columns of its categories but for the most frequent one.
    pub fn columns(&self) -> Vec<Column> {
        if self.reason.is_some() {
            return Vec::new();
        }
        let others = self.categories.iter().skip(1);
        others
            .filter(|category| category.rides >= RIDES)
            .map(|category| Column {
                fact: self.fact.clone(),
                category: Some(category.name.clone()),
            })
            .collect()
    }

    /// Whether a ride is of a category that is fitted.
    pub fn takes(&self, ride: &Ride) -> bool {
        let name = ride.texts.get(self.fact.as_str());
        let own = self.categories.iter().find(|c| Some(&c.name) == name);
        self.reason.is_some() || own.is_some_and(|category| category.rides >= RIDES)
    }

    pub fn category(&mut self, name: &str) -> Option<&mut Category> {
        self.categories.iter_mut().find(|c| c.name == name)
    }
}

fn counts<'a>(fact: &str, rides: &'a [Ride]) -> BTreeMap<&'a str, usize> {
    let mut counts = BTreeMap::new();
    for name in rides.iter().filter_map(|ride| ride.texts.get(fact)) {
        *counts.entry(name.as_str()).or_insert(0) += 1;
    }
    counts
}

/// The facts in words that some rides have.
pub fn known(rides: &[Ride]) -> Vec<KnownCategories> {
    let mut facts: Vec<&str> = rides.iter().flat_map(|r| r.texts.keys().copied()).collect();
    facts.sort_unstable();
    facts.dedup();
    let known = |fact: &str| {
        let counts = counts(fact, rides);
        KnownCategories {
            name: fact.to_owned(),
            rides: counts.values().sum(),
            categories: counts.len(),
        }
    };
    facts.into_iter().map(known).collect()
}
