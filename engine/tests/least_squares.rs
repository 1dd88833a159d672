use veloid_core::bicycle::{Axle, Bike};
use veloid_core::settings::Settings;
use veloid_engine::observe;
use veloid_methods::simulate::simulated_ride::{Excitation, SimulatedRide, Spring};
use veloid_report::Estimate;
use veloid_report::stages::Observed;
use veloid_ride::Ride;

fn bike() -> Bike {
    Bike {
        mass_front_kg: Some(23.0),
        mass_rear_kg: Some(63.0),
        ..Bike::default()
    }
}

fn observed(ride: &Ride, bike: &Bike) -> Observed {
    observe(ride, bike, &Settings::default()).unwrap()
}

/// Errors of k and B in percent.
fn percent(e: &Estimate) -> [f64; 2] {
    [
        e.k_n_m / 110e3 * 100.0 - 100.0,
        e.b_n_s_m / 1150.0 * 100.0 - 100.0,
    ]
}

fn noisy(noise_displacement_m: f64) -> Ride {
    SimulatedRide {
        noise_displacement_m,
        ..SimulatedRide::default()
    }
    .ride()
}

#[test]
fn clean_ride_gives_the_truth() {
    let o = observed(&noisy(0.0), &bike());
    for (_, e) in o.least_squares.iter() {
        let [k, b] = percent(e);
        assert!(k.abs() < 0.5 && b.abs() < 5.0, "{k} % {b} %");
    }
    for (_, e) in o.instrumental.iter() {
        let [k, b] = percent(e);
        assert!(k.abs() < 0.1 && b.abs() < 0.1, "{k} % {b} %");
    }
}

/// As by definition: every sample that is not valid takes those around it out.
#[test]
fn unusable_are_those_near_what_is_not_valid() {
    let valid: Vec<bool> = (0..200)
        .map(|i| i % 37 != 20 && !(90..95).contains(&i))
        .collect();
    for (first, before, after) in [
        (0, 5, 5),
        (10, 0, 30),
        (0, 12, 3),
        (3, 0, 0),
        (0, usize::MAX, 2),
        (0, 2, usize::MAX),
    ] {
        let want: Vec<bool> = (0..200_usize)
            .map(|j| {
                let near = |i: usize| i <= j && j - i <= after || j <= i && i - j <= before;
                j >= first && !(0..200).any(|i| !valid[i] && near(i))
            })
            .collect();
        assert_eq!(
            veloid_methods::least_squares::usable(&valid, first, before, after),
            want,
            "{first} {before} {after}"
        );
    }
}

/// Noise biases the paper's estimate and not the one with instruments.
#[test]
fn instruments_take_away_the_bias() {
    let o = observed(&noisy(1e-4), &bike());
    for (axle, e) in o.instrumental.iter() {
        let [k, b] = percent(e);
        assert!(k.abs() < 0.5 && b.abs() < 1.0, "{axle}: {k} % {b} %");
        assert!((e.k_n_m - 110e3).abs() < 3.5 * e.k_std_n_m.unwrap());
        assert!((e.b_n_s_m - 1150.0).abs() < 3.5 * e.b_std_n_s_m.unwrap());
        assert!(percent(o.least_squares.get(axle).unwrap())[0] > 5.0);
    }
}

#[test]
fn recursive_path_ends_at_the_batch_estimate() {
    let o = observed(&noisy(5e-5), &bike());
    for (axle, path) in o.recursive.iter() {
        let e = o.least_squares.get(axle).unwrap();
        assert!((path.k_n_m.last().unwrap() / e.k_n_m - 1.0).abs() < 1e-12);
        assert!((path.b_n_s_m.last().unwrap() / e.b_n_s_m - 1.0).abs() < 1e-12);
        assert!((250..=301).contains(&path.t_s.len()));
        assert!((path.t_s.last().unwrap() - 60.0).abs() < 1e-9);
    }
}

#[test]
fn equal_axles_share_one_pair() {
    let both = Bike {
        equal_axles: true,
        ..bike()
    };
    let ride = noisy(5e-5);
    let (joint, own) = (observed(&ride, &both), observed(&ride, &bike()));
    let pair = |o: &Observed, a| o.instrumental.get(a).unwrap().clone();
    let (f, r) = (pair(&joint, Axle::Front), pair(&joint, Axle::Rear));
    assert_eq!((f.k_n_m, f.b_n_s_m), (r.k_n_m, r.b_n_s_m));
    assert!(percent(&f)[0].abs() < 0.2 && percent(&f)[1].abs() < 0.4);
    assert!(f.k_std_n_m.unwrap() < pair(&own, Axle::Front).k_std_n_m.unwrap());
    assert_eq!(joint.recursive.front, joint.recursive.rear);
}

#[test]
fn samples_not_valid_do_not_count() {
    let mut ride = noisy(5e-5);
    for record in [&mut ride.axles.front, &mut ride.axles.rear] {
        let record = record.as_mut().unwrap();
        for i in 2000..2300 {
            record.displacement[i] = 0.004;
            record.valid[i] = false;
        }
    }
    for (_, e) in observed(&ride, &bike()).instrumental.iter() {
        let [k, b] = percent(e);
        assert!(k.abs() < 0.5 && b.abs() < 1.0, "{k} % {b} %");
    }
}

fn shaken() -> Ride {
    SimulatedRide {
        excitation: Excitation::Shaker {
            amplitude_n: 60.0,
            from_hz: 0.5,
            to_hz: 18.0,
        },
        noise_displacement_m: 5e-6,
        rear: None,
        ..SimulatedRide::default()
    }
    .ride()
}

#[test]
fn a_force_makes_the_mass_known() {
    let unweighed = Bike {
        mass_front_kg: None,
        ..bike()
    };
    let e = observed(&shaken(), &unweighed).instrumental.front.unwrap();
    assert!((e.mass_kg / 23.0 - 1.0).abs() < 0.01, "{e:?}");
    assert!((e.mass_kg - 23.0).abs() < 4.0 * e.mass_std_kg.unwrap());
    assert!(
        percent(&e)[0].abs() < 1.0 && percent(&e)[1].abs() < 1.0,
        "{e:?}"
    );
    let weighed = observed(&shaken(), &bike()).instrumental.front.unwrap();
    assert!(percent(&weighed)[0].abs() < 0.5, "{weighed:?}");
}

#[test]
fn a_free_decay_is_enough() {
    let ride = SimulatedRide {
        duration_s: 4.0,
        excitation: Excitation::Release {
            displacement_m: 0.02,
        },
        noise_displacement_m: 2e-5,
        front: Some(Spring {
            mass_kg: 23.0,
            k_n_m: 110e3,
            b_n_s_m: 115.0,
        }),
        rear: None,
        ..SimulatedRide::default()
    }
    .ride();
    let e = observed(&ride, &bike()).instrumental.front.unwrap();
    assert!(percent(&e)[0].abs() < 0.5, "{e:?}");
    assert!((e.b_n_s_m / 115.0 - 1.0).abs() < 0.03, "{e:?}");
}

#[test]
fn a_mass_needs_a_force() {
    let unweighed = Bike {
        mass_front_kg: None,
        ..bike()
    };
    let message = observe(&noisy(0.0), &unweighed, &Settings::default())
        .unwrap_err()
        .to_string();
    assert!(message.contains("mass_front_kg is null"), "{message}");
}

#[test]
fn a_ride_at_rest_is_refused() {
    let mut ride = noisy(0.0);
    let front = ride.axles.front.as_mut().unwrap();
    front.road.fill(0.0);
    front.displacement.fill(0.001);
    let message = observe(&ride, &bike(), &Settings::default())
        .unwrap_err()
        .to_string();
    assert!(message.contains("does not determine"), "{message}");
}
