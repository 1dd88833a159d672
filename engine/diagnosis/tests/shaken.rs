//! Benches: forces shake masses that the plain model does not know of.

use super::*;

/// Half a minute of a front axle that sines up to 20 Hz shake, its ground at rest. Two masses move with the
/// accelerations `pull` (force, z, z', s, s'); the sensor is on the first. Semi-implicit Euler at 200 times the rate.
fn shaken(pull: impl Fn(f64, [f64; 4]) -> [f64; 2]) -> Ride {
    const FINE: usize = 200;
    let mut ride = Outing {
        duration_s: 30.0,
        ..Outing::default()
    }
    .ride();
    let sines = |t: f64| {
        (1..=60)
            .map(|i| (f64::from(i * i) + TAU * f64::from(i) * t / 3.0).sin())
            .sum::<f64>()
    };
    let record = ride.axles.front.take().unwrap();
    let force: Vec<f64> = (0..ride.samples)
        .map(|i| 40.0 * sines(ride.step_s * i as f64))
        .collect();
    let slope = slopes(&force, ride.step_s);
    let h = ride.step_s / FINE as f64;
    let mut x = [0.0; 4];
    let mut positions = Vec::new();
    for i in 0..force.len() {
        positions.push(x[0]);
        let j = (i + 1).min(force.len() - 1);
        let f = cubic(force[i], force[j], slope[i], slope[j], ride.step_s);
        for sub in 0..FINE {
            let s = (sub as f64 + 0.5) / FINE as f64;
            let [a, b] = pull(f[0] + s * (f[1] + s * (f[2] + s * f[3])), x);
            x[1] += h * a;
            x[3] += h * b;
            x[0] += h * x[1];
            x[2] += h * x[3];
        }
    }
    let still = AxleRecord {
        road: vec![0.0; force.len()],
        force: Some(force),
        ..record
    };
    ride.axles.front = Some(logged(&still, positions.into_iter(), &mut Normal::new(5)));
    ride.axles.rear = None;
    ride
}

/// A drive without a spring that carries a lightly damped mass: it drifts by far more than that mass moves it, and noise of
/// its own colour passes for what is left.
#[test]
fn a_second_mass_on_a_drive_without_a_spring_is_no_noise() {
    let (share, omega, zeta) = (0.375, TAU * 8.7, 0.01);
    let d = diagnosed(&shaken(|force, [z, v, s, sv]| {
        let pull = omega * omega * (z - s) + 2.0 * zeta * omega * (v - sv);
        let first = force - 60.0 * v - share * MASS * pull;
        [first / ((1.0 - share) * MASS), pull]
    }));
    assert_ne!(d.verdict, Verdict::NothingMissing, "{}", d.sentence);
    let mut names = d.effects.iter().map(|e| e.id.as_str());
    assert!(names.all(|id| id == "sprung_mass"), "{}", d.sentence);
}

/// The sensor sits on another mass than the force: the residual is as narrow as noise of some colour may be.
#[test]
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
