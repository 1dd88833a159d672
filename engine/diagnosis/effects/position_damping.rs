use crate::diagnosis::law::*;

/// c d^2 w: a damper that depends on where it is. Not an effect to be named: a general shape against
/// which the named laws of the rate are held.
pub struct PositionDamping;

const C: Parameter = Parameter {
    name: "c",
    unit: "N s/m^3",
    size: |s| 0.2 * s.b_size() / (s.d_rms * s.d_rms),
    limits: |s| {
        let most = 100.0 * s.b_size() / (s.d_rms * s.d_rms);
        [-most, most]
    },
};

impl Effect for PositionDamping {
    const SPEC: Spec = Spec {
        id: "position_damping",
        acts: Acts::OneAxle,
        parameters: &[C],
        amplitudes: &[0],
        starts: |s| vec![[(C.size)(s), 0.0, 0.0, 0.0]],
        report: |p, s| vec![reported(&C, p[0], (C.limits)(s))],
        law: "c d^2 w",
        words: "the damper depends on its position",
        confused_with: &["quadratic_damping"],
        source: "van der Pol 1926, Phil. Mag. 2:978-992",
        family: Some(Family::Damper),
        is_general: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force + p[0] * m.per_mass * m.d * m.d * m.w
    }
}
