use super::coulomb_friction::{FRICTION, WIDTH, dry, sharpness};
use crate::diagnosis::law::*;

/// -Fc sign(z'), smoothed: dry friction against the resting frame of a rig.
pub struct GuideFriction;

impl Effect for GuideFriction {
    const SPEC: Spec = Spec {
        id: "guide_friction",
        acts: Acts::OneAxle,
        needs: &[Need::Road],
        parameters: &[FRICTION, WIDTH],
        amplitudes: &[0],
        starts: |s| vec![[(FRICTION.size)(s), 0.02 * s.w_rms, 0.0, 0.0]],
        report: |p, s| vec![reported(&FRICTION, p[0], [0.0, (FRICTION.limits)(s)[1]])],
        damps: sharpness,
        corners: true,
        law: "-friction sign(z') on the mass",
        words: "dry friction holds the mass against the resting frame",
        confused_with: &["coulomb_friction", "ground_damping"],
        source: "Olsson et al. 1998, Eur. J. Control 4:176-195",
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn body(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force - dry(p[0] * m.per_mass, m.v, p[1], m.felt_after)
    }

    fn from_reported(reported: &[f64], scale: &Scale) -> Values {
        [reported[0], (WIDTH.size)(scale), 0.0, 0.0]
    }
}
