//! Classical Runge-Kutta of fourth order with a fixed step, on the grid of the drive.

use super::drive::Drive;
use super::vehicle::{State, Vehicle};

/// z, z' and z'' of both axles on the step grid.
#[derive(Clone, Debug)]
pub struct Motion {
    pub start_s: f64,
    pub step_s: f64,
    pub z: [Vec<f64>; 2],
    pub z_rate: [Vec<f64>; 2],
    pub z_acceleration: [Vec<f64>; 2],
}

/// Integrates over the whole drive, or to `until_s`; axles that are not active stay at rest.
pub fn integrate(
    vehicle: &Vehicle,
    drive: &Drive,
    from: State,
    active: [bool; 2],
    until_s: f64,
) -> Motion {
    let step = 2.0 * drive.half_s;
    let whole = drive.len() / 2;
    let steps = (((until_s - drive.start_s) / step).ceil().max(0.0) as usize).min(whole);
    let mut motion = Motion {
        start_s: drive.start_s,
        step_s: step,
        z: [0, 1].map(|_| Vec::with_capacity(steps + 1)),
        z_rate: [0, 1].map(|_| Vec::with_capacity(steps + 1)),
        z_acceleration: [0, 1].map(|_| Vec::with_capacity(steps + 1)),
    };
    let used = [0, 1].map(|axle| {
        if active[axle] {
            vehicle.states(axle)
        } else {
            0
        }
    });
    let mut state = from;
    let mut next = drive.at(0);
    for i in 0..=steps {
        let k1 = vehicle.derivative(&next, &state, active);
        for (axle, own) in state.iter().enumerate() {
            motion.z[axle].push(own[0]);
            motion.z_rate[axle].push(own[1]);
            motion.z_acceleration[axle].push(k1[axle][1]);
        }
        if i == steps {
            break;
        }
        let middle = drive.at(2 * i + 1);
        next = drive.at(2 * i + 2);
        let moved = |rate: &State, by: f64| sum(&state, rate, by, used);
        let k2 = vehicle.derivative(&middle, &moved(&k1, step / 2.0), active);
        let k3 = vehicle.derivative(&middle, &moved(&k2, step / 2.0), active);
        let k4 = vehicle.derivative(&next, &moved(&k3, step), active);
        for axle in 0..2 {
            for n in 0..used[axle] {
                state[axle][n] +=
                    step / 6.0 * (k1[axle][n] + 2.0 * (k2[axle][n] + k3[axle][n]) + k4[axle][n]);
            }
        }
    }
    motion
}

fn sum(state: &State, rate: &State, by: f64, used: [usize; 2]) -> State {
    let mut out = *state;
    for axle in 0..2 {
        for n in 0..used[axle] {
            out[axle][n] += by * rate[axle][n];
        }
    }
    out
}

impl Motion {
    /// z at any time by the cubic through z and z'; clamped at the ends.
    pub fn position(&self, axle: usize, t: f64) -> f64 {
        let z = &self.z[axle];
        let at = ((t - self.start_s) / self.step_s).clamp(0.0, (z.len() - 1) as f64);
        let i = (at as usize).min(z.len().saturating_sub(2));
        let s = at - i as f64;
        let (a, b) = (z[i], z[i + 1]);
        let (p, q) = (
            self.z_rate[axle][i] * self.step_s,
            self.z_rate[axle][i + 1] * self.step_s,
        );
        a + s * (p + s * (3.0 * (b - a) - 2.0 * p - q + s * (2.0 * (a - b) + p + q)))
    }

    /// z'' at any time, by the second difference over a step to both sides.
    pub fn acceleration(&self, axle: usize, t: f64) -> f64 {
        let h = self.step_s;
        let [before, here, after] = [t - h, t, t + h].map(|t| self.position(axle, t));
        (before - 2.0 * here + after) / (h * h)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::drive::{STEP_S, Wave};
    use crate::simulate::effect::{Axle, Effect, Kind};
    use crate::simulate::vehicle::{Bike, STATES};

    const OMEGA: f64 = std::f64::consts::TAU * 6.0;

    fn bike() -> Bike {
        Bike {
            mass_kg: [23.0, 63.0],
            arm_m: [1.101 * 63.0 / 86.0, 1.101 * 23.0 / 86.0],
            wheel_radius_m: [0.34; 2],
            stiffness_n_m: [90e3, 110e3],
            damping_n_s_m: [300.0, 700.0],
        }
    }

    fn run(effects: Vec<Effect>, drive: &Drive, from: State) -> Motion {
        let vehicle = Vehicle {
            effects,
            ..Vehicle::plain(bike())
        };
        integrate(&vehicle, drive, from, [true, true], f64::INFINITY)
    }

    fn sine_ground(seconds: f64) -> Drive {
        let mut drive = Drive::empty(0.0, STEP_S, (seconds / STEP_S) as usize);
        for axle in 0..2 {
            drive.shake_ground(axle, &Wave::Multisine(vec![(2e-3, OMEGA, 0.0)]));
        }
        drive
    }

    /// Amplitude and phase of the last fifteen periods (a whole number of steps), as a complex number.
    fn phasor(motion: &Motion, axle: usize) -> (f64, f64) {
        let n = (15.0 * std::f64::consts::TAU / OMEGA / motion.step_s).round() as usize;
        let z = &motion.z[axle];
        let first = z.len() - n;
        let sum = |f: &dyn Fn(f64) -> f64| {
            2.0 / n as f64
                * (first..z.len())
                    .map(|i| z[i] * f(OMEGA * (motion.start_s + i as f64 * motion.step_s)))
                    .sum::<f64>()
        };
        (sum(&f64::sin), sum(&f64::cos))
    }

    /// (a + i b) / (c + i d) times 2 mm.
    fn ratio(a: f64, b: f64, c: f64, d: f64) -> (f64, f64) {
        let n = c * c + d * d;
        (2e-3 * (a * c + b * d) / n, 2e-3 * (b * c - a * d) / n)
    }

    fn close(got: (f64, f64), expected: (f64, f64)) {
        let error = ((got.0 - expected.0).powi(2) + (got.1 - expected.1).powi(2)).sqrt();
        assert!(error < 2e-8, "{got:?} against {expected:?}: {error} m");
    }

    #[test]
    fn plain_steady_state_is_the_transfer_function() {
        let motion = run(vec![], &sine_ground(10.0), [[0.0; STATES]; 2]);
        for axle in 0..2 {
            let b = bike();
            let (k, c) = (b.stiffness_n_m[axle], b.damping_n_s_m[axle] * OMEGA);
            close(
                phasor(&motion, axle),
                ratio(k, c, k - b.mass_kg[axle] * OMEGA * OMEGA, c),
            );
        }
    }

    #[test]
    fn accelerations_integrate_to_the_rates() {
        let friction = Effect::new(Kind::CoulombFriction, Axle::Front, &[20.0]);
        let rider = Effect::new(Kind::SprungMass, Axle::Rear, &[0.4, 5.0, 0.3]);
        let motion = run(vec![friction, rider], &sine_ground(2.0), [[0.0; STATES]; 2]);
        for axle in 0..2 {
            let a = &motion.z_acceleration[axle];
            let v = &motion.z_rate[axle];
            assert_eq!(a.len(), v.len());
            let mut sum = 0.0;
            for i in 1..a.len() {
                sum += motion.step_s / 2.0 * (a[i - 1] + a[i]);
                assert!((sum - v[i]).abs() < 2e-5, "{sum} and {} m/s", v[i]);
            }
        }
    }

    #[test]
    fn viscoelastic_and_ground_damping_are_their_transfer_functions() {
        let (k1, tau, cg) = (30e3, 0.02, 200.0);
        let effects = vec![
            Effect::new(Kind::ViscoelasticTyre, Axle::Front, &[k1, tau]),
            Effect::new(Kind::GroundDamping, Axle::Front, &[cg]),
        ];
        let motion = run(effects, &sine_ground(10.0), [[0.0; STATES]; 2]);
        let x = OMEGA * tau;
        let (re, im) = (
            90e3 + k1 * x * x / (1.0 + x * x),
            300.0 * OMEGA + k1 * x / (1.0 + x * x),
        );
        close(
            phasor(&motion, 0),
            ratio(re, im, re - 23.0 * OMEGA * OMEGA, im + cg * OMEGA),
        );
    }

    #[test]
    fn a_sprung_mass_adds_its_apparent_mass() {
        let (mu, f, zeta) = (0.3, 5.0, 0.3);
        let motion = run(
            vec![Effect::new(Kind::SprungMass, Axle::Front, &[mu, f, zeta])],
            &sine_ground(10.0),
            [[0.0; STATES]; 2],
        );
        let wn = std::f64::consts::TAU * f;
        // Transmissibility of the rider, then m_apparent = (1 - mu) m + mu m T.
        let (a, b) = (wn * wn, 2.0 * zeta * wn * OMEGA);
        let (c, n) = (a - OMEGA * OMEGA, (a - OMEGA * OMEGA).powi(2) + b * b);
        let (tr, ti) = ((a * c + b * b) / n, (b * c - a * b) / n);
        let (mr, mi) = (23.0 * (1.0 - mu + mu * tr), 23.0 * mu * ti);
        let (k, c) = (90e3, 300.0 * OMEGA);
        close(
            phasor(&motion, 0),
            ratio(k, c, k - mr * OMEGA * OMEGA, c - mi * OMEGA * OMEGA),
        );
    }

    #[test]
    fn an_unsprung_mass_is_two_stages_in_series() {
        let (mu, f, zeta) = (0.1, 15.0, 0.2);
        let motion = run(
            vec![Effect::new(Kind::UnsprungMass, Axle::Front, &[mu, f, zeta])],
            &sine_ground(10.0),
            [[0.0; STATES]; 2],
        );
        let (upper, wheel, wn) = (23.0 * (1.0 - mu), 23.0 * mu, std::f64::consts::TAU * f);
        use nalgebra::{Complex, Matrix2, Vector2};
        let i = Complex::new(0.0, 1.0);
        let s = Complex::new(upper * wn * wn, 0.0) + i * (2.0 * zeta * upper * wn * OMEGA);
        let t = Complex::new(90e3, 300.0 * OMEGA);
        let matrix = Matrix2::new(
            s - upper * OMEGA * OMEGA,
            -s,
            -s,
            s + t - wheel * OMEGA * OMEGA,
        );
        let z = matrix
            .lu()
            .solve(&Vector2::new(Complex::new(0.0, 0.0), t * 2e-3))
            .expect("regular")[0];
        close(phasor(&motion, 0), (z.re, z.im));
    }

    #[test]
    fn neutral_pitch_inertia_changes_nothing() {
        let b = bike();
        let neutral = b.total_kg() * b.arm_m[0] * b.arm_m[1];
        let plain = run(vec![], &sine_ground(2.0), [[0.0; STATES]; 2]);
        let pitch = run(
            vec![Effect::new(Kind::PitchCoupling, Axle::Both, &[neutral])],
            &sine_ground(2.0),
            [[0.0; STATES]; 2],
        );
        for (a, b) in plain.z[0].iter().zip(&pitch.z[0]) {
            assert!((a - b).abs() < 1e-8);
        }
    }

    #[test]
    fn a_release_decays_as_the_closed_form() {
        let mut from = [[0.0; STATES]; 2];
        from[0][0] = 5e-3;
        let motion = run(vec![], &Drive::empty(0.0, STEP_S, 4000), from);
        let (sigma, w0) = (300.0 / 46.0, (90e3_f64 / 23.0).sqrt());
        let wd = (w0 * w0 - sigma * sigma).sqrt();
        for (i, z) in motion.z[0].iter().enumerate() {
            let t = i as f64 * STEP_S;
            let exact = 5e-3 * (-sigma * t).exp() * ((wd * t).cos() + sigma / wd * (wd * t).sin());
            assert!((z - exact).abs() < 1e-9, "at {t} s");
        }
    }

    #[test]
    fn dry_friction_takes_four_friction_deflections_per_cycle() {
        let mut vehicle = Vehicle::plain(Bike {
            damping_n_s_m: [0.0; 2],
            ..bike()
        });
        vehicle.effects = vec![Effect::new(Kind::CoulombFriction, Axle::Front, &[20.0])];
        let mut from = [[0.0; STATES]; 2];
        from[0][0] = 5e-3;
        let motion = integrate(
            &vehicle,
            &Drive::empty(0.0, STEP_S, 4000),
            from,
            [true, false],
            f64::INFINITY,
        );
        let period = std::f64::consts::TAU / (90e3_f64 / 23.0).sqrt();
        let after = motion.position(0, 2.0 * period);
        let exact = 5e-3 - 2.0 * 4.0 * 20.0 / 90e3;
        assert!((after - exact).abs() < 2e-5, "{after} against {exact}");
    }

    #[test]
    fn conservative_springs_keep_the_energy() {
        let mut vehicle = Vehicle::plain(Bike {
            damping_n_s_m: [0.0; 2],
            ..bike()
        });
        let (k3, k2) = (2e9, 3e6);
        vehicle.effects = vec![
            Effect::new(Kind::CubicStiffness, Axle::Front, &[k3]),
            Effect::new(Kind::ProgressiveStiffness, Axle::Front, &[k2]),
        ];
        let mut from = [[0.0; STATES]; 2];
        from[0][0] = 5e-3;
        let motion = integrate(
            &vehicle,
            &Drive::empty(0.0, STEP_S, 8000),
            from,
            [true, false],
            f64::INFINITY,
        );
        let energy = |i: usize| {
            let (d, v) = (-motion.z[0][i], motion.z_rate[0][i]);
            0.5 * 23.0 * v * v + 0.5 * 90e3 * d * d + k2 / 3.0 * d.powi(3) + k3 / 4.0 * d.powi(4)
        };
        assert!((energy(8000) / energy(0) - 1.0).abs() < 1e-6);
    }

    #[test]
    fn the_tyre_cannot_pull_more_than_its_load() {
        let motion = run(
            vec![Effect::new(Kind::WheelLift, Axle::Front, &[23.0 * 9.81])],
            &{
                let mut drive = Drive::empty(0.0, STEP_S, 8000);
                drive.shake_ground(0, &Wave::Multisine(vec![(2e-2, OMEGA, 0.0)]));
                drive
            },
            [[0.0; STATES]; 2],
        );
        let v = &motion.z_rate[0];
        let lowest = v
            .windows(2)
            .map(|p| (p[1] - p[0]) / STEP_S)
            .fold(0.0, f64::min);
        assert!((lowest + 9.81).abs() < 1e-6, "{lowest} m/s^2");
    }
}
