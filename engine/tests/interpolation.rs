use veloid_core::bicycle::Bike;
use veloid_core::settings::Settings;
use veloid_engine::{conclude, observe};
use veloid_methods::simulate::simulated_ride::{SimulatedRide, Spring};
use veloid_methods::uncertainty::interpolation::SLOW;
use veloid_report::stages::Conclusion;

fn concluded(rate_hz: f64, spring: Spring) -> Conclusion {
    let simulated = SimulatedRide {
        rate_hz,
        duration_s: 60.0,
        front: Some(spring),
        rear: None,
        noise_displacement_m: 5e-5,
        ..SimulatedRide::default()
    };
    let bike = Bike {
        mass_front_kg: Some(spring.mass_kg),
        ..Bike::default()
    };
    let settings = Settings::default();
    let ride = simulated.ride();
    let observed = observe(&ride, &bike, &settings).unwrap();
    conclude(&ride, &bike, &settings, &observed, Vec::new()).unwrap()
}

/// At 20 Hz an axle of 8 Hz is off by more than the fit knows of, and the interval bears it; at 100 Hz nothing is off.
#[test]
fn intervals_bear_what_slow_samples_hide() {
    let spring = Spring {
        mass_kg: 23.0,
        k_n_m: 60e3,
        b_n_s_m: 600.0,
    };
    let slow = concluded(20.0, spring);
    let e = slow.output_error.front.unwrap();
    let by = slow.interpolation_error.front.unwrap();
    assert!(by.b_n_s_m.abs() > 0.01 * spring.b_n_s_m, "{by:?}");
    assert!(
        (e.b_n_s_m - spring.b_n_s_m).abs() < 3.0 * e.b_std_n_s_m.unwrap(),
        "{e:?}"
    );
    assert!(
        (e.k_n_m - spring.k_n_m).abs() < 3.0 * e.k_std_n_m.unwrap(),
        "{e:?}"
    );
    assert!(concluded(100.0, spring).interpolation_error.front.is_none());
}

/// The axle's motion per sample decides whether there is anything to refit.
#[test]
fn an_axle_is_fast_from_its_motion_per_sample_on() {
    let at = |share: f64| {
        let k_n_m = 23.0 * (share * SLOW * 50.0_f64).powi(2);
        let spring = Spring {
            mass_kg: 23.0,
            k_n_m,
            b_n_s_m: 400.0,
        };
        concluded(50.0, spring).interpolation_error.front.is_some()
    };
    assert!(!at(0.9) && at(1.1));
}
