use crate::diagnosis::law::*;

/// c |w / w_rms|^p sign(w): a damper of any power. Not an effect to be named: a general curve against
/// which the named laws of the rate are held.
pub struct PowerDamping;

const FORCE: Parameter = Parameter {
    name: "force",
    unit: "N",
    size: |s| 0.1 * s.b_size() * s.w_rms,
    limits: |s| [0.0, 20.0 * s.force_rms()],
};

const POWER: Parameter = Parameter {
    name: "power",
    unit: "-",
    size: |_| 0.3,
    limits: |_| [0.15, 5.0],
};

/// Rate below which the power law is rounded off, in RMS rates.
const ROUND: f64 = 0.03;

impl Effect for PowerDamping {
    const SPEC: Spec = Spec {
        id: "power_damping",
        acts: Acts::OneAxle,
        parameters: &[FORCE, POWER],
        amplitudes: &[0],
        starts: |s| {
            [0.4, 1.6, 3.0]
                .map(|power| [(FORCE.size)(s), power, 0.0, 0.0])
                .to_vec()
        },
        report: |p, s| vec![reported(&FORCE, p[0], (FORCE.limits)(s)), reported(&POWER, p[1], [0.15, 5.0])],
        law: "force |w / w_rms|^power sign(w)",
        words: "the damper follows some power of the rate",
        confused_with: &["coulomb_friction", "quadratic_damping"],
        source: "Worden & Tomlinson 2001, Nonlinearity in Structural Dynamics",
        family: Some(Family::Damper),
        is_general: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        let w = m.w / m.scale.w_rms;
        let law = w * (w * w + ROUND * ROUND).powf((p[1] - 1.0) * 0.5);
        force + p[0] * m.per_mass * law
    }
}
