//! The one door: [`identify`], and the stages it is made of beside [`Swarm`]'s trials, which the server
//! runs as queued jobs. Each stage's result can be stored as JSON and read back without losing a bit.

use rayon::prelude::*;

use super::limits::{self, limited};
use super::result::{dynamics, result};
use super::validate::validate;
use super::what_next::what_next;
use super::widening::Widening;
use super::{beside, gains};
use crate::replay::comparison;
use veloid_core::EngineError;
use veloid_core::Progress;
use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_core::document::checked;
use veloid_core::settings::Settings;
use veloid_diagnosis::judge::scores::Scores;
use veloid_diagnosis::tried::{NO_VERDICT, with_own_law};
use veloid_methods::output_error;
use veloid_methods::output_error::start::{start_from, starts_from};
use veloid_methods::swarm::Swarm;
use veloid_methods::uncertainty::laser::{are_unplaced, misleading, unconfirmed};
use veloid_methods::uncertainty::road_noise::decides;
use veloid_mistakes::mistakes;
use veloid_report::Method;
use veloid_report::diagnosis::{Diagnosis, Verdict};
use veloid_report::identifiable::{MISTAKEN, UNPLACED};
use veloid_report::stages::{Conclusion, Observed};
use veloid_report::{Comparison, Estimate, LatentRoad, Mistake, Report, SwarmReport, Trial};
use veloid_ride::Ride;

/// Stiffness k and damping B of every axle by every method, and what physics the model leaves out. Trials of the swarm run
/// in parallel on the current rayon pool.
///
/// # Errors
/// A bike file that lacks a mass which the ride does not show either, settings out of range, a ride that does not determine k and B,
/// a fit that diverges, cancellation.
///
/// ```
/// use veloid_engine::simulate::simulated_ride::SimulatedRide;
/// use veloid_engine::{Bike, EngineError, Settings, Silent, identify};
///
/// let simulated = SimulatedRide {
///     duration_s: 10.0,
///     noise_displacement_m: 5e-5,
///     ..SimulatedRide::default()
/// };
/// let bike = Bike {
///     mass_front_kg: simulated.front.map(|spring| spring.mass_kg),
///     mass_rear_kg: simulated.rear.map(|spring| spring.mass_kg),
///     ..Bike::default()
/// };
/// let settings = Settings {
///     trials: 1,
///     diagnosis: false,
///     ..Settings::default()
/// };
/// let report = identify(&simulated.ride(), &bike, &settings, &Silent)?;
/// let (found, made) = (report.output_error.front.unwrap(), simulated.front.unwrap());
/// let std_error = found.k_std_n_m.unwrap();
/// assert!(std_error < 0.01 * made.k_n_m && (found.k_n_m - made.k_n_m).abs() < 4.0 * std_error);
///
/// let unsure = Settings { trials: 0, ..settings };
/// let error = identify(&simulated.ride(), &bike, &unsure, &Silent).unwrap_err();
/// assert_eq!(error.to_string(), "setting trials: 0 is outside 1 to 100");
/// # Ok::<(), EngineError>(())
/// ```
pub fn identify(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Report, EngineError> {
    let (observed, conclusion) = concluded(ride, bike, settings, progress)?;
    let diagnosis = if settings.diagnosis {
        progress.stage("diagnose");
        Some(diagnose(ride, bike, settings, &conclusion, progress)?)
    } else {
        None
    };
    assemble(ride, bike, settings, observed, conclusion, diagnosis)
}

/// Held-out scores of every set of effects that is tried on each axle of a bench, from which `diagnosis::judge` reads a verdict.
///
/// # Errors
/// As [`identify`].
pub fn scores(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<PerAxle<Scores>, EngineError> {
    let (_, conclusion) = concluded(ride, bike, settings, progress)?;
    veloid_diagnosis::scores(ride, bike, settings, &conclusion, progress)
}

/// The stages before the diagnosis.
fn concluded(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<(Observed, Conclusion), EngineError> {
    validate(settings)?;
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
    Ok((observed, conclusion))
}

/// Stage `observe`: what is visible at once.
pub fn observe(ride: &Ride, bike: &Bike, settings: &Settings) -> Result<Observed, EngineError> {
    let bike = &limited(ride, bike, settings)?;
    checked(
        "observe",
        crate::pipeline::observe::observe(ride, bike, settings)?,
    )
}

/// Stage `conclude`: after the last trial. `trials` in the order of their index.
pub fn conclude(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    observed: &Observed,
    trials: Vec<Trial>,
) -> Result<Conclusion, EngineError> {
    let bike = &limited(ride, bike, settings)?;
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
    let mistakes = mistakes(ride, bike, settings, &fits);
    let output_error = fits.map(|axle, fit| {
        let estimate = fit.estimate(bike.mass(axle).is_some());
        let estimate = estimate.limited(bike.limits(axle)).reportable();
        estimate.within_reach(ride.step_s)
    });
    let widening = Widening::find(ride, bike, settings, &output_error)?;
    let output_error = widening.of_output_error(&output_error);
    let judged = |estimates: &PerAxle<Estimate>| {
        let estimates = widening.of_any(estimates);
        estimates.map(|axle, e| e.clone().judged_by(output_error.get(axle)))
    };
    let swarm = SwarmReport {
        front: swarm
            .front
            .map(|e| e.judged_by(output_error.front.as_ref())),
        rear: swarm.rear.map(|e| e.judged_by(output_error.rear.as_ref())),
        ..swarm
    };
    let mut notes = widening.notes(&output_error);
    notes.extend(bike.limited().next().map(|_| limits::NOTE.to_owned()));
    let comparison = compared(ride, observed, &swarm, &output_error, notes);
    let clock_unconfirmed = unconfirmed(
        &ride.summary.clocks,
        &output_error,
        observed.latent_road.as_ref(),
        settings.alpha,
    );
    let conclusion = Conclusion {
        mistakes,
        least_squares: judged(&observed.least_squares),
        instrumental: judged(&observed.instrumental),
        swarm,
        output_error,
        laser_error: widening.laser,
        mass_error: widening.mass,
        road_noise_error: widening.road_noise,
        interpolation_error: widening.interpolation,
        clock_unconfirmed,
        unidentified: (observed.latent_road.as_ref()).and_then(|latent| latent.reason.clone()),
        comparison,
    };
    checked("conclude", conclusion)
}

/// The paper's Table 1, with what there is to say beside it.
fn compared(
    ride: &Ride,
    observed: &Observed,
    swarm: &SwarmReport,
    output_error: &PerAxle<Estimate>,
    notes: Vec<String>,
) -> Comparison {
    let swarm = PerAxle {
        front: swarm.front.clone(),
        rear: swarm.rear.clone(),
    };
    let comparison = comparison::of(
        ride,
        &[
            (Method::LeastSquares.name(), &observed.least_squares),
            (Method::Instrumental.name(), &observed.instrumental),
            (Method::Swarm.name(), &swarm),
            (Method::OutputError.name(), output_error),
        ],
    );
    Comparison {
        notes: [comparison.notes, skipped(ride), notes].concat(),
        ..comparison
    }
}

/// Why the methods that compare motion and road have no rows.
fn skipped(ride: &Ride) -> Vec<String> {
    let why = "observer, least squares, swarm and output error are skipped: they need the road, which was not measured";
    (ride.has_no_road())
        .then(|| why.to_owned())
        .into_iter()
        .collect()
}

/// Why there is no fit of a law of the user's own on an axle.
const UNFITTED: &str =
    "not fitted: the axle's drive was not recorded, or no start of the law moves the axle";

/// Stage `diagnose`: what physics the model leaves out.
pub fn diagnose(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    conclusion: &Conclusion,
    progress: &dyn Progress,
) -> Result<Diagnosis, EngineError> {
    let unlimited = bike;
    let bike = &limited(ride, bike, settings)?;
    if let Some(why) = no_verdict(ride, conclusion) {
        let found = with_own_law(Diagnosis::without_verdict(why), settings, NO_VERDICT)?;
        return checked("diagnose", found);
    }
    if ride.has_no_road() {
        let unidentified = conclusion.unidentified.as_deref();
        let found = veloid_diagnosis::no_road::diagnose(ride, bike, unidentified, progress)?;
        let found = with_own_law(found, settings, "not looked for without a road")?;
        return checked("diagnose", found);
    }
    let found = match veloid_diagnosis::diagnose(ride, bike, settings, conclusion, progress) {
        // What the other methods found stands without it.
        Err(EngineError::Diverged { problem, .. }) => Diagnosis::without_verdict(format!(
            "No verdict: {problem}. Record what drives the axle, a road or a force, together with its motion; if a rig prescribes \
             the motion and measures the force, omit the mass."
        )),
        found => found?,
    };
    let asked = (ride, unlimited, settings);
    let found = match limits::contradicted(asked, conclusion, &found, progress)? {
        Some(why) => Diagnosis::without_verdict(why),
        None => found,
    };
    let found = with_own_law(found, settings, UNFITTED)?;
    let plain = |axle| !found.effects.iter().any(|e| e.axle.acts_on(axle));
    let extended = Widening::stored(conclusion).of_extended(ride, &found.extended, plain);
    let extended = gains::withheld(ride, &found, &extended);
    let extended = extended.map(|axle, e| e.clone().limited(bike.limits(axle)));
    let sentence = [
        Some(found.sentence.clone()),
        gains::tie(ride, bike, &found),
        unjudged(ride),
    ];
    let sentence: Vec<String> = sentence.into_iter().flatten().collect();
    checked(
        "diagnose",
        Diagnosis {
            extended,
            sentence: sentence.join(" "),
            ..found
        },
    )
}

/// That an axle has no verdict beside one that has.
fn unjudged(ride: &Ride) -> Option<String> {
    let is_sensed = |axle| ride.sensors.iter().any(|sensor| sensor.axle == axle);
    let axle = (Axle::BOTH.into_iter())
        .find(|axle| ride.axles.get(*axle).is_none() && is_sensed(*axle))?;
    Some(format!(
        "There is no verdict on the {axle} axle, whose road was not measured."
    ))
}

/// Why a ride carries no verdict, whatever the model; nothing where it may.
fn no_verdict(ride: &Ride, conclusion: &Conclusion) -> Option<String> {
    let clocks = &ride.summary.clocks;
    let laser = || misleading(clocks, &conclusion.output_error, &conclusion.laser_error);
    if ride.has_no_road() {
        return to_be_mended(&conclusion.mistakes).or_else(laser);
    }
    let noise = || decides(&conclusion.output_error, &conclusion.road_noise_error);
    let first = to_be_mended(&conclusion.mistakes)
        .or_else(laser)
        .or_else(noise);
    first.or_else(|| conclusion.clock_unconfirmed.clone())
}

/// What has to be mended before there can be a verdict.
fn to_be_mended(mistakes: &[Mistake]) -> Option<String> {
    let said = mistakes.iter().filter(|m| m.takes_the_verdict);
    let said: Vec<&str> = said.map(|m| m.sentence.as_str()).collect();
    (!said.is_empty()).then(|| said.join(" "))
}

/// Puts the stages' results into the report.
pub fn assemble(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    observed: Observed,
    conclusion: Conclusion,
    mut diagnosis: Option<Diagnosis>,
) -> Result<Report, EngineError> {
    let found = diagnosis
        .as_mut()
        .map(|d| std::mem::take(&mut d.validation));
    let found = found.unwrap_or_default();
    let validation = beside::validations(ride, bike, settings, &conclusion.output_error, found);
    let mistaken = to_be_mended(&conclusion.mistakes).map(|_| MISTAKEN);
    let unplaced = are_unplaced(&ride.summary.clocks).then_some(UNPLACED);
    let reported = |estimates: PerAxle<Estimate>| match (mistaken.or(unplaced), &diagnosis) {
        (Some(why), _) => estimates.map(|_, e| e.clone().withheld(why)),
        (None, Some(diagnosis)) => gains::withheld(ride, diagnosis, &estimates),
        (None, None) => estimates,
    };
    let widening = Widening::stored(&conclusion);
    let report = Report {
        veloid: env!("CARGO_PKG_VERSION").to_owned(),
        ride: ride.summary.clone(),
        bike: bike.clone(),
        settings: settings.clone(),
        mistakes: conclusion.mistakes,
        observer: observed.observer,
        least_squares: reported(conclusion.least_squares),
        instrumental: reported(conclusion.instrumental),
        recursive: observed.recursive,
        swarm: conclusion.swarm,
        output_error: reported(conclusion.output_error),
        latent_road: observed.latent_road.map(|latent| {
            let estimates = reported(widening.of_latent_road(&latent.axles()));
            let PerAxle { front, rear } = match ride.has_no_road() {
                true => refined(diagnosis.as_ref(), estimates),
                false => estimates,
            };
            LatentRoad {
                front,
                rear,
                ..latent
            }
        }),
        comparison: conclusion.comparison,
        laser_error: conclusion.laser_error,
        mass_error: conclusion.mass_error,
        road_noise_error: conclusion.road_noise_error,
        interpolation_error: conclusion.interpolation_error,
        roll: observed.roll,
        diagnosis,
        result: PerAxle::default(),
        dynamics: PerAxle::default(),
        validation,
        what_next: Vec::new(),
    };
    let result = result(ride, &report);
    let report = report.with_result(result);
    let (dynamics, what_next) = (dynamics(ride, &report), what_next(ride, &report));
    let report = Report {
        dynamics,
        what_next,
        ..report
    };
    checked("report", report)
}

/// Estimates of plain axles without a road: the diagnosis, where it names nothing, knows more of how the wheels differ than the spectra,
/// which are biased where contact patches are not alike.
fn refined(diagnosis: Option<&Diagnosis>, estimates: PerAxle<Estimate>) -> PerAxle<Estimate> {
    let plain = diagnosis.filter(|d| d.verdict == Verdict::NothingMissing);
    estimates.map(|axle, e| {
        let refined = plain.and_then(|d| d.extended.get(axle));
        refined.unwrap_or(e).clone()
    })
}

#[cfg(test)]
mod tests;
