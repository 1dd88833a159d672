//! Rigs: a motor prescribes the motion, and what is measured is the force that answers.

use super::*;
use veloid_report::diagnosis::Predicted;
use veloid_ride::{ReadOptions, read};

const SECONDS: f64 = 20.0;
const RATE: f64 = 200.0;

/// Deflection (m) and its rate (m/s): sines that beat, so that the motion has quiet and loud stretches.
fn driven(t: f64) -> [f64; 2] {
    let sines = [(6e-3, 1.3, 0.0), (4e-3, 1.7, 1.0), (1e-3, 6.1, 2.0)];
    let sum =
        |of: &dyn Fn(f64, f64, f64) -> f64| sines.iter().map(|(a, f, p)| of(*a, TAU * f, *p)).sum();
    [
        sum(&|a, w, p| a * (w * t + p).sin()),
        sum(&|a, w, p| a * w * (w * t + p).cos()),
    ]
}

/// What a logger writes of a rig with k = 20 kN/m, B = 300 N s/m and what is `missing` (d, w, sample).
fn logged(header: &str, sign: f64, mut missing: impl FnMut(f64, f64, usize) -> f64) -> String {
    let mut noise = Normal::new(3);
    let mut text = format!("{header}\n");
    for i in 0..(SECONDS * RATE) as usize {
        let t = i as f64 / RATE;
        let [d, w] = driven(t);
        let force = 20e3 * d + 300.0 * w + missing(d, w, i) + 0.5 * noise.draw();
        text += &format!("{t:.4},{d:.9},{:.5}\n", sign * force);
    }
    text
}

fn reported(text: &str) -> Report {
    let bike = Bike {
        mass_front_kg: None,
        ..bike()
    };
    let ride = read(text.as_bytes(), "rig.csv", &bike, &ReadOptions::default()).unwrap();
    let settings = Settings {
        trials: 2,
        iterations: 2,
        ..Settings::default()
    };
    veloid_engine::identify(&ride, &bike, &settings, &Silent).unwrap()
}

#[test]
#[ignore = "slow"]
fn a_rigs_stiffness_and_damping_are_found_whichever_way_it_is_logged() {
    for (header, sign) in [
        ("t,u_f,force_f", 1.0),
        ("t,d_f,force_f", 1.0),
        ("t,z_f,force_f", 1.0),
        ("t,z_f,force_f", -1.0),
    ] {
        let report = reported(&logged(header, sign, |_, _, _| 0.0));
        let fit = report.output_error.front.unwrap();
        assert!((fit.k_n_m / 20e3 - 1.0).abs() < 2e-3, "{header}: {fit:?}");
        assert!(
            (fit.b_n_s_m / 300.0 - 1.0).abs() < 5e-3,
            "{header}: {fit:?}"
        );
        assert_eq!((fit.mass_kg, fit.mass_std_kg), (0.0, None));
        assert!(report.observer.front.is_none() && report.swarm.front.is_none());
        assert!(
            report
                .comparison
                .notes
                .iter()
                .any(|n| n.contains("prescribes the motion"))
        );
        let d = report.diagnosis.unwrap();
        assert_eq!(d.verdict, Verdict::NothingMissing, "{}", d.sentence);
        let held = d.held_out.front.unwrap();
        let left = held.plain_rms_m.unwrap();
        // The logger's noise, or less where the record is thinned to what moves.
        assert!((0.1..0.55).contains(&left), "{left} N");
        assert_eq!(held.predicted, Predicted::Force);
        assert_eq!(d.evidence.front.unwrap().predicted, Predicted::Force);
        let turned = report
            .ride
            .warnings
            .iter()
            .any(|w| w.contains("its sign is inverted"));
        assert_eq!(turned, sign < 0.0, "{:?}", report.ride.warnings);
    }
}

#[test]
#[ignore = "slow"]
fn what_a_rigs_force_holds_beside_spring_and_damper_is_named() {
    let friction = |_: f64, w: f64, _: usize| 25.0 * w / w.hypot(2e-3);
    let hardening = |d: f64, _: f64, _: usize| 4e7 * d.powi(3);
    let mut slid = 0.0;
    let sliding = move |d: f64, _: f64, i: usize| {
        let before = if i == 0 {
            d
        } else {
            driven((i - 1) as f64 / RATE)[0]
        };
        let moved: f64 = d - before;
        // Dahl's friction over the way moved, exactly.
        let end = 2e-3 * moved.signum();
        slid = end + (slid - end) * (-moved.abs() / 2e-3).exp();
        2e4 * slid
    };
    let one = |name: &str, parameter: &str, truth: f64, text: String| {
        let d = reported(&text).diagnosis.unwrap();
        let names: Vec<_> = d.effects.iter().map(|e| e.id.as_str()).collect();
        assert_eq!(
            (d.verdict, &names[..]),
            (Verdict::Named, &[name][..]),
            "{}",
            d.sentence
        );
        let found = &d.effects[0].parameters[parameter];
        let off = found.value / truth - 1.0;
        assert!(
            off.abs() < 0.03,
            "{name}: {} instead of {truth}",
            found.value
        );
        assert!(d.sentence.contains("\u{a0}N"), "{}", d.sentence);
    };
    let header = "t,z_f,force_f";
    one(
        "coulomb_friction",
        "friction",
        25.0,
        logged(header, 1.0, friction),
    );
    one("cubic_stiffness", "k3", 4e7, logged(header, 1.0, hardening));
    one(
        "hysteresis",
        "yield_force",
        40.0,
        logged(header, 1.0, sliding),
    );
}

/// Bingham's damper whose force comes late: the lag is what makes friction look like hysteresis.
#[test]
#[ignore = "slow"]
fn a_lag_of_the_force_is_named_with_the_friction_that_it_rounds() {
    let mut late = 0.0;
    let text = logged("t,z_f,force_f", 1.0, |d, w, _| {
        let plain = 20e3 * d + 300.0 * w;
        late += (plain + 25.0 * w / w.hypot(2e-2) - late) * (1.0 - (-1.0 / (RATE * 0.02)).exp());
        late - plain
    });
    let d = reported(&text).diagnosis.unwrap();
    let found = |id: &str| d.effects.iter().find(|e| e.id == id);
    assert!(found("force_lag").is_some(), "{}", d.sentence);
    // What the force does between the samples of the lag may pass for a little hysteresis.
    let friction = found("coulomb_friction").map_or(0.0, |e| e.parameters["friction"].value);
    assert!(
        (0.75..1.05).contains(&(friction / 25.0)),
        "{friction}: {}",
        d.sentence
    );
}

/// A force cell whose gain wanders by 1 %: that has no name, but the friction has.
#[test]
fn a_force_cell_that_wanders_hides_no_friction() {
    let text = logged("t,d_f,force_f", 1.0, |d, w, i| {
        let force = 1e3 * d + 400.0 * w + 40.0 * (w / 3e-3).tanh();
        let wandering = 1.0 + 0.01 * (0.3 * i as f64 / RATE).sin();
        force * wandering - 20e3 * d - 300.0 * w
    });
    let d = reported(&text).diagnosis.unwrap();
    let affirmed: Vec<_> = d.effects.iter().filter(|e| e.affirmed).collect();
    assert_eq!(affirmed.len(), 1, "{}", d.sentence);
    assert_eq!(affirmed[0].id, "coulomb_friction", "{}", d.sentence);
    let found = affirmed[0].parameters["friction"].value;
    assert!((found / 40.0 - 1.0).abs() < 0.05, "{found}");
}

#[test]
fn a_rig_whose_force_never_changes_is_refused() {
    let text = logged("t,d_f,force_f", 0.0, |_, _, _| 0.0);
    let said = read(text.as_bytes(), "rig.csv", &bike(), &ReadOptions::default());
    assert!(said.unwrap_err().to_string().contains("force_f"));
}

#[test]
fn a_force_that_is_noise_is_neither_turned_round_nor_explained() {
    let mut noise = Normal::new(8);
    let text = logged("t,d_f,force_f", 1.0, |d, w, _| {
        30.0 * noise.draw() - 20e3 * d - 300.0 * w
    });
    let report = reported(&text);
    let turned = |w: &String| w.contains("its sign is inverted");
    assert!(!report.ride.warnings.iter().any(turned));
    let d = report.diagnosis.unwrap();
    assert_eq!(d.verdict, Verdict::CannotTell, "{}", d.sentence);
}
