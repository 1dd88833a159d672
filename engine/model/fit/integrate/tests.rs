//! The integrator against motions that are known in closed form.

use nalgebra::{Matrix4, Vector4};

use super::{AxleLanes, EffectLanes, Motions, run};
use crate::dataset::{Dataset, Track};
use crate::effects::Kind;
use crate::law::{MAX_OWN_STATES, MAX_PARAMETERS, Values, padded};
use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_core::numerics::lanes::{LANES, Lanes};
use veloid_core::plant::{Coefficients, PlantRef};
use veloid_methods::output_error::AxleFit;
use veloid_ride::{AxleRecord, Ride};

const TAU: f64 = std::f64::consts::TAU;
/// Sample interval (s), of which an axle turns through 0.9 rad, and samples.
const STEP_S: f64 = 0.02;
const SAMPLES: usize = 40;

/// k/m and B/m of an axle of 30 kg on 60 kN/m and 300 N s/m.
const KAPPA: f64 = 2000.0;
const BETA: f64 = 10.0;

/// Both axles over this road (m), as a sensor records it.
fn dataset(road: impl Fn(f64) -> f64) -> Dataset {
    let record = AxleRecord {
        road: (0..SAMPLES).map(|i| road(i as f64 * STEP_S)).collect(),
        force: None,
        displacement: vec![0.0; SAMPLES],
        acceleration: None,
        valid: vec![true; SAMPLES],
        prescribed: false,
        plant: PlantRef::default(),
        band: None,
    };
    let plain = Coefficients {
        kappa: KAPPA,
        beta: BETA,
        per_mass: 1.0 / 30.0,
        ..Coefficients::default()
    };
    let ride = Ride {
        step_s: STEP_S,
        samples: SAMPLES,
        axles: PerAxle {
            front: Some(record.clone()),
            rear: Some(record),
        },
        ..Ride::default()
    };
    let bike = Bike {
        mass_front_kg: Some(24.0),
        mass_rear_kg: Some(64.0),
        l_front_m: Some(0.8),
        l_rear_m: Some(0.3),
        ..Bike::default()
    };
    let mut fits = PerAxle::default();
    for axle in [Axle::Front, Axle::Rear] {
        fits.set(axle, AxleFit::exact(plain, SAMPLES));
    }
    Dataset::new(&ride, &bike, &fits, SAMPLES)
}

/// An axle that starts from a height (m) and velocity (m/s), each lane from its own share of them.
fn axle([kappa, beta]: [f64; 2], start: [f64; 2], effect: Option<(Kind, Values)>) -> AxleLanes {
    let [z, v] = start.map(|x| Lanes(std::array::from_fn(|lane| share(lane) * x)));
    let [kappa, beta, per_mass] = [kappa, beta, 1.0 / 30.0].map(Lanes::all);
    AxleLanes {
        base: Coefficients {
            kappa,
            beta,
            per_mass,
            constant: Lanes::ZERO,
            height: z,
            velocity: v,
        },
        effects: (effect.into_iter())
            .map(|(kind, values)| EffectLanes {
                kind,
                values: values.map(Lanes::all),
                initial: [Lanes::ZERO; MAX_OWN_STATES],
            })
            .collect(),
    }
}

fn share(lane: usize) -> f64 {
    1.0 - 0.2 * lane as f64
}

fn integrated(
    dataset: &Dataset,
    axles: &[AxleLanes],
    coupling: Option<f64>,
    substeps: usize,
) -> Vec<Motions> {
    let axles: Vec<(&Track, &AxleLanes)> = dataset.tracks.iter().zip(axles).collect();
    let coupling = coupling.map(Lanes::all);
    run(
        dataset,
        &axles,
        coupling.as_ref(),
        0..SAMPLES,
        substeps,
        true,
    )
}

/// Checks that the largest error of the heights falls with the fourth power of the step. `truth` says the height (m) of axle `a`
/// in a lane after `t` seconds.
#[track_caller]
fn is_of_fourth_order(
    dataset: &Dataset,
    axles: &[AxleLanes],
    coupling: Option<f64>,
    truth: impl Fn(usize, usize, f64) -> f64,
) {
    let error = |substeps: usize| {
        let motions = integrated(dataset, axles, coupling, substeps);
        assert_eq!(motions.len(), axles.len());
        let mut error: f64 = 0.0;
        for (a, motion) in motions.iter().enumerate() {
            assert_eq!(motion.z.len(), SAMPLES);
            for (i, z) in motion.z.iter().enumerate() {
                for lane in 0..LANES {
                    error = error.max((z.0[lane] - truth(a, lane, i as f64 * STEP_S)).abs());
                }
            }
        }
        error
    };
    let errors = [4, 8, 16].map(error);
    for pair in errors.windows(2) {
        let ratio = pair[0] / pair[1];
        assert!((12.0..20.0).contains(&ratio), "{ratio}, errors {errors:?}");
    }
}

/// Of x'' + BETA x' + KAPPA x = 0 from a height and a velocity.
fn free([x, v]: [f64; 2], t: f64) -> f64 {
    let decay = 0.5 * BETA;
    let turn = f64::sqrt(KAPPA - decay * decay);
    f64::exp(-decay * t) * (x * f64::cos(turn * t) + (v + decay * x) / turn * f64::sin(turn * t))
}

#[test]
fn a_free_swing_is_met_to_the_fourth_order() {
    let axles = [axle([KAPPA, BETA], [0.01, -0.2], None)];
    is_of_fourth_order(&dataset(|_| 0.0), &axles, None, |_, lane, t| {
        free([0.01 * share(lane), -0.2 * share(lane)], t)
    });
}

/// A cubic is its own spline. Over u = 0.3 t - 0.9 t^2 + 0.8 t^3 the axle is e above the road, e'' + BETA e' + KAPPA e = -u'',
/// of which a solution is e = p t + q.
#[test]
fn a_road_that_its_spline_meets_is_followed_to_the_fourth_order() {
    let road = |t: f64| 0.3 * t - 0.9 * t * t + 0.8 * t * t * t;
    let p = -4.8 / KAPPA;
    let q = (1.8 - BETA * p) / KAPPA;
    let axles = [axle([KAPPA, BETA], [0.01, 0.1], None)];
    is_of_fourth_order(&dataset(road), &axles, None, |_, lane, t| {
        let [z, v] = [0.01 * share(lane), 0.1 * share(lane)];
        road(t) + p * t + q + free([z - q, v - 0.3 - p], t)
    });
}

/// The motion of four states after `t` seconds.
fn linear(rates: Matrix4<f64>, start: [f64; 4], t: f64) -> Vector4<f64> {
    (rates * t).exp() * Vector4::from(start)
}

/// 0.2 of the mass at 4 Hz above the axle: z'' is moved by the tyre and what the other pulls, over 0.8 of the mass.
#[test]
fn an_axle_that_carries_a_mass_is_met_to_the_fourth_order() {
    let own = 4.0 * TAU;
    let [spring, damping] = [own * own, 2.0 * 0.1 * own];
    let r = 0.2 / 0.8;
    #[rustfmt::skip]
    let rates = Matrix4::new(
        0.0, 1.0, 0.0, 0.0,
        -KAPPA / 0.8 - r * spring, -BETA / 0.8 - r * damping, r * spring, r * damping,
        0.0, 0.0, 0.0, 1.0,
        spring, damping, -spring, -damping,
    );
    holds_of_two_masses(Kind::SprungMass, padded([0.2, 4.0, 0.1]), rates);
}

/// The same from below: the tyre moves 0.2 of the mass, which carries the rest at 4 Hz.
#[test]
fn an_axle_that_stands_on_a_wheel_is_met_to_the_fourth_order() {
    let own = 4.0 * TAU;
    let [spring, damping] = [own * own, 2.0 * 0.1 * own];
    let r = 0.8 / 0.2;
    #[rustfmt::skip]
    let rates = Matrix4::new(
        0.0, 1.0, 0.0, 0.0,
        -spring, -damping, spring, damping,
        0.0, 0.0, 0.0, 1.0,
        r * spring, r * damping, -KAPPA / 0.2 - r * spring, -BETA / 0.2 - r * damping,
    );
    holds_of_two_masses(Kind::UnsprungMass, padded([0.2, 4.0, 0.1]), rates);
}

/// Of an axle with a second mass, which starts with it.
#[track_caller]
fn holds_of_two_masses(kind: Kind, values: Values, rates: Matrix4<f64>) {
    let [z, v] = [0.01, -0.2];
    let axles = [axle([KAPPA, BETA], [z, v], Some((kind, values)))];
    is_of_fourth_order(&dataset(|_| 0.0), &axles, None, |_, lane, t| {
        share(lane) * linear(rates, [z, v, z, v], t)[0]
    });
}

/// z_F'' = F_F (1/m + l_F^2/I) + F_R (1/m - l_F l_R/I), z_R'' likewise, with m = 88 kg, l_F = 0.8 m, l_R = 0.3 m.
#[test]
fn axles_that_push_each_other_are_met_to_the_fourth_order() {
    for coupling in [0.5, -0.3] {
        let inertia = 88.0 * 0.8 * 0.3 / (1.0 + coupling);
        let [front, rear] = [[1800.0, 8.0], [1200.0, 15.0]];
        let cross = 1.0 / 88.0 - 0.8 * 0.3 / inertia;
        let own = [0.8, 0.3].map(|l| 1.0 / 88.0 + l * l / inertia);
        let [f, r] = [front.map(|x| -24.0 * x), rear.map(|x| -64.0 * x)];
        #[rustfmt::skip]
        let rates = Matrix4::new(
            0.0, 1.0, 0.0, 0.0,
            own[0] * f[0], own[0] * f[1], cross * r[0], cross * r[1],
            0.0, 0.0, 0.0, 1.0,
            cross * f[0], cross * f[1], own[1] * r[0], own[1] * r[1],
        );
        let mut values = [0.0; MAX_PARAMETERS];
        values[0] = coupling;
        let effect = Some((Kind::PitchCoupling, values));
        let axles = [
            axle(front, [0.01, 0.0], effect),
            axle(rear, [-0.004, 0.1], effect),
        ];
        let dataset = dataset(|_| 0.0);
        is_of_fourth_order(&dataset, &axles, Some(coupling), |a, lane, t| {
            share(lane) * linear(rates, [0.01, 0.0, -0.004, 0.1], t)[2 * a]
        });
    }
}

#[test]
fn accelerations_are_those_that_the_forces_give() {
    let axles = [axle([KAPPA, BETA], [0.01, -0.2], None)];
    let motion = &integrated(&dataset(|_| 0.0), &axles, None, 2)[0];
    for i in 0..SAMPLES {
        for lane in 0..LANES {
            let [z, v, a] = [&motion.z, &motion.v, &motion.a].map(|x| x[i].0[lane]);
            let truth = -KAPPA * z - BETA * v;
            assert!((a - truth).abs() < 1e-10, "{a} instead of {truth}");
        }
    }
}
