use crate::diagnosis::law::*;

/// B (1 + a sign(w)) w: compression and rebound damp differently.
pub struct AsymmetricDamping;

const ASYMMETRY: Parameter = Parameter {
    name: "asymmetry",
    unit: "-",
    size: |_| 0.2,
    limits: |_| [-3.0, 3.0],
};

impl Effect for AsymmetricDamping {
    const SPEC: Spec = Spec {
        id: "asymmetric_damping",
        acts: Acts::OneAxle,
        parameters: &[ASYMMETRY],
        amplitudes: &[0],
        starts: |_| vec![[0.2, 0.0, 0.0, 0.0]],
        report: |p, _| vec![reported(&ASYMMETRY, p[0], [-1.0, 1.0])],
        law: "B (1 + asymmetry sign(w)) w in the place of B w",
        words: "compression and rebound damp differently",
        confused_with: &["progressive_stiffness"],
        source: "Dixon, The Shock Absorber Handbook, 2nd ed. 2007",
        family: Some(Family::Damper),
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force + p[0] * m.beta * m.w.abs()
    }
}
