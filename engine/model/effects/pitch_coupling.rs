use crate::law::*;

/// Pitch inertia I differs from m l_F l_R, so that the axles push each other. Fitted as
/// m l_F l_R / I - 1, zero in the plain model; the integrator couples the axles.
pub struct PitchCoupling;

const EXCESS: Parameter = Parameter {
    name: "coupling",
    unit: "-",
    size: |_| 0.1,
    limits: |_| [-0.95, 10.0],
};

impl Effect for PitchCoupling {
    const SPEC: Spec = Spec {
        id: "pitch_coupling",
        acts: Acts::Both,
        needs: &[Need::Geometry, Need::Mass],
        parameters: &[EXCESS],
        amplitudes: &[0],
        starts: |_| vec![padded([0.2])],
        report: |p, s| {
            vec![Reported {
                name: "pitch_inertia".into(),
                unit: "kg m^2".into(),
                value: s.balanced_pitch_inertia / (1.0 + p[0]),
                physical: p[0] > -0.9 && p[0] < 5.0,
            }]
        },
        law: "the axles push each other as pitch_inertia differs from m l_F l_R",
        words: "pitching couples the two axles",
        confused_with: &["sprung_mass"],
        noun: "pitch coupling with a pitch inertia of {pitch_inertia}",
        source: "Gillespie, Fundamentals of Vehicle Dynamics, 1992 (dynamic index)",
        ..Spec::ORDINARY
    };

    fn from_reported(reported: &[f64], scale: &Scale) -> Values {
        padded([scale.balanced_pitch_inertia / reported[0] - 1.0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    /// TYPICAL has m l_F l_R = 10 kg m^2. What the coupling does is tested with the integrator, which does it.
    #[test]
    fn the_pitch_inertia_is_told_from_the_coupling_and_back() {
        for (coupling, inertia) in [(0.0, 10.0), (0.25, 8.0), (-0.5, 20.0), (4.0, 2.0)] {
            let values = padded([coupling]);
            near(report::<PitchCoupling>(values)[0], inertia);
            comes_back::<PitchCoupling>(values);
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_lie_within_limits::<PitchCoupling>();
        limits_are::<PitchCoupling>(&[[-0.95, 10.0]]);
        physical_within::<PitchCoupling>(padded([]), [0, 0], [-0.9, 5.0]);
    }
}
