//! How large an effect is made, from what the plain bicycle does on the same ride.

use crate::chance::Chance;
use crate::simulate::drive::Drive;
use crate::simulate::effect::{Axle, Effect, Kind};
use crate::simulate::integrate::Motion;
use crate::simulate::vehicle::Bike;

/// Root mean squares of the plain ride and what else sizes depend on.
pub struct Scale {
    pub deflection_m: [f64; 2],
    pub rate_m_s: [f64; 2],
    pub fastest_m_s: f64,
    pub mean_speed_m_s: f64,
    pub duration_s: f64,
    pub noise_m: f64,
}

impl Scale {
    pub fn measure(
        motion: &Motion,
        drive: &Drive,
        duration_s: f64,
        mean_speed_m_s: f64,
        noise_m: f64,
    ) -> Self {
        let first = (-motion.start_s / motion.step_s).round().max(0.0) as usize;
        let rms = |value: &dyn Fn(usize) -> f64| {
            let n = motion.z[0].len();
            ((first..n).map(|i| value(i).powi(2)).sum::<f64>() / (n - first) as f64).sqrt()
        };
        let axle = |a: usize| {
            (
                rms(&|i| drive.at(2 * i).road[a] - motion.z[a][i]),
                rms(&|i| drive.at(2 * i).road_rate[a] - motion.z_rate[a][i]),
            )
        };
        let ((front, front_rate), (rear, rear_rate)) = (axle(0), axle(1));
        Self {
            deflection_m: [front, rear],
            rate_m_s: [front_rate, rear_rate],
            fastest_m_s: drive.travel.speed.iter().fold(0.0, |a, &b| a.max(b)),
            mean_speed_m_s,
            duration_s,
            noise_m,
        }
    }
}

/// Draws the parameters of one effect at a size (0 small, 1 medium, 2 large).
pub fn draw(
    kind: Kind,
    axle: Axle,
    size: usize,
    bike: &Bike,
    scale: &Scale,
    chance: &mut Chance,
) -> Effect {
    let a = if axle == Axle::Rear { 1 } else { 0 };
    let (m, k, b) = (
        bike.mass_kg[a],
        bike.stiffness_n_m[a],
        bike.damping_n_s_m[a],
    );
    let (d, w) = (scale.deflection_m[a], scale.rate_m_s[a]);
    let vary = chance.uniform(0.85, 1.15);
    let of = |sizes: [f64; 3]| sizes[size] * vary;
    let values = match kind {
        Kind::CubicStiffness if size == 0 && chance.happens(0.3) => {
            vec![-of([0.1, 0.0, 0.0]) * k / (4.0 * d * d)]
        }
        Kind::CubicStiffness => vec![of([0.12, 0.35, 0.9]) * k / (4.0 * d * d)],
        Kind::ProgressiveStiffness => vec![of([0.12, 0.3, 0.7]) * k / (2.0 * d)],
        Kind::QuadraticDamping => vec![of([0.25, 0.7, 1.8]) * b / w],
        Kind::AsymmetricDamping => vec![of([0.22, 0.4, 0.6]) * chance.sign()],
        Kind::CoulombFriction | Kind::GuideFriction => vec![of([6.0, 18.0, 50.0])],
        Kind::Hysteresis => {
            let stiffness = of([0.15, 0.35, 0.6]) * k;
            vec![stiffness, stiffness * d * chance.uniform(0.35, 0.8)]
        }
        Kind::ViscoelasticTyre => vec![of([0.22, 0.4, 0.7]) * k, chance.log_uniform(0.010, 0.100)],
        Kind::BumpStop => {
            let side = chance.pick(&[1.0, 1.0, 1.0, 0.0, 0.0, -1.0]);
            vec![
                of([2.0, 1.6, 1.2]) * d,
                [1.0, 2.0, 4.0][size] * k * chance.uniform(0.7, 1.3),
                side,
            ]
        }
        Kind::FreePlay => vec![of([0.35, 0.8, 1.5]) * d],
        Kind::WheelLift => vec![m * 9.81 * chance.uniform(0.95, 1.0)],
        Kind::SprungMass => {
            vec![
                of([0.15, 0.3, 0.55]),
                chance.uniform(3.5, 6.5),
                chance.uniform(0.15, 0.45),
            ]
        }
        Kind::UnsprungMass => vec![
            of([0.06, 0.12, 0.22]),
            chance.log_uniform(10.0, 22.0),
            chance.uniform(0.08, 0.3),
        ],
        Kind::PitchCoupling => {
            let neutral = bike.total_kg() * bike.arm_m[0] * bike.arm_m[1];
            let ratio = [[0.85, 1.2], [0.7, 1.45], [0.55, 1.9]][size];
            vec![neutral * chance.pick(&ratio) * chance.uniform(0.96, 1.04)]
        }
        Kind::LoadTransfer => vec![chance.uniform(0.85, 1.2)],
        Kind::TyreEnveloping => vec![of([0.09, 0.17, 0.29])],
        Kind::WheelOutOfRound => {
            let radius = bike.wheel_radius_m[a] * chance.uniform(0.975, 1.025);
            vec![of([0.15, 0.4, 0.9]) * 1e-3, chance.phase(), radius]
        }
        Kind::PedallingForce => vec![of([11.0, 25.0, 50.0]), chance.phase()],
        Kind::StiffnessDrift => {
            let over_ride = of([0.12, 0.25, 0.45]);
            vec![
                if chance.happens(0.75) {
                    -over_ride
                } else {
                    over_ride
                } / scale.duration_s,
            ]
        }
        Kind::SpeedDependentStiffness => {
            vec![of([0.06, 0.11, 0.2]) / (scale.fastest_m_s - scale.mean_speed_m_s).max(0.5)]
        }
        Kind::SpeedDependentDamping => vec![of([0.32, 0.55, 0.8])],
        Kind::MassStep => {
            let from = scale.duration_s * chance.uniform(0.2, 0.4);
            // A window that also ends within the fitted part, or one that lasts to the end of the ride.
            let to = if size == 0 {
                from + scale.duration_s * 0.15
            } else {
                scale.duration_s
            };
            vec![of([0.09, 0.15, 0.26]) * chance.sign(), from, to]
        }
        Kind::GroundDamping => vec![of([0.1, 0.3, 0.8]) * b],
        Kind::SensorDelay => vec![of([1.5, 6.0, 22.0]) * 1e-3 * chance.sign()],
        Kind::WheelbaseDelay => vec![of([0.011, 0.024, 0.045]) * chance.sign()],
        Kind::SensorGain => vec![1.0 + of([0.025, 0.06, 0.105]) * chance.sign()],
        Kind::SensorOffset => vec![of([0.6, 1.5, 5.0]) * scale.noise_m.max(2e-4) * chance.sign()],
        Kind::SensorDrift => vec![of([0.5, 1.5, 4.0]) * 1e-3 * chance.sign() / scale.duration_s],
    };
    Effect::new(kind, axle, &values)
}
