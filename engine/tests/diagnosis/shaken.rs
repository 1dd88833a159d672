//! Benches: forces shake masses that the plain model does not know of.

use super::*;

/// Steps of a bench's motion for each sample.
const FINE: usize = 200;

/// The ride with a front axle alone, on ground at rest: what force shook it, and where it was.
fn bench(mut ride: Ride, force: Vec<f64>, positions: Vec<f64>, seed: u64) -> Ride {
    let still = AxleRecord {
        road: vec![0.0; force.len()],
        force: Some(force),
        ..ride.axles.front.take().unwrap()
    };
    ride.axles.front = Some(logged(
        &still,
        positions.into_iter(),
        &mut Normal::new(seed),
    ));
    ride.axles.rear = None;
    ride
}

/// Half a minute of a front axle that sines up to 20 Hz shake, its ground at rest. Two masses move with the
/// accelerations `pull` (force, z, z', s, s'); the sensor is on the first. Semi-implicit Euler at 200 times the rate.
fn shaken(pull: impl Fn(f64, [f64; 4]) -> [f64; 2]) -> Ride {
    let ride = half_a_minute();
    let sines = |t: f64| {
        (1..=60)
            .map(|i| (f64::from(i * i) + TAU * f64::from(i) * t / 3.0).sin())
            .sum::<f64>()
    };
    let force: Vec<f64> = (0..ride.samples)
        .map(|i| 40.0 * sines(ride.step_s * i as f64))
        .collect();
    let pushed = lifted(&force);
    let slope = slopes(&pushed, ride.step_s);
    let h = ride.step_s / FINE as f64;
    let mut x = [0.0; 4];
    let mut positions = Vec::new();
    for i in 0..force.len() {
        positions.push(x[0]);
        let j = (i + 1).min(force.len() - 1);
        let f = cubic(pushed[i], pushed[j], slope[i], slope[j], ride.step_s);
        for sub in 0..FINE {
            let s = (sub as f64 + 0.5) / FINE as f64;
            let [a, b] = pull(f[0] + s * (f[1] + s * (f[2] + s * f[3])), x);
            x[1] += h * a;
            x[3] += h * b;
            x[0] += h * x[1];
            x[2] += h * x[3];
        }
    }
    bench(ride, force, positions, 5)
}

/// A drive without a spring that carries another mass: it drifts by far more than that mass moves it, and noise of
/// its own colour passes for what is left.
#[test]
#[ignore = "slow"]
fn val_a_second_mass_on_a_drive_without_a_spring_is_found() {
    for zeta in [0.01, 0.1] {
        let (share, omega) = (0.375, TAU * 8.7);
        let d = diagnosed(&shaken(|force, [z, v, s, sv]| {
            let pull = omega * omega * (z - s) + 2.0 * zeta * omega * (v - sv);
            let first = force - 60.0 * v - share * MASS * pull;
            [first / ((1.0 - share) * MASS), pull]
        }));
        let names: Vec<_> = d.effects.iter().map(|e| e.id.as_str()).collect();
        assert_eq!(names, ["sprung_mass"], "{zeta}: {}", d.sentence);
        assert_eq!(d.verdict, Verdict::Named, "{zeta}: {}", d.sentence);
        let found = d.effects[0].parameters["mass_fraction"].value;
        assert!((found - share).abs() < 0.02 * share, "{zeta}: {found}");
    }
}

/// A closed-loop drive without a spring, whose dry friction falls with the rate: a general curve explains more, but
/// friction alone takes nearly everything off the held-out error.
#[test]
#[ignore = "slow"]
fn val_friction_keeps_its_name_beside_what_is_small() {
    let ride = half_a_minute();
    let h = ride.step_s / FINE as f64;
    let (mut z, mut v, mut force) = (0.0, 0.0, vec![0.0]);
    let mut positions = Vec::new();
    for i in 0..ride.samples {
        let t = ride.step_s * i as f64;
        let aim = 0.1 * (TAU * 0.4 * t).sin() + 0.05 * (TAU * 1.3 * t + 1.0).sin();
        positions.push(z);
        force.push(20e3 * (aim - z) - 2e3 * v);
        for sub in 0..FINE {
            let s = (sub as f64 + 0.5) / FINE as f64;
            let push = force[i] + s * (force[i + 1] - force[i]) - 60.0 * v;
            let free = v + h * push / MASS;
            let friction = h * (200.0 + 10.0 * (-free.abs() / 0.1).exp()) / MASS;
            v = free.signum() * (free.abs() - friction).max(0.0);
            z += h * v;
        }
    }
    force.truncate(ride.samples);
    let d = diagnosed(&bench(ride, force, positions, 6));
    let names: Vec<_> = d.effects.iter().map(|e| e.id.as_str()).collect();
    assert_eq!(names, ["coulomb_friction"], "{}", d.sentence);
    assert_eq!(d.verdict, Verdict::Named, "{}", d.sentence);
    let found = d.effects[0].parameters["friction"].value;
    assert!((found - 205.0).abs() < 8.0, "{found}");
}

/// The sensor sits on another mass than the force: the residual is as narrow as noise of some colour may be.
#[test]
#[ignore = "slow"]
fn a_spring_between_force_and_sensor_gets_no_name() {
    let (upper, lower) = (25.0, 15.0);
    let d = diagnosed(&shaken(|force, [z, v, s, sv]| {
        let spring = 30e3 * (s - z) + 40.0 * (sv - v);
        [
            spring / upper,
            (force - spring - 40e3 * s - 100.0 * sv) / lower,
        ]
    }));
    assert_eq!(d.verdict, Verdict::Unnamed, "{}", d.sentence);
}

/// A sled on guides, which a chirp as large as a motor allows pushes against dry friction: it often stands, and a spring would take
/// the friction's place. What is searched without one names the friction.
#[test]
#[ignore = "slow"]
fn val_a_sled_without_a_spring_has_friction() {
    let ride = half_a_minute();
    let h = ride.step_s / FINE as f64;
    let push = |t: f64| 6.5 * MASS * (TAU * (0.2 + 0.1 * t) * t).sin();
    let (friction, rate) = (4.8 * MASS, 7.0 * MASS);
    let (mut z, mut v) = (0.0_f64, 0.0_f64);
    let mut positions = Vec::new();
    for i in 0..ride.samples {
        positions.push((1e4 * z).round() / 1e4);
        for sub in 0..FINE {
            let t = ride.step_s * (i as f64 + (sub as f64 + 0.5) / FINE as f64);
            let free = v + h * (push(t) - rate * v - 0.25 * MASS) / MASS;
            v = free.signum() * (free.abs() - h * friction / MASS).max(0.0);
            z += h * v;
        }
    }
    let force = (0..ride.samples).map(|i| push(ride.step_s * i as f64));
    let d = diagnosed(&bench(ride.clone(), force.collect(), positions, 17));
    assert_eq!(d.base, Base::Damper, "{}", d.sentence);
    assert_named_alone(&d, "coulomb_friction");
    let reported = &d.effects[0].parameters["friction"];
    assert!(
        (reported.value - friction).abs() < 0.05 * friction,
        "{reported:?}"
    );
    let extended = d.extended.front.unwrap();
    assert_eq!((extended.k_n_m, extended.k_std_n_m), (0.0, None));
    assert!((extended.b_n_s_m - rate).abs() < 0.1 * rate, "{extended:?}");
}
