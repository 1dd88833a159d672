//! A mass that a force contradicts. Where a shaker pushes an axle, m z'' + B z' + k z = F shows the mass; a displacement that reads g times
//! too large makes m, B and k g times smaller, and half of a mass that hangs loosely leaves the other half. No ride of a shaker tells these
//! apart, and they have other k and B.

use crate::balance::confirms_mass;
use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_core::document::format_number::significant;
use veloid_core::numerics::spectrum::measured_noise;
use veloid_core::settings::Settings;
use veloid_methods::output_error::{self, AxleFit, start::Start};
use veloid_report::{Mistake, MistakeKind};
use veloid_ride::{AxleRecord, Ride};

/// How far (ratio) the force's mass must be from that of the bike file: scales agree better.
pub const APART: f64 = 1.2;
/// Largest part of the error (RMS, held-out part) that is left with that mass, and how many times the sensor's noise it may be: all of it is
/// explained, as a lighter mass rarely does for something else.
const LEFT: f64 = 0.5;
const NOISE: f64 = 1.5;

/// Masses of axles that only a force moves, and nothing else confirms.
pub fn mistakes(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    fitted: &PerAxle<AxleFit>,
) -> Vec<Mistake> {
    let of_axle = |(axle, record): (Axle, &AxleRecord)| {
        let only_a_force = record.force.is_some() && !record.has_road() && !record.prescribed;
        let mass = bike.mass(axle).filter(|_| only_a_force)?;
        if confirms_mass(bike, axle) {
            return None;
        }
        let declared = fitted.get(axle)?;
        let free = with_any_mass(ride, bike, settings, axle, declared)?;
        let shown = 1.0 / free.plain.per_mass;
        let noise = measured_noise(&record.displacement, ride.step_s)?;
        let explains = free.held_rms < LEFT * declared.held_rms && free.held_rms < NOISE * noise;
        let is_other = !(APART.recip()..APART).contains(&(shown / mass));
        (explains && is_other && shown > 0.0).then(|| mistake(axle, mass, shown))
    };
    ride.axles.iter().filter_map(of_axle).collect()
}

fn with_any_mass(
    ride: &Ride,
    bike: &Bike,
    settings: &Settings,
    axle: Axle,
    declared: &AxleFit,
) -> Option<AxleFit> {
    let mut one = ride.clone();
    one.axles = PerAxle::default();
    one.axles.set(axle, ride.axles.get(axle)?.clone());
    let mut unweighed = bike.clone();
    match axle {
        Axle::Front => unweighed.mass_front_kg = None,
        Axle::Rear => unweighed.mass_rear_kg = None,
    }
    let mut start = PerAxle::default();
    let declared = &declared.plain;
    start.set(
        axle,
        Start {
            kappa: declared.kappa,
            beta: declared.beta,
            per_mass: declared.per_mass,
        },
    );
    let fits = output_error::fit(&one, &unweighed, settings, &[start]).ok()?;
    fits.get(axle).cloned()
}

fn mistake(axle: Axle, mass: f64, shown: f64) -> Mistake {
    let [declared, true_mass] = [mass, shown].map(|kg| significant(kg, 3));
    let gain = significant(mass / shown, 3);
    Mistake {
        kind: MistakeKind::Bicycle,
        sentence: format!(
            "The force moves the {axle} axle as a mass of {true_mass} kg would, not as the {declared} kg of the bike file. A displacement \
             that reads {gain} times what it should, or a part of the mass that does not follow, would fit as well, with other k and B. \
             Weigh the axle (mass_{axle}_kg and static_load_{axle}_n), or calibrate the sensor."
        ),
        takes_the_verdict: true,
    }
}
