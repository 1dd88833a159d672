//! The plain model beside the record, where no diagnosis compared the two.

use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_core::settings::Settings;
use veloid_inside::{Models, Record, validation, without_validation};
use veloid_methods::output_error::start::starts_from;
use veloid_methods::output_error::{self, Split};
use veloid_methods::simulate::linear::Input;
use veloid_report::Estimate;
use veloid_report::validation::Validation;
use veloid_ride::Ride;

/// Why nothing is compared.
const NO_ROAD: &str = "the road was not measured: there is no input to simulate this axle from, to respond to or to deflect against";

/// What the diagnosis `found`, or the plain model where it found none, and why an axle has neither.
pub fn validations(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    output_error: &PerAxle<Estimate>,
    found: PerAxle<Validation>,
) -> PerAxle<Validation> {
    let mut all = match found.is_empty() {
        true => plain(ride, bike, settings, output_error),
        false => found,
    };
    for axle in Axle::BOTH {
        let is_sensed = ride.sensors.iter().any(|sensor| sensor.axle == axle);
        if is_sensed && all.get(axle).is_none() {
            all.set(axle, without_validation(NO_ROAD));
        }
    }
    all
}

/// The fit of output error once more from where it ended, with its covariance and residual.
fn plain(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    output_error: &PerAxle<Estimate>,
) -> PerAxle<Validation> {
    let fits = match output_error::refit(ride, bike, settings, starts_from(output_error)) {
        Ok(fits) => fits,
        Err(error) => {
            let why = error.to_string();
            return ride.axles.map(|_, _| without_validation(&why));
        }
    };
    let split = Split::of(ride, settings);
    ride.axles.filter_map(|axle, record| {
        let models = Models {
            plain: fits.get(axle)?,
            extended: None,
        };
        let record = Record {
            measured: record.output(),
            valid: &record.valid,
            input: &Input::of(record, ride.step_s),
            has_road: record.has_road(),
            train: split.train.clone(),
        };
        Some(validation(&record, &models))
    })
}
