#![allow(clippy::unwrap_used)]
use super::*;
use crate::simulate::simulated_ride::{Motion, SimulatedRide};

fn observed(motion: &Motion, y: &[f64]) -> (States, f64) {
    let f = jerk_bound(y, &vec![true; y.len()], 0.01);
    assert_eq!(motion.displacement.len(), y.len());
    let [states] = differentiate([y], [f], 0.01);
    (states, f)
}

fn largest(a: &[f64], b: &[f64], from: usize) -> f64 {
    let to = a.len() - 1;
    a[from..to]
        .iter()
        .zip(&b[from..to])
        .fold(0.0, |m, (a, b)| m.max((a - b).abs()))
}

/// The paper's own claims: displacement within 1 mm, velocity within 0.06 m/s.
#[test]
fn noisy_ride_is_observed_as_the_paper_claims() {
    for seed in 0..5 {
        let simulated_ride = SimulatedRide {
            noise_displacement_m: 5e-5,
            seed,
            ..SimulatedRide::default()
        };
        let ride = simulated_ride.ride();
        for (axle, motion) in simulated_ride.motion().iter() {
            let y = &ride.axles.get(axle).unwrap().displacement;
            let (states, f) = observed(motion, y);
            let (p, v, a) = (
                largest(&states.position, &motion.displacement, 100),
                largest(&states.velocity, &motion.velocity, 100),
                largest(&states.acceleration, &motion.acceleration, 100),
            );
            println!("{axle} f {f:.0}: {p:.2e} m, {v:.4} m/s, {a:.2} m/s^2");
            assert!(
                p < 1e-3 && v < 0.04 && a < 15.0,
                "{axle}: {p} m, {v} m/s, {a} m/s^2"
            );
        }
    }
}

/// Without noise only the differences' own attenuation is left: no chatter, no lag.
#[test]
fn clean_ride_is_observed_without_chatter() {
    for (axle, motion) in SimulatedRide::default().motion().iter() {
        let (states, f) = observed(motion, &motion.displacement);
        let (p, v, a) = (
            largest(&states.position, &motion.displacement, 100),
            largest(&states.velocity, &motion.velocity, 100),
            largest(&states.acceleration, &motion.acceleration, 100),
        );
        println!("{axle} f {f:.0}: {p:.2e} m, {v:.4} m/s, {a:.2} m/s^2");
        assert!(
            p < 1e-12 && v < 0.01 && a < 2.0,
            "{axle}: {p} m, {v} m/s, {a} m/s^2"
        );
    }
}

/// From wrong velocity and acceleration the errors vanish after a finite time and stay away.
#[test]
fn converges_in_finite_time() {
    let step = 0.01;
    let exact = |t: f64| 0.3 + 2.0 * t - 1.5 * t * t;
    let y: Vec<f64> = (0..400).map(|i| exact(i as f64 * step)).collect();
    let mut before = usize::MAX;
    for f in [50.0, 400.0, 3200.0] {
        let [states] = differentiate([y.as_slice()], [f], step);
        let wrong = |i: usize| {
            let t = i as f64 * step;
            (states.position[i] - y[i]).abs() > 1e-10
                || (states.velocity[i] - (2.0 - 3.0 * t)).abs() > 1e-8
                || (states.acceleration[i] + 3.0).abs() > 1e-6
        };
        let last = (0..399).rev().find(|i| wrong(*i)).unwrap();
        assert!(last < 150, "f {f}: still wrong at {last}");
        assert!(last < before, "a larger f is to converge faster");
        before = last;
    }
}

/// The implicit step solves its own equation.
#[test]
fn root_solves_the_cubic() {
    for rho in [1.1, 1.1 + 1e-9, 1.2, 2.0, 7.0, 100.0, 1e6, 1e12] {
        let q = root(rho);
        let value = q * q * q + GAINS[0] * q * q + GAINS[1] * GAINS[0].sqrt() * q + GAINS[2];
        assert!((value / rho - 1.0).abs() < 1e-9, "{rho}: {q}");
    }
}

/// One implicit step against the plain form of eq. (12), solved by bisection.
#[test]
fn val_step_is_the_implicit_form_of_the_paper() {
    let (f, h) = (700.0_f64, 0.005);
    let (l0, l1, l2) = (3.0 * f.powf(1.0 / 3.0), 1.2 * f.sqrt(), 1.1 * f);
    for y in [0.1, 0.0101, -0.02, 0.0100003] {
        let mut lanes = Lanes::<1>::new([0.01], [f], h);
        (lanes.x2, lanes.x3) = ([0.02], [-1.0]);
        lanes.advance([y]);
        // v2 and v3 are the corrections of the line above, so they carry v1's sign.
        let after = |v1: f64| {
            let v2 = l0 * v1.abs().powf(2.0 / 3.0);
            let v3 = l1 * v2.sqrt();
            let x3 = -1.0 - h * l2 * v1.signum();
            let x2 = 0.02 + h * (x3 - v3 * v1.signum());
            (0.01 + h * (x2 - v2 * v1.signum()) - y, x2, x3)
        };
        let (mut low, mut high) = (-1.0_f64, 1.0);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if after(middle).0 > middle {
                low = middle
            } else {
                high = middle
            }
        }
        assert!((lanes.x1[0] - y - low).abs() < 1e-12);
        if low.abs() > 1e-12 {
            let (_, x2, x3) = after(low);
            assert!((lanes.x2[0] - x2).abs() < 1e-9 && (lanes.x3[0] - x3).abs() < 1e-9);
        }
    }
}

#[test]
fn lanes_do_not_mix() {
    let motion = SimulatedRide {
        duration_s: 5.0,
        ..SimulatedRide::default()
    }
    .motion();
    let (f, r) = (
        motion.front.unwrap().displacement,
        motion.rear.unwrap().displacement,
    );
    let [a, b] = differentiate([f.as_slice(), &r], [900.0, 300.0], 0.01);
    let [alone] = differentiate([f.as_slice()], [900.0], 0.01);
    assert_eq!(a, alone);
    let four = [(f.as_slice(), 900.0), (&r, 300.0), (&f, 70.0), (&r, 900.0)];
    let all = differentiate_all(&four, 0.01);
    assert_eq!((&all[0], &all[1]), (&a, &b));
    assert_eq!(follow([f.as_slice()], [70.0], 0.01)[0], all[2]);
    assert_ne!(a, b);
}
