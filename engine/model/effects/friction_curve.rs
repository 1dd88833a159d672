use crate::law::*;
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
                    starts.push(padded([(FRICTION.size)(s), excess, rate * s.w_rms]));
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
        // While the sign changes, the friction is that at standstill.
        damps: |p, s| (1.0 + p[1].max(0.0)) * sharpness(p, s),
        corners: true,
        law: "friction sign(w) (1 + excess rate^2 / (w^2 + rate^2))",
        formula: Formula {
            tyre: "friction * (1 + excess * rate^2 / (w^2 + rate^2)) * w / sqrt(w^2 + (friction / m * (1 + excess * rate^2 / (w^2 + rate^2)) * 0.5 * felt_after + 0.01 * w_rms)^2)",
            ..Formula::NONE
        },
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    /// Friction of 30 N that is 1 + 2 times as large at standstill and falls over 0.02 m/s; its sign changes over 1 mm/s, and over
    /// the rate that the force gives the mass in half a step.
    #[test]
    fn friction_falls_from_its_excess_as_the_rate_grows() {
        for felt_after in [0.0, 2e-3] {
            for w in [-0.3, -0.02, -1e-3, 0.0, 5e-4, 0.02, 0.1] {
                let size = 30.0 * (1.0 + 2.0 * 4e-4 / (w * w + 4e-4));
                let width = 1e-3 + size / 30.0 * 0.5 * felt_after;
                let truth = size * w / f64::sqrt(w * w + width * width);
                let at = At { d: 1e-3, w, felt_after, ..AT };
                near(tyre::<FrictionCurve>(padded([30.0, 2.0, 0.02]), &at), 60.0 + 500.0 * w + truth);
            }
        }
    }

    #[test]
    fn friction_of_an_excess_of_minus_one_is_gone_at_standstill_and_whole_at_speed() {
        let friction = |w: f64| tyre::<FrictionCurve>(padded([30.0, -1.0, 0.02]), &At { w, ..AT }) - 500.0 * w;
        assert!(friction(1e-4).abs() < 1e-3);
        assert!((friction(-2.0) + 30.0).abs() < 0.01);
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<FrictionCurve>();
        let limits = [[0.0, 3000.0], [-1.0, 20.0], [2e-3, 0.2]];
        limits_are::<FrictionCurve>(&limits);
        for q in 0..3 {
            physical_within::<FrictionCurve>(padded([30.0, 0.5, 0.02]), [q, q], limits[q]);
        }
        comes_back::<FrictionCurve>(padded([30.0, -0.5, 0.02]));
    }

    /// Where the sign changes, the friction is that at standstill.
    #[test]
    fn the_integrator_is_told_the_slope_with_the_excess() {
        let told = (FrictionCurve::SPEC.damps)(&padded([30.0, 2.0, 0.02]), &Scale::TYPICAL);
        near(told, 90.0 / 5e-3);
    }
}
