//! Sizes of the laws without a memory.

use super::around::{Around, Law};
use crate::chance::Chance;
use crate::simulate::outside::Strange;

pub fn draw(kind: Strange, a: &Around, chance: &mut Chance) -> Option<Law> {
    let (d, w, strength, load) = (a.d, a.w, a.strength, a.load);
    let values = match kind {
        Strange::TwoPowerSpring => vec![
            0.25 * strength * load,
            1.2 * d,
            chance.uniform(2.5, 3.5),
            chance.uniform(0.2, 0.4),
        ],
        Strange::RateStiffenedSpring => vec![1.2 * strength, w],
        Strange::InterlinkedSprings => vec![(0.2 * strength).min(0.5)],
        Strange::WanderingStop => return Some(stop(a, chance)),
        Strange::LoadFriction => vec![(0.3 * strength).min(0.5), 0.15 * w],
        Strange::EddyDamping => vec![1.2 * strength * load / w, 0.5 * w],
        Strange::SlackCable => vec![strength * load / w, 0.2 * d, 0.3 * d],
        Strange::CrankDamping => vec![0.5 * strength * load / w, chance.phase()],
        Strange::ValveBump => vec![
            strength * load,
            chance.uniform(10.0, 20.0),
            a.radius,
            chance.phase(),
        ],
        Strange::Gusts => return Some(gusts(a, chance)),
        Strange::SnapDome => vec![0.35 * strength * load, 0.9 * d, 0.45 * d],
        Strange::DetentRipple => vec![0.25 * strength * load, chance.uniform(1.5, 2.5) * d],
        Strange::SkyhookDamper => vec![0.6 * strength * load / w, (0.2 * w).powi(2)],
        _ => return None,
    };
    Some(Law::of(values))
}

/// In the way for 3 to 8 s, out of it for as long.
fn stop(a: &Around, chance: &mut Chance) -> Law {
    let mut events = Vec::new();
    let mut at = chance.uniform(0.0, 4.0);
    while at < a.scale.duration_s {
        let lasts = chance.uniform(3.0, 8.0);
        events.push([at, at + lasts, 1.0]);
        at += lasts + chance.uniform(3.0, 8.0);
    }
    Law::in_stretches(vec![0.4 * a.d, a.strength * a.k], events)
}

/// Twenty-four sines of 0.15 to 3 Hz whose forces fall with the square root of the frequency.
fn gusts(a: &Around, chance: &mut Chance) -> Law {
    let lines = (0..24).map(|i| {
        let frequency = 0.15 * 20.0_f64.powf((i as f64 + chance.uniform(0.0, 1.0)) / 24.0);
        let force = 0.12 * a.strength * a.load * frequency.powf(-0.5) * chance.uniform(0.6, 1.4);
        [std::f64::consts::TAU * frequency, chance.phase(), force]
    });
    let lines = lines.collect();
    Law::in_stretches(Vec::new(), lines)
}
