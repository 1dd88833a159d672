//! Rides of known k and B.
#![allow(clippy::unwrap_used)]

use super::likelihood::{Likelihood, Own};
use super::record::{Lateness, Sensor};
use super::*;
use veloid_core::bicycle::Axle;
use veloid_core::numerics::random::Normal;
use veloid_methods::simulate::road::Roughness;
use veloid_methods::simulate::simulated_ride::{Excitation, SimulatedRide, SpeedChange, Spring};
use veloid_report::Estimate;
use veloid_ride::SensorKind;

/// What is not as the ride's file says.
#[derive(Clone, Copy)]
struct Off {
    noise: f64,
    speed: f64,
    gain: f64,
    late: usize,
}

const NOTHING: Off = Off {
    noise: 0.03,
    speed: 0.0,
    gain: 1.0,
    late: 0,
};

fn simulated_ride(seed: u64, rear: [f64; 2]) -> SimulatedRide {
    SimulatedRide {
        rear: Some(Spring {
            mass_kg: 63.0,
            k_n_m: rear[0],
            b_n_s_m: rear[1],
        }),
        excitation: Excitation::Road {
            roughness: Some(Roughness::C),
            bumps: Vec::new(),
        },
        seed,
        ..SimulatedRide::default()
    }
}

const REAR: [f64; 2] = [95e3, 900.0];

fn bike() -> Bike {
    Bike {
        mass_front_kg: Some(23.0),
        mass_rear_kg: Some(63.0),
        l_front_m: Some(0.808),
        l_rear_m: Some(0.293),
        ..Bike::default()
    }
}

/// The ride as two accelerometers and a speed sensor record it.
fn ride(simulated_ride: &SimulatedRide, off: Off) -> Ride {
    let mut ride = simulated_ride.sensed(off.noise).unwrap();
    let rear = &mut ride.sensors[1].values;
    *rear = (0..rear.len())
        .map(|i| off.gain * rear[i.saturating_sub(off.late)])
        .collect();
    for v in ride.speed.iter_mut().flatten() {
        *v *= 1.0 + off.speed;
    }
    ride
}

fn off_by(estimate: &Estimate, k: f64, b: f64) -> [f64; 2] {
    [estimate.k_n_m / k - 1.0, estimate.b_n_s_m / b - 1.0]
}

/// Whether k is within 2 % and B within 4 % on both axles, and inside three standard errors.
fn is_found(found: &LatentRoad) {
    for (estimate, [k, b]) in [(&found.front, [110e3, 1150.0]), (&found.rear, REAR)] {
        let e = estimate.as_ref().unwrap();
        let [off_k, off_b] = off_by(e, k, b);
        assert!(off_k.abs() < 0.02 && off_b.abs() < 0.04, "{e:?}");
        let (std_k, std_b) = (e.k_std_n_m.unwrap() / k, e.b_std_n_s_m.unwrap() / b);
        assert!(
            off_k.abs() < 3.0 * std_k && off_b.abs() < 3.0 * std_b,
            "{e:?}"
        );
        assert!(std_k < 0.02 && std_b < 0.03, "{e:?}");
    }
}

#[test]
fn two_accelerometers_and_a_speed_show_k_and_b() {
    for seed in 1..4 {
        let found = latent_road(&ride(&simulated_ride(seed, REAR), NOTHING), &bike()).unwrap();
        is_found(&found);
        let road = found.road.unwrap();
        assert_eq!(road.class, "C");
        assert!((road.psd_m3 / 256e-6).ln().abs() < 0.3, "{}", road.psd_m3);
        for sensor in &found.sensors {
            assert!(sensor.noise.is_none_or(|noise| noise < 0.15), "{sensor:?}");
        }
        assert!(found.notes.is_empty(), "{:?}", found.notes);
    }
}

#[test]
fn a_speed_that_changes_does_no_harm() {
    let changing = SimulatedRide {
        speed_m_s: 6.0,
        speed_change: Some(SpeedChange {
            share: 0.2,
            period_s: 20.0,
        }),
        ..simulated_ride(3, REAR)
    };
    let noisy = Off {
        noise: 0.1,
        ..NOTHING
    };
    is_found(&latent_road(&ride(&changing, noisy), &bike()).unwrap());
}

#[test]
fn a_speed_that_is_off_a_gain_and_a_delay_are_found() {
    let off = Off {
        speed: 0.02,
        gain: 1.03,
        late: 1,
        ..NOTHING
    };
    let fine = SimulatedRide {
        rate_hz: 500.0,
        ..simulated_ride(2, REAR)
    };
    let found = latent_road(&ride(&fine, off), &bike()).unwrap();
    is_found(&found);
    let gain = found.sensors[1].gain.clone().unwrap();
    assert!((gain.value - 1.03).abs() < 0.005, "{gain:?}");
}

#[test]
fn axles_alike_have_no_interval_but_a_reason() {
    let alike = [110e3 * 63.0 / 23.0, 1150.0 * 63.0 / 23.0];
    let found = latent_road(&ride(&simulated_ride(1, alike), NOTHING), &bike()).unwrap();
    for e in [found.front.unwrap(), found.rear.unwrap()] {
        assert_eq!((e.k_std_n_m, e.b_std_n_s_m), (None, None));
        assert!(e.k_not_identifiable.unwrap().contains("too similar"));
    }
}

#[test]
fn what_is_lacking_is_said() {
    let whole = ride(&simulated_ride(1, REAR), NOTHING);
    let why = |ride: &Ride, bike: &Bike| {
        let found = latent_road(ride, bike).unwrap();
        assert!(found.front.is_none() && found.rear.is_none());
        found.reason.unwrap()
    };
    let mut one = whole.clone();
    one.sensors.truncate(1);
    assert!(why(&one, &bike()).contains("one accelerometer alone"));
    let no_base = Bike {
        l_rear_m: None,
        ..bike()
    };
    assert!(why(&whole, &no_base).contains("wheelbase"));
    let mut silent = whole.clone();
    silent.speed = None;
    assert!(why(&silent, &bike()).contains("speed"));
    let mut standing = whole.clone();
    standing.speed = Some(vec![0.0; whole.samples]);
    assert!(why(&standing, &bike()).contains("only 0 stretches"));
    let mut strange = whole.clone();
    strange.sensors[1].values = Normals::of(9, whole.samples);
    assert!(why(&strange, &bike()).contains("not coherent"));
    for (windows, enough) in [(LEAST_WINDOWS, true), (LEAST_WINDOWS - 1, false)] {
        let short = SimulatedRide {
            duration_s: 2.0 * windows as f64 + 2.5,
            ..simulated_ride(1, REAR)
        };
        let found = latent_road(&ride(&short, NOTHING), &bike()).unwrap();
        assert_eq!(found.reason.is_none(), enough, "{:?}", found.reason);
    }
    let recorded = SimulatedRide::default().ride();
    assert_eq!(latent_road(&recorded, &bike()), None);
}

/// Two accelerometers, and a laser at the rear whose clock is late by so many of 100 Hz's samples.
fn with_laser(seed: u64, late: isize) -> Ride {
    let simulated_ride = simulated_ride(seed, REAR);
    let mut ride = simulated_ride.sensed(0.03).unwrap();
    let motion = simulated_ride.motion().rear.unwrap();
    let d: Vec<f64> = (motion.road.iter().zip(&motion.displacement))
        .map(|(u, z)| u - z)
        .collect();
    let noise = Normals::of(50 + seed, d.len());
    let last = d.len() as isize - 1;
    let mut laser = ride.sensors[1].clone();
    laser.kind = SensorKind::Deflection;
    laser.values = (0..=last)
        .map(|i| d[(i - late).clamp(0, last) as usize] + 2e-4 * noise[i as usize])
        .collect();
    ride.sensors.push(laser);
    ride
}

#[test]
fn a_lasers_clock_is_found_and_does_no_harm() {
    for (seed, late) in [(1, 0), (2, 2), (3, -120)] {
        let found = latent_road(&with_laser(seed, late), &bike()).unwrap();
        is_found(&found);
        let delay = found.sensors[2].delay_s.clone().unwrap();
        let off = delay.value - 0.01 * late as f64;
        assert!(
            off.abs() < 1e-3 && off.abs() < 4.0 * delay.std_error,
            "{delay:?}"
        );
    }
}

struct Normals;

impl Normals {
    fn of(seed: u64, count: usize) -> Vec<f64> {
        let mut normal = Normal::new(seed);
        (0..count).map(|_| normal.draw()).collect()
    }
}

#[test]
fn the_same_ride_gives_the_same_bits() {
    let ride = ride(&simulated_ride(4, REAR), NOTHING);
    assert_eq!(latent_road(&ride, &bike()), latent_road(&ride, &bike()));
}

#[test]
fn a_gain_common_to_all_changes_the_road_only() {
    let plain = ride(&simulated_ride(1, REAR), NOTHING);
    let mut loud = plain.clone();
    for sensor in &mut loud.sensors {
        sensor.values.iter_mut().for_each(|a| *a *= -2.0);
    }
    let found = [&plain, &loud].map(|r| latent_road(r, &bike()).unwrap());
    let k = found.each_ref().map(|f| f.front.as_ref().unwrap().k_n_m);
    let road = found.each_ref().map(|f| f.road.as_ref().unwrap().psd_m3);
    assert!((k[1] / k[0] - 1.0).abs() < 1e-3, "{k:?}");
    assert!((road[1] / road[0] - 4.0).abs() < 0.05, "{road:?}");
}

/// Rides that no bicycle makes end in a reason or in numbers.
#[test]
fn hostile_rides_do_no_harm() {
    let plain = ride(&simulated_ride(1, REAR), NOTHING);
    let n = plain.samples;
    type Way<'a> = (&'a str, &'a dyn Fn(&mut Ride));
    let ways: [Way; 12] = [
        ("constant", &|r| r.sensors[0].values.fill(9.81)),
        ("both constant", &|r| {
            r.sensors.iter_mut().for_each(|s| s.values.fill(0.0))
        }),
        ("no number", &|r| r.sensors[1].values[777] = f64::NAN),
        ("infinite", &|r| r.sensors[1].values[777] = f64::INFINITY),
        ("tiny", &|r| scale(r, 1e-300)),
        ("small", &|r| scale(r, 1e-150)),
        ("large", &|r| scale(r, 1e140)),
        ("huge", &|r| scale(r, 1e300)),
        ("the same twice", &|r| {
            r.sensors[1].values = r.sensors[0].values.clone()
        }),
        ("one wild sample", &|r| r.sensors[0].values[3000] = 1e9),
        ("speed no number", &|r| r.speed = Some(vec![f64::NAN; n])),
        ("light", &|r| r.speed = Some(vec![3e8; n])),
    ];
    for (name, way) in ways {
        let mut ride = plain.clone();
        way(&mut ride);
        let found = latent_road(&ride, &bike()).unwrap();
        let gate = veloid_core::document::checked::<_, veloid_core::EngineError>("observe", found);
        assert!(gate.is_ok(), "{name}: {gate:?}");
    }
    let mut short = plain;
    short.samples = 3;
    short.sensors.iter_mut().for_each(|s| s.values.truncate(3));
    assert!(latent_road(&short, &bike()).unwrap().reason.is_some());
}

fn scale(ride: &mut Ride, by: f64) {
    for sensor in &mut ride.sensors {
        sensor.values.iter_mut().for_each(|a| *a *= by);
    }
}

/// Value and gradient of the likelihood against differences, in every unknown, with a laser beside the accelerometers.
#[test]
fn the_gradient_is_that_of_the_likelihood() {
    let short = SimulatedRide {
        duration_s: 20.0,
        ..simulated_ride(1, REAR)
    };
    let mut record = gather::gather(&ride(&short, NOTHING), &bike()).unwrap();
    record.sensors.push(Sensor {
        axle: Axle::Rear,
        kind: SensorKind::Deflection,
        values: Normals::of(4, record.valid.len()),
        known: Lateness::default(),
        highest_hz: 12.0,
        clock_s: 0.02,
        beside: Some(1),
        drift: 200e-6,
    });
    let windows = Windows::of(&record);
    let band = band::Band {
        low_hz: 1.0,
        high_hz: 18.0,
        highest_per_m: 3.5,
    };
    let bins = Bins::of(&windows, &record.sensors, band);
    let layout = Layout::new(&record.sensors, bins.span().unwrap(), 1.0);
    let problem = Likelihood {
        bins: &bins,
        sensors: &record.sensors,
        layout: &layout,
        any_road: false,
    };
    let mut theta = layout.start();
    let nudge = Normals::of(8, theta.len());
    theta
        .iter_mut()
        .zip(&nudge)
        .for_each(|(t, n)| *t += 0.02 * n);
    let own: Vec<Own> = (0..bins.groups.len())
        .map(|i| [0.1 * i as f64, 2e-3])
        .collect();
    let at = problem.evaluate(&theta, &own).unwrap();
    let step = 1e-5;
    for i in 0..theta.len() {
        let value = |by: f64| {
            let mut moved = theta.clone();
            moved[i] += by;
            problem.evaluate(&moved, &own).unwrap().value
        };
        let slope = (value(step) - value(-step)) / (2.0 * step);
        let size = 1e-5 * (1.0 + slope.abs() + at.value.abs() * 1e-3);
        assert!(
            (slope - at.gradient[i]).abs() < size,
            "{i}: {slope} {}",
            at.gradient[i]
        );
    }
    for i in 0..2 {
        let value = |by: f64| {
            let mut moved = own.clone();
            moved[1][i] += by;
            problem.evaluate(&theta, &moved).unwrap().value
        };
        let slope = (value(step) - value(-step)) / (2.0 * step);
        let found = at.windows[1].gradient[i];
        assert!(
            (slope - found).abs() < 1e-5 * (1.0 + slope.abs() + at.value.abs() * 1e-3),
            "{i}: {slope} {found}"
        );
    }
}
