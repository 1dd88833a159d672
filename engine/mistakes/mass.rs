//! A mass that a force contradicts. Where a shaker pushes an axle, m z'' + B z' + k z = F shows the mass; a displacement that reads g times
//! too large makes m, B and k g times smaller, and half of a mass that hangs loosely leaves the other half. No ride of a shaker tells these
//! apart, and they have other k and B.

use crate::bicycle::{Axle, Bike, PerAxle};
use crate::document::format_number::significant;
use crate::mistakes::balance::confirms_mass;
use crate::numerics::spectrum::measured_noise;
use crate::output_error::{self, AxleFit, start::Start};
use crate::report::{Mistake, MistakeKind};
use crate::ride::{AxleRecord, Ride};
use crate::settings::Settings;

/// How far (ratio) the force's mass must be from that of the bike file: scales agree better.
const APART: f64 = 1.2;
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::output_error::start::starts_from;
    use crate::pipeline::observe;
    use crate::simulate::simulated_ride::{Excitation, SimulatedRide};

    fn found(share: f64, load: Option<f64>, noise: f64) -> Vec<Mistake> {
        let simulated = SimulatedRide {
            excitation: Excitation::Shaker {
                amplitude_n: 200.0,
                from_hz: 1.0,
                to_hz: 20.0,
            },
            noise_displacement_m: noise,
            ..SimulatedRide::default()
        };
        let spring = simulated.front.unwrap();
        let bike = Bike {
            mass_front_kg: Some(share * spring.mass_kg),
            mass_rear_kg: simulated.rear.map(|s| s.mass_kg),
            static_load_front_n: load,
            ..Bike::default()
        };
        let (ride, settings) = (simulated.ride(), Settings::default());
        let starts = [starts_from(
            &observe(&ride, &bike, &settings).unwrap().instrumental,
        )];
        let fits = output_error::fit(&ride, &bike, &settings, &starts).unwrap();
        mistakes(&ride, &bike, &settings, &fits)
    }

    #[test]
    fn val_the_force_shows_a_mass_that_is_twice_what_it_is() {
        assert_eq!(found(1.0, None, 5e-5), []);
        let twice = found(2.0, None, 5e-5);
        assert_eq!(twice.len(), 1);
        assert!(
            twice[0].sentence.contains("a mass of 23.0 kg"),
            "{}",
            twice[0].sentence
        );
        // The static load says that the mass is right: then it is the sensor, or something loose.
        assert_eq!(found(2.0, Some(2.0 * 23.0 * 9.81), 5e-5), []);
    }

    #[test]
    fn a_mass_is_doubted_from_the_ratio_on_that_scales_do_not_have() {
        assert_eq!(found(0.98 * APART, None, 5e-5), []);
        assert_eq!(found(1.02 * APART, None, 5e-5).len(), 1);
    }
}
