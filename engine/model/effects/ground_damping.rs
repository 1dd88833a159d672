use crate::law::*;

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
        starts: |s| vec![padded([(DAMPING.size)(s)])],
        report: |p, s| vec![reported(&DAMPING, p[0], [0.0, (DAMPING.limits)(s)[1]])],
        damps: |p, _| p[0],
        law: "-damping z' on the mass",
        formula: Formula { body: "-damping * z_dot", ..Formula::NONE },
        words: "a damper acts against the resting frame (a rig's guide, air)",
        confused_with: &["guide_friction", "sensor_gain", "sensor_delay"],
        noun: "damping of {damping} against the resting frame",
        source: "Gillespie, Fundamentals of Vehicle Dynamics, 1992 (quarter car on a rig)",
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn body(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force - p[0] * m.per_mass * m.v
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    #[test]
    fn the_damper_holds_the_mass_against_the_ground_and_not_across_the_tyre() {
        for v in [-0.4, -0.01, 0.0, 0.2] {
            let at = At { d: 1e-3, w: 0.3, v, ..AT };
            near(body::<GroundDamping>(padded([200.0]), &at), PUSH - 200.0 * v);
            near(tyre::<GroundDamping>(padded([200.0]), &at), 60.0 + 150.0);
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<GroundDamping>();
        limits_are::<GroundDamping>(&[[0.0, 5e4]]);
        physical_within::<GroundDamping>(padded([]), [0, 0], [0.0, 5e4]);
        comes_back::<GroundDamping>(padded([300.0]));
    }

    #[test]
    fn the_integrator_is_told_how_strongly_the_mass_is_damped() {
        let told = (GroundDamping::SPEC.damps)(&padded([2e4]), &Scale::TYPICAL);
        near(told, 2e4);
    }
}
