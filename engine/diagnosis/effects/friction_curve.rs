use crate::diagnosis::law::*;
use super::coulomb_friction::{FRICTION, dry, sharpness};

/// Fc sign(w) (1 + a v^2 / (w^2 + v^2)): dry friction that is larger or smaller while it hardly slides
/// (Stribeck's curve). Not an effect to be named: a general curve against which the named laws of the
/// rate are held.
pub struct FrictionCurve;

const EXCESS: Parameter = Parameter {
    name: "excess",
    unit: "-",
    size: |_| 0.3,
    limits: |_| [-1.0, 20.0],
};
const RATE: Parameter = Parameter {
    name: "rate",
    unit: "m/s",
    size: |s| 0.1 * s.w_rms,
    limits: |s| [0.02 * s.w_rms, 2.0 * s.w_rms],
};

/// Rate over which the sign is smooth, in RMS rates.
const WIDTH: f64 = 0.01;

impl Effect for FrictionCurve {
    const SPEC: Spec = Spec {
        id: "friction_curve",
        acts: Acts::OneAxle,
        parameters: &[FRICTION, EXCESS, RATE],
        amplitudes: &[0],
        starts: |s| {
            let mut starts = Vec::new();
            for excess in [-0.5, 2.0] {
                for rate in [0.1, 0.4] {
                    starts.push([(FRICTION.size)(s), excess, rate * s.w_rms, 0.0]);
                }
            }
            starts
        },
        report: |p, s| {
            vec![
                reported(&FRICTION, p[0], (FRICTION.limits)(s)),
                reported(&EXCESS, p[1], (EXCESS.limits)(s)),
                reported(&RATE, p[2], (RATE.limits)(s)),
            ]
        },
        damps: sharpness,
        corners: true,
        law: "friction sign(w) (1 + excess rate^2 / (w^2 + rate^2))",
        words: "dry friction changes with the sliding rate",
        confused_with: &["coulomb_friction", "hysteresis"],
        source: "Armstrong-Helouvry, Dupont & Canudas de Wit 1994, Automatica 30:1083-1138",
        family: Some(Family::Damper),
        is_general: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        let slow = p[2] * p[2];
        let size = Lanes::all(1.0) + p[1] * (slow / (m.w * m.w + slow));
        let width = Lanes::all(WIDTH * m.scale.w_rms);
        force + dry(p[0] * m.per_mass * size, m.w, width, m.felt_after)
    }
}
