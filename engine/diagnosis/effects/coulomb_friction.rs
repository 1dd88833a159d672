use crate::diagnosis::law::*;

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
        starts: |s| vec![[(FRICTION.size)(s), 0.02 * s.w_rms, 0.0, 0.0]],
        report: |p, s| vec![reported(&FRICTION, p[0], [0.0, (FRICTION.limits)(s)[1]])],
        damps: sharpness,
        corners: true,
        law: "friction sign(w)",
        words: "dry friction acts along the suspension (fork, seat post, guide)",
        confused_with: &["quadratic_damping", "hysteresis", "guide_friction"],
        limit_of: &["hysteresis"],
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
        [reported[0], (WIDTH.size)(scale), 0.0, 0.0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_width_shows_however_strong_the_friction() {
        let at = |width: f64| {
            let [force, rate, width] = [20.0, 1e-3, width].map(Lanes::all);
            dry(force, rate, width, 2e-3).0[0]
        };
        assert!(at(2e-4) < 0.999 * at(1e-4));
    }
}
