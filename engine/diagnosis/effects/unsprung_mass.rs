use crate::diagnosis::law::*;

/// A wheel of share mu of the mass stands on the tyre and carries the rest, which is z, on its own
/// spring and damper: a fork or suspension stage. The integrator takes the tyre's deflection from
/// the wheel's states.
pub struct UnsprungMass;

const FRACTION: Parameter = Parameter {
    name: "mass_fraction",
    unit: "-",
    size: |_| 0.05,
    limits: |_| [0.005, 0.9],
};
const FREQUENCY: Parameter = Parameter {
    name: "natural_frequency",
    unit: "Hz",
    size: |s| 1.0 / s.period(),
    limits: |s| [0.1 / s.period(), 1.5 / s.step],
};
const DAMPING: Parameter = Parameter {
    name: "damping_ratio",
    unit: "-",
    size: |_| 0.1,
    limits: |_| [0.0, 3.0],
};

/// Least share of the mass that a wheel with its tyre has: a light one of 1.2 kg under a wheel that carries 48 kg.
const LIGHTEST: f64 = 0.025;

impl UnsprungMass {
    /// Force of the suspension on the upper mass, over the whole axle mass.
    #[inline(always)]
    fn lift(p: &LaneValues, m: &Motion, s: &States) -> Lanes {
        let w = p[1] * std::f64::consts::TAU;
        (Lanes::all(1.0) - p[0]) * w * (w * (s[0] - m.z) + p[2] * (s[1] - m.v) * 2.0)
    }
}

impl Effect for UnsprungMass {
    const SPEC: Spec = Spec {
        id: "unsprung_mass",
        acts: Acts::OneAxle,
        needs: &[Need::Mass],
        parameters: &[FRACTION, FREQUENCY, DAMPING],
        amplitudes: &[],
        size_parameter: 1,
        stronger: Stronger::Smaller,
        starts: |s| {
            let f0 = 1.0 / s.period();
            let mut starts = Vec::new();
            for fraction in [0.08, 0.25] {
                for f in [1.5, 2.5, 4.0] {
                    for zeta in [0.1, 0.4] {
                        starts.push([fraction, f * f0, zeta, 0.0]);
                    }
                }
            }
            starts
        },
        report: |p, s| {
            vec![
                reported(&FRACTION, p[0], [LIGHTEST, 0.8]),
                reported(&FREQUENCY, p[1], [0.2 / s.period(), 1.0 / s.step]),
                reported(&DAMPING, p[2], [0.0, 1.5]),
            ]
        },
        stiffens: |p, s| s.k_size() / p[0].max(0.01),
        alone: |[tyre, tyre_damping], p| {
            let w = p[1] * std::f64::consts::TAU;
            let [spring, damping] = [(1.0 - p[0]) * w * w, (1.0 - p[0]) * 2.0 * p[2] * w];
            // Two springs in series; each damper sees its own share of the deflection.
            let share = spring / (tyre + spring);
            [
                tyre * share,
                tyre_damping * share * share + damping * (1.0 - share) * (1.0 - share),
            ]
        },
        // Of two springs in series below the mass that is measured either may be the tyre: from u to z
        // k1 k2 / ((m1 s^2 + k1 + k2) (m2 s^2 + k2) - k2^2) is the same with k1' = k2 M/m2, k2' = k1 m2/M; dampers likewise.
        twin: Some(|[tyre, tyre_damping], p| {
            let w = p[1] * std::f64::consts::TAU;
            let turn = tyre.max(0.0).sqrt();
            let ratio = tyre_damping / (2.0 * turn).max(f64::MIN_POSITIVE);
            ([w * w, 2.0 * p[2] * w], [p[0], turn / std::f64::consts::TAU, ratio, 0.0])
        }),
        states: 2,
        second_mass: true,
        carries: true,
        expected: &[(0, 0.15, 0.1)],
        law: "a share (mass_fraction) of the mass stands on the tyre and carries the rest, z, on a spring and damper (natural_frequency, damping_ratio)",
        words: "the wheel is a mass of its own on the tyre, below a fork or suspension stage",
        confused_with: &["viscoelastic_tyre", "sensor_delay", "tyre_enveloping"],
        source: "Schoeneck & Nagurka, BMD 2023 (quarter car of a bicycle)",
        ..Spec::ORDINARY
    };

    /// With the wheel between tyre and mass, the suspension's force takes the tyre's place.
    #[inline(always)]
    fn inertia(p: &LaneValues, m: &Motion, s: &States, force: Lanes) -> Lanes {
        (force + Self::lift(p, m, s)) / (Lanes::all(1.0) - p[0])
    }

    /// Rates of the wheel's height and velocity without the tyre's force, which the integrator adds.
    #[inline(always)]
    fn rates(p: &LaneValues, m: &Motion, s: &States) -> States {
        [s[1], -(Self::lift(p, m, s) / p[0])]
    }
}
