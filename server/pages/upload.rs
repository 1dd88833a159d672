//! The form that sends rides. Without JavaScript it sends one ride at a time; `web/upload.js` adds several at once, previews
//! with a table of columns for each file, and progress.

use askama::Template;
use axum::extract::{Request, State};
use axum::http::StatusCode;
use axum::response::{Html, IntoResponse, Redirect, Response};
use serde::Deserialize;
use veloid_engine::Settings;

use super::bicycle::BicycleForm;
use super::facts::{Field, fields};
use super::layout::{Fault, Query, filled, html};
use crate::api::access::Caller;
use crate::api::bikes::existing;
use crate::api::problem::{Kind, Problem};
use crate::api::rides::{Refused, Submitted, submit_upload};
use crate::api::{App, Server};
use crate::columns::{Choice, choices};
use crate::facts::Facts;
use crate::store::bike;

/// Most bikes that the form lists.
const BIKES: i64 = 1000;

#[derive(Template)]
#[template(path = "upload.html")]
struct Form {
    problem: Option<Problem>,
    bicycle: BicycleForm,
    numbers: Vec<Number>,
    choices: Vec<Choice>,
    facts: Vec<Field>,
}

/// A field for a number.
struct Number {
    name: &'static str,
    label: &'static str,
    default: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// The bike that is selected at first.
    bike: Option<String>,
}

impl Form {
    fn new(bicycle: BicycleForm, problem: Option<Problem>) -> Self {
        Self {
            problem,
            bicycle,
            numbers: numbers(),
            choices: choices(),
            facts: fields(&Facts::default()),
        }
    }

    fn has_spreadsheets(&self) -> bool {
        cfg!(feature = "spreadsheets")
    }

    fn here(&self) -> &'static str {
        "/"
    }

    /// Whether the problem belongs to this part of the form.
    fn fault(&self, part: &str) -> bool {
        self.problem.as_ref().is_some_and(|problem| {
            part == match problem.kind {
                Kind::UnreadableRide | Kind::NotBuilt | Kind::TooLarge => "file",
                Kind::BadBike => "bike",
                Kind::BadOption => "option",
                Kind::BadFact => "fact",
                _ => "",
            }
        })
    }

    fn detail(&self) -> &str {
        self.problem.as_ref().map_or("", |problem| &problem.detail)
    }
}

fn numbers() -> Vec<Number> {
    let settings = Settings::default();
    let number = |name, label, default: f64| Number {
        name,
        label,
        default: default.to_string(),
    };
    vec![
        number("seed", "Seed", settings.seed as f64),
        number("trials", "Swarm trials", settings.trials as f64),
        number("particles", "Particles", settings.particles as f64),
        number("iterations", "Iterations", settings.iterations as f64),
        number("alpha", "Significance level", settings.alpha),
        number("held_out", "Held-out share", settings.held_out),
    ]
}

/// Names of the caller's bicycles.
async fn bikes(server: &Server, caller: &Caller) -> Result<Vec<String>, Problem> {
    let bikes = bike::page(&server.db, &caller.group, "", BIKES).await?;
    Ok(bikes.into_iter().map(|bike| bike.name).collect())
}

pub async fn form(
    State(server): App,
    caller: Caller,
    Query(params): Query<Params>,
) -> Result<Html<String>, Fault> {
    let chosen = filled(params.bike);
    if let Some(name) = &chosen {
        existing(&server, &caller.group, name).await?;
    }
    let bicycle = BicycleForm::new(bikes(&server, &caller).await?, chosen);
    html(&Form::new(bicycle, None))
}

/// Takes the form and redirects to the job's page, or shows the form again with the problem.
pub async fn send(State(server): App, caller: Caller, request: Request) -> Result<Response, Fault> {
    match submit_upload(&server, &caller, request).await {
        Ok(Submitted { job, .. }) => Ok(Redirect::to(&format!("/jobs/{}", job.id)).into_response()),
        Err(Refused {
            problem, bicycle, ..
        }) => {
            let status = StatusCode::from_u16(problem.status).unwrap_or_default();
            let bikes = bikes(&server, &caller).await?;
            let bicycle = BicycleForm::again(&server, &caller, bikes, bicycle, &problem).await;
            let page = html(&Form::new(bicycle, Some(problem)))?;
            Ok((status, page).into_response())
        }
    }
}
