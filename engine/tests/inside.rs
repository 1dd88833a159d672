use veloid_core::bicycle::{Bike, PerAxle};
use veloid_core::settings::Settings;
use veloid_inside::{Models, Record, validation};
use veloid_methods::output_error::start::starts_from;
use veloid_methods::output_error::{Split, refit};
use veloid_methods::simulate::linear::Input;
use veloid_methods::simulate::simulated_ride::{SimulatedRide, Spring};
use veloid_report::Estimate;

/// Also of the input: what the fit takes off with k and B is no longer there to be tested. `tests/rigs/residuals.py` asks more rides.
#[test]
fn residuals_of_plain_rides_leave_the_bounds_at_one_lag_of_a_hundred() {
    let settings = Settings::default();
    let (mut outside, mut lags) = ([0, 0], [0, 0]);
    for seed in 1..=24 {
        let simulated = SimulatedRide {
            duration_s: 30.0,
            noise_displacement_m: 5e-5,
            seed,
            ..SimulatedRide::default()
        };
        let ride = simulated.ride();
        let masses = [simulated.front, simulated.rear].map(|s| s.map(|s| s.mass_kg));
        let bike = Bike {
            mass_front_kg: masses[0],
            mass_rear_kg: masses[1],
            ..Bike::default()
        };
        let truth = |spring: Option<Spring>| {
            spring.map(|s| Estimate {
                k_n_m: s.k_n_m,
                b_n_s_m: s.b_n_s_m,
                mass_kg: s.mass_kg,
                ..Estimate::default()
            })
        };
        let start = PerAxle {
            front: truth(simulated.front),
            rear: truth(simulated.rear),
        };
        let fits = refit(&ride, &bike, &settings, starts_from(&start)).unwrap();
        for (axle, record) in ride.axles.iter() {
            let models = Models {
                plain: fits.get(axle).unwrap(),
                extended: None,
            };
            let record = Record {
                measured: record.output(),
                valid: &record.valid,
                input: &Input::of(record, ride.step_s),
                has_road: record.has_road(),
                train: Split::of(&ride, &settings).train,
            };
            let tests = validation(&record, &models).residual.unwrap();
            let cross = tests.cross_correlation.unwrap();
            for (i, test) in [tests.autocorrelation, cross].into_iter().enumerate() {
                outside[i] += test.outside;
                lags[i] += test.lags;
            }
        }
    }
    for i in 0..2 {
        let share = outside[i] as f64 / lags[i] as f64;
        assert!((0.002..0.025).contains(&share), "{outside:?} of {lags:?}");
    }
}
