//! Two to eight results beside each other.

use std::collections::BTreeMap;

use askama::Template;
use axum::extract::{RawQuery, State};
use axum::response::Html;
use uuid::Uuid;
use veloid_engine::bicycle::{Axle, PerAxle};
use veloid_engine::document::format_number::{Quantity, fixed};
use veloid_engine::report::{AxleResult, Report, ResultQuantity};
use veloid_engine::result_of;

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
    /// Absent where its report cannot be read.
    address: Option<String>,
    page: String,
    ride: String,
    bike: String,
    verdict: String,
}

struct Cell {
    /// Absent where it is withheld.
    quantity: Option<Quantity>,
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
    let (mut jobs, mut reports) = (Vec::new(), Vec::new());
    for id in ids {
        let job = find(&server.db, &caller.group, id).await?;
        let report = published(&server.db, id, job.study.is_some()).await;
        let report = match report.and_then(|report| Ok(report.parse()?)) {
            Err(problem) if problem.kind == Kind::ReportUnreadable => None,
            report => Some(report?),
        };
        jobs.push(Side {
            address: report.is_some().then_some(job.links.job),
            page: job.links.page,
            ride: job.ride.name,
            bike: job.bike,
            verdict: match (&report, job.verdict) {
                (None, _) => "the report cannot be read".to_owned(),
                (_, None) => "no diagnosis".to_owned(),
                (_, Some(verdict)) => words::plain(&verdict),
            },
        });
        reports.push(report);
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

fn rows(reports: &[Option<Report>]) -> Vec<(String, Vec<Option<Cell>>)> {
    let result = |report: &Option<Report>| report.as_ref().map(result_of).unwrap_or_default();
    let results: Vec<PerAxle<AxleResult>> = reports.iter().map(result).collect();
    let mut rows = Vec::new();
    for axle in Axle::BOTH {
        let on_axle: Vec<Option<&AxleResult>> = results.iter().map(|r| r.get(axle)).collect();
        let mut names: Vec<&str> = Vec::new();
        for (name, _) in on_axle.iter().flatten().flat_map(|result| result.iter()) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        for name in names {
            let found: Vec<Option<&ResultQuantity>> = (on_axle.iter())
                .map(|result| result.and_then(|r| r.get(name)))
                .collect();
            rows.push((format!("{axle} {}", words::plain(name)), cells(&found)));
        }
    }
    rows
}

/// The values of one quantity, each with its difference to the first.
fn cells(found: &[Option<&ResultQuantity>]) -> Vec<Option<Cell>> {
    let first = found.first().copied().flatten();
    let cell = |(i, found): (usize, &Option<&ResultQuantity>)| {
        let found = (*found)?;
        let difference = first.filter(|_| i > 0).and_then(|first| {
            let error = found.std_error?.hypot(first.std_error?);
            Some((found.value? - first.value?) / error)
        });
        Some(Cell {
            quantity: found.quantity(),
            clear: difference.is_some_and(|d| d.abs() > CLEAR),
            difference: difference.filter(|d| d.is_finite()).map(|d| fixed(d, 1)),
        })
    };
    found.iter().enumerate().map(cell).collect()
}

/// Every effect that any of the jobs names, with its parameters.
fn effects(reports: &[Option<Report>]) -> Vec<(String, Vec<String>)> {
    let mut found: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for (i, report) in reports.iter().enumerate() {
        let diagnosis = report.as_ref().and_then(|report| report.diagnosis.as_ref());
        for effect in diagnosis.iter().flat_map(|d| &d.effects) {
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
