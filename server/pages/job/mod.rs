//! One job: live while it runs, its result once it is there.

mod bars;
mod diagnosis;
mod inside;
mod latent;
mod report;
mod tried;

use askama::Template;
use axum::extract::State;
use axum::response::{Html, Redirect};
use uuid::Uuid;
use veloid_engine::document::format_number::{Quantity, fixed, significant};

use super::facts::{self, Field};
use super::layout::{Fault, Path, html};
use super::study;
use crate::api::App;
use crate::api::access::Caller;
use crate::api::extract;
use crate::api::jobs::view::{JobView, no_such_job};
use crate::api::jobs::{cancel as cancelling, retry as retrying};
use crate::api::problem::Problem;
use crate::erasure::DAY_MS;
use crate::store::job::{self, Request, Stage};
use crate::store::result::{self, DocumentError};
use diagnosis::DiagnosisView;
use report::ReportView;

#[derive(Template)]
#[template(path = "job.html")]
struct Page {
    job: JobView,
    sha256: String,
    /// The bike file as it was used.
    bike: String,
    report: Option<ReportView>,
    /// Why there is a report and it is not shown.
    unreadable: Option<String>,
    diagnosis: Option<DiagnosisView>,
    /// Least squares of a job that is not finished.
    early: Vec<Early>,
    grace_days: i64,
    /// What is known of the ride, to read and to change.
    known: Vec<(String, String)>,
    facts: Vec<Field>,
}

/// The first estimate of an axle.
struct Early {
    axle: &'static str,
    k: Quantity,
    b: Quantity,
    k_unknown: bool,
    b_unknown: bool,
}

/// The stages in order, in the words of the page.
const STAGES: [(Stage, &str); 4] = [
    (Stage::Observe, "Observer and least squares"),
    (Stage::Trial, "Particle swarm"),
    (Stage::Conclude, "Output error"),
    (Stage::Diagnose, "Diagnosis"),
];

impl Page {
    fn here(&self) -> &'static str {
        ""
    }

    /// Class and words of every stage that this job goes through.
    fn stages(&self) -> Vec<(&'static str, &'static str, &'static str)> {
        let now = STAGES
            .iter()
            .position(|(stage, _)| *stage == self.job.stage);
        let diagnosed = self.job.options.settings.diagnosis;
        STAGES
            .iter()
            .enumerate()
            .filter(|(_, (stage, _))| diagnosed || *stage != Stage::Diagnose)
            .map(|(i, (stage, words))| {
                let class = match now {
                    Some(now) if i < now => "done",
                    Some(now) if i == now && !self.job.state.is_final() => "now",
                    _ => "",
                };
                (class, stage.name(), *words)
            })
            .collect()
    }

    fn warnings(&self) -> Vec<&String> {
        let ride = &self.job.ride.summary.warnings;
        let more = self.diagnosis.iter().flat_map(|d| &d.warnings);
        let mistakes = self.report.iter().flat_map(|report| &report.mistakes);
        mistakes
            .chain(ride)
            .chain(more.filter(|w| !ride.contains(w)))
            .collect()
    }

    /// Class of the state: a job that succeeded without a verdict is not shown as a success.
    fn state(&self) -> &'static str {
        let no_verdict = self.job.verdict.as_deref() == Some("cannot_tell");
        if no_verdict {
            "unanswered"
        } else {
            self.job.state.name()
        }
    }

    fn duration(&self) -> String {
        fixed(self.job.ride.summary.duration_s, 1)
    }

    fn rate(&self) -> String {
        significant(self.job.ride.summary.rate_hz, 5)
    }

    fn percent(&self) -> u32 {
        (100.0 * self.job.progress) as u32
    }
}

pub async fn page(
    State(server): App,
    caller: Caller,
    Path(id): Path<Uuid>,
) -> Result<Html<String>, Fault> {
    let row = job::find(&server.db, &caller.group, id)
        .await?
        .ok_or_else(no_such_job)?;
    if row.study.is_some() {
        return study::page(&server, row).await;
    }
    let (sha256, Request { bike, .. }) = (row.sha256.clone(), row.request.0.clone());
    let job = JobView::from(row);
    let (report, unreadable) = match result::report(&server.db, id).await {
        Ok(report) => (report, None),
        Err(DocumentError::Database(error)) => return Err(error.into()),
        Err(error) => (None, Some(error.to_string())),
    };
    let early = job
        .least_squares
        .iter()
        .flat_map(|estimates| estimates.iter());
    let early = early.map(|(axle, e)| Early {
        axle: axle.name(),
        k_unknown: e.k_not_identifiable.is_some(),
        b_unknown: e.b_not_identifiable.is_some(),
        k: Quantity::new(e.k_n_m, e.k_std_n_m, "N/m"),
        b: Quantity::new(e.b_n_s_m, e.b_std_n_s_m, "N s/m"),
    });
    html(&Page {
        early: early.collect(),
        sha256,
        bike: serde_json::to_string_pretty(&bike).map_err(Problem::internal)?,
        diagnosis: report.as_ref().and_then(DiagnosisView::of),
        report: report.as_ref().map(ReportView::of),
        unreadable,
        known: facts::lines(&job.ride.facts),
        facts: facts::fields(&job.ride.facts),
        grace_days: server.policy.grace_ms / DAY_MS,
        job,
    })
}

pub async fn cancel(server: App, caller: Caller, Path(id): Path<Uuid>) -> Result<Redirect, Fault> {
    let _ = cancelling::cancel(server, caller, extract::Path(id)).await?;
    Ok(Redirect::to(&format!("/jobs/{id}")))
}

pub async fn retry(server: App, caller: Caller, Path(id): Path<Uuid>) -> Result<Redirect, Fault> {
    retrying::retry(server, caller, extract::Path(id)).await?;
    Ok(Redirect::to(&format!("/jobs/{id}")))
}
