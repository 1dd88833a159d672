use crate::law::*;

/// a sin(2 crank angle + phase), fitted as its sine and cosine parts.
pub struct PedallingForce;

const fn part(name: &'static str) -> Parameter {
    Parameter {
        name,
        unit: "N",
        size: |s| 0.03 * s.force_rms(),
        limits: |s| [-20.0 * s.force_rms(), 20.0 * s.force_rms()],
    }
}

impl Effect for PedallingForce {
    const SPEC: Spec = Spec {
        id: "pedalling_force",
        acts: Acts::OneAxle,
        needs: &[Need::Cadence, Need::Mass],
        parameters: &[part("sine"), part("cosine")],
        amplitudes: &[0, 1],
        starts: |s| {
            let a = 0.03 * s.force_rms();
            vec![padded([a]), padded([0.0, a])]
        },
        report: |p, s| {
            let limit = 20.0 * s.force_rms();
            vec![
                Reported { name: "amplitude".into(), unit: "N".into(), value: p[0].hypot(p[1]), physical: p[0].hypot(p[1]) < limit },
                Reported { name: "phase".into(), unit: "rad".into(), value: p[1].atan2(p[0]), physical: true },
            ]
        },
        law: "amplitude sin(2 crank + phase) on the mass",
        formula: Formula { body: "sine * sin(2 * crank) + cosine * cos(2 * crank)", ..Formula::NONE },
        words: "pedalling pushes the axle at twice the cadence",
        confused_with: &["wheel_out_of_round"],
        noun: "a pedalling force of {amplitude} with a phase of {phase}",
        source: "Wilson & Schmidt, Bicycling Science, 4th ed. 2020 (two strokes in a turn of the crank)",
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn body(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        let [sin, cos] = m.crank.double();
        force + (p[0] * sin + p[1] * cos) * m.per_mass
    }

    fn from_reported(reported: &[f64], _scale: &Scale) -> Values {
        let (sin, cos) = reported[1].sin_cos();
        padded([reported[0] * cos, reported[0] * sin])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    #[test]
    fn the_force_swings_twice_in_a_turn_of_the_crank() {
        let [amplitude, phase] = [50.0, 0.7];
        let values = padded([amplitude * f64::cos(phase), amplitude * f64::sin(phase)]);
        for crank in [0.0, 0.4, 1.5, 3.0, 40.0] {
            let at = At { crank, ..AT };
            near(body::<PedallingForce>(values, &at), PUSH + amplitude * f64::sin(2.0 * crank + phase));
        }
        near(report::<PedallingForce>(values)[0], amplitude);
        near(report::<PedallingForce>(values)[1], phase);
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<PedallingForce>();
        limits_are::<PedallingForce>(&[[-3000.0, 3000.0]; 2]);
        physical_within::<PedallingForce>(padded([]), [0, 0], [-3000.0, 3000.0]);
        physical_within::<PedallingForce>(padded([0.0, 1800.0]), [0, 0], [-2400.0, 2400.0]);
        for (sin, cos) in [(20.0, -5.0), (-3.0, -40.0), (0.0, 7.0)] {
            comes_back::<PedallingForce>(padded([sin, cos]));
        }
    }
}
