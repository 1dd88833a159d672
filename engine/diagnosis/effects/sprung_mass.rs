use crate::diagnosis::law::*;

/// A share mu of the axle mass rides on its own spring and damper above the rest, which is z: a rider
/// on the saddle, luggage, a second stage.
pub struct SprungMass;

pub(super) const FRACTION: Parameter = Parameter {
    name: "mass_fraction",
    unit: "-",
    size: |_| 0.1,
    limits: |_| [0.0, 0.97],
};
pub(super) const FREQUENCY: Parameter = Parameter {
    name: "natural_frequency",
    unit: "Hz",
    size: |s| 0.3 / s.period(),
    limits: |s| [0.3 / s.train_s, 0.45 / s.step],
};
pub(super) const DAMPING: Parameter = Parameter {
    name: "damping_ratio",
    unit: "-",
    size: |_| 0.1,
    limits: |_| [0.0, 3.0],
};

/// Least share of the mass that is one of its own. A lighter one is no rider or luggage: on a free decay (a bicycle's fork as a
/// pendulum, ../shared/real) a mass of 6e-5 with the axle's own frequency and a start of its own bends the envelope as friction does.
const LIGHTEST: f64 = 5e-3;

impl SprungMass {
    /// Acceleration that spring and damper give the sprung mass.
    #[inline(always)]
    pub(super) fn pull(p: &LaneValues, m: &Motion, s: &States) -> Lanes {
        let w = p[1] * std::f64::consts::TAU;
        w * (w * (m.z - s[0]) + p[2] * (m.v - s[1]) * 2.0)
    }
}

impl Effect for SprungMass {
    const SPEC: Spec = Spec {
        id: "sprung_mass",
        acts: Acts::OneAxle,
        needs: &[Need::Mass],
        parameters: &[FRACTION, FREQUENCY, DAMPING],
        amplitudes: &[0],
        starts: |s| {
            let f0 = 1.0 / s.period();
            let mut hertz = [0.15, 0.3, 0.5, 0.75, 1.0, 1.4, 2.0, 3.0].map(|f| f * f0).to_vec();
            // Where the axle moves faster than that its mode may be as fast, and on a drive, which has hardly a
            // spring and drifts, faster.
            let moves = s.a_rms / s.v_rms / std::f64::consts::TAU;
            let most = if f0 < 0.1 * moves { f64::INFINITY } else { 2.0 * moves };
            let top = most.min(0.4 / s.step);
            let mut f = 4.5 * f0;
            while f < top {
                hertz.push(f);
                f *= 1.5;
            }
            let each = |f: f64| [0.07, 0.3].map(|zeta| [0.1, f, zeta, 0.0]);
            hertz.into_iter().flat_map(each).collect()
        },
        nearer: |p, s, zoom| {
            let ratio = 1.5_f64.powf(0.5_f64.powi(zoom as i32));
            let fastest = 0.45 / s.step;
            let each = |f: f64| [p[2], 0.4 * p[2]].map(|zeta| [0.1, f.min(fastest), zeta, 0.0]);
            [p[1] * ratio, p[1] / ratio].into_iter().flat_map(each).collect()
        },
        report: |p, s| {
            vec![
                reported(&FRACTION, p[0], [LIGHTEST, 0.95]),
                reported(&FREQUENCY, p[1], [0.5 / s.train_s, 0.4 / s.step]),
                reported(&DAMPING, p[2], [0.0, 0.9]),
            ]
        },
        states: 2,
        second_mass: true,
        law: "a share (mass_fraction) of the mass rides on a spring and damper of its own (natural_frequency, damping_ratio) above z",
        words: "a part of the mass rides on its own spring (rider on the saddle, luggage)",
        confused_with: &["viscoelastic_tyre", "sensor_delay", "pitch_coupling"],
        source: "Fairley & Griffin 1989, J. Biomech. 22:81-94 (seated body)",
        case_of: Some("hardening_mass"),
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn inertia(p: &LaneValues, m: &Motion, s: &States, force: Lanes) -> Lanes {
        (force - p[0] * Self::pull(p, m, s)) / (Lanes::all(1.0) - p[0])
    }

    /// Position and velocity of the sprung mass, from its place at rest.
    #[inline(always)]
    fn rates(p: &LaneValues, m: &Motion, s: &States) -> States {
        [s[1], Self::pull(p, m, s)]
    }
}
