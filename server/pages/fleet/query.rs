//! What the address of the fleet's page asks for: which bicycles, and in which order.

use std::cmp::Ordering;

use serde::Deserialize;

use crate::api::names::one_of;
use crate::fleet::{self, Kind, PooledBike};
use crate::pages::layout::{Fault, filled};

/// What bicycles are sorted by, with the words for it; parameters in the order of [`fleet::FOLLOWED`].
pub const SORTS: [(&str, &str); 6] = [
    ("name", "Bicycle"),
    ("k_front", "k front (kN/m)"),
    ("b_front", "B front (N\u{a0}s/m)"),
    ("k_rear", "k rear (kN/m)"),
    ("b_rear", "B rear (N\u{a0}s/m)"),
    ("last", "Last ride"),
];
pub const SHOWS: [(&str, &str); 4] = [
    ("drift", "a drift"),
    ("step", "a step"),
    ("effect", "named effects"),
    ("outlier", "an outlier"),
];
const ORDERS: [&str; 2] = ["rising", "falling"];

/// The query, blank where the form's field was.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    name: Option<String>,
    shows: Option<String>,
    effect: Option<String>,
    sort: Option<String>,
    order: Option<String>,
}

/// What is asked for.
pub struct FleetQuery {
    pub name: String,
    pub shows: String,
    pub effect: String,
    pub sort: String,
    pub falls: bool,
}

impl FleetQuery {
    pub fn of(params: Params) -> Result<Self, Fault> {
        let known = |name, value: Option<String>, known: &[&str]| {
            let value = filled(value);
            one_of(name, value.as_deref(), known)?;
            Ok::<_, Fault>(value.unwrap_or_default())
        };
        let sort = known("sort", params.sort, &SORTS.map(|(name, _)| name))?;
        Ok(Self {
            shows: known("shows", params.shows, &SHOWS.map(|(name, _)| name))?,
            falls: known("order", params.order, &ORDERS)? == "falling",
            name: filled(params.name).unwrap_or_default(),
            effect: filled(params.effect).unwrap_or_default(),
            sort: if sort.is_empty() {
                "name".to_owned()
            } else {
                sort
            },
        })
    }

    pub fn wants(&self, bike: &PooledBike) -> bool {
        let named = bike.bike.to_lowercase().contains(&self.name.to_lowercase());
        let has_effect = self.effect.is_empty() || bike.effects.contains(&self.effect);
        let became = |kinds: [Kind; 2]| {
            let mut developments = bike
                .parameters
                .iter()
                .filter_map(|p| p.development.as_ref());
            developments.any(|development| kinds.contains(&development.kind))
        };
        let shows = match self.shows.as_str() {
            "drift" => became([Kind::Drift, Kind::Both]),
            "step" => became([Kind::Step, Kind::Both]),
            "effect" => !bike.effects.is_empty(),
            "outlier" => bike.parameters.iter().any(|p| p.outlier),
            _ => true,
        };
        named && has_effect && shows
    }

    pub fn order(&self, a: &PooledBike, b: &PooledBike) -> Ordering {
        let ordering = match self.sort.as_str() {
            "name" => self.turned(a.bike.cmp(&b.bike)),
            "last" => {
                let [a, b] = [a, b].map(|bike| bike.last_ride_at.as_ref());
                self.known_first(a, b, |a, b| a.cmp(b))
            }
            sort => {
                let [a, b] = [a, b].map(|bike| sorted_value(bike, sort));
                self.known_first(a, b, f64::total_cmp)
            }
        };
        ordering.then_with(|| a.bike.cmp(&b.bike))
    }

    fn turned(&self, ordering: Ordering) -> Ordering {
        match self.falls {
            true => ordering.reverse(),
            false => ordering,
        }
    }

    /// What is not known stands last in either order.
    fn known_first<T>(
        &self,
        a: Option<T>,
        b: Option<T>,
        order: impl Fn(&T, &T) -> Ordering,
    ) -> Ordering {
        match (a, b) {
            (Some(a), Some(b)) => self.turned(order(&a, &b)),
            (a, b) => b.is_some().cmp(&a.is_some()),
        }
    }
}

/// The value that `sort` names.
fn sorted_value(bike: &PooledBike, sort: &str) -> Option<f64> {
    let columns = SORTS[1..].iter().zip(fleet::FOLLOWED);
    let mut named = columns.filter(|((name, _), _)| *name == sort);
    let (_, followed) = named.next()?;
    value(bike, followed)
}

fn value(bike: &PooledBike, (axle, name): (&str, &str)) -> Option<f64> {
    let mut parameters = bike.parameters.iter();
    let found = parameters.find(|p| p.axle == axle && p.name == name);
    found.map(|p| p.pooled.value)
}
