//! A job's model on another ride.

use askama::Template;
use axum::extract::State;
use axum::response::Html;
use serde::Deserialize;
use uuid::Uuid;
use veloid_engine::bicycle::Axle;
use veloid_engine::diagnosis::validation::quantity;
use veloid_engine::document::format_number::{Quantity, fixed, significant};
use veloid_engine::report::model_on_ride::{AxleOnRide, FitOnRide, ParameterOnRide};

use super::layout::{Fault, Path, Query, html};
use crate::api::App;
use crate::api::access::Caller;
use crate::api::jobs::view::{JobView, find};
use crate::api::validations::{NewValidation, RideValidation, validation};
use crate::fleet::words::capital;
use crate::store::Db;
use crate::store::job;

/// Rides that are offered at most, those of the same bicycle and those of others.
const OFFERED: i64 = 50;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Asked {
    ride: Option<Uuid>,
}

#[derive(Template)]
#[template(path = "validation.html")]
struct Page {
    job: JobView,
    /// Rides of the same bicycle, newest first.
    same: Vec<Offer>,
    /// Rides of others.
    others: Vec<Offer>,
    found: Option<Found>,
    /// Why the chosen ride was not compared.
    problem: Option<String>,
}

/// A ride to compare with.
struct Offer {
    id: Uuid,
    name: String,
    bike: String,
    is_chosen: bool,
}

struct Found {
    name: String,
    /// Of each axle.
    sentences: Vec<String>,
    warnings: Vec<String>,
    axles: Vec<AxleView>,
    left_out: Vec<String>,
    /// The comparison as JSON, for the figures.
    json: String,
}

struct AxleView {
    axle: &'static str,
    /// What each model is, its fit, what it explains, and the RMS of what it leaves.
    fits: Vec<[String; 4]>,
    noise: Option<Quantity>,
    numbers: Vec<NumberView>,
    compared: String,
}

struct NumberView {
    name: String,
    model: Quantity,
    ride: Quantity,
    apart: String,
    differs: bool,
}

impl Page {
    fn here(&self) -> &'static str {
        ""
    }
}

pub async fn page(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
    Query(asked): Query<Asked>,
) -> Result<Html<String>, Fault> {
    let job = find(&server.db, &caller.group, id).await?;
    let offers = offers(&server.db, &caller.group, &job, asked.ride).await?;
    let (same, others) = offers.into_iter().partition(|offer| offer.bike == job.bike);
    let compared = match asked.ride {
        Some(ride) => {
            let new = NewValidation { model: id, ride };
            Some(validation(&server, &caller.group, &new).await)
        }
        None => None,
    };
    let (found, problem) = match compared {
        Some(Ok(validation)) => (Some(Found::of(&validation)?), None),
        Some(Err(problem)) if problem.status < 500 => (None, Some(capital(&problem.detail))),
        Some(Err(problem)) => return Err(problem.into()),
        None if job.state != job::State::Succeeded => {
            let problem = format!(
                "The job is {}: its model is known once it has succeeded.",
                job.state.name()
            );
            (None, Some(problem))
        }
        None => (None, None),
    };
    html(&Page {
        job,
        same,
        others,
        found,
        problem,
    })
}

/// Rides other than the model's own, each once.
async fn offers(
    db: &Db,
    group: &str,
    model: &JobView,
    chosen: Option<Uuid>,
) -> sqlx::Result<Vec<Offer>> {
    let mut found: Vec<Offer> = Vec::new();
    for bike in [Some(model.bike.as_str()), None] {
        let filter = job::Filter {
            group,
            bike,
            ..job::Filter::default()
        };
        for job in job::page(db, &filter, OFFERED).await? {
            let is_new = found.iter().all(|offer| offer.id != job.ride_id);
            let is_own = job.ride_id == model.ride.id;
            if is_new && (!is_own || chosen == Some(job.ride_id)) {
                found.push(Offer {
                    id: job.ride_id,
                    name: job.ride_name,
                    bike: job.bike,
                    is_chosen: chosen == Some(job.ride_id),
                });
            }
        }
    }
    Ok(found)
}

impl Found {
    fn of(validation: &RideValidation) -> Result<Self, Fault> {
        let found = &validation.found;
        let json = serde_json::to_string(validation);
        Ok(Self {
            name: validation.name.clone(),
            sentences: found
                .axles
                .iter()
                .map(|(_, on)| on.sentence.clone())
                .collect(),
            warnings: found.warnings.clone(),
            axles: found
                .axles
                .iter()
                .map(|(axle, on)| AxleView::of(axle, on))
                .collect(),
            left_out: found.left_out.clone(),
            // Within a script element nothing may end it.
            json: json
                .map_err(crate::api::problem::Problem::internal)?
                .replace('<', "\\u003c"),
        })
    }
}

impl AxleView {
    fn of(axle: Axle, found: &AxleOnRide) -> Self {
        let unit = found.predicted.unit();
        let row = |what: &str, fit: &FitOnRide| {
            [
                what.to_owned(),
                fixed(fit.fit_percent, 2),
                fixed(fit.explained_percent, 3),
                Quantity::rough(fit.rms, 3, unit).to_string(),
            ]
        };
        let mut fits = vec![row("The model", &found.model)];
        fits.extend(
            found
                .plain
                .iter()
                .map(|fit| row("Without its effects", fit)),
        );
        fits.extend(
            found
                .refitted
                .iter()
                .map(|fit| row("Fitted to this ride", fit)),
        );
        let [from, to] = found.compared_s.map(|t| significant(t, 3));
        Self {
            axle: axle.name(),
            fits,
            noise: found.noise.map(|noise| Quantity::rough(noise, 3, unit)),
            numbers: found.parameters.iter().map(NumberView::of).collect(),
            compared: format!("{from} to {to} s"),
        }
    }
}

impl NumberView {
    fn of(p: &ParameterOnRide) -> Self {
        Self {
            name: quantity(&p.name),
            model: Quantity::new(p.model, p.model_std_error, &p.unit),
            ride: Quantity::new(p.ride, p.ride_std_error, &p.unit),
            apart: p
                .difference_in_errors
                .map_or("–".to_owned(), |z| significant(z, 2)),
            differs: p.differs == Some(true),
        }
    }
}
