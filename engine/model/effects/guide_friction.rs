use super::coulomb_friction::{FRICTION, WIDTH, dry, sharpness};
use crate::law::*;

/// -Fc sign(z'), smoothed: dry friction against the resting frame of a rig.
pub struct GuideFriction;

impl Effect for GuideFriction {
    const SPEC: Spec = Spec {
        id: "guide_friction",
        acts: Acts::OneAxle,
        needs: &[Need::Road],
        parameters: &[FRICTION, WIDTH],
        amplitudes: &[0],
        starts: |s| vec![padded([(FRICTION.size)(s), 0.02 * s.w_rms])],
        report: |p, s| vec![reported(&FRICTION, p[0], [0.0, (FRICTION.limits)(s)[1]])],
        damps: sharpness,
        corners: true,
        law: "-friction sign(z') on the mass",
        formula: Formula {
            body: "-friction * z_dot / sqrt(z_dot^2 + (friction / m * 0.5 * felt_after + width)^2)",
            ..Formula::NONE
        },
        words: "dry friction holds the mass against the resting frame",
        confused_with: &["coulomb_friction", "ground_damping"],
        noun: "dry friction of {friction} against the resting frame",
        source: "Olsson et al. 1998, Eur. J. Control 4:176-195",
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn body(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force - dry(p[0] * m.per_mass, m.v, p[1], m.felt_after)
    }

    fn from_reported(reported: &[f64], scale: &Scale) -> Values {
        padded([reported[0], (WIDTH.size)(scale)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    #[test]
    fn friction_holds_the_mass_against_the_ground_whatever_the_tyre_does() {
        for felt_after in [0.0, 4e-3] {
            for v in [-0.3, -2e-3, 0.0, 1e-3, 0.05] {
                let width = 2e-3 + 60.0 / 30.0 * 0.5 * felt_after;
                let friction = 60.0 * v / f64::sqrt(v * v + width * width);
                let at = At { w: -0.1, v, felt_after, ..AT };
                near(body::<GuideFriction>(padded([60.0, 2e-3]), &at), PUSH - friction);
                near(tyre::<GuideFriction>(padded([60.0, 2e-3]), &at), -50.0);
            }
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<GuideFriction>();
        limits_are::<GuideFriction>(&[[0.0, 3000.0], [2e-4, 0.04]]);
        physical_within::<GuideFriction>(padded([]), [0, 0], [0.0, 3000.0]);
    }

    #[test]
    fn friction_comes_back_from_the_report_with_the_usual_width() {
        let back = GuideFriction::from_reported(&report::<GuideFriction>(padded([25.0, 0.03])), &Scale::TYPICAL);
        assert_eq!(back, padded([25.0, 1e-3]));
    }
}
