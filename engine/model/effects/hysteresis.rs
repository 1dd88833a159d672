use crate::law::*;

/// Rate-independent loss, Dahl's law: f' = A w - (A/fy) |w| f, which is the law of Bouc and Wen with n = 1 and
/// gamma = 0. Fitted as A and the yield deflection fy/A, in which the force is linear in A.
pub struct Hysteresis;

pub(super) const STIFFNESS: Parameter = Parameter {
    name: "stiffness",
    unit: "N/m",
    size: |s| 0.2 * s.k_size(),
    limits: |s| [0.0, 300.0 * s.k_size()],
};

pub(super) const YIELD: Parameter = Parameter {
    name: "yield_deflection",
    unit: "m",
    size: |s| 0.3 * s.d_rms,
    limits: |s| [0.01 * s.d_rms, 10.0 * s.d_peak],
};

/// w - |w| s / y, slowed down where the state s would yield faster than the integrator can follow; it still goes to
/// y sign(w).
#[inline(always)]
pub(super) fn slide(y: Lanes, m: &Motion, s: Lanes) -> Lanes {
    let turn = m.w.abs() / y;
    let fastest = Lanes::all(STABLE / m.step);
    (m.w - turn * s) * (fastest / turn.max(fastest))
}

impl Effect for Hysteresis {
    const SPEC: Spec = Spec {
        id: "hysteresis",
        acts: Acts::OneAxle,
        parameters: &[STIFFNESS, YIELD],
        amplitudes: &[0],
        starts: |s| [0.1, 0.3, 0.8, 2.0].map(|y| padded([(STIFFNESS.size)(s), y * s.d_rms])).to_vec(),
        report: |p, s| {
            let force = Parameter { name: "yield_force", unit: "N", ..YIELD };
            vec![
                reported(&STIFFNESS, p[0], [0.0, (STIFFNESS.limits)(s)[1]]),
                reported(&force, p[0] * p[1], [0.0, 1e3 * s.force_rms()]),
            ]
        },
        stiffens: |p, _| p[0],
        states: 1,
        law: "f with f' = stiffness (w - |w| f / yield_force) (Dahl's law)",
        formula: Formula {
            tyre: "stiffness * slip",
            states: &[("slip", "(w - abs(w) / yield_deflection * slip) / max(1, dt * abs(w) / (1.5 * yield_deflection))")],
            ..Formula::NONE
        },
        words: "the tyre or frame loses energy by rate-independent hysteresis",
        confused_with: &["coulomb_friction", "cubic_stiffness", "free_play"],
        noun: "hysteresis with a stiffness of {stiffness} and a yield force of {yield_force}",
        source: "Dahl 1968, A solid friction model, Aerospace Corp. TOR-0158(3107-18)-1",
        family: Some(Family::Damper),
        is_odd: true,
        case_of: Some("rate_hysteresis"),
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, s: &States, force: Lanes) -> Lanes {
        force + p[0] * m.per_mass * s[0]
    }

    /// The state is f/A, a length.
    #[inline(always)]
    fn rates(p: &LaneValues, m: &Motion, s: &States) -> States {
        [slide(p[1], m, s[0]), Lanes::ZERO]
    }

    fn from_reported(reported: &[f64], _scale: &Scale) -> Values {
        padded([reported[0], reported[1] / reported[0]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    const VALUES: Values = padded([2e4, 4e-4]);

    #[test]
    fn the_state_goes_as_dahls_law_says_and_the_force_with_it() {
        for (w, s) in [(0.1, 0.0), (0.1, 3e-4), (-0.1, 3e-4), (-0.02, -4e-4), (0.02, -4e-4)] {
            let at = At { d: 1e-3, w, states: [s, 0.0], ..AT };
            near(rates::<Hysteresis>(VALUES, &at)[0], w - f64::abs(w) * s / 4e-4);
            near(tyre::<Hysteresis>(VALUES, &at), 60.0 + 500.0 * w + 2e4 * s);
        }
    }

    /// Where it would yield within less than 1/1.5 of a step it goes the same way, more slowly.
    #[test]
    fn a_state_too_fast_for_the_integrator_is_slowed_down() {
        let (w, s) = (0.3, -1e-4);
        let at = At { w, step: 5e-3, states: [s, 0.0], ..AT };
        let sharp = w - w * s / 4e-4;
        near(rates::<Hysteresis>(VALUES, &at)[0], sharp * (1.5 / 5e-3) / (w / 4e-4));
    }

    /// Solved over the way x that has gone by: y (1 - e^(-x/y)).
    #[test]
    fn the_force_grows_towards_the_yield_force_and_stays_there() {
        for w in [0.05, -0.05] {
            let at = At { w, ..AT };
            let f = |seconds: f64| 2e4 * later::<Hysteresis>(VALUES, &at, seconds)[0];
            let sign = f64::signum(w);
            for way in [1e-4, 4e-4, 1e-3] {
                let truth = sign * 8.0 * (1.0 - f64::exp(-way / 4e-4));
                assert!((f(way / 0.05) - truth).abs() < 1e-9, "{truth}");
            }
            assert!((f(0.02 / 0.05) - sign * 8.0).abs() < 1e-9);
        }
    }

    #[test]
    fn from_rest_it_is_as_stiff_as_the_integrator_is_told() {
        let found = steepness(0.0);
        let told = (Hysteresis::SPEC.stiffens)(&VALUES, &Scale::TYPICAL);
        assert!((found / told - 1.0).abs() < 1e-3, "{found} instead of {told}");
    }

    #[test]
    fn where_the_rate_turns_after_the_force_has_yielded_it_is_twice_as_stiff_at_most() {
        let told = (Hysteresis::SPEC.stiffens)(&VALUES, &Scale::TYPICAL);
        for s in [-4e-4, -2e-4, 0.0, 4e-4] {
            assert!(steepness(s) < 2.001 * told, "{} at {s}", steepness(s));
        }
    }

    /// Force (N) per deflection (m) while it is pressed on from the state `s`.
    fn steepness(s: f64) -> f64 {
        let at = At { w: 0.01, states: [s, 0.0], ..AT };
        let seconds = 1e-6;
        2e4 * (later::<Hysteresis>(VALUES, &at, seconds)[0] - s) / (0.01 * seconds)
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<Hysteresis>();
        limits_are::<Hysteresis>(&[[0.0, 1.8e7], [1e-5, 0.03]]);
        physical_within::<Hysteresis>(VALUES, [0, 0], [0.0, 1.8e7]);
        // The yield force, 2e4 N/m times the yield deflection, up to 1000 times the RMS force.
        physical_within::<Hysteresis>(VALUES, [1, 1], [0.0, 7.5]);
        near(report::<Hysteresis>(VALUES)[1], 8.0);
        comes_back::<Hysteresis>(VALUES);
    }
}
