use crate::law::*;

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
        needs: &[Need::Drive, Need::Hold],
        parameters: &[RATE],
        amplitudes: &[0],
        starts: |s| vec![padded([(RATE.size)(s)])],
        report: |p, s| vec![reported(&RATE, p[0], (RATE.limits)(s))],
        stiffens: |p, s| (p[0] * s.duration).max(0.0) * s.k_size(),
        law: "k (1 + rate t) d in the place of k d",
        formula: Formula { tyre: "k * rate * t * d", ..Formula::NONE },
        words: "the stiffness drifts along the ride (pressure loss, warming)",
        confused_with: &["mass_step", "speed_dependent_stiffness"],
        noun: "a stiffness drift of {rate}",
        source: "effect library, S16: dk/dp of a tyre 24 N/mm per bar (Dressel & Sadauckas 2020)",
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force + p[0] * m.kappa * m.d * m.t
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    #[test]
    fn stiffness_changes_evenly_with_time() {
        for (rate, t, stiffness) in [(2e-3, 0.0, 60e3), (2e-3, 50.0, 66e3), (-5e-3, 40.0, 48e3)] {
            for d in [2e-3, -1e-3] {
                let at = At { d, w: 0.1, t, ..AT };
                near(tyre::<StiffnessDrift>(padded([rate]), &at), stiffness * d + 50.0);
            }
        }
    }

    /// At the lower limit a fiftieth of the stiffness is left in the end.
    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<StiffnessDrift>();
        limits_are::<StiffnessDrift>(&[[-9.8e-3, 0.1]]);
        physical_within::<StiffnessDrift>(padded([]), [0, 0], [-9.8e-3, 0.1]);
        comes_back::<StiffnessDrift>(padded([-2e-3]));
        near(tyre::<StiffnessDrift>(padded([-9.8e-3]), &At { d: 1e-3, t: 100.0, ..AT }), 1.2);
    }

    #[test]
    fn the_integrator_is_told_how_much_stiffer_the_spring_becomes() {
        let told = (StiffnessDrift::SPEC.stiffens)(&padded([0.02]), &Scale::TYPICAL);
        assert!(told > 0.999 * 0.02 * 100.0 * 60e3, "{told}");
    }
}
