//! Sizes of the laws with a memory.

use std::f64::consts::TAU;

use super::around::{Around, Law};
use crate::chance::Chance;
use crate::simulate::outside::Strange;

pub fn draw(kind: Strange, a: &Around, chance: &mut Chance) -> Option<Law> {
    let (k, d, w, strength, load) = (a.k, a.d, a.w, a.strength, a.load);
    // Damping (N s/m) whose force at the typical rate is that of spring and damper.
    let damping = strength * load / w;
    let values = match kind {
        Strange::ThixotropicGrease => vec![1.5 * damping, 12.0 * d, chance.uniform(0.5, 1.2)],
        Strange::DelayedRelief => vec![(0.35 * strength).min(0.7), chance.uniform(0.02, 0.05)],
        Strange::LogCreep => vec![1.2 * strength * k, 0.2 * w, 0.2 * strength * load],
        Strange::SlowFollower => vec![0.7 * strength, 0.4 * w, 0.3 * d],
        Strange::InertiaValve => vec![0.8 * damping, 1.6 * w, chance.uniform(0.15, 0.4)],
        Strange::RectifiedGenerator => vec![1.5 * damping, 0.7 * w, chance.uniform(0.01, 0.03)],
        Strange::ImpactPreload => vec![0.7 * strength * load, 1.5 * d, chance.uniform(1.0, 3.0)],
        Strange::DwellFriction => vec![0.06 * strength * load, 1.5, d, 2e-3],
        Strange::BistableLatch => {
            vec![
                0.35 * strength * load,
                2.2 * d,
                chance.uniform(0.004, 0.008),
            ]
        }
        Strange::Slosh => {
            let (extra, omega) = (0.35 * strength * a.m, TAU * chance.uniform(3.5, 6.0));
            vec![extra, omega, 3.0 * d, 0.2 * extra * omega / w]
        }
        Strange::LeakingAirSpring => {
            let length = 3.5 * d;
            vec![
                0.35 * strength * k * length,
                length,
                chance.uniform(5.0, 12.0),
            ]
        }
        Strange::GranularJamming => vec![1.2 * strength, d, chance.uniform(0.05, 0.15), w],
        Strange::BreakingBond => {
            let aged = a.scale.duration_s * chance.uniform(0.3, 0.5);
            vec![0.35 * strength, 1.3 * d, aged]
        }
        Strange::HydraulicMount => {
            let (spring, omega) = (0.5 * strength * k, TAU * chance.uniform(7.0, 12.0));
            let inertance = spring / (omega * omega);
            vec![spring, inertance, 0.4 * inertance * omega / w]
        }
        _ => return None,
    };
    Some(Law::of(values))
}
