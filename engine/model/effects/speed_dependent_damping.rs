use crate::law::*;

/// B (1 + s (V0/V - 1)), V0 = 5 m/s, V no less than 0.5 m/s: tyre damping falls with rolling speed.
pub struct SpeedDependentDamping;

const SHARE: Parameter = Parameter {
    name: "share",
    unit: "-",
    size: |_| 0.3,
    limits: |_| [-3.0, 10.0],
};

impl Effect for SpeedDependentDamping {
    const SPEC: Spec = Spec {
        id: "speed_dependent_damping",
        acts: Acts::OneAxle,
        needs: &[Need::VaryingSpeed],
        parameters: &[SHARE],
        amplitudes: &[0],
        starts: |_| vec![padded([0.3])],
        report: |p, _| vec![reported(&SHARE, p[0], [0.0, 1.0])],
        law: "B (1 + share (5 m/s / V - 1)) w in the place of B w, V no less than 0.5 m/s",
        formula: Formula { tyre: "share * B * w * (5 / max(speed, 0.5) - 1)", ..Formula::NONE },
        words: "the tyre's damping falls with rolling speed",
        confused_with: &["speed_dependent_stiffness", "tyre_enveloping"],
        noun: "speed-dependent damping with a share of {share}",
        source: "effect library: a rolling tyre damps less than a standing one; no publication gives this law",
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force + p[0] * m.beta * m.w * (5.0 / m.speed.max(0.5) - 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    /// B of 500 N s/m at 5 m/s; slower than 0.5 m/s it stays as it is there.
    #[test]
    fn damping_falls_with_the_speed() {
        for (speed, damping) in [(5.0, 500.0), (10.0, 400.0), (2.5, 700.0), (0.5, 2300.0), (0.0, 2300.0)] {
            for w in [0.1, -0.3] {
                let at = At { d: 1e-3, w, speed, ..AT };
                near(tyre::<SpeedDependentDamping>(padded([0.4]), &at), 60.0 + damping * w);
            }
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<SpeedDependentDamping>();
        limits_are::<SpeedDependentDamping>(&[[-3.0, 10.0]]);
        physical_within::<SpeedDependentDamping>(padded([]), [0, 0], [0.0, 1.0]);
        comes_back::<SpeedDependentDamping>(padded([0.6]));
    }
}
