//! Laws of the user's own.

use super::*;
use std::sync::Arc;
use veloid_diagnosis::search::extend::candidates;
use veloid_model::effects::Shape;
use veloid_model::law::{OwnLaw, Values};

fn with(law: &str) -> Settings {
    Settings {
        trials: 1,
        iterations: 2,
        law: Some(law.to_owned()),
        ..Settings::default()
    }
}

fn reported(ride: &Ride, law: &str) -> Diagnosis {
    let report = veloid_engine::identify(ride, &bike(), &with(law), &Silent).unwrap();
    report.diagnosis.unwrap()
}

const FIFTH: &str = r#"
id = "fifth_power_spring"
force = "k5 * d^5"
parameters.k5 = { unit = "N/m^5", start = 1e13, range = [-1e16, 1e16] }
"#;

#[test]
fn a_law_that_no_library_has_is_named_and_measured() {
    let ride = ride(|_, d, _| 2e14 * d.powi(5));
    let d = reported(&ride, FIFTH);
    assert_named_alone(&d, "fifth_power_spring");
    assert_eq!(d.effects[0].axle, Place::Front);
    let k5 = &d.effects[0].parameters["k5"];
    assert_eq!(k5.unit, "N/m^5");
    let error = k5.std_error.unwrap();
    assert!(
        (k5.value - 2e14).abs() < 4.0 * error && error < 4e12,
        "{k5:?}"
    );
    let spoken_of = d.sentence.contains("fifth power spring");
    assert!(spoken_of, "{}", d.sentence);
    // Without the law no other spring takes its name.
    let without = diagnosed(&ride);
    assert_eq!(without.verdict, Verdict::Unnamed, "{}", without.sentence);
    assert!(without.location.front.as_ref().unwrap().mismatch);
    assert!(!without.location.rear.as_ref().unwrap().mismatch);
    let named = without.effects.iter().any(|e| e.affirmed);
    assert!(!named, "{}", without.sentence);
}

#[test]
fn a_law_is_not_named_where_it_does_not_act() {
    let clean = reported(&ride(|_, _, _| 0.0), FIFTH);
    assert_eq!(clean.verdict, Verdict::NothingMissing, "{}", clean.sentence);
    assert!(
        clean
            .detectable
            .iter()
            .any(|d| d.id == "fifth_power_spring")
    );
    let friction = reported(&ride(|_, _, w| 12.0 * (w / 1e-3).tanh()), FIFTH);
    assert_named_alone(&friction, "coulomb_friction");
}

/// Laws of the library, written as one's own, move the axle as the library does.
#[test]
fn val_a_law_of_the_library_moves_the_same_when_it_is_written() {
    for (id, values, law) in [
        (
            "cubic_stiffness",
            [3e9, 0.0, 0.0, 0.0],
            "force = \"k3*d^3\"\nparameters.k3 = { start = 1e9, range = [0, 1e12] }",
        ),
        (
            "viscoelastic_tyre",
            [2e4, 0.02, 0.0, 0.0],
            "force = \"a*x\"\nstates.x = \"w - x/b\"\nparameters.a = { start = 1, range = [0, 1e9] }\n\
             parameters.b = { start = 0.02, range = [0.001, 1] }",
        ),
        (
            "quadratic_damping",
            [300.0, 0.0, 0.0, 0.0],
            "force = \"c*w*abs(w)\"\nparameters.c = { start = 1, range = [0, 1e9] }",
        ),
        (
            "pedalling_force",
            [30.0, 20.0, 0.0, 0.0],
            "force = \"a*sin(2*crank) + b*cos(2*crank)\"\nparameters.a = { start = 1, range = [0, 1e9] }\n\
             parameters.b = { start = 0.02, range = [0, 100] }",
        ),
    ] {
        let simulated_ride = SimulatedRide {
            cadence_rpm: Some(80.0),
            ..SimulatedRide::default()
        };
        let ride = simulated_ride.ride();
        let settings = Settings::default();
        let observed = veloid_engine::observe(&ride, &bike(), &settings).unwrap();
        let start = starts_from(&observed.instrumental);
        let fits = output_error::fit(&ride, &bike(), &settings, &[start]).unwrap();
        let mut dataset = Dataset::new(&ride, &bike(), &fits, 3000);
        let law = OwnLaw::read(&format!("id = \"own\"\n{law}")).unwrap();
        let own = Kind::Own(Shape::of(&law));
        dataset.set_law(&Arc::new(law));
        let known = candidates(&dataset).0;
        assert!(known.iter().any(|term| term.kind == own));
        let moved = |kind: Kind, values: Values| -> Vec<f64> {
            let unit = Unit {
                tracks: vec![1],
                terms: vec![Term {
                    kind,
                    place: Place::Rear,
                }],
            };
            let point = Point {
                base: vec![dataset.tracks[1].plain()],
                values: vec![values],
                initial: vec![[0.0; 2]],
            };
            let points: [Point; LANES] = std::array::from_fn(|_| point.clone());
            let z = unit.simulate(&dataset, &points, None, 0..3000, 4);
            z[0].iter().map(|lanes| lanes.0[0]).collect()
        };
        let library = moved(Kind::by_id(id).unwrap(), values);
        let written = moved(own, values);
        let most = library.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        for (a, b) in library.iter().zip(&written) {
            assert!((a - b).abs() < 1e-9 * most, "{id}: {a} and {b}");
        }
    }
}
