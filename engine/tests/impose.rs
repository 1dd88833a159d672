use veloid_core::Silent;
use veloid_core::bicycle::Bike;
use veloid_core::settings::Settings;
use veloid_diagnosis::impose::*;
use veloid_diagnosis::search::extend::candidates;
use veloid_methods::simulate::simulated_ride::SimulatedRide;
use veloid_methods::simulate::simulated_ride::{SpeedChange, Spring};
use veloid_model::effects::ALL;
use veloid_model::effects::Kind;
use veloid_model::law::Need;
use veloid_report::diagnosis::Place;
use veloid_report::diagnosis::{Diagnosis, Verdict};

fn bike() -> Bike {
    Bike {
        mass_front_kg: Some(30.0),
        mass_rear_kg: Some(50.0),
        l_front_m: Some(0.6),
        l_rear_m: Some(0.45),
        wheel_radius_front_m: Some(0.34),
        wheel_radius_rear_m: Some(0.34),
        ..Bike::default()
    }
}

/// Half a minute with 30 um of noise, at a speed that swings, pedalling.
fn simulated_ride() -> SimulatedRide {
    let spring = |mass_kg| {
        Some(Spring {
            mass_kg,
            k_n_m: 60e3,
            b_n_s_m: 500.0,
        })
    };
    SimulatedRide {
        duration_s: 30.0,
        speed_change: Some(SpeedChange {
            share: 0.3,
            period_s: 11.0,
        }),
        cadence_rpm: Some(80.0),
        wheelbase_m: 1.05,
        front: spring(30.0),
        rear: spring(50.0),
        noise_displacement_m: 3e-5,
        ..SimulatedRide::default()
    }
}

fn imposed(id: &str, axle: Place, parameters: &[(&str, f64)]) -> Imposed {
    Imposed {
        id: id.to_owned(),
        axle,
        parameters: parameters
            .iter()
            .map(|(n, v)| ((*n).to_owned(), *v))
            .collect(),
    }
}

fn diagnosed(effect: &Imposed) -> Diagnosis {
    let settings = Settings {
        trials: 1,
        iterations: 2,
        ..Settings::default()
    };
    let ride = ride(&simulated_ride(), &bike(), std::slice::from_ref(effect)).unwrap();
    veloid_engine::identify(&ride, &bike(), &settings, &Silent)
        .unwrap()
        .diagnosis
        .unwrap()
}

fn is_found(id: &str, axle: Place, parameters: &[(&str, f64)]) {
    let d = diagnosed(&imposed(id, axle, parameters));
    assert_eq!(d.verdict, Verdict::Named, "{}", d.sentence);
    assert_eq!(d.effects.len(), 1, "{}", d.sentence);
    assert_eq!((d.effects[0].id.as_str(), d.effects[0].axle), (id, axle));
    for (name, value) in parameters {
        let found = &d.effects[0].parameters[*name];
        assert!(
            (found.value / value - 1.0).abs() < 0.02,
            "{name}: {found:?}"
        );
    }
}

#[test]
fn a_cubic_spring_is_found_again() {
    is_found("cubic_stiffness", Place::Front, &[("k3", 4e9)]);
}

#[test]
fn a_late_sensor_is_found_again() {
    is_found("sensor_delay", Place::Rear, &[("delay", 0.008)]);
}

#[test]
fn dry_friction_is_found_again() {
    is_found("coulomb_friction", Place::Front, &[("friction", 8.0)]);
}

#[test]
fn a_wheel_out_of_round_is_found_again() {
    let parameters = [
        ("amplitude", 8e-4),
        ("phase", 1.1),
        ("rolling_radius", 0.337),
    ];
    is_found("wheel_out_of_round", Place::Rear, &parameters);
}

#[test]
fn pitch_is_found_again() {
    let balanced = 80.0 * 0.6 * 0.45;
    is_found(
        "pitch_coupling",
        Place::Both,
        &[("pitch_inertia", 1.3 * balanced)],
    );
}

/// Every effect with what the first of its physical starts would report: it moves the axle, and values and reports agree.
#[test]
fn every_effect_can_be_imposed() {
    let simulated_ride = SimulatedRide {
        duration_s: 6.0,
        noise_displacement_m: 0.0,
        ..simulated_ride()
    };
    let fine = simulated_ride.fine();
    let dataset = dataset(&simulated_ride, &bike(), &fine);
    let plain = simulated_ride.ride();
    let (terms, off) = candidates(&dataset);
    let on_rigs = |kind: &Kind| kind.spec().needs.contains(&Need::PrescribedMotion);
    let rigs = ALL.iter().filter(|kind| on_rigs(kind));
    assert_eq!(off.len(), rigs.count(), "{off:?}");
    for kind in Kind::named().filter(|kind| !on_rigs(kind)) {
        let term = terms.iter().find(|t| t.kind == kind).unwrap();
        let track = dataset
            .tracks
            .iter()
            .find(|t| term.acts_on(t.axle))
            .unwrap();
        let physical = (kind.spec().starts)(&track.scale)
            .iter()
            .map(|start| (kind.spec().report)(start, &track.scale))
            .find(|report| report.iter().all(|p| p.physical))
            .unwrap();
        let parameters: Vec<_> = physical.iter().map(|p| (&*p.name, p.value)).collect();
        let effect = imposed(kind.id(), term.place, &parameters);
        let ride = ride(&simulated_ride, &bike(), &[effect]).unwrap();
        let [before, after] = [&plain, &ride].map(|r| r.axles.get(track.axle).unwrap());
        assert_eq!(before.road, after.road);
        assert!(before.displacement != after.displacement, "{}", kind.id());
    }
}

#[test]
fn what_cannot_be_imposed_is_refused() {
    let steady = SimulatedRide {
        speed_change: None,
        cadence_rpm: None,
        rear: None,
        ..simulated_ride()
    };
    let one = |id, axle, parameters: &[(&str, f64)]| {
        let effect = imposed(id, axle, parameters);
        ride(&steady, &bike(), &[effect]).unwrap_err().to_string()
    };
    let front = Place::Front;
    for (found, expected) in [
        (
            one("square_wheel", front, &[]),
            "no such effect, expected one of cubic_stiffness, ",
        ),
        (
            one("power_damping", front, &[]),
            "no such effect, expected one of cubic_stiffness, ",
        ),
        (
            one("cubic_stiffness", Place::Rear, &[("k3", 1e9)]),
            "the axle can be front here",
        ),
        (one("cubic_stiffness", front, &[]), "k3 is missing"),
        (
            one("cubic_stiffness", front, &[("k4", 1.0)]),
            "no parameter 'k4', only k3",
        ),
        (
            one("cubic_stiffness", front, &[("k3", f64::NAN)]),
            "k3 = NaN is outside",
        ),
        (
            one("sensor_delay", front, &[("delay", 7.0)]),
            "delay = 7 is outside",
        ),
        (
            one("pitch_coupling", Place::Both, &[("pitch_inertia", 9.0)]),
            "both axles with",
        ),
        (
            one("stiffness_drift", Place::Both, &[("rate", 0.01)]),
            "the axle can be front",
        ),
        (
            one("load_transfer", Place::Both, &[("cog_height", 1.0)]),
            "no speed channel",
        ),
        (
            one("pedalling_force", front, &[("amplitude", 9.0)]),
            "no cadence channel",
        ),
    ] {
        assert!(found.contains(expected), "{found}");
    }
    let delay = imposed("sensor_delay", front, &[("delay", 0.01)]);
    let twice = [delay.clone(), delay];
    assert!(ride(&steady, &bike(), &twice).is_err());
}
