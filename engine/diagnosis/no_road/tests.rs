//! Rides of two axles on one road, made by the way from the road to the accelerations and solved the other way round.

#![allow(clippy::unwrap_used)]

use super::late::Late;
use super::law::Law;
use super::model::{Model, lanes};
use super::motion::{drive, invert};
use super::record::{Record, Segment};
use super::verdict::diagnose;
use veloid_core::Silent;
use veloid_core::bicycle::{Axle, Bike};
use veloid_core::numerics::lanes::Lanes;
use veloid_core::numerics::random::normal;
use veloid_model::effects::Kind;
use veloid_model::fit::Term;
use veloid_model::law::{Scale, Values, padded};
use veloid_report::diagnosis::{Diagnosis, Place, Surface, Verdict};
use veloid_ride::{ReadOptions, Ride, read};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

const WHEELBASE: f64 = 1.101;
const SPEED: f64 = 5.5;
const MASSES: [f64; 2] = [23.0, 63.0];
/// N/m, N s/m.
const FRONT: [f64; 2] = [110e3, 1150.0];
const REAR: [f64; 2] = [95e3, 900.0];

fn base([k, b]: [f64; 2], mass: f64) -> [f64; 2] {
    [(k / mass).ln(), (b / mass).ln()]
}

fn bike() -> Bike {
    Bike {
        mass_front_kg: Some(MASSES[0]),
        mass_rear_kg: Some(MASSES[1]),
        l_front_m: Some(0.808),
        l_rear_m: Some(0.293),
        ..Bike::default()
    }
}

/// Rate of a road (m/s) that is white up to 30 Hz at this speed, at steps of `step` (s).
fn road(steps: usize, step: f64, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let part = step / (step + 1.0 / (std::f64::consts::TAU * 30.0));
    let mut smooth = [0.0; 2];
    (0..steps)
        .map(|_| {
            smooth[0] += part * (0.9 * normal(&mut rng) - smooth[0]);
            smooth[1] += part * (smooth[0] - smooth[1]);
            smooth[1]
        })
        .collect()
}

/// A segment for laws that need its clock alone.
fn clock(steps: usize) -> Segment {
    Segment {
        start_s: 0.0,
        over: 3,
        step: 1.0 / 600.0,
        lead: super::record::Moved::default(),
        speed: vec![SPEED; steps],
        speed_rate: vec![0.0; steps],
        distance: (0..steps).map(|i| SPEED * i as f64 / 600.0).collect(),
        crank: vec![0.0; steps],
        double_crank: vec![[0.0, 1.0]; steps],
        stood: vec![0.0; steps],
        window: vec![1.0; steps],
        other: Vec::new(),
        measured: Vec::new(),
    }
}

fn model(effect: Option<(Kind, Place, Values)>) -> Model {
    let plain = Model::new(base(FRONT, MASSES[0]), base(REAR, MASSES[1]));
    match effect {
        Some((kind, place, values)) => plain.with(Term { kind, place }, values),
        None => plain,
    }
}

/// Acceleration of an axle on a road.
fn acceleration(model: &Model, axle: Axle, road: &[f64]) -> Vec<f64> {
    let mass = match axle {
        Axle::Front => MASSES[0],
        Axle::Rear => MASSES[1],
    };
    let segment = clock(road.len());
    let lanes = lanes(std::slice::from_ref(model), axle, 1.0 / mass);
    let scale = Scale {
        mass,
        ..Scale::TYPICAL
    };
    let law = Law {
        lanes: &lanes,
        scale: &scale,
        segment: &segment,
        rolled: 0.0,
        felt_after: segment.step,
    };
    let road: Vec<Lanes> = road.iter().map(|r| Lanes::all(*r)).collect();
    drive(&law, &road).a.iter().map(|a| a.0[0]).collect()
}

/// Both accelerometers at 200 Hz on one road for so many seconds, the rear one `late` (s).
fn ride(model: &Model, seconds: f64, late: f64, seed: u64) -> Ride {
    let steps = (600.0 * seconds) as usize;
    let fine = road(steps, 1.0 / 600.0, seed);
    let delay = (600.0 * (WHEELBASE / SPEED)).round() as usize;
    let rear: Vec<f64> = (0..steps)
        .map(|i| if i < delay { 0.0 } else { fine[i - delay] })
        .collect();
    let front = acceleration(model, Axle::Front, &fine);
    let rear = acceleration(model, Axle::Rear, &rear);
    let mut rng = ChaCha8Rng::seed_from_u64(seed + 1);
    let mut text = "t,a_f,a_r,v\n".to_owned();
    let lag = (600.0 * late).round() as usize;
    for i in (0..steps).step_by(3) {
        let [f, r] = [front[i], rear[i.saturating_sub(lag)]].map(|a| a + 0.05 * normal(&mut rng));
        // Where the rear wheel truly is, to a step of the fine clock.
        let v = WHEELBASE / (delay as f64 / 600.0);
        text += &format!("{:.4},{f:.5},{r:.5},{v}\n", i as f64 / 600.0);
    }
    read(
        text.as_bytes(),
        "ride.csv",
        &bike(),
        &ReadOptions::default(),
    )
    .unwrap()
}

fn diagnosed(ride: &Ride) -> Diagnosis {
    diagnose(ride, &bike(), None, &Silent).unwrap()
}

#[test]
fn the_road_comes_back_from_the_acceleration() {
    for effect in [
        None,
        Some((Kind::CubicStiffness, Place::Front, padded([2e9]))),
        Some((Kind::CoulombFriction, Place::Front, padded([30.0, 2e-3]))),
        Some((Kind::SprungMass, Place::Front, padded([0.4, 5.0, 0.3]))),
        Some((Kind::ViscoelasticTyre, Place::Front, padded([3e4, 0.03]))),
    ] {
        let model = model(effect);
        let road = road(3000, 1.0 / 600.0, 3);
        let a = acceleration(&model, Axle::Front, &road);
        let mut segment = clock(road.len());
        let integral = |x: &[f64]| -> Vec<f64> {
            let mut sum = 0.0;
            let mut before = 0.0;
            x.iter()
                .map(|x| {
                    sum += 0.5 / 600.0 * (x + before);
                    before = *x;
                    sum
                })
                .collect()
        };
        segment.lead.v = integral(&a);
        segment.lead.z = integral(&segment.lead.v);
        segment.lead.a = a;
        let lanes = lanes(std::slice::from_ref(&model), Axle::Front, 1.0 / MASSES[0]);
        let scale = Scale {
            mass: MASSES[0],
            ..Scale::TYPICAL
        };
        let law = Law {
            lanes: &lanes,
            scale: &scale,
            segment: &segment,
            rolled: 0.0,
            felt_after: segment.step,
        };
        let found = invert(&law);
        let mut off: f64 = 0.0;
        let mut all: f64 = 0.0;
        for i in 300..road.len() {
            let back = segment.lead.v[i] + found.w[i].0[0];
            off += (back - road[i]).powi(2);
            all += road[i].powi(2);
        }
        assert!(
            (off / all).sqrt() < 0.02,
            "{effect:?}: {}",
            (off / all).sqrt()
        );
    }
}

#[test]
fn two_plain_axles_lack_nothing_and_have_their_k_and_b() {
    let d = diagnosed(&ride(&model(None), 40.0, 0.0, 5));
    assert_eq!(d.verdict, Verdict::NothingMissing, "{}", d.sentence);
    assert!(d.effects.is_empty() && d.detectable.len() > 15);
    for (axle, [k, b]) in [(Axle::Front, FRONT), (Axle::Rear, REAR)] {
        let e = d.extended.get(axle).unwrap();
        assert!((e.k_n_m / k - 1.0).abs() < 0.01, "{axle} {}", e.k_n_m);
        assert!((e.b_n_s_m / b - 1.0).abs() < 0.03, "{axle} {}", e.b_n_s_m);
    }
}

#[test]
fn concealed_effects_are_named_at_their_axle() {
    for (kind, place, values) in [
        (Kind::CoulombFriction, Place::Rear, padded([30.0, 2e-3])),
        (Kind::CubicStiffness, Place::Front, padded([3e10])),
    ] {
        let d = diagnosed(&ride(&model(Some((kind, place, values))), 40.0, 0.0, 6));
        assert_eq!(d.verdict, Verdict::Named, "{}", d.sentence);
        let named: Vec<_> = d.effects.iter().map(|e| (e.id.as_str(), e.axle)).collect();
        assert_eq!(named, [(kind.id(), place)]);
        let found = d.effects[0].parameters.values().next().unwrap().value;
        assert!(
            (found / values[0] - 1.0).abs() < 0.2,
            "{found} instead of {}",
            values[0]
        );
        let axle = if place == Place::Front {
            Axle::Front
        } else {
            Axle::Rear
        };
        let surface = &d.evidence.get(axle).unwrap().surface;
        let law = |[d, w]: [f64; 2]| match kind {
            Kind::CoulombFriction => values[0] * w.signum(),
            _ => values[0] * d.powi(3),
        };
        let alike = alike(surface, law);
        assert!(alike > 0.9, "{kind:?}: {alike}");
    }
}

/// Correlation of a map of the missing force with a law of deflection (m) and rate (m/s).
fn alike(surface: &Surface, law: impl Fn([f64; 2]) -> f64) -> f64 {
    let mut sums = [0.0; 3];
    for (row, w) in surface.lacking_n.iter().zip(&surface.rate_m_s) {
        for (force, d) in row.iter().zip(&surface.deflection_m) {
            let (Some(force), law) = (force, law([*d, *w])) else {
                continue;
            };
            sums[0] += force * law;
            sums[1] += force * force;
            sums[2] += law * law;
        }
    }
    sums[0] / (sums[1] * sums[2]).sqrt()
}

/// A front tyre that relaxes slowly passes for a stiffer one.
#[test]
fn a_tyre_that_may_relax_has_no_stiffness() {
    let relaxing = (Kind::ViscoelasticTyre, Place::Front, padded([4e4, 0.06]));
    let d = diagnosed(&ride(&model(Some(relaxing)), 40.0, 0.0, 6));
    let e = d.extended.front.as_ref().unwrap();
    let known = (e.k_std_n_m).is_some_and(|std| (e.k_n_m - FRONT[0]).abs() < 3.0 * std);
    assert!(
        known || e.k_not_identifiable.is_some(),
        "{e:?}: {}",
        d.sentence
    );
}

#[test]
fn a_late_sensor_is_said_to_be_late() {
    let ride = ride(&model(None), 40.0, 8e-3, 7);
    let d = diagnosed(&ride);
    let late = d.effects.iter().find(|e| e.id == "sensor_delay").unwrap();
    assert_eq!(late.axle, Place::Rear);
    let delay = late.parameters["delay"].value;
    assert!((delay - 8e-3).abs() < 2e-3, "{delay}");
    let record = Record::new(&ride, WHEELBASE, Axle::Front).unwrap();
    assert!(Late::of(&record, &[]).is_none());
}

/// The rear's road is another one: nothing can be said.
#[test]
fn wheels_on_roads_of_their_own_carry_no_verdict() {
    let mut one = ride(&model(None), 30.0, 0.0, 8);
    let other = ride(&model(None), 30.0, 0.0, 9);
    let rear = |ride: &Ride| {
        ride.sensors
            .iter()
            .position(|s| s.axle == Axle::Rear)
            .unwrap()
    };
    let (at, from) = (rear(&one), rear(&other));
    one.sensors[at] = other.sensors[from].clone();
    let d = diagnosed(&one);
    assert_eq!(d.verdict, Verdict::CannotTell, "{}", d.sentence);
    assert!(
        d.effects.is_empty() && d.sentence.starts_with("No verdict: "),
        "{}",
        d.sentence
    );
}

#[test]
fn axles_that_are_alike_carry_no_verdict() {
    let alike = Model::new(base(FRONT, MASSES[0]), base(FRONT, MASSES[0]));
    let d = diagnosed(&ride(&alike, 30.0, 0.0, 10));
    assert_eq!(d.verdict, Verdict::CannotTell, "{}", d.sentence);
    assert!(d.sentence.contains("too similar"), "{}", d.sentence);
}
