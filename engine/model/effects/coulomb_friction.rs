use crate::law::*;

/// Fc sign(w), smoothed over the rate that the integrator can resolve: dry friction in a fork, a
/// seat post, a rig.
pub struct CoulombFriction;

pub(super) const FRICTION: Parameter = Parameter {
    name: "friction",
    unit: "N",
    size: |s| 0.05 * s.force_rms(),
    limits: |s| [0.0, 20.0 * s.force_rms()],
};

/// Rate (m/s) over which the sign is smooth: fitted, since no two contacts slip alike, but a nuisance.
pub(super) const WIDTH: Parameter = Parameter {
    name: "width",
    unit: "m/s",
    size: |s| 0.01 * s.w_rms,
    limits: |s| [0.002 * s.w_rms, 0.4 * s.w_rms],
};

/// Part of the RMS rate over which the integrator must resolve how the sign changes.
const RESOLVED: f64 = 0.05;

/// Damping (N s/m) of dry friction while its sign changes, no sharper than resolved.
pub(super) fn sharpness(p: &Values, s: &Scale) -> f64 {
    p[0] / (RESOLVED * s.w_rms)
}

/// Dry friction of `force` (m/s^2), no sharper than the integrator can resolve.
#[inline(always)]
pub(super) fn dry(force: Lanes, rate: Lanes, width: Lanes, step: f64) -> Lanes {
    force * rate.soft_sign(force * (0.5 * step) + width)
}

impl Effect for CoulombFriction {
    const SPEC: Spec = Spec {
        id: "coulomb_friction",
        acts: Acts::OneAxle,
        parameters: &[FRICTION, WIDTH],
        amplitudes: &[0],
        starts: |s| vec![padded([(FRICTION.size)(s), 0.02 * s.w_rms])],
        report: |p, s| vec![reported(&FRICTION, p[0], [0.0, (FRICTION.limits)(s)[1]])],
        damps: sharpness,
        corners: true,
        law: "friction sign(w)",
        formula: Formula { tyre: "friction * w / sqrt(w^2 + (friction / m * 0.5 * felt_after + width)^2)", ..Formula::NONE },
        words: "dry friction acts along the suspension (fork, seat post, guide)",
        confused_with: &["quadratic_damping", "hysteresis", "guide_friction"],
        limit_of: &["hysteresis"],
        noun: "dry friction of {friction}",
        source: "Olsson et al. 1998, Eur. J. Control 4:176-195",
        family: Some(Family::Damper),
        is_odd: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force + dry(p[0] * m.per_mass, m.w, p[1], m.felt_after)
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
    fn the_width_shows_however_strong_the_friction() {
        let at = |width: f64| {
            let [force, rate, width] = [20.0, 1e-3, width].map(Lanes::all);
            dry(force, rate, width, 2e-3).0[0]
        };
        assert!(at(2e-4) < 0.999 * at(1e-4));
    }

    #[test]
    fn friction_is_against_the_rate_and_its_sign_changes_over_the_width() {
        for felt_after in [0.0, 4e-3] {
            for w in [-0.3, -2e-3, 0.0, 1e-3, 0.05] {
                let width = 2e-3 + 60.0 / 30.0 * 0.5 * felt_after;
                let friction = 60.0 * w / f64::sqrt(w * w + width * width);
                let at = At { d: 1e-3, w, felt_after, ..AT };
                near(tyre::<CoulombFriction>(padded([60.0, 2e-3]), &at), 60.0 + 500.0 * w + friction);
            }
        }
    }

    /// Where the sign changes over a twentieth of the RMS rate, 5 mm/s.
    #[test]
    fn the_integrator_is_told_the_slope_of_the_sharpest_change() {
        let force = |w: f64| tyre::<CoulombFriction>(padded([60.0, 5e-3]), &At { w, ..AT });
        let found = slope(force, 0.0, 1e-7) - 500.0;
        let told = (CoulombFriction::SPEC.damps)(&padded([60.0, 5e-3]), &Scale::TYPICAL);
        assert!((found / told - 1.0).abs() < 1e-6, "{found} instead of {told}");
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<CoulombFriction>();
        limits_are::<CoulombFriction>(&[[0.0, 3000.0], [2e-4, 0.04]]);
        physical_within::<CoulombFriction>(padded([]), [0, 0], [0.0, 3000.0]);
    }

    #[test]
    fn friction_comes_back_from_the_report_with_the_usual_width() {
        let back = CoulombFriction::from_reported(&report::<CoulombFriction>(padded([25.0, 0.03])), &Scale::TYPICAL);
        assert_eq!(back, padded([25.0, 1e-3]));
    }
}
