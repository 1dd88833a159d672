//! Numbers of the report are what they say, or they are not there.

use super::*;

/// The default simulated ride's bicycle, whose displacement sensors have 50 um of noise, and the file says so.
fn noisy() -> (SimulatedRide, Bike) {
    let simulated_ride = SimulatedRide {
        noise_displacement_m: 50e-6,
        seed: SimulatedRide::default().seed + 10,
        ..SimulatedRide::default()
    };
    let bike = Bike {
        mass_front_kg: Some(23.0),
        mass_rear_kg: Some(63.0),
        l_front_m: Some(0.808),
        l_rear_m: Some(0.293),
        noise_displacement_m: Some(50e-6),
        equal_axles: false,
        ..Bike::default()
    };
    (simulated_ride, bike)
}

fn gain(axle: Place, gain: f64) -> impose::Imposed {
    impose::Imposed {
        id: "sensor_gain".to_owned(),
        axle,
        parameters: [("gain".to_owned(), gain)].into(),
    }
}

/// A gain that takes a tenth off the error of its axle is not made material by one that takes nearly all off the other's.
#[test]
fn each_effect_is_material_by_itself() {
    let (simulated_ride, bike) = noisy();
    let gains = [gain(Place::Front, 1.003), gain(Place::Rear, 1.05)];
    let ride = impose::ride(&simulated_ride, &bike, &gains).unwrap();
    let settings = Settings {
        trials: 1,
        iterations: 2,
        materiality: 0.3,
        ..Settings::default()
    };
    let report = veloid_engine::identify(&ride, &bike, &settings, &Silent).unwrap();
    let d = report.diagnosis.unwrap();
    let material = |place| {
        let mut effects = d.effects.iter();
        let effect = effects.find(|e| e.axle == place);
        effect.map(|e| e.material)
    };
    assert_eq!(material(Place::Front), Some(false), "{}", d.sentence);
    assert_eq!(material(Place::Rear), Some(true), "{}", d.sentence);
    let held = d.held_out.rear.unwrap();
    assert_eq!(held.noise_floor_m, Some(50e-6));
    assert!(held.explained_share.unwrap() > 0.98, "{held:?}");
}

/// The floor of a record is that of its sensor, whatever a model leaves.
#[test]
#[ignore = "slow"]
fn the_noise_floor_is_measured_not_what_is_left() {
    let sway = |t: f64| (1..40).map(move |i| (f64::from(i * i) + 0.37 * f64::from(i) * t).sin());
    let d = diagnosed(&ride(|t, _, _| 12.0 * sway(t).sum::<f64>()));
    assert_eq!(d.verdict, Verdict::Unnamed, "{}", d.sentence);
    let held = d.held_out.front.unwrap();
    let noise = held.noise_floor_m.unwrap();
    assert!((noise / 50e-6 - 1.0).abs() < 0.1, "{held:?}");
    assert!(held.extended_rms_m.unwrap() > 1.5 * noise, "{held:?}");
    assert!(held.explained_share.is_none_or(|s| s < 0.9), "{held:?}");
    let silent = diagnosed(&SimulatedRide::default().ride());
    let held = silent.held_out.front.unwrap();
    assert_eq!((held.noise_floor_m, held.explained_share), (None, None));
    assert!(!silent.sentence.contains("noise is"), "{}", silent.sentence);
}

/// What is reported of an axle without a mismatch is what was computed, not the threshold.
#[test]
fn the_p_value_of_a_match_is_its_own() {
    let d = diagnosed(&ride(|_, _, _| 0.0));
    assert_eq!(d.verdict, Verdict::NothingMissing, "{}", d.sentence);
    let locations = [d.location.front.unwrap(), d.location.rear.unwrap()];
    assert!(locations.iter().all(|l| !l.mismatch), "{locations:?}");
    // Neither threshold nor bound: a probability of this axle's own noise.
    let [front, rear] = locations.map(|l| l.p_value.unwrap());
    let ordinary = 0.02..0.98;
    assert!(
        ordinary.contains(&front) && ordinary.contains(&rear) && front != rear,
        "{front} {rear}"
    );
}

/// With four times the noise every effect must be about four times as strong to show, or does not show at all.
#[test]
fn what_would_have_shown_grows_with_the_noise() {
    let (simulated_ride, mut bike) = noisy();
    let quiet = diagnosed_on(&simulated_ride.ride(), &bike);
    bike.noise_displacement_m = Some(200e-6);
    let simulated_ride = SimulatedRide {
        noise_displacement_m: 200e-6,
        ..simulated_ride
    };
    let loud = diagnosed_on(&simulated_ride.ride(), &bike);
    assert!(quiet.detectable.len() > 20);
    let mut shown = 0;
    for x in &quiet.detectable {
        let Some(size) = x.smallest_detectable else {
            assert!(x.reason.is_some(), "{x:?}");
            continue;
        };
        assert!((1e-9..1e12).contains(&size) && x.reason.is_none(), "{x:?}");
        let same = |y: &&Detectable| y.id == x.id && y.axle == x.axle;
        let other = loud
            .detectable
            .iter()
            .find(same)
            .and_then(|y| y.smallest_detectable);
        match (x.stronger, other) {
            (Stronger::Larger, Some(other)) => {
                assert!((2.0..8.0).contains(&(other / size)), "{x:?}: {other}")
            }
            (Stronger::Smaller, Some(other)) => assert!(other < size, "{x:?}: {other}"),
            (_, None) => {}
        }
        shown += 1;
    }
    assert!(shown > 20, "{shown}");
    let of = |id: &str| quiet.detectable.iter().find(|x| x.id == id).unwrap();
    assert_eq!(of("bump_stop").parameter, "stop_stiffness");
    let lift = of("wheel_lift");
    assert_eq!(
        (lift.stronger, lift.parameter.as_str()),
        (Stronger::Smaller, "static_load")
    );
}

/// Where the record shows less of a wheel's share of the mass than was expected before it, no interval pretends otherwise;
/// where it shows more, the interval holds the truth, also far from what was expected.
#[test]
fn val_a_wheels_mass_is_reported_by_the_ride_or_not_at_all() {
    for wheel in [0.08, 0.3] {
        let d = diagnosed(&carried_by_a_wheel(wheel));
        let effect = d.effects.iter().find(|e| e.id == "unsprung_mass");
        let found = &effect.unwrap().parameters["mass_fraction"];
        let warned = d
            .warnings
            .iter()
            .any(|w| w.contains("not identifiable beyond"));
        assert_eq!(
            found.std_error.is_none(),
            warned,
            "{wheel}: {:?}",
            d.warnings
        );
        assert_eq!(
            found.not_identifiable.is_some(),
            warned,
            "{wheel}: {found:?}"
        );
        if let Some(error) = found.std_error {
            assert!(
                (found.value - wheel).abs() < 3.0 * error,
                "{wheel}: {found:?}"
            );
            assert!(error < 0.071, "{wheel}: {found:?}");
        } else {
            assert!(
                d.sentence.contains("mass fraction as expected"),
                "{}",
                d.sentence
            );
        }
        let front = d.extended.front.as_ref().unwrap();
        assert_eq!(
            front.k_std_n_m.is_none(),
            warned,
            "{wheel}: {found:?} {front:?}"
        );
        if let Some(error) = front.k_std_n_m {
            let off = (front.k_n_m - K).abs();
            assert!(off < 3.0 * error, "{wheel}: {found:?} {front:?}");
        }
    }
}
