//! Sizes of the twelve known laws.

use super::around::{Around, Law};
use crate::chance::Chance;
use crate::simulate::outside::Strange;

pub fn draw(kind: Strange, a: &Around, chance: &mut Chance) -> Option<Law> {
    let (k, b, d, w, strength, load) = (a.k, a.b, a.d, a.w, a.strength, a.load);
    let values = match kind {
        Strange::PowerDamping => {
            let power = chance.uniform(0.3, 0.5);
            vec![0.5 * strength * load / w.powf(power), power]
        }
        Strange::CubicDamping => vec![2.0 * strength * b / (w * w)],
        Strange::StribeckFriction => {
            let kinetic = 0.12 * strength * load;
            vec![kinetic, kinetic * chance.uniform(3.0, 4.0), 0.3 * w, 1e-4]
        }
        Strange::ParametricWheel => vec![(0.3 * strength).min(0.6), a.radius, chance.phase()],
        Strange::HardeningFrameMode => {
            let (extra, omega) = (
                0.35 * strength * a.m,
                std::f64::consts::TAU * chance.uniform(5.0, 9.0),
            );
            let spring = extra * omega * omega;
            vec![
                extra,
                spring,
                1.5 * spring / (d * d),
                2.0 * 0.06 * extra * omega,
            ]
        }
        Strange::ImpactBacklash => {
            vec![0.9 * d, strength * k, 0.7 / w, chance.uniform(0.002, 0.004)]
        }
        Strange::ThermalSoftening => vec![(0.3 * strength).min(0.5), w, chance.uniform(1.0, 3.0)],
        Strange::PostureBursts => return Some(bursts(a, chance)),
        Strange::LateralCoupling => vec![0.15 * strength * k / a.scale.mean_speed_m_s.max(1.0)],
        Strange::DampingSteps => return Some(steps(a, chance)),
        Strange::MagneticRepulsion => {
            let gap = 3.2 * d;
            let at_two_sigma = (gap - 2.0 * d).powi(-2) - gap.powi(-2);
            vec![strength * 2.0 * k * d / at_two_sigma, gap]
        }
        Strange::PositionDamping => vec![0.7 * b * strength.min(1.3), 0.6 * d],
        _ => return None,
    };
    Some(Law::of(values))
}

fn bursts(a: &Around, chance: &mut Chance) -> Law {
    let mut events = Vec::new();
    let mut at = chance.uniform(0.5, 3.0);
    while at < a.scale.duration_s {
        let lasts = chance.uniform(0.15, 0.6);
        events.push([
            at,
            at + lasts,
            a.strength * 0.7 * a.load * chance.uniform(0.5, 1.2) * chance.sign(),
        ]);
        at += lasts + chance.uniform(0.6, 3.0);
    }
    Law::in_stretches(Vec::new(), events)
}

fn steps(a: &Around, chance: &mut Chance) -> Law {
    let mut events = Vec::new();
    let mut at = 0.0;
    while at < a.scale.duration_s {
        let (lasts, more) = (
            chance.uniform(2.0, 5.0),
            2.5 * a.strength * chance.uniform(0.6, 1.2),
        );
        events.push([at, at + lasts, more]);
        at += lasts + chance.uniform(2.0, 5.0);
    }
    Law::in_stretches(Vec::new(), events)
}
