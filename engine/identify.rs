//! The one door: [`identify`], and the stages it is made of beside [`Swarm`]'s trials, which the server
//! runs as queued jobs. Each stage's result can be stored as JSON and read back without losing a bit.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::EngineError;
use crate::bicycle::{Bike, PerAxle};
use crate::checked::checked;
use crate::diagnosis::{self, Diagnosis};
use crate::output_error;
use crate::report::{
    Comparison, Estimate, ObserverReport, RecursivePath, Report, RollReport, SwarmReport, Trial,
};
use crate::ride::Ride;
use crate::settings::Settings;
use crate::swarm::Swarm;

/// Hears how an identification advances and may stop it. Called from several threads.
pub trait Progress: Sync {
    /// A stage begins: `observe`, `trials`, `conclude` or `diagnose`.
    fn stage(&self, _name: &str) {}
    /// A swarm iteration is done.
    fn iteration(&self, _trial: usize, _iteration: usize, _best_cost: f64) {}
    /// Asked at least once per swarm iteration and per fit of the diagnosis.
    fn cancelled(&self) -> bool {
        false
    }
}

/// Hears nothing, stops nothing.
pub struct Silent;

impl Progress for Silent {}

/// First stage: observer, least squares and instrumental variables.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Observed {
    pub observer: PerAxle<ObserverReport>,
    pub least_squares: PerAxle<Estimate>,
    pub instrumental: PerAxle<Estimate>,
    pub recursive: PerAxle<RecursivePath>,
    pub roll: Option<RollReport>,
}

/// Third stage: the swarm's result, the output-error fit and the comparison of all methods.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct Conclusion {
    pub least_squares: PerAxle<Estimate>,
    pub instrumental: PerAxle<Estimate>,
    pub swarm: SwarmReport,
    pub output_error: PerAxle<Estimate>,
    pub comparison: Comparison,
}

/// Runs all stages; trials run in parallel on the current rayon pool.
pub fn identify(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Report, EngineError> {
    progress.stage("observe");
    let observed = observe(ride, bike, settings)?;
    progress.stage("trials");
    let swarm = Swarm::new(ride, bike, settings, &observed)?;
    let trials = (0..settings.trials)
        .into_par_iter()
        .map(|index| swarm.trial(index, progress))
        .collect::<Result<Vec<_>, _>>()?;
    progress.stage("conclude");
    let conclusion = conclude(ride, bike, settings, &observed, trials)?;
    let diagnosis = if settings.diagnosis {
        progress.stage("diagnose");
        Some(diagnose(ride, bike, settings, &conclusion, progress)?)
    } else {
        None
    };
    assemble(ride, bike, settings, observed, conclusion, diagnosis)
}

/// Stage `observe`: what is visible at once.
pub fn observe(ride: &Ride, bike: &Bike, settings: &Settings) -> Result<Observed, EngineError> {
    checked("observe", crate::observe::observe(ride, bike, settings)?)
}

/// Stage `conclude`: after the last trial. `trials` in the order of their index.
pub fn conclude(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    observed: &Observed,
    trials: Vec<Trial>,
) -> Result<Conclusion, EngineError> {
    let swarm = SwarmReport::of(trials, observed);
    let mut starts = vec![
        starts_from(&observed.instrumental),
        starts_from(&observed.least_squares),
    ];
    starts.push(PerAxle {
        front: swarm.front.as_ref().map(start_from),
        rear: swarm.rear.as_ref().map(start_from),
    });
    let fits = output_error::fit(ride, bike, settings, &starts)?;
    let output_error = fits.map(|axle, fit| fit.estimate(bike.mass(axle).is_some()).told());
    let judged = |estimates: &PerAxle<Estimate>| {
        estimates.map(|axle, e| e.clone().judged_by(output_error.get(axle)))
    };
    let swarm = SwarmReport {
        front: swarm
            .front
            .map(|e| e.judged_by(output_error.front.as_ref())),
        rear: swarm.rear.map(|e| e.judged_by(output_error.rear.as_ref())),
        ..swarm
    };
    let swarmed = PerAxle {
        front: swarm.front.clone(),
        rear: swarm.rear.clone(),
    };
    let comparison = Comparison::of(
        ride,
        &[
            ("least_squares", &observed.least_squares),
            ("instrumental", &observed.instrumental),
            ("swarm", &swarmed),
            ("output_error", &output_error),
        ],
    );
    let conclusion = Conclusion {
        least_squares: judged(&observed.least_squares),
        instrumental: judged(&observed.instrumental),
        swarm,
        output_error,
        comparison,
    };
    checked("conclude", conclusion)
}

pub(crate) fn starts_from(estimates: &PerAxle<Estimate>) -> PerAxle<output_error::Start> {
    estimates.map(|_, e| start_from(e))
}

fn start_from(e: &Estimate) -> output_error::Start {
    output_error::Start {
        kappa: e.k_n_m / e.mass_kg,
        beta: e.b_n_s_m / e.mass_kg,
        per_mass: 1.0 / e.mass_kg,
    }
}

/// Stage `diagnose`: what physics the model leaves out.
pub fn diagnose(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    conclusion: &Conclusion,
    progress: &dyn Progress,
) -> Result<Diagnosis, EngineError> {
    let found = diagnosis::diagnose(ride, bike, settings, conclusion, progress)?;
    checked("diagnose", found)
}

/// Puts the stages' results into the report.
pub fn assemble(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    observed: Observed,
    conclusion: Conclusion,
    diagnosis: Option<Diagnosis>,
) -> Result<Report, EngineError> {
    let report = Report {
        veloid: env!("CARGO_PKG_VERSION").to_owned(),
        ride: ride.summary.clone(),
        bike: bike.clone(),
        settings: settings.clone(),
        observer: observed.observer,
        least_squares: conclusion.least_squares,
        instrumental: conclusion.instrumental,
        recursive: observed.recursive,
        swarm: conclusion.swarm,
        output_error: conclusion.output_error,
        comparison: conclusion.comparison,
        roll: observed.roll,
        diagnosis,
    };
    checked("report", report)
}

#[cfg(test)]
mod tests;
