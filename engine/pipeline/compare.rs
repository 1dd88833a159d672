//! A model on another ride, and what is wrong with the ride.

use veloid_core::bicycle::Bike;
use veloid_core::settings::Settings;
use veloid_diagnosis::validation::{self, Incomparable};
use veloid_methods::output_error;
use veloid_methods::output_error::start::starts_from;
use veloid_mistakes::{misread, mistakes};
use veloid_report::{IdentifiedModel, Mistake, ModelOnRide};
use veloid_ride::Ride;

/// Compares a model with a ride, `bike` being the bicycle as it was ridden there. Numbers differ where chance would do so less often than
/// `alpha`. Mistakes of the recording, as in a diagnosis, stand before the answer.
///
/// # Errors
/// The ride and the model have no axle in common that could be simulated, or the model is not one of this version.
pub fn compare(
    model: &IdentifiedModel,
    ride: &Ride,
    bike: &Bike,
    alpha: f64,
) -> Result<ModelOnRide, Incomparable> {
    let mistakes = wrong(model, ride, bike, alpha);
    let mut found = match validation::compare(model, ride, bike, alpha) {
        Err(Incomparable::NothingLeft(reasons)) if !mistakes.is_empty() => {
            let said = mistakes.into_iter().map(|mistake| mistake.sentence);
            return Err(Incomparable::NothingLeft(said.chain(reasons).collect()));
        }
        found => found?,
    };
    let to_mend = mistakes.iter().filter(|mistake| mistake.takes_the_verdict);
    let mut first: Vec<String> = to_mend.map(|mistake| mistake.sentence.clone()).collect();
    if !model.ride_sha256.is_empty() && model.ride_sha256 == ride.summary.sha256 {
        let own = "The model was identified from this very ride, so that it says nothing of how well it predicts another one.";
        first.push(own.to_owned());
    }
    first.push(found.sentence);
    found.sentence = first.join(" ");
    found.warnings = mistakes.into_iter().map(|m| m.sentence).collect();
    found.warnings.extend(ride.summary.warnings.iter().cloned());
    Ok(found)
}

/// Mistakes of the recording; of sensors and times alone where the plain model cannot be fitted.
fn wrong(model: &IdentifiedModel, ride: &Ride, bike: &Bike, alpha: f64) -> Vec<Mistake> {
    let settings = Settings {
        alpha,
        ..Settings::default()
    };
    let starts = [starts_from(&model.plain)];
    match output_error::fit(ride, bike, &settings, &starts) {
        Ok(fits) => mistakes(ride, bike, &settings, &fits),
        Err(_) => misread(ride, bike).into_iter().collect(),
    }
}
