//! Stiffness and damping that the user fixes or bounds, on a ride.

use veloid_core::bicycle::{Axle, Bike, LimitError};
use veloid_core::document::format_number::Quantity;
use veloid_core::plant::Of;
use veloid_core::settings::{Settings, limit};
use veloid_core::{EngineError, Progress};
use veloid_methods::output_error;
use veloid_methods::output_error::start::starts_from;
use veloid_report::diagnosis::{Diagnosis, Verdict};
use veloid_report::stages::Conclusion;
use veloid_ride::Ride;

/// Held-out error of the free models, beside those with the limits, up to which they explain a ride as well.
const AS_WELL: f64 = 1.02;
/// Standard errors beyond which a limit excludes what the ride says.
const FAR: f64 = 3.0;

/// That methods beside output error and the search know no limits.
pub const NOTE: &str = "what is fixed or bounded holds in output error and in the search for missing physics; least squares, instrumental \
    variables and the swarm are estimated freely";

/// The bicycle with what its file and the settings fix and bound on a ride.
///
/// # Errors
/// What cannot be fixed or bounded, and axles without a mass or without a road or force.
pub fn limited(ride: &Ride, bike: &Bike, settings: &Settings) -> Result<Bike, EngineError> {
    let limited = settings.limited(bike)?;
    for (key, axle) in limited.limited() {
        let key = key.to_owned();
        match ride.axles.get(axle).filter(|_| !ride.has_no_road()) {
            None => return Err(limit(LimitError::NotRecorded { key, axle })),
            Some(record) if !record.prescribed && bike.mass(axle).is_none() => {
                return Err(limit(LimitError::NoMass { key, axle }));
            }
            Some(_) => {}
        }
    }
    Ok(limited)
}

/// Refuses limits where several rides are fitted as one.
///
/// # Errors
/// Anything that is fixed or bounded.
pub fn none(bike: &Bike, settings: &Settings) -> Result<(), EngineError> {
    let limited = settings.limited(bike)?;
    let key = limited.limited().next().map(|(key, _)| key.to_owned());
    key.map_or(Ok(()), |key| Err(limit(LimitError::Study { key })))
}

/// That what is missing beside the limits is nothing but them: with k and B free, fewer effects explain the ride as well. `bike` has no
/// limits but its file's.
///
/// # Errors
/// As of a diagnosis.
pub fn contradicted(
    (ride, bike, settings): (&Ride, &Bike, &Settings),
    conclusion: &Conclusion,
    found: &Diagnosis,
    progress: &dyn Progress,
) -> Result<Option<String>, EngineError> {
    let limits = settings.limited(bike)?;
    let is_missing = !matches!(found.verdict, Verdict::NothingMissing | Verdict::CannotTell);
    if limits.limited().next().is_none() || !is_missing {
        return Ok(None);
    }
    let free_bike = Bike {
        fix: Default::default(),
        bound: Default::default(),
        ..bike.clone()
    };
    let free_settings = Settings {
        fix: Default::default(),
        bound: Default::default(),
        ..settings.clone()
    };
    let starts = [&conclusion.instrumental, &conclusion.least_squares].map(starts_from);
    let fits = output_error::fit(ride, &free_bike, &free_settings, &starts)?;
    let output_error = fits.map(|axle, fit| fit.estimate(bike.mass(axle).is_some()).reportable());
    let freed = Conclusion {
        output_error,
        ..conclusion.clone()
    };
    let free = veloid_diagnosis::diagnose(ride, &free_bike, &free_settings, &freed, progress)?;
    let contradictions: Vec<String> = Axle::BOTH
        .into_iter()
        .flat_map(|axle| excluded(&limits, &free, axle))
        .collect();
    let is_simpler = effects(&free) < effects(found) && explains_as_well(&free, found);
    Ok((is_simpler && !contradictions.is_empty()).then(|| {
        format!(
            "No verdict: {}. With that free, {} explains the ride as well: give the limits up, or check masses and units.",
            contradictions.join("; "),
            match effects(&free) {
                0 => "a spring and a damper",
                _ => "less physics",
            }
        )
    }))
}

/// Effects that a diagnosis needs; more than any where they do not explain the ride.
fn effects(found: &Diagnosis) -> usize {
    match found.verdict {
        Verdict::NothingMissing => 0,
        Verdict::Named | Verdict::Ambiguous => found.effects.len(),
        _ => usize::MAX,
    }
}

fn explains_as_well(free: &Diagnosis, found: &Diagnosis) -> bool {
    found.held_out.iter().all(|(axle, limited)| {
        let left = free.held_out.get(axle).and_then(|held| held.extended_rms_m);
        let pair = left.zip(limited.extended_rms_m);
        pair.is_some_and(|(free, limited)| free <= AS_WELL * limited)
    })
}

/// Limits of an axle that exclude what the ride says without them.
fn excluded(limits: &Bike, free: &Diagnosis, axle: Axle) -> Vec<String> {
    let Some(estimate) = free.extended.get(axle) else {
        return Vec::new();
    };
    let k = (
        Of::Stiffness,
        "k",
        "N/m",
        estimate.k_n_m,
        estimate.k_std_n_m,
    );
    let b = (
        Of::Damping,
        "B",
        "N s/m",
        estimate.b_n_s_m,
        estimate.b_std_n_s_m,
    );
    let one = |(of, name, unit, value, error): (Of, &str, &str, f64, Option<f64>)| {
        let [low, high] = limits.limit(axle, of)?;
        let nearest = value.clamp(low, high);
        let is_far = (value - nearest).abs() > FAR * error.unwrap_or(0.0);
        is_far.then(|| {
            format!(
                "{name} of the {axle} axle is held at {}, but free it is {}",
                Quantity::rough(nearest, 6, unit),
                Quantity::new(value, error, unit)
            )
        })
    };
    [k, b].into_iter().filter_map(one).collect()
}
