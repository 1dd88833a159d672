//! The fleet: every bicycle in a row, sorted and filtered as the query asks.

use std::cmp::Ordering;

use askama::Template;
use axum::extract::State;
use axum::response::Html;
use serde::Deserialize;
use veloid_engine::document::format_number::{Quantity, fixed};

use crate::api::App;
use crate::api::access::Caller;
use crate::api::fleet::look;
use crate::api::names::one_of;
use crate::fleet::{self, Kind, PooledBike};
use crate::pages::bike::{changes, day, label};
use crate::pages::layout::{Fault, Query, filled, html};
use crate::pages::words;

/// What bicycles are sorted by, with the words for it; parameters in the order of [`fleet::FOLLOWED`].
const SORTS: [(&str, &str); 6] = [
    ("name", "Bicycle"),
    ("k_front", "k front"),
    ("b_front", "B front"),
    ("k_rear", "k rear"),
    ("b_rear", "B rear"),
    ("last", "Last ride"),
];
/// The columns, each with what it is sorted by.
const COLUMNS: [(&str, &str); 9] = [
    SORTS[0],
    SORTS[1],
    SORTS[2],
    SORTS[3],
    SORTS[4],
    SORTS[5],
    ("", "Changes"),
    ("", "Named physics"),
    ("", "Stands out"),
];
const SHOWS: [(&str, &str); 4] = [
    ("drift", "a drift"),
    ("step", "a step"),
    ("effect", "named physics"),
    ("outlier", "that it stands out"),
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
struct FleetQuery {
    name: String,
    shows: String,
    effect: String,
    sort: String,
    falls: bool,
}

impl FleetQuery {
    fn of(params: Params) -> Result<Self, Fault> {
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

    fn wants(&self, bike: &PooledBike) -> bool {
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

    fn order(&self, a: &PooledBike, b: &PooledBike) -> Ordering {
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

#[derive(Template)]
#[template(path = "fleet.html")]
struct Bikes {
    /// Whether there is no bicycle at all.
    is_empty: bool,
    rows: Vec<Row>,
    spread: Vec<[String; 4]>,
    query: FleetQuery,
    sorts: [(&'static str, &'static str); 6],
    columns: [(&'static str, &'static str); 9],
    shows: [(&'static str, &'static str); 4],
    /// Those that the fleet names, with their words.
    effects: Vec<(String, String)>,
}

impl Bikes {
    fn here(&self) -> &'static str {
        "/bikes"
    }
}

struct Row {
    name: String,
    /// Label and pooled value of k and B, front and rear.
    cells: Vec<(String, Option<Quantity>)>,
    last: String,
    /// What drifts or changed.
    changes: Vec<String>,
    effects: Vec<(String, String)>,
    outliers: Vec<String>,
}

impl Row {
    fn of(bike: &PooledBike) -> Self {
        let cell = |(axle, name): (&str, &str)| {
            let mut parameters = bike.parameters.iter();
            let found = parameters.find(|p| p.axle == axle && p.name == name);
            let quantity =
                found.map(|p| Quantity::new(p.pooled.value, Some(p.pooled.std_error), &p.unit));
            (label(axle, name), quantity)
        };
        let outliers = bike.parameters.iter().filter(|p| p.outlier);
        let outliers = outliers.filter_map(|p| {
            let deviations = p.deviations?;
            let side = if deviations > 0.0 { "above" } else { "below" };
            let far = fixed(deviations.abs(), 1);
            Some(format!(
                "{} {far} deviations {side}",
                label(&p.axle, &p.name)
            ))
        });
        let changes = bike.parameters.iter().filter_map(|p| {
            let said = changes(p.development.as_ref()?, p.pooled.value)?;
            Some(format!("{} {said}", label(&p.axle, &p.name)))
        });
        Self {
            name: bike.bike.clone(),
            cells: fleet::FOLLOWED.into_iter().map(cell).collect(),
            last: day(bike.last_ride_at.as_deref().unwrap_or_default()).to_owned(),
            changes: changes.collect(),
            effects: bike.effects.iter().map(|id| with_words(id)).collect(),
            outliers: outliers.collect(),
        }
    }
}

fn with_words(effect: &str) -> (String, String) {
    (effect.to_owned(), words::plain(effect))
}

pub async fn bikes(
    State(server): App,
    caller: Caller,
    Query(params): Query<Params>,
) -> Result<Html<String>, Fault> {
    let query = FleetQuery::of(params)?;
    let fleet = look(&server, &caller.group).await?;
    let spread = fleet.spread.iter().map(|s| {
        let value = |x: f64| Quantity::rough(x, 4, &s.unit).to_string();
        [
            label(&s.axle, &s.name),
            s.bikes.to_string(),
            value(s.median),
            match s.bikes {
                0 | 1 => "–".to_owned(),
                _ => value(s.scatter),
            },
        ]
    });
    let mut effects: Vec<&String> = fleet.bikes.iter().flat_map(|b| &b.effects).collect();
    effects.sort_unstable();
    effects.dedup();
    let mut wanted: Vec<&PooledBike> = fleet.bikes.iter().filter(|b| query.wants(b)).collect();
    wanted.sort_by(|a, b| query.order(a, b));
    html(&Bikes {
        is_empty: fleet.bikes.is_empty(),
        rows: wanted.into_iter().map(Row::of).collect(),
        spread: spread.collect(),
        effects: effects.into_iter().map(|id| with_words(id)).collect(),
        sorts: SORTS,
        columns: COLUMNS,
        shows: SHOWS,
        query,
    })
}
