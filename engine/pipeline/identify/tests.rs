//! Rides that no bicycle makes, through both ways: at once, as the command line goes, and stage by stage with a JSON
//! text in between, as the server does.
#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::pipeline::identify::*;
use veloid_core::Silent;
use veloid_core::bicycle::Axle;
use veloid_methods::simulate::simulated_ride::SimulatedRide;
use veloid_ride::AxleRecord;

fn bike() -> Bike {
    Bike {
        mass_front_kg: Some(23.0),
        mass_rear_kg: Some(63.0),
        ..Bike::default()
    }
}

fn settings(diagnosis: bool) -> Settings {
    Settings {
        trials: 2,
        particles: 8,
        iterations: 3,
        diagnosis,
        ..Settings::default()
    }
}

fn stored<T: Serialize + DeserializeOwned>(result: &T) -> T {
    serde_json::from_str(&serde_json::to_string(result).unwrap()).unwrap()
}

fn by_stages(ride: &Ride, settings: &Settings) -> Result<Report, EngineError> {
    let (bike, progress) = (&bike(), &Silent);
    let observed: Observed = stored(&observe(ride, bike, settings)?);
    let swarm = Swarm::new(ride, bike, settings, &observed)?;
    let trials = (0..settings.trials)
        .map(|index| Ok(stored(&swarm.trial(index, progress)?)))
        .collect::<Result<_, EngineError>>()?;
    let conclusion: Conclusion = stored(&conclude(ride, bike, settings, &observed, trials)?);
    let diagnosis = match settings.diagnosis {
        true => Some(diagnose(ride, bike, settings, &conclusion, progress)?),
        false => None,
    };
    assemble(ride, bike, settings, observed, conclusion, diagnosis)
}

/// Both ways end alike: in the same report, which can be read back, or in the same words, which blame nobody's program.
fn holds(ride: &Ride, diagnosis: bool) {
    let settings = settings(diagnosis);
    let at_once = identify(ride, &bike(), &settings, &Silent);
    let by_stages = by_stages(ride, &settings);
    match (at_once, by_stages) {
        (Ok(a), Ok(b)) => {
            assert_eq!(a, b);
            assert_eq!(stored(&a), a);
        }
        (a, b) => {
            let [a, b] = [a, b].map(|r| r.unwrap_err());
            assert_eq!(a.to_string(), b.to_string());
            assert!(!matches!(a, EngineError::NotFinite { .. }), "{a}");
        }
    }
}

/// What goes wrong with the front axle of a ride.
#[derive(Clone, Copy, Debug)]
enum Fate {
    Negated,
    Early(usize),
    Late(usize),
    Sine,
    Rigid,
    StillFor(usize),
    Scaled(f64),
    Growing(f64),
    FlatRoad,
    Still,
}

fn ride(fate: Fate, duration_s: f64) -> Ride {
    let mut ride = SimulatedRide {
        duration_s,
        noise_displacement_m: 2e-5,
        ..SimulatedRide::default()
    }
    .ride();
    let step = ride.step_s;
    let front = ride.axles.front.as_mut().unwrap();
    let (u, z) = (&mut front.road, &mut front.displacement);
    let was = z.clone();
    let last = was.len() - 1;
    let each = |z: &mut Vec<f64>, of: &dyn Fn(usize) -> f64| {
        z.iter_mut().enumerate().for_each(|(i, z)| *z = of(i));
    };
    match fate {
        Fate::Negated => each(z, &|i| -was[i]),
        Fate::Early(by) => each(z, &|i| was[(i + by).min(last)]),
        Fate::Late(by) => each(z, &|i| was[i.saturating_sub(by)]),
        Fate::Sine => {
            each(u, &|i| 0.01 * (19.0 * step * i as f64).sin());
            each(z, &|i| 0.013 * (19.0 * step * i as f64 - 0.2).sin());
        }
        Fate::Rigid => each(z, &|i| u[i]),
        Fate::StillFor(samples) => each(z, &|i| was[if i < samples { 0 } else { i }]),
        Fate::Scaled(by) => {
            u.iter_mut().for_each(|u| *u *= by);
            each(z, &|i| by * was[i]);
        }
        Fate::Growing(rate) => each(z, &|i| was[i] * (rate * step * i as f64).exp()),
        Fate::FlatRoad => u.fill(0.0),
        Fate::Still => z.fill(0.0),
    }
    ride
}

#[test]
fn both_ways_end_alike_on_rides_that_no_bicycle_makes() {
    for fate in [
        Fate::Negated,
        Fate::Early(2),
        Fate::Sine,
        Fate::Scaled(1e-9),
        Fate::Growing(1.0),
    ] {
        holds(&ride(fate, 8.0), true);
    }
    let mut twins = ride(Fate::Scaled(1.0), 8.0);
    let rear: AxleRecord = twins.axles.get(Axle::Front).unwrap().clone();
    twins.axles.set(Axle::Rear, rear);
    holds(&twins, true);
}

fn fate() -> impl Strategy<Value = Fate> {
    prop_oneof![
        Just(Fate::Negated),
        Just(Fate::Sine),
        Just(Fate::Rigid),
        Just(Fate::FlatRoad),
        Just(Fate::Still),
        (1..40_usize).prop_map(Fate::Early),
        (1..40_usize).prop_map(Fate::Late),
        (1..600_usize).prop_map(Fate::StillFor),
        (-12.0..12.0).prop_map(|e| Fate::Scaled(10_f64.powf(e))),
        (-4.0..4.0).prop_map(Fate::Growing),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn both_ways_end_alike(fate in fate(), duration_s in 3.0..60.0) {
        holds(&ride(fate, duration_s), false);
    }
}
