//! Several rides of one bicycle as one: the page of such a job, and the form on the bicycle's page that queues it.

use std::collections::BTreeMap;

use askama::Template;
use axum::Form;
use axum::extract::State;
use axum::response::{Html, Redirect};
use serde::Deserialize;
use veloid_engine::bicycle::Axle;
use veloid_engine::document::format_number::{Quantity, significant};
use veloid_engine::report::Estimate;
use veloid_engine::report::diagnosis::ParameterReport;
use veloid_engine::report::study::{LeftAside, StudyEffect, StudyReport, StudyRide};

use super::layout::{Fault, Path, html};
use super::words;
use crate::api::access::Caller;
use crate::api::jobs::report::stored;
use crate::api::jobs::view::JobView;
use crate::api::studies::{NewStudy, submit};
use crate::api::{App, Server};
use crate::jobs::named_rides;
use crate::store::job::{JobRow, State as JobState};

#[derive(Template)]
#[template(path = "study.html")]
struct Page {
    job: JobView,
    found: Option<Found>,
    /// File and page of each ride.
    rides: Vec<(String, String)>,
}

/// The row of all rides.
const TOGETHER: &str = "all together";

/// The report as tables.
struct Found {
    sentence: String,
    effects: Vec<EffectRow>,
    numbers: Vec<NumberRow>,
    /// RMS on the held-out parts (mm), axle by axle: with the plain and with the common model.
    held_out: Vec<[String; 3]>,
    /// Rides that alone show more, and what.
    more: Vec<(String, String)>,
    left_aside: Vec<LeftAside>,
}

struct EffectRow {
    name: String,
    parameters: Vec<(String, Quantity)>,
    /// Each ride's sizes by themselves, where the rides differ in them by more than chance.
    by_ride: Vec<(String, Vec<(String, Quantity)>)>,
    rides: String,
}

/// k and B of an axle on one ride, or on all.
struct NumberRow {
    ride: String,
    axle: &'static str,
    k: Option<Quantity>,
    b: Option<Quantity>,
}

impl Page {
    fn here(&self) -> &'static str {
        ""
    }
}

impl Found {
    /// Whether the rides have no k or B in common.
    fn differs(&self) -> bool {
        self.numbers
            .iter()
            .any(|row| row.ride == TOGETHER && (row.k.is_none() || row.b.is_none()))
    }

    fn of(report: StudyReport) -> Self {
        let mut numbers = Vec::new();
        for ride in &report.rides {
            numbers.extend(
                ride.axles
                    .iter()
                    .map(|(axle, e)| NumberRow::of(&ride.name, axle, Some(e))),
            );
        }
        let together = report.axles.iter();
        numbers
            .extend(together.map(|(axle, on)| NumberRow::of(TOGETHER, axle, on.estimate.as_ref())));
        let held_out = report.axles.iter().map(|(axle, on)| {
            let [plain, common] =
                [on.plain_held_out_m, on.held_out_m].map(|x| significant(1e3 * x, 3));
            [axle.title().to_owned(), plain, common]
        });
        let more = report.rides.iter().filter(|ride| ride.shows_more);
        Self {
            sentence: report.sentence,
            effects: report
                .effects
                .iter()
                .map(|found| EffectRow::of(found, &report.rides, report.settings.alpha))
                .collect(),
            held_out: held_out.collect(),
            more: more
                .map(|ride| (ride.name.clone(), ride.alone_sentence.clone()))
                .collect(),
            left_aside: report.left_aside,
            numbers,
        }
    }
}

impl EffectRow {
    fn of(found: &StudyEffect, rides: &[StudyRide], alpha: f64) -> Self {
        let effect = &found.effect;
        let sizes = |parameters: &BTreeMap<String, ParameterReport>| -> Vec<(String, Quantity)> {
            let sizes = parameters.iter();
            sizes
                .map(|(name, p)| (words::plain(name), p.quantity(name)))
                .collect()
        };
        let differs = found.differs_p_value.is_some_and(|p| p < alpha);
        let each = rides.iter().zip(&found.by_ride);
        let each = each.filter(|(ride, _)| found.acts_in.contains(&ride.name));
        Self {
            name: format!("{} ({})", words::title(&effect.id), effect.axle.name()),
            parameters: match differs {
                true => Vec::new(),
                false => sizes(&effect.parameters),
            },
            by_ride: match differs {
                true => each
                    .map(|(ride, found)| (ride.name.clone(), sizes(found)))
                    .collect(),
                false => Vec::new(),
            },
            rides: match &found.only_in {
                Some(ride) => format!("{ride} alone"),
                None => found.acts_in.join(", "),
            },
        }
    }
}

impl NumberRow {
    fn of(ride: &str, axle: Axle, e: Option<&Estimate>) -> Self {
        let known = |why: &Option<String>, value, error, unit| {
            why.is_none().then(|| Quantity::new(value, error, unit))
        };
        Self {
            ride: ride.to_owned(),
            axle: axle.name(),
            k: e.and_then(|e| known(&e.k_not_identifiable, e.k_n_m, e.k_std_n_m, "N/m")),
            b: e.and_then(|e| known(&e.b_not_identifiable, e.b_n_s_m, e.b_std_n_s_m, "N s/m")),
        }
    }
}

/// The page of a study's job.
pub async fn page(server: &Server, row: JobRow) -> Result<Html<String>, Fault> {
    let ids = row.study.as_ref().map_or(&[][..], |ids| &ids.0);
    let rides = named_rides(&server.db, &row.group_name, ids).await?;
    let rides = rides
        .into_iter()
        .map(|(name, job)| (name, format!("/jobs/{}", job.id)))
        .collect();
    let found = match row.state {
        JobState::Succeeded => Some(Found::of(stored(&server.db, row.id).await?.parse()?)),
        _ => None,
    };
    html(&Page {
        job: row.into(),
        found,
        rides,
    })
}

/// What the form sends.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Latest {
    last: usize,
}

pub async fn create(
    State(server): App,
    caller: Caller,
    Path(bike): Path<String>,
    Form(latest): Form<Latest>,
) -> Result<Redirect, Fault> {
    let new = NewStudy {
        bike: Some(bike),
        last: Some(latest.last),
        ..NewStudy::default()
    };
    let job = submit(&server, &caller, &new).await?;
    Ok(Redirect::to(&format!("/jobs/{}", job.id)))
}
