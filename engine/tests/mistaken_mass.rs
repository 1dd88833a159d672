use veloid_core::bicycle::Bike;
use veloid_core::settings::Settings;
use veloid_engine::observe;
use veloid_methods::output_error;
use veloid_methods::output_error::start::starts_from;
use veloid_methods::simulate::simulated_ride::{Excitation, SimulatedRide};
use veloid_mistakes::mass::APART;
use veloid_mistakes::mass::*;
use veloid_report::Mistake;

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
