//! Several rides of one bicycle as one model: [`study`].

use rayon::prelude::*;

use crate::pipeline::identify::{conclude, diagnose, observe};
use crate::pipeline::limits;
use crate::pipeline::validate::validate;
use veloid_core::Progress;
use veloid_core::bicycle::Bike;
use veloid_core::document::checked;
use veloid_core::settings::Settings;
use veloid_core::{EngineError, SettingProblem};
use veloid_diagnosis::prepare::Prepared;
use veloid_diagnosis::study::{Ready, study as together};
use veloid_methods::uncertainty::interpolation::interpolation_error_of_many;
use veloid_report::diagnosis::{Base, Verdict};
use veloid_report::study::{LeftAside, StudyReport};
use veloid_ride::Ride;

/// A ride with a name, and the bicycle as it was ridden.
pub struct Ridden<'a> {
    /// Its name in the report.
    pub name: String,
    /// The ride.
    pub ride: &'a Ride,
    /// Masses may differ from ride to ride, the bicycle not.
    pub bike: &'a Bike,
}

/// Fits 2 to 64 rides of one bicycle as one model: effects' parameters in common, k and B too where the rides bear that.
///
/// # Errors
/// Fewer than two rides that can take part, one record given twice, rides of different axles, more samples than a search can hold, cancellation.
///
/// ```
/// use veloid_engine::report::diagnosis::Verdict;
/// use veloid_engine::simulate::simulated_ride::SimulatedRide;
/// use veloid_engine::{Bike, EngineError, Ridden, Settings, Silent, study};
///
/// let simulated = |seed| SimulatedRide {
///     duration_s: 10.0,
///     noise_displacement_m: 5e-5,
///     rear: None,
///     seed,
///     ..SimulatedRide::default()
/// };
/// let made = simulated(1).front.unwrap();
/// let bike = Bike { mass_front_kg: Some(made.mass_kg), ..Bike::default() };
/// let rides = [1, 2].map(|seed| simulated(seed).ride());
/// let ridden = [("out", &rides[0]), ("back", &rides[1])];
/// let ridden = ridden.map(|(name, ride)| Ridden { name: name.to_owned(), ride, bike: &bike });
/// let settings = Settings { search_budget: 300.0, ..Settings::default() };
///
/// let report = study(&ridden, &settings, &Silent)?;
/// assert_eq!(report.verdict, Verdict::NothingMissing);
/// let names: Vec<&str> = report.rides.iter().map(|ride| ride.name.as_str()).collect();
/// assert_eq!(names, ["out", "back"]);
/// let estimate = report.axles.front.unwrap().estimate.unwrap();
/// assert!((estimate.k_n_m / made.k_n_m - 1.0).abs() < 0.01);
///
/// let error = study(&ridden[..1], &settings, &Silent).err();
/// assert!(matches!(error, Some(EngineError::Setting { name: "rides of a study", .. })));
/// # Ok::<(), EngineError>(())
/// ```
pub fn study(
    rides: &[Ridden],
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<StudyReport, EngineError> {
    validate(settings)?;
    for ridden in rides {
        limits::none(ridden.bike, settings)?;
    }
    if let Some([first, second]) = given_twice(rides) {
        return Err(EngineError::Setting {
            name: "rides of a study",
            problem: SettingProblem::SameRecord {
                first: first.to_owned(),
                second: second.to_owned(),
            },
        });
    }
    progress.stage("each ride");
    let each = rides.par_iter().enumerate().map(|(i, ridden)| {
        // Noise that is laid over quiet rides must not be the same in all of them: together they would show it.
        let own = Settings {
            seed: settings.seed.wrapping_add(i as u64),
            ..settings.clone()
        };
        prepare(ridden, &own, progress)
    });
    let each = each.collect::<Result<Vec<_>, EngineError>>()?;
    let (mut ready, mut aside) = (Vec::new(), Vec::new());
    for ride in each {
        match ride {
            Ok(prepared) => ready.push(prepared),
            Err(left) => aside.push(left),
        }
    }
    if ready.len() < 2 {
        return Err(EngineError::Setting {
            name: "rides of a study",
            problem: SettingProblem::TooFewRides {
                ready: ready.len(),
                given: rides.len(),
                left_aside: aside.into_iter().map(|a| (a.name, a.why)).collect(),
            },
        });
    }
    progress.stage("together");
    checked("study", together(&ready, aside, settings, progress)?)
}

/// Names of two rides that are one record: it would count twice.
fn given_twice<'r>(rides: &'r [Ridden]) -> Option<[&'r str; 2]> {
    let moved = |ridden: &'r Ridden| ridden.ride.axles.iter().map(|(_, r)| &r.displacement);
    let same = |a: &'r Ridden, b: &'r Ridden| moved(a).next().is_some() && moved(a).eq(moved(b));
    let pair = |(i, a): (usize, &'r Ridden)| {
        let other = rides[i + 1..].iter().find(|b| same(a, b))?;
        Some([a.name.as_str(), other.name.as_str()])
    };
    rides.iter().enumerate().find_map(pair)
}

/// The ride made ready, with what it says alone, or why it is left aside.
fn prepare(
    ridden: &Ridden,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Result<Ready, LeftAside>, EngineError> {
    let aside = |why: String| {
        let name = ridden.name.clone();
        Ok(Err(LeftAside { name, why }))
    };
    match made_ready(ridden, settings, progress) {
        Ok(ready) if ready.alone.verdict == Verdict::CannotTell => aside(ready.alone.sentence),
        Ok(ready) => Ok(Ok(ready)),
        Err(EngineError::Cancelled) => Err(EngineError::Cancelled),
        Err(error) => aside(error.to_string()),
    }
}

fn made_ready(
    Ridden { name, ride, bike }: &Ridden,
    settings: &Settings,
    progress: &dyn Progress,
) -> Result<Ready, EngineError> {
    let observed = observe(ride, bike, settings)?;
    let conclusion = conclude(ride, bike, settings, &observed, Vec::new())?;
    let alone = diagnose(ride, bike, settings, &conclusion, progress)?;
    let base = Base::SpringAndDamper;
    let prepared = Prepared::new(ride, bike, settings, &conclusion, base)?;
    let found = &conclusion.output_error;
    Ok(Ready {
        interpolation: interpolation_error_of_many(ride, bike, settings, found),
        output_error: found.clone(),
        mass: conclusion.mass_error.clone(),
        laser: conclusion.laser_error.clone(),
        road_noise: conclusion.road_noise_error.clone(),
        name: name.clone(),
        dataset: prepared.dataset,
        plain: prepared.plain,
        split: prepared.split,
        warnings: prepared.warnings,
        alone,
    })
}

#[cfg(test)]
mod tests;
