//! The one door: [`identify`], and the stages it is made of beside [`Swarm`]'s trials, which the server
//! runs as queued jobs. Each stage's result can be stored as JSON and read back without losing a bit.

use rayon::prelude::*;

use crate::EngineError;
use crate::bicycle::{Bike, PerAxle};
use crate::checked::checked;
use crate::diagnosis;
use crate::output_error;
use crate::output_error::start::{start_from, starts_from};
use crate::progress::Progress;
use crate::report::diagnosis::Diagnosis;
use crate::report::stages::{Conclusion, Observed};
use crate::report::{Comparison, Estimate, Report, SwarmReport, Trial};
use crate::ride::Ride;
use crate::settings::Settings;
use crate::swarm::Swarm;

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

/// Stage `diagnose`: what physics the model leaves out.
pub fn diagnose(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    conclusion: &Conclusion,
    progress: &dyn Progress,
) -> Result<Diagnosis, EngineError> {
    let found = match diagnosis::diagnose(ride, bike, settings, conclusion, progress) {
        // What the other methods found stands without it.
        Err(EngineError::Diverged { problem, .. }) => Diagnosis::cannot_tell(format!(
            "This record carries no verdict: {problem}. Record what drives the axle, a road or a force, together with its motion."
        )),
        found => found?,
    };
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
