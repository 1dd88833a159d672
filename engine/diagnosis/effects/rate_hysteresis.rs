use super::hysteresis::{Hysteresis, STIFFNESS, YIELD, slide};
use crate::diagnosis::law::*;

/// Hysteresis whose yield force goes with a power of the rate. Not an effect to be named: a general law against which
/// rate-independent loss is held.
pub struct RateHysteresis;

const POWER: Parameter = Parameter {
    name: "power",
    unit: "-",
    size: |_| 0.1,
    limits: |_| [-2.0, 2.0],
};

/// Rate below which the power law is rounded off, in RMS rates.
const ROUND: f64 = 0.05;

impl Effect for RateHysteresis {
    const SPEC: Spec = Spec {
        id: "rate_hysteresis",
        acts: Acts::OneAxle,
        parameters: &[STIFFNESS, YIELD, POWER],
        report: |p, s| vec![reported(&POWER, p[2], (POWER.limits)(s))],
        stiffens: |p, _| p[0],
        states: 1,
        law: "hysteresis whose yield force goes with a power of |w|",
        words: "the loss depends on the rate",
        confused_with: &["hysteresis"],
        source: "Armstrong-Helouvry, Dupont & Canudas de Wit 1994, Automatica 30:1083-1138",
        is_general: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, s: &States, force: Lanes) -> Lanes {
        Hysteresis::tyre(p, m, s, force)
    }

    #[inline(always)]
    fn rates(p: &LaneValues, m: &Motion, s: &States) -> States {
        let w = m.w / m.scale.w_rms;
        let y = p[1] * (w * w + ROUND * ROUND).powf(p[2] * 0.5);
        [slide(y, m, s[0]), Lanes::ZERO]
    }
}
