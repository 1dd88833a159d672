use crate::diagnosis::law::*;

/// -cg z': a damper to the resting frame, not across the tyre.
pub struct GroundDamping;

const DAMPING: Parameter = Parameter {
    name: "damping",
    unit: "N s/m",
    size: |s| 0.1 * s.b_size(),
    limits: |s| [0.0, 100.0 * s.b_size()],
};

impl Effect for GroundDamping {
    const SPEC: Spec = Spec {
        id: "ground_damping",
        acts: Acts::OneAxle,
        needs: &[Need::Road],
        parameters: &[DAMPING],
        amplitudes: &[0],
        starts: |s| vec![[(DAMPING.size)(s), 0.0, 0.0, 0.0]],
        report: |p, s| vec![reported(&DAMPING, p[0], [0.0, (DAMPING.limits)(s)[1]])],
        law: "-damping z' on the mass",
        words: "a damper acts against the resting frame (a rig's guide, air)",
        confused_with: &["guide_friction", "sensor_gain", "sensor_delay"],
        source: "Gillespie, Fundamentals of Vehicle Dynamics, 1992 (quarter car on a rig)",
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn body(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force - p[0] * m.per_mass * m.v
    }
}
