//! Laws of the user's own.

use super::*;
use std::sync::Arc;
use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_diagnosis::search::extend::candidates;
use veloid_model::effects::Shape;
use veloid_model::fit::{Effort, Slot};
use veloid_model::law::{OwnLaw, Values};
use veloid_report::tried::Tried;

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
#[ignore = "slow"]
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
    let of_law = |d: &Diagnosis| {
        let own = |t: &&Tried| t.has("fifth_power_spring") && t.effects.len() == 1;
        let own: Vec<Tried> = d.tried.iter().filter(own).cloned().collect();
        assert_eq!(own.len(), 2, "{:?}", d.tried);
        own
    };
    for tried in of_law(&clean) {
        assert!(tried.why_not.is_some() && tried.gain.is_some(), "{tried:?}");
        assert!(tried.effects[0].parameters.contains_key("k5"), "{tried:?}");
    }
    let friction = reported(&ride(|_, _, w| 12.0 * (w / 1e-3).tanh()), FIFTH);
    assert_named_alone(&friction, "coulomb_friction");
    assert!(
        of_law(&friction)
            .iter()
            .all(|tried| tried.why_not.is_some())
    );
    let answer = &friction.tried[0];
    assert!(
        answer.has("coulomb_friction") && answer.why_not.is_none(),
        "{answer:?}"
    );
}

/// A ride of the plain model with pedalling.
fn pedalled() -> Dataset {
    let simulated_ride = SimulatedRide {
        cadence_rpm: Some(80.0),
        ..SimulatedRide::default()
    };
    let ride = simulated_ride.ride();
    let settings = Settings::default();
    let observed = veloid_engine::observe(&ride, &bike(), &settings).unwrap();
    let start = starts_from(&observed.instrumental);
    let fits = output_error::fit(&ride, &bike(), &settings, &[start]).unwrap();
    Dataset::new(&ride, &bike(), &fits, 3000)
}

/// The rear axle with one effect.
fn rear(dataset: &Dataset, kind: Kind, values: Values) -> (Unit, Point) {
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
        initial: vec![AT_REST],
    };
    (unit, point)
}

/// Three branches of the tyre that resonate, beside three curved laws: stiffness, frequency (rad/s) and decay (1/s) of each branch.
const RESONANT: &str = r#"
id = "resonant_tyre"
force = "g1 * x1 + g2 * x2 + g3 * x3 + h2 * d * abs(d) + h3 * d^3 + c2 * w * abs(w)"
states = { x1 = "v1", v1 = "r1^2 * (d - x1) - c_1 * v1", x2 = "v2", v2 = "r2^2 * (d - x2) - c_2 * v2", x3 = "v3", v3 = "r3^2 * (d - x3) - c_3 * v3" }
parameters.g1 = { start = 7e3, range = [0, 1e6] }
parameters.g2 = { start = 7e3, range = [0, 1e6] }
parameters.g3 = { start = 7e3, range = [0, 1e6] }
parameters.r1 = { start = 29, range = [5, 400] }
parameters.r2 = { start = 65, range = [5, 400] }
parameters.r3 = { start = 150, range = [5, 400] }
parameters.c_1 = { start = 17, range = [0.1, 200] }
parameters.c_2 = { start = 35, range = [0.1, 200] }
parameters.c_3 = { start = 70, range = [0.1, 200] }
parameters.h2 = { start = 1e6, range = [-1e8, 1e8] }
parameters.h3 = { start = 1e9, range = [-1e11, 1e11] }
parameters.c2 = { start = 200, range = [-1e4, 1e4] }
"#;

#[test]
#[ignore = "slow"]
fn a_law_of_twelve_parameters_and_six_states_is_recovered() {
    let mut dataset = pedalled();
    let law = OwnLaw::read(RESONANT).unwrap();
    let kind = Kind::Own(Shape::of(&law));
    assert_eq!((law.parameters.len(), law.states()), (12, 6));
    dataset.set_law(&Arc::new(law.clone()));
    let truth = law.parameters.iter().map(|p| match p.name.as_str() {
        "g1" | "g2" | "g3" => 8e3,
        "r1" => 30.0,
        "r2" => 63.0,
        "r3" => 155.0,
        "c_1" => 20.0,
        "c_2" => 40.0,
        "c_3" => 80.0,
        "h2" => 2e6,
        "h3" => 2e9,
        _ => 300.0,
    });
    let truth: Vec<f64> = truth.collect();
    let mut values = padded([]);
    values[..12].copy_from_slice(&truth);
    let (unit, point) = rear(&dataset, kind, values);
    let samples = dataset.samples;
    let points: [Point; LANES] = std::array::from_fn(|_| point.clone());
    let z = unit.simulate(&dataset, &points, None, 0..samples, 4);
    let mut noise = Normal::new(5);
    let noisy = z[0].iter().map(|lanes| lanes.0[0] + 1e-5 * noise.draw());
    dataset.tracks[1].measured = noisy.collect();
    let fitter = Fitter {
        dataset: &dataset,
        samples,
    };
    let effort = Effort {
        iterations: 60,
        gain: 1e-6,
        substeps: 4,
    };
    let (_, start) = rear(&dataset, kind, law.starts()[0]);
    let white = [NoiseModel::white(1e-10)];
    let fit = fitter.fit(&unit, start, &white, effort).unwrap();
    let slots = unit.slots(&dataset);
    for (q, (parameter, truth)) in law.parameters.iter().zip(truth).enumerate() {
        let i = slots.iter().position(|s| *s == Slot::Value(0, q)).unwrap();
        let found = fit.point.values[0][q];
        let error = fit.covariance[(i, i)].sqrt();
        let name = &parameter.name;
        assert!(
            (found - truth).abs() < 4.0 * error,
            "{name}: {found} ± {error}, {truth}"
        );
        assert!(error < truth, "{name}: {found} ± {error}");
    }
}

/// Laws of the library, written as one's own, move the axle as the library does.
#[test]
fn val_a_law_of_the_library_moves_the_same_when_it_is_written() {
    for (id, values, law) in [
        (
            "cubic_stiffness",
            padded([3e9]),
            "force = \"k3*d^3\"\nparameters.k3 = { start = 1e9, range = [0, 1e12] }",
        ),
        (
            "viscoelastic_tyre",
            padded([2e4, 0.02]),
            "force = \"a*x\"\nstates.x = \"w - x/b\"\nparameters.a = { start = 1, range = [0, 1e9] }\n\
             parameters.b = { start = 0.02, range = [0.001, 1] }",
        ),
        (
            "quadratic_damping",
            padded([300.0]),
            "force = \"c*w*abs(w)\"\nparameters.c = { start = 1, range = [0, 1e9] }",
        ),
        (
            "pedalling_force",
            padded([30.0, 20.0]),
            "force = \"a*sin(2*crank) + b*cos(2*crank)\"\nparameters.a = { start = 1, range = [0, 1e9] }\n\
             parameters.b = { start = 0.02, range = [0, 100] }",
        ),
    ] {
        let mut dataset = pedalled();
        let law = OwnLaw::read(&format!("id = \"own\"\n{law}")).unwrap();
        let own = Kind::Own(Shape::of(&law));
        dataset.set_law(&Arc::new(law));
        let known = candidates(&dataset).0;
        assert!(known.iter().any(|term| term.kind == own));
        let moved = |kind: Kind, values: Values| -> Vec<f64> {
            let (unit, point) = rear(&dataset, kind, values);
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
