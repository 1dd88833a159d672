use crate::diagnosis::law::*;

/// k (1 + r t), t from the first sample: pressure loss, warming.
pub struct StiffnessDrift;

const RATE: Parameter = Parameter {
    name: "rate",
    unit: "1/s",
    size: |s| 0.1 / s.train_s,
    limits: |s| [-0.98 / s.duration, 10.0 / s.duration],
};

impl Effect for StiffnessDrift {
    const SPEC: Spec = Spec {
        id: "stiffness_drift",
        acts: Acts::OneAxle,
        parameters: &[RATE],
        amplitudes: &[0],
        starts: |s| vec![[(RATE.size)(s), 0.0, 0.0, 0.0]],
        report: |p, s| vec![reported(&RATE, p[0], (RATE.limits)(s))],
        law: "k (1 + rate t) d in the place of k d",
        words: "the stiffness drifts along the ride (pressure loss, warming)",
        confused_with: &["mass_step", "speed_dependent_stiffness"],
        source: "effect library, S16: dk/dp of a tyre 24 N/mm per bar (Dressel & Sadauckas 2020)",
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force + p[0] * m.kappa * m.d * m.t
    }
}
