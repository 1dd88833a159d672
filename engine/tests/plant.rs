//! A torsional pendulum, which no other file knows: that a base model needs a file of its own and a line in `registry.rs`.

use veloid_core::numerics::random::Normal;
use veloid_core::plant::PlantRef;
use veloid_core::plant::{Of, Plant, Quantity};
use veloid_engine::{Bike, Settings, Silent, identify};
use veloid_report::diagnosis::Verdict;
use veloid_report::{Method, Report, ResultQuantity};
use veloid_ride::{ReadOptions, read};

/// I theta'' = k (phi - theta) + c (phi' - theta') + M.
#[derive(Debug)]
pub struct Pendulum;

impl Plant for Pendulum {
    fn id(&self) -> &'static str {
        "torsional_pendulum"
    }

    fn quantities(&self) -> &'static [Quantity] {
        const fn quantity(name: &'static str, unit: &'static str, of: Of) -> Quantity {
            Quantity { name, unit, of }
        }
        const ALL: [Quantity; 3] = [
            quantity("torsional_stiffness", "N m/rad", Of::Stiffness),
            quantity("torsional_damping", "N m s/rad", Of::Damping),
            quantity("moment_of_inertia", "kg m^2", Of::Mass),
        ];
        &ALL
    }
}

/// Moment of inertia (kg m^2), stiffness (N m/rad) and damping (N m s/rad).
const INERTIA: f64 = 2.0;
const STIFFNESS: f64 = 300.0;
const DAMPING: f64 = 2.0;
const RATE: f64 = 100.0;
const FINE: usize = 200;

/// What is identified of a minute under a moment of four tones, with drag (N m s^2/rad^2) and 50 microradians of noise.
fn report(drag: f64) -> Report {
    let mut noise = Normal::new(5);
    let moment = |t: f64| -> f64 {
        let tone = |(amplitude, rate): (f64, f64)| amplitude * (rate * t).sin();
        [(9.0, 3.1), (6.0, 8.3), (4.0, 13.7), (5.0, 23.9)]
            .map(tone)
            .iter()
            .sum()
    };
    let h = 1.0 / (RATE * FINE as f64);
    let (mut angle, mut rate) = (0.0_f64, 0.0_f64);
    let rates = |t: f64, angle: f64, rate: f64| {
        let rest = STIFFNESS * angle + DAMPING * rate + drag * rate * rate.abs();
        (rate, (moment(t) - rest) / INERTIA)
    };
    let mut text = String::from("t,z_f,force_f\n");
    for i in 0..(60.0 * RATE) as usize {
        let t = i as f64 / RATE;
        let read = angle + 5e-5 * noise.draw();
        text += &format!("{t},{read:.8},{:.6}\n", moment(t));
        for sub in 0..FINE {
            let t = t + sub as f64 * h;
            let a = rates(t, angle, rate);
            let b = rates(t + 0.5 * h, angle + 0.5 * h * a.0, rate + 0.5 * h * a.1);
            angle += h * b.0;
            rate += h * b.1;
        }
    }
    let bike = Bike {
        mass_front_kg: Some(INERTIA),
        ..Bike::default()
    };
    let options = ReadOptions::default();
    let mut ride = read(text.as_bytes(), "pendulum.csv", &bike, &options).unwrap();
    ride.axles.front.as_mut().unwrap().plant = PlantRef(&Pendulum);
    let settings = Settings {
        trials: 1,
        iterations: 2,
        ..Settings::default()
    };
    identify(&ride, &bike, &settings, &Silent).unwrap()
}

fn quantity<'a>(report: &'a Report, name: &str) -> &'a ResultQuantity {
    let front = report.result.front.as_ref();
    front.and_then(|front| front.get(name)).unwrap()
}

fn assert_reported(report: &Report, name: &str, truth: f64, unit: &str) {
    let found = quantity(report, name);
    let std_error = found.std_error.unwrap();
    assert!(
        (found.value.unwrap() - truth).abs() < 4.0 * std_error,
        "{found:?}"
    );
    assert!(std_error < 0.02 * truth, "{found:?}");
    assert_eq!(found.unit, unit);
}

#[test]
fn a_pendulum_is_reported_under_its_own_names() {
    let report = report(0.0);
    assert_reported(&report, "torsional_stiffness", STIFFNESS, "N m/rad");
    assert_reported(&report, "torsional_damping", DAMPING, "N m s/rad");
    let stiffness = quantity(&report, "torsional_stiffness");
    assert_eq!(stiffness.method, Method::OutputError);
    let inertia = quantity(&report, "moment_of_inertia");
    assert_eq!((inertia.value, inertia.std_error), (Some(INERTIA), None));
    assert_eq!(report.result.front.as_ref().unwrap().iter().count(), 3);
    assert_eq!(report.diagnosis.unwrap().verdict, Verdict::NothingMissing);
}

#[test]
fn what_a_pendulum_lacks_is_named() {
    let drag = 3.0;
    let report = report(drag);
    assert_reported(&report, "torsional_stiffness", STIFFNESS, "N m/rad");
    let stiffness = quantity(&report, "torsional_stiffness");
    assert_eq!(stiffness.method, Method::Extended);
    let diagnosis = report.diagnosis.unwrap();
    let named: Vec<&str> = diagnosis.effects.iter().map(|e| e.id.as_str()).collect();
    assert_eq!(named, ["quadratic_damping"], "{}", diagnosis.sentence);
    let found = &diagnosis.effects[0].parameters["c2"];
    assert!((found.value / drag - 1.0).abs() < 0.05, "{found:?}");
}
