use crate::diagnosis::law::*;

/// k3 d^3: stiffens (or softens) alike in compression and rebound.
pub struct CubicStiffness;

const K3: Parameter = Parameter {
    name: "k3",
    unit: "N/m^3",
    size: |s| 0.1 * s.k / (4.0 * s.d_rms * s.d_rms),
    limits: |s| [-0.9 * s.k.abs() / (s.d_peak * s.d_peak), 1e3 * s.k.abs() / (s.d_rms * s.d_rms)],
};

impl Effect for CubicStiffness {
    const SPEC: Spec = Spec {
        id: "cubic_stiffness",
        acts: Acts::OneAxle,
        parameters: &[K3],
        amplitudes: &[0],
        starts: |s| vec![[(K3.size)(s), 0.0, 0.0, 0.0]],
        report: |p, s| vec![reported(&K3, p[0], (K3.limits)(s))],
        stiffens: |p, s| 3.0 * p[0].max(0.0) * 4.0 * s.d_rms * s.d_rms,
        law: "k3 d^3",
        words: "the spring stiffens (or softens) with the cube of its deflection",
        confused_with: &["bump_stop", "free_play", "wheel_lift"],
        source: "Kerschen et al. 2006, Mech. Syst. Signal Process. 20:505-592",
        family: Some(Family::Spring),
        is_odd: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force + p[0] * m.per_mass * m.d * m.d * m.d
    }
}
