//! What people get wrong before a record comes here: a sign, a unit, an axle, a mass. Asked of every ride before anything is
//! made of its numbers. Each is reported only where the record shows the right reading beside the wrong one; a ride that is odd
//! for another reason is left to the diagnosis.

mod balance;
mod clock;
mod course;
pub mod delay;
mod frequency;
mod gain;
pub mod mass;
mod sensors;

pub use gain::{agrees, contradicts};
pub use sensors::lasers_are_turned;

use veloid_core::bicycle::{Bike, PerAxle};
use veloid_core::settings::Settings;
use veloid_methods::output_error::AxleFit;
use veloid_report::Mistake;
use veloid_ride::Ride;

/// All that is found on a ride, whose axles were `fitted` so as they are declared.
pub fn mistakes(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    fitted: &PerAxle<AxleFit>,
) -> Vec<Mistake> {
    let mut found: Vec<Mistake> = times(ride, bike).into_iter().collect();
    let gains = gain::mistakes(ride);
    // A wrong sign or unit moves an axle's frequency too.
    if found.is_empty() && gains.is_empty() {
        found.extend(frequency::mistakes(ride, bike, fitted));
    }
    found.extend(balance::mistake(bike));
    found.extend(mass::mistakes(ride, bike, settings, fitted));
    found.extend(gains);
    found.extend(delay::mistake(ride, fitted));
    found.extend(course::mistake(ride, bike));
    found.extend(sensors::mistake(ride, bike));
    found
}

/// What is found in the sensors and times of a ride by itself, first of all.
pub fn misread(ride: &Ride, bike: &Bike) -> Option<Mistake> {
    times(ride, bike).or_else(|| sensors::mistake(ride, bike))
}

/// What is wrong with the times: what speed and wheelbase say comes first.
fn times(ride: &Ride, bike: &Bike) -> Option<Mistake> {
    course::time_scale(ride, bike).or_else(|| clock::mistake(ride))
}
