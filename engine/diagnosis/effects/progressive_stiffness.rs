use crate::diagnosis::law::*;

/// k2 d^2: stiffens in compression, softens in rebound; beyond its turning point d = -k/(2 k2) the
/// spring force stays constant.
pub struct ProgressiveStiffness;

const K2: Parameter = Parameter {
    name: "k2",
    unit: "N/m^2",
    size: |s| 0.1 * s.k / (2.0 * s.d_rms),
    limits: |s| [-30.0 * s.k.abs() / s.d_rms, 30.0 * s.k.abs() / s.d_rms],
};

impl Effect for ProgressiveStiffness {
    const SPEC: Spec = Spec {
        id: "progressive_stiffness",
        acts: Acts::OneAxle,
        parameters: &[K2],
        amplitudes: &[0],
        starts: |s| vec![[(K2.size)(s), 0.0, 0.0, 0.0]],
        report: |p, s| vec![reported(&K2, p[0], (K2.limits)(s))],
        stiffens: |p, s| 2.0 * p[0].abs() * 2.0 * s.d_rms,
        law: "k2 d^2, constant beyond the turning point d = -k / (2 k2)",
        words: "the spring stiffens in compression and softens in rebound",
        confused_with: &["asymmetric_damping", "wheel_lift", "bump_stop"],
        source: "Renart & Roura-Grabulosa, Am. J. Phys. 87:102 (F ~ d^1.5 of a light tyre)",
        family: Some(Family::Spring),
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        let k2 = p[0] * m.per_mass;
        // The turning point lies in rebound for k2 > 0 and in compression for k2 < 0.
        let mut d = m.d;
        for i in 0..d.0.len() {
            let turn = -m.kappa.0[i] / (2.0 * k2.0[i]);
            let (low, high) = if k2.0[i] > 0.0 { (turn, f64::MAX) } else { (f64::MIN, turn) };
            let x = d.0[i];
            let x = if x < low { low } else { x };
            d.0[i] = if x > high && k2.0[i] < 0.0 { high } else { x };
        }
        force + m.kappa * (d - m.d) + k2 * d * d
    }
}
