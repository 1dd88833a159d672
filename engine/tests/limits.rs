//! Stiffness and damping that the user fixes or bounds.

use std::collections::BTreeMap;

use veloid_core::bicycle::Bike;
use veloid_core::settings::Settings;
use veloid_core::{EngineError, Silent};
use veloid_engine::identify;
use veloid_methods::simulate::simulated_ride::{SimulatedRide, Spring};
use veloid_report::Report;
use veloid_report::diagnosis::Verdict;
use veloid_ride::{ReadOptions, read};

/// Twenty seconds on rough roads with 50 um of noise.
fn simulated(seed: u64) -> SimulatedRide {
    let spring = |mass_kg| {
        Some(Spring {
            mass_kg,
            k_n_m: 60e3,
            b_n_s_m: 500.0,
        })
    };
    SimulatedRide {
        duration_s: 20.0,
        front: spring(30.0),
        rear: spring(50.0),
        noise_displacement_m: 5e-5,
        seed,
        ..SimulatedRide::default()
    }
}

fn bike() -> Bike {
    Bike {
        mass_front_kg: Some(30.0),
        mass_rear_kg: Some(50.0),
        ..Bike::default()
    }
}

fn settings(fix: &[(&str, f64)], bound: &[(&str, [f64; 2])]) -> Settings {
    let named = |key: &&str| (*key).to_owned();
    Settings {
        trials: 1,
        iterations: 2,
        diagnosis: false,
        fix: fix.iter().map(|(key, x)| (named(key), *x)).collect(),
        bound: bound.iter().map(|(key, x)| (named(key), *x)).collect(),
        ..Settings::default()
    }
}

fn found(seed: u64, settings: &Settings) -> Report {
    identify(&simulated(seed).ride(), &bike(), settings, &Silent).unwrap()
}

#[test]
fn k_fixed_at_its_estimate_leaves_b_as_it_is_and_no_less_certain() {
    for seed in 1..=6 {
        let free = found(seed, &settings(&[], &[]));
        let k = free
            .result
            .rear
            .as_ref()
            .unwrap()
            .get("k")
            .unwrap()
            .value
            .unwrap();
        let held = found(seed, &settings(&[("r.k", k)], &[]));
        let b = |report: &Report| {
            let b = report.result.rear.as_ref().unwrap().get("B").unwrap();
            (b.value.unwrap(), b.std_error.unwrap())
        };
        let ((before, error), (after, less)) = (b(&free), b(&held));
        assert!((after / before - 1.0).abs() < 1e-6, "{before} {after}");
        assert!(less < (1.0 + 1e-6) * error, "{error} {less}");
        assert_eq!(held.result.front, free.result.front);
        let fixed = held.result.rear.as_ref().unwrap().get("k").unwrap().clone();
        assert!((fixed.value.unwrap() / k - 1.0).abs() < 1e-12);
        assert_eq!((fixed.std_error, fixed.interval), (None, None));
        assert!(fixed.why.unwrap().starts_with("fixed at "));
        let notes = held.comparison.notes.join(" ");
        assert!(notes.contains("the swarm are estimated freely"), "{notes}");
    }
}

#[test]
fn a_bound_holds_what_leaves_it_and_nothing_else() {
    let free = found(1, &settings(&[], &[]));
    let wide = settings(&[], &[("f.k", [1e4, 1e6]), ("f.B", [0.0, 5000.0])]);
    assert_eq!(found(1, &wide).result, free.result);
    let bounded = found(1, &settings(&[], &[("front.B", [0.0, 300.0])]));
    let front = bounded.result.front.unwrap();
    let b = front.get("B").unwrap();
    assert_eq!((b.value, b.interval), (Some(300.0), None));
    let why = b.why.as_deref().unwrap();
    assert_eq!(why, "at its bound of 300 N s/m, which the user has set");
    assert!(front.get("k").unwrap().interval.is_some());
    assert_eq!(bounded.result.rear, free.result.rear);
}

#[test]
fn the_search_for_missing_physics_holds_what_is_fixed() {
    let friction = veloid_diagnosis::impose::Imposed {
        id: "coulomb_friction".to_owned(),
        axle: veloid_report::diagnosis::Place::Front,
        parameters: BTreeMap::from([("friction".to_owned(), 20.0)]),
    };
    let ride = veloid_diagnosis::impose::ride(&simulated(1), &bike(), &[friction]).unwrap();
    let settings = Settings {
        diagnosis: true,
        ..settings(&[("f.k", 60e3)], &[])
    };
    let report = identify(&ride, &bike(), &settings, &Silent).unwrap();
    let diagnosis = report.diagnosis.unwrap();
    assert_eq!(diagnosis.verdict, Verdict::Named, "{}", diagnosis.sentence);
    let extended = diagnosis.extended.front.unwrap();
    assert!((extended.k_n_m / 60e3 - 1.0).abs() < 1e-12, "{extended:?}");
    assert_eq!(extended.k_std_n_m, None);
    assert!(extended.b_std_n_s_m.is_some(), "{extended:?}");
    let k = report.result.front.unwrap().get("k").unwrap().clone();
    let why = "fixed at 60000 N/m by the user";
    assert_eq!(k.why.as_deref(), Some(why));
}

#[test]
fn a_wrong_value_is_not_taken_for_missing_physics() {
    for fix in [("f.k", 40e3), ("r.B", 900.0)] {
        let settings = Settings {
            diagnosis: true,
            ..settings(&[fix], &[])
        };
        let diagnosis = found(1, &settings).diagnosis.unwrap();
        assert_eq!(diagnosis.verdict, Verdict::CannotTell, "{fix:?}");
        assert!(diagnosis.effects.is_empty());
        let said = diagnosis.sentence.replace('\u{a0}', " ");
        assert!(
            said.contains("is held at") && said.contains("but free it is"),
            "{said}"
        );
    }
}

#[test]
fn what_cannot_be_fixed_is_refused() {
    let refused = |bike: &Bike, ride: &veloid_ride::Ride, key: &str| {
        let refused = identify(ride, bike, &settings(&[(key, 1e4)], &[]), &Silent);
        let error: EngineError = refused.unwrap_err();
        assert!(error.is_input());
        error.to_string()
    };
    let mut table = "t,v,a_f,a_r\n".to_owned();
    for i in 0..6000 {
        let t = f64::from(i) / 200.0;
        table += &format!("{t},5,{},{}\n", (30.0 * t).sin(), (30.0 * t - 6.0).sin());
    }
    let options = ReadOptions::default();
    let accelerometers = read(table.as_bytes(), "ride.csv", &bike(), &options).unwrap();
    let said = refused(&bike(), &accelerometers, "f.k");
    assert!(
        said.contains("f.k: the ride has no road or force for the front axle"),
        "{said}"
    );
    let said = refused(&bike(), &simulated(1).ride(), "x.k");
    assert_eq!(
        said,
        "setting fix or bound: x.k: unknown axle 'x', expected f, front, r or rear"
    );
    let without_rear = SimulatedRide {
        rear: None,
        ..simulated(1)
    };
    let said = refused(&bike(), &without_rear.ride(), "r.k");
    assert!(
        said.contains("r.k: the ride has no road or force for the rear axle"),
        "{said}"
    );
}
