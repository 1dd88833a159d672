//! The fleet: what changed, then every bicycle in a row, sorted and filtered as the query asks.

mod query;
mod row;
mod sparkline;

use askama::Template;
use axum::extract::State;
use axum::response::Html;
use veloid_engine::document::format_number::Quantity;

use crate::api::App;
use crate::api::access::Caller;
use crate::api::fleet::look;
use crate::api::pressure;
use crate::fleet::words::subject;
use crate::fleet::{FleetSpread, PooledBike, PooledParameter};
use crate::pages::bike::label;
use crate::pages::layout::{Fault, Query, html};
use query::{FleetQuery, Params, SHOWS, SORTS};
use row::{Row, with_words};

/// The columns, each with what it is sorted by.
const COLUMNS: [(&str, &str); 9] = [
    SORTS[0],
    SORTS[1],
    SORTS[2],
    SORTS[3],
    SORTS[4],
    ("", "Latest rides"),
    SORTS[5],
    ("", "Effects named"),
    ("", "Outlier"),
];
/// Bicycles that are listed with what changed; more are folded.
const LISTED: usize = 8;

#[derive(Template)]
#[template(path = "fleet.html")]
struct Bikes {
    /// Whether there is no bicycle at all.
    is_empty: bool,
    /// Bicycles with a drift or a step, and what became of which parameter; those that changed most first.
    changed: Vec<(String, Vec<String>)>,
    /// What tyre pressure does, in a sentence for each axle.
    pressure: Vec<String>,
    /// Bicycles of so many rides that a drift or a step would be seen.
    followed: usize,
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

/// How much a bicycle changed: its largest step or drift over 30 days, as a share of the value.
fn extent(bike: &PooledBike) -> f64 {
    let of = bike.parameters.iter().filter_map(|p| {
        let development = p.development.as_ref()?;
        let steps = development.steps.iter().map(|step| step.size.abs());
        let most = steps.fold(30.0 * development.per_day.abs(), f64::max);
        Some(most / p.pooled.value.abs())
    });
    of.fold(0.0, f64::max)
}

/// What changed, in a sentence for each parameter.
fn changed(bikes: &[PooledBike]) -> Vec<(String, Vec<String>)> {
    let mut bikes: Vec<&PooledBike> = bikes.iter().collect();
    bikes.sort_by(|a, b| extent(b).total_cmp(&extent(a)));
    let sentences = |bike: &PooledBike| -> Vec<String> {
        let said = |p: &PooledParameter| {
            Some(format!(
                "{} {}",
                subject(&p.axle, &p.name),
                p.summary.as_ref()?
            ))
        };
        bike.parameters.iter().filter_map(said).collect()
    };
    let of_each = bikes
        .iter()
        .map(|bike| (bike.bike.clone(), sentences(bike)));
    of_each.filter(|(_, said)| !said.is_empty()).collect()
}

fn spread(spread: &FleetSpread) -> [String; 4] {
    let value = |x: f64| Quantity::rough(x, 4, &spread.unit).to_string();
    [
        label(&spread.axle, &spread.name),
        spread.bikes.to_string(),
        value(spread.median),
        match spread.bikes {
            0 | 1 => "–".to_owned(),
            _ => value(spread.scatter),
        },
    ]
}

pub async fn bikes(
    State(server): App,
    caller: Caller,
    Query(params): Query<Params>,
) -> Result<Html<String>, Fault> {
    let query = FleetQuery::of(params)?;
    let fleet = look(&server, &caller.group).await?;
    let mut effects: Vec<&String> = fleet.bikes.iter().flat_map(|b| &b.effects).collect();
    effects.sort_unstable();
    effects.dedup();
    let mut wanted: Vec<&PooledBike> = fleet.bikes.iter().filter(|b| query.wants(b)).collect();
    wanted.sort_by(|a, b| query.order(a, b));
    let followed = |bike: &&PooledBike| bike.parameters.iter().any(|p| p.development.is_some());
    html(&Bikes {
        is_empty: fleet.bikes.is_empty(),
        changed: changed(&fleet.bikes),
        pressure: pressure::of(&server, &caller.group, None).await?,
        followed: fleet.bikes.iter().filter(followed).count(),
        rows: wanted.into_iter().map(Row::of).collect(),
        spread: fleet.spread.iter().map(spread).collect(),
        effects: effects.into_iter().map(|id| with_words(id)).collect(),
        sorts: SORTS,
        columns: COLUMNS,
        shows: SHOWS,
        query,
    })
}
