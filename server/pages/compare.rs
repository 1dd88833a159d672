//! Two to eight results beside each other.

use std::collections::BTreeMap;

use askama::Template;
use axum::extract::{RawQuery, State};
use axum::response::Html;
use uuid::Uuid;
use veloid_engine::bicycle::{Axle, PerAxle};
use veloid_engine::document::format_number::{Quantity, fixed};
use veloid_engine::report::{Estimate, Report};

use super::estimate::best;
use super::layout::{Fault, html};
use super::words;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::jobs::report::published;
use crate::api::jobs::view::find;
use crate::api::problem::{Kind, Problem};

/// Names of the address that `web/compare.js` reads.
const VIEW: [&str; 5] = ["quantity", "curve", "t0", "t1", "theme"];
/// Differences beyond so many standard errors are marked.
const CLEAR: f64 = 3.0;

#[derive(Template)]
#[template(path = "compare.html")]
struct Compare {
    jobs: Vec<Side>,
    rows: Vec<(String, Vec<Option<Cell>>)>,
    effects: Vec<(String, Vec<String>)>,
}

struct Side {
    address: String,
    page: String,
    ride: String,
    bike: String,
    verdict: String,
}

struct Cell {
    quantity: Quantity,
    /// To the first job, in standard errors.
    difference: Option<String>,
    clear: bool,
}

impl Compare {
    fn here(&self) -> &'static str {
        ""
    }
}

pub async fn compare(
    State(server): App,
    caller: Caller,
    RawQuery(query): RawQuery,
) -> Result<Html<String>, Fault> {
    let query = query.unwrap_or_default();
    let mut ids = Vec::new();
    for (name, value) in form_urlencoded::parse(query.as_bytes()) {
        if name == "job" {
            let id = value.parse::<Uuid>();
            ids.push(id.map_err(|_| bad(format!("job: `{value}`, expected the id of a job")))?);
        } else if !VIEW.contains(&&*name) {
            let known = VIEW.join(", ");
            return Err(bad(format!("unknown name `{name}`, expected job, {known}")).into());
        }
    }
    if !(2..=8).contains(&ids.len()) {
        let chosen = match ids.len() {
            1 => "1 job was".to_owned(),
            count => format!("{count} jobs were"),
        };
        let detail = format!("{chosen} chosen, expected two to eight");
        return Err(bad(detail).into());
    }
    let (mut jobs, mut reports) = (Vec::new(), Vec::<Report>::new());
    for id in ids {
        let job = find(&server.db, &caller.group, id).await?;
        let text = published(&server.db, id).await?;
        reports.push(serde_json::from_str(&text).map_err(Problem::internal)?);
        jobs.push(Side {
            address: job.links.job,
            page: job.links.page,
            ride: job.ride.name,
            bike: job.bike,
            verdict: job.verdict.map_or_else(
                || "no diagnosis".to_owned(),
                |verdict| words::plain(&verdict),
            ),
        });
    }
    html(&Compare {
        jobs,
        rows: rows(&reports),
        effects: effects(&reports),
    })
}

fn bad(detail: String) -> Problem {
    Problem::new(Kind::BadRequest, detail)
}

fn rows(reports: &[Report]) -> Vec<(String, Vec<Option<Cell>>)> {
    type Pick = fn(&Estimate) -> (f64, Option<f64>);
    let picks: [(&str, &str, Pick); 2] = [
        ("stiffness k", "N/m", |e| (e.k_n_m, e.k_std_n_m)),
        ("damping B", "N s/m", |e| (e.b_n_s_m, e.b_std_n_s_m)),
    ];
    let estimates: Vec<PerAxle<Estimate>> = reports.iter().map(best).collect();
    let row = |axle: Axle, (name, unit, pick): (&str, &str, Pick)| {
        let values: Vec<Option<(f64, Option<f64>)>> =
            estimates.iter().map(|e| e.get(axle).map(pick)).collect();
        let first = values.first().copied().flatten();
        let cell = |(i, value): (usize, &Option<(f64, Option<f64>)>)| {
            let (value, error) = (*value)?;
            let difference = first
                .filter(|_| i > 0)
                .and_then(|(v, e)| Some((value - v) / error?.hypot(e?)));
            Some(Cell {
                quantity: Quantity::new(value, error, unit),
                clear: difference.is_some_and(|d| d.abs() > CLEAR),
                difference: difference.filter(|d| d.is_finite()).map(|d| fixed(d, 1)),
            })
        };
        (
            format!("{axle} {name}"),
            values.iter().enumerate().map(cell).collect(),
        )
    };
    Axle::BOTH
        .into_iter()
        .flat_map(|axle| picks.map(|pick| row(axle, pick)))
        .collect()
}

/// Every effect that any of the jobs names, with its parameters.
fn effects(reports: &[Report]) -> Vec<(String, Vec<String>)> {
    let mut found: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (i, report) in reports.iter().enumerate() {
        for effect in report.diagnosis.iter().flat_map(|d| &d.effects) {
            let name = format!("{} ({})", words::title(&effect.id), effect.axle.name());
            let values = effect
                .parameters
                .iter()
                .map(|(name, p)| format!("{} {}", words::plain(name), p.quantity(name)));
            let cells = found
                .entry(name)
                .or_insert_with(|| vec!["–".to_owned(); reports.len()]);
            cells[i] = values.collect::<Vec<_>>().join(", ");
        }
    }
    found.into_iter().collect()
}
