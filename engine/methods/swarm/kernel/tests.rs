#![allow(clippy::unwrap_used)]
use super::*;
use crate::simulate::simulated_ride::{Excitation, SimulatedRide};
use crate::swarm::straight;
use veloid_core::bicycle::Axle;
use veloid_core::settings::Settings;
use veloid_ride::Ride;

const OBJECTIVES: [Objective; 3] = [Objective::Consistent, Objective::Paper, Objective::Gradient];

fn target(ride: &Ride, objective: Objective) -> Target {
    let settings = Settings {
        objective,
        ..Settings::default()
    };
    let record = ride.axles.front.as_ref().unwrap();
    Target::new(
        Axle::Front,
        record,
        ride,
        &settings,
        [4782.0, 50.0, 1.0 / 23.0],
    )
    .unwrap()
}

fn thetas() -> Vec<[f64; 3]> {
    (0..37)
        .map(|i| {
            let i = i as f64;
            [300.0 * (0.13 * i).exp(), 2.0 + 5.0 * i, 0.03 + 0.001 * i]
        })
        .collect()
}

/// Every width against the plain form.
fn check(ride: &Ride, tolerance: f64) {
    for objective in OBJECTIVES {
        let target = target(ride, objective);
        for width in Width::available() {
            let kernel = Kernel::new(&target, width);
            let thetas = thetas();
            let mut costs = vec![0.0; thetas.len()];
            kernel.add_costs(&thetas, &mut costs);
            for (theta, cost) in thetas.iter().zip(costs) {
                let want = straight::cost(&target, *theta);
                assert!(
                    (cost / want - 1.0).abs() < tolerance,
                    "{objective:?} {width:?} {theta:?}: {cost} instead of {want}"
                );
            }
        }
    }
}

fn rough() -> SimulatedRide {
    SimulatedRide {
        duration_s: 8.0,
        noise_displacement_m: 5e-5,
        rear: None,
        ..SimulatedRide::default()
    }
}

#[test]
fn road_ride_as_in_the_plain_form() {
    check(&rough().ride(), 1e-12);
}

#[test]
fn samples_not_valid_as_in_the_plain_form() {
    let mut ride = rough().ride();
    let front = ride.axles.front.as_mut().unwrap();
    for i in [0, 1, 150, 151, 152, 300, 306, 310, 500, 799, 800] {
        front.valid[i] = false;
    }
    check(&ride, 1e-12);
}

#[test]
fn shaken_ride_as_in_the_plain_form() {
    let shaken = SimulatedRide {
        excitation: Excitation::Shaker {
            amplitude_n: 60.0,
            from_hz: 0.5,
            to_hz: 18.0,
        },
        ..rough()
    };
    let mut ride = shaken.ride();
    check(&ride, 1e-11);
    ride.axles.front.as_mut().unwrap().road = rough().ride().axles.front.unwrap().road;
    check(&ride, 1e-11);
}

#[test]
fn free_decay_as_in_the_plain_form() {
    let mut simulated_ride = rough();
    simulated_ride.excitation = Excitation::Release {
        displacement_m: 0.02,
    };
    check(&simulated_ride.ride(), 1e-11);
}

#[test]
fn costs_are_added_and_do_not_depend_on_the_company() {
    let target = target(&rough().ride(), Objective::Consistent);
    let kernel = Kernel::new(&target, Width::widest());
    let thetas = thetas();
    let mut together = vec![1.0; thetas.len()];
    kernel.add_costs(&thetas, &mut together);
    for (theta, cost) in thetas.iter().zip(together) {
        let mut alone = [1.0];
        kernel.add_costs(&[*theta], &mut alone);
        assert_eq!(alone[0], cost);
    }
}

/// Lagged products against the way through the record, at the parameters `about` and far from them.
fn check_lags(ride: &Ride, about: [f64; 3]) {
    let target = target(ride, Objective::Consistent);
    let [kappa, beta, per_mass] = about;
    let mut asked = thetas();
    asked.extend((-20..20).map(|i| {
        let by = (0.3 * f64::from(i)).exp();
        [kappa * by, beta * by.sqrt(), per_mass]
    }));
    asked.extend((-9..10).map(|i| {
        let by = 1.0 + 2e-4 * f64::from(i);
        [kappa * by, beta / by, per_mass * by]
    }));
    for width in Width::available() {
        let through = Kernel::new(&target, width);
        let kernel = through
            .clone()
            .with_lags([1.02 * kappa, 0.97 * beta, per_mass]);
        let Form::Differences(form, Some(lags)) = &kernel.form else {
            panic!("no lags");
        };
        let short = asked.iter().filter(|t| lags.memory(form, **t).is_some());
        assert!(short.count() > 60);
        let [mut by_lags, mut want] = [(); 2].map(|()| vec![0.0; asked.len()]);
        kernel.add_costs(&asked, &mut by_lags);
        through.add_costs(&asked, &mut want);
        let mut worst = 0.0_f64;
        for ((theta, cost), want) in asked.iter().zip(by_lags).zip(want) {
            worst = worst.max((cost / want - 1.0).abs());
            assert!(
                (cost - want).abs() < 1e-10 * want + 1e-16,
                "{width:?} {theta:?}: {cost} instead of {want}"
            );
        }
        println!("{width:?}: {worst:.1e}");
    }
}

const FRONT: [f64; 3] = [110e3 / 23.0, 50.0, 1.0 / 23.0];

fn long() -> SimulatedRide {
    SimulatedRide {
        duration_s: 250.0,
        ..rough()
    }
}

#[test]
fn lagged_products_as_the_way_through() {
    check_lags(&long().ride(), FRONT);
}

#[test]
fn lagged_products_without_noise() {
    let quiet = SimulatedRide {
        noise_displacement_m: 0.0,
        ..long()
    };
    check_lags(&quiet.ride(), FRONT);
}

#[test]
fn lagged_products_around_gaps() {
    let mut ride = SimulatedRide {
        duration_s: 460.0,
        ..rough()
    }
    .ride();
    let front = ride.axles.front.as_mut().unwrap();
    for i in [0, 1, 150, 151, 400, 21_000, 21_300, 21_301, 45_990] {
        front.valid[i] = false;
    }
    check_lags(&ride, FRONT);
}

#[test]
fn lagged_products_of_a_shaken_ride() {
    let shaken = SimulatedRide {
        excitation: Excitation::Shaker {
            amplitude_n: 60.0,
            from_hz: 0.5,
            to_hz: 18.0,
        },
        ..long()
    };
    check_lags(&shaken.ride(), FRONT);
}
