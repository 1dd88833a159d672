use crate::law::*;

/// k (1 + s (V - mean V over the ride)).
pub struct SpeedDependentStiffness;

const SLOPE: Parameter = Parameter {
    name: "slope",
    unit: "s/m",
    size: |s| 0.1 / s.speed_span,
    limits: |s| [-0.9 / s.speed_span, 5.0 / s.speed_span],
};

impl Effect for SpeedDependentStiffness {
    const SPEC: Spec = Spec {
        id: "speed_dependent_stiffness",
        acts: Acts::OneAxle,
        needs: &[Need::VaryingSpeed],
        parameters: &[SLOPE],
        amplitudes: &[0],
        starts: |s| vec![padded([(SLOPE.size)(s)])],
        report: |p, s| vec![reported(&SLOPE, p[0], (SLOPE.limits)(s))],
        law: "k (1 + slope (V - mean V)) d in the place of k d",
        formula: Formula { tyre: "k * slope * (speed - mean_speed) * d", ..Formula::NONE },
        words: "the tyre's stiffness changes with speed",
        confused_with: &["stiffness_drift", "tyre_enveloping"],
        noun: "speed-dependent stiffness with a slope of {slope}",
        source: "TNO, MF-Tyre/MF-Swift 6.2 Equation Manual, 2013 (vertical force, Q_V2)",
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force + p[0] * m.kappa * m.d * (m.speed - m.scale.mean_speed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    /// 60 kN/m at the mean speed, 5 m/s.
    #[test]
    fn stiffness_changes_evenly_with_the_speed() {
        for (slope, speed, stiffness) in [(0.1, 5.0, 60e3), (0.1, 8.0, 78e3), (0.1, 1.0, 36e3), (-0.2, 7.0, 36e3)] {
            for d in [2e-3, -1e-3] {
                let at = At { d, w: 0.1, speed, ..AT };
                near(tyre::<SpeedDependentStiffness>(padded([slope]), &at), stiffness * d + 50.0);
            }
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<SpeedDependentStiffness>();
        limits_are::<SpeedDependentStiffness>(&[[-0.9, 5.0]]);
        physical_within::<SpeedDependentStiffness>(padded([]), [0, 0], [-0.9, 5.0]);
        comes_back::<SpeedDependentStiffness>(padded([-0.05]));
    }
}
