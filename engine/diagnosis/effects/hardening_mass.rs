use super::sprung_mass::{DAMPING, FRACTION, FREQUENCY, SprungMass};
use crate::diagnosis::law::*;

/// A sprung mass whose spring hardens or softens with the square of its travel. Not an effect to be named: a general law
/// against which a linear mode is held.
pub struct HardeningMass;

/// Stiffness that is added at a travel of the axle's RMS deflection, over the linear one.
const HARDENING: Parameter = Parameter {
    name: "hardening",
    unit: "-",
    size: |_| 0.1,
    limits: |_| [-0.2, 10.0],
};

impl Effect for HardeningMass {
    const SPEC: Spec = Spec {
        id: "hardening_mass",
        acts: Acts::OneAxle,
        needs: &[Need::Mass],
        parameters: &[FRACTION, FREQUENCY, DAMPING, HARDENING],
        report: |p, s| vec![reported(&HARDENING, p[3], (HARDENING.limits)(s))],
        states: 2,
        second_mass: true,
        law: "a sprung mass whose stiffness is multiplied by 1 + hardening (travel / z_rms)^2",
        words: "the frequency of a second mass depends on how far it moves",
        confused_with: &["sprung_mass"],
        source: "Kerschen et al. 2006, Mech. Syst. Signal Process. 20:505-592",
        is_general: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn inertia(p: &LaneValues, m: &Motion, s: &States, force: Lanes) -> Lanes {
        (force - p[0] * pull(p, m, s)) / (Lanes::all(1.0) - p[0])
    }

    #[inline(always)]
    fn rates(p: &LaneValues, m: &Motion, s: &States) -> States {
        [s[1], pull(p, m, s)]
    }
}

/// Acceleration that spring and damper give the sprung mass.
#[inline(always)]
fn pull(p: &LaneValues, m: &Motion, s: &States) -> Lanes {
    let w = p[1] * std::f64::consts::TAU;
    let travel = m.z - s[0];
    let share = travel / m.scale.d_rms;
    // Beyond ten deflections no ride goes, but a fit on its way may.
    let most = Lanes::all(100.0);
    SprungMass::pull(p, m, s) + w * w * p[3] * (share * share).min(most) * travel
}
