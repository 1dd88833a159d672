use crate::diagnosis::law::*;

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
        starts: |s| [0.1, 0.3, 0.8, 2.0].map(|y| [(STIFFNESS.size)(s), y * s.d_rms, 0.0, 0.0]).to_vec(),
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
        words: "the tyre or frame loses energy by rate-independent hysteresis",
        confused_with: &["coulomb_friction", "cubic_stiffness", "free_play"],
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
        [reported[0], reported[1] / reported[0], 0.0, 0.0]
    }
}
