//! Studies of simulated rides, and what they must not say.
#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use crate::pipeline::study::*;
use veloid_core::Silent;
use veloid_diagnosis::impose;
use veloid_methods::simulate::simulated_ride::{SimulatedRide, Spring};
use veloid_report::diagnosis::{Place, Verdict};

const K: f64 = 110e3;
const FRONT: Spring = Spring {
    mass_kg: 23.0,
    k_n_m: K,
    b_n_s_m: 1150.0,
};

fn simulated_ride(seed: u64, front: Spring) -> SimulatedRide {
    SimulatedRide {
        duration_s: 30.0,
        seed,
        front: Some(front),
        noise_displacement_m: 20e-6,
        ..SimulatedRide::default()
    }
}

fn bike(mass: f64) -> Bike {
    Bike {
        mass_front_kg: Some(mass),
        mass_rear_kg: Some(63.0),
        ..Bike::default()
    }
}

/// A ride on whose front axle one more effect acts.
fn acted_on(simulated_ride: &SimulatedRide, id: &str, parameter: &str, value: f64) -> Ride {
    let effect = impose::Imposed {
        id: id.to_owned(),
        axle: Place::Front,
        parameters: BTreeMap::from([(parameter.to_owned(), value)]),
    };
    impose::ride(simulated_ride, &bike(23.0), &[effect]).unwrap()
}

/// A ride whose front spring stiffens by `k3` (N/m^3).
fn stiffening(seed: u64, k3: f64) -> Ride {
    acted_on(&simulated_ride(seed, FRONT), "cubic_stiffness", "k3", k3)
}

/// A minute's ride with friction (N), too weak to be distinguished from hysteresis.
fn rubbing(seed: u64, friction: f64) -> Ride {
    let minute = SimulatedRide {
        duration_s: 60.0,
        ..simulated_ride(seed, FRONT)
    };
    acted_on(&minute, "coulomb_friction", "friction", friction)
}

fn studied(rides: &[(Ride, Bike)]) -> Result<StudyReport, EngineError> {
    let ridden: Vec<Ridden> = (rides.iter().enumerate())
        .map(|(i, (ride, bike))| Ridden {
            name: format!("ride {i}"),
            ride,
            bike,
        })
        .collect();
    study(&ridden, &Settings::default(), &Silent)
}

#[test]
fn val_a_spring_too_weak_for_one_ride_is_found_in_eight_and_measured() {
    let k3 = 3e8;
    let rides: Vec<_> = (20..28)
        .map(|seed| (stiffening(seed, k3), bike(23.0)))
        .collect();
    let (ride, bike) = &rides[0];
    let settings = Settings {
        trials: 1,
        iterations: 2,
        ..Settings::default()
    };
    let alone = crate::pipeline::identify(ride, bike, &settings, &Silent).unwrap();
    assert_eq!(alone.diagnosis.unwrap().verdict, Verdict::NothingMissing);
    let report = studied(&rides).unwrap();
    assert_eq!(report.verdict, Verdict::Named, "{}", report.sentence);
    let [found] = &report.effects[..] else {
        panic!("{}", report.sentence);
    };
    assert_eq!(found.effect.id, "cubic_stiffness");
    assert!(found.effect.affirmed && found.only_in.is_none());
    assert_eq!((found.by_ride.len(), found.gain_by_ride.len()), (8, 8));
    let reported = &found.effect.parameters["k3"];
    let off = reported.value - k3;
    assert!(
        off.abs() < 3.0 * reported.std_error.unwrap(),
        "{reported:?}"
    );
    let axle = report.axles.front.as_ref().unwrap();
    assert!(axle.held_out_m < axle.plain_held_out_m);
}

#[test]
fn val_clean_rides_lack_nothing_and_show_k_more_closely_than_each() {
    let rides: Vec<_> = (0..6)
        .map(|seed| (simulated_ride(seed, FRONT).ride(), bike(23.0)))
        .collect();
    let report = studied(&rides).unwrap();
    assert_eq!(
        report.verdict,
        Verdict::NothingMissing,
        "{}",
        report.sentence
    );
    assert!(report.effects.is_empty());
    let whole = report
        .axles
        .front
        .as_ref()
        .unwrap()
        .estimate
        .as_ref()
        .unwrap();
    let std = whole.k_std_n_m.unwrap();
    assert!((whole.k_n_m - K).abs() < 3.5 * std, "{whole:?}");
    let each = report
        .rides
        .iter()
        .filter_map(|r| r.axles.front.as_ref()?.k_std_n_m);
    let mean = each.sum::<f64>() / 6.0;
    assert!(
        (std * 6_f64.sqrt() / mean - 1.0).abs() < 0.15,
        "{std} {mean}"
    );
}

#[test]
fn val_a_heavier_rider_changes_the_mass_and_not_the_spring() {
    let rides: Vec<_> = [20.0, 23.0, 30.0]
        .into_iter()
        .enumerate()
        .map(|(seed, mass_kg)| {
            let front = Spring { mass_kg, ..FRONT };
            (simulated_ride(seed as u64, front).ride(), bike(mass_kg))
        })
        .collect();
    let report = studied(&rides).unwrap();
    let front = report.axles.front.as_ref().unwrap();
    let whole = front.estimate.as_ref().unwrap();
    assert!((whole.k_n_m / K - 1.0).abs() < 2e-3, "{whole:?}");
    assert!(front.differs_p_value.unwrap() > 0.01);
}

#[test]
fn a_spring_that_differs_from_ride_to_ride_is_not_reported_as_one() {
    let rides: Vec<_> = [0.97, 1.0, 1.04]
        .into_iter()
        .enumerate()
        .map(|(seed, by)| {
            let front = Spring {
                k_n_m: by * K,
                ..FRONT
            };
            (simulated_ride(seed as u64, front).ride(), bike(23.0))
        })
        .collect();
    let report = studied(&rides).unwrap();
    let front = report.axles.front.as_ref().unwrap();
    assert!(front.estimate.is_none() && front.differs_p_value.unwrap() < 1e-6);
    assert!(report.axles.rear.as_ref().unwrap().estimate.is_some());
    for (ride, by) in report.rides.iter().zip([0.97, 1.0, 1.04]) {
        let k = ride.axles.front.as_ref().unwrap().k_n_m;
        assert!((k / (by * K) - 1.0).abs() < 5e-3, "{k}");
    }
    assert!(report.summary().contains("differ from ride to ride"));
}

#[test]
fn what_one_ride_alone_shows_is_its_own_affair() {
    let mut rides: Vec<_> = (0..5)
        .map(|seed| (simulated_ride(seed, FRONT).ride(), bike(23.0)))
        .collect();
    rides.push((stiffening(5, 8e9), bike(23.0)));
    let report = studied(&rides).unwrap();
    assert!(
        report.effects.iter().all(|e| !e.effect.affirmed),
        "{}",
        report.sentence
    );
    let only = report
        .effects
        .iter()
        .any(|e| e.only_in.as_deref() == Some("ride 5"));
    assert!(only || report.rides[5].shows_more, "{}", report.sentence);
    assert!(report.rides[..5].iter().all(|r| !r.shows_more));
}

#[test]
#[ignore = "slow"]
fn val_an_effect_acts_on_the_rides_that_show_it_and_leaves_the_others_as_they_are() {
    for acting in [&[2][..], &[0, 3]] {
        let rides: Vec<_> = (0..4)
            .map(|i| {
                let friction = if acting.contains(&i) { 20.0 } else { 0.0 };
                (rubbing(50 + i, friction), bike(23.0))
            })
            .collect();
        let report = studied(&rides).unwrap();
        let names: Vec<String> = acting.iter().map(|i| format!("ride {i}")).collect();
        let found = report.effects.iter().find(|e| e.acts_in == names);
        let found = found.unwrap_or_else(|| panic!("{acting:?}: {}", report.sentence));
        assert_eq!(
            found.effect.affirmed,
            acting.len() > 1,
            "{}",
            report.sentence
        );
        let axle = report.axles.front.as_ref().unwrap();
        let whole = axle.estimate.as_ref().unwrap();
        for (value, std, truth) in [
            (whole.k_n_m, whole.k_std_n_m, K),
            (whole.b_n_s_m, whole.b_std_n_s_m, FRONT.b_n_s_m),
        ] {
            assert!(
                (value - truth).abs() < 3.0 * std.unwrap(),
                "{acting:?}: {value} {std:?}"
            );
        }
        for (i, ride) in report.rides.iter().enumerate() {
            assert_eq!(ride.shows_more, acting == [i as u64], "{}", report.sentence);
        }
    }
}

#[test]
fn val_what_every_ride_shows_is_named_and_measured_more_closely() {
    let k3 = 4e9;
    let rides: Vec<_> = (0..4)
        .map(|seed| (stiffening(seed, k3), bike(23.0)))
        .collect();
    let report = studied(&rides).unwrap();
    assert_eq!(report.verdict, Verdict::Named, "{}", report.sentence);
    let found = &report.effects[0];
    assert_eq!(
        (report.effects.len(), found.effect.id.as_str()),
        (1, "cubic_stiffness")
    );
    assert!(
        report
            .rides
            .iter()
            .all(|r| r.alone == Verdict::Named && !r.shows_more)
    );
    let whole = &found.effect.parameters["k3"];
    assert!(
        (whole.value - k3).abs() < 3.0 * whole.std_error.unwrap(),
        "{whole:?}"
    );
    let each = found.by_ride.iter().filter_map(|p| p["k3"].std_error);
    assert!(
        each.clone().count() == 4 && each.into_iter().all(|std| std > whole.std_error.unwrap())
    );
}

#[test]
fn a_tie_in_every_ride_is_a_tie_of_all() {
    let rides = [21, 22].map(|seed| (rubbing(seed, 0.5), bike(23.0)));
    let report = studied(&rides).unwrap();
    assert_eq!(report.verdict, Verdict::Ambiguous, "{}", report.sentence);
    let shown: Vec<_> = report
        .rides
        .iter()
        .map(|r| (r.alone, r.shows_more))
        .collect();
    assert!(shown.iter().all(|(_, more)| !more), "{shown:?}");
}

#[test]
fn a_tie_in_one_ride_is_nothing_that_two_have_in_common() {
    let rides = [
        (rubbing(21, 1.0), bike(23.0)),
        (rubbing(22, 0.0), bike(23.0)),
    ];
    let report = studied(&rides).unwrap();
    assert_eq!(
        report.verdict,
        Verdict::NothingMissing,
        "{}",
        report.sentence
    );
    assert!(report.effects.iter().all(|e| e.only_in.is_some()));
}

#[test]
fn rides_that_cannot_take_part_are_left_aside_with_the_reason() {
    let mut roadless = simulated_ride(3, FRONT).ride();
    roadless.axles = veloid_core::bicycle::PerAxle::default();
    let good = |seed| (simulated_ride(seed, FRONT).ride(), bike(23.0));
    let report = studied(&[good(1), (roadless.clone(), bike(23.0)), good(2)]).unwrap();
    assert_eq!((report.rides.len(), report.left_aside.len()), (2, 1));
    assert_eq!(report.left_aside[0].name, "ride 1");
    let error = studied(&[good(1), (roadless, bike(23.0))]).unwrap_err();
    assert!(
        error.is_input() && error.to_string().contains("1 of 2 can be used"),
        "{error}"
    );
}

#[test]
fn a_ride_counts_once() {
    let good = |seed| (simulated_ride(seed, FRONT).ride(), bike(23.0));
    let error = studied(&[good(1), good(2), good(1)]).unwrap_err();
    assert!(
        error.is_input() && error.to_string().contains("ride 0 and ride 2"),
        "{error}"
    );
}
