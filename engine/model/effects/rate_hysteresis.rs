use super::hysteresis::{Hysteresis, STIFFNESS, YIELD, slide};
use crate::law::*;

/// Hysteresis whose yield force goes with a power of the rate. Not an effect to be named: a general law against which
/// rate-independent loss is held.
pub struct RateHysteresis;

const POWER: Parameter = Parameter {
    name: "power",
    unit: "-",
    size: |_| 0.1,
    limits: |_| [-2.0, 2.0],
};

/// Rate below which the power law is rounded off, in RMS rates.
const ROUND: f64 = 0.05;

impl Effect for RateHysteresis {
    const SPEC: Spec = Spec {
        id: "rate_hysteresis",
        acts: Acts::OneAxle,
        parameters: &[STIFFNESS, YIELD, POWER],
        report: |p, s| vec![reported(&POWER, p[2], (POWER.limits)(s))],
        stiffens: |p, _| p[0],
        states: 1,
        law: "hysteresis whose yield force goes with a power of |w|",
        formula: Formula {
            tyre: "stiffness * slip",
            states: &[
                ("slip", "(w - abs(w) / (yield_deflection * ((w / w_rms)^2 + 0.0025)^(0.5 * power)) * slip) / max(1, dt * abs(w) / (1.5 * yield_deflection * ((w / w_rms)^2 + 0.0025)^(0.5 * power)))"),
            ],
            ..Formula::NONE
        },
        words: "the loss depends on the rate",
        confused_with: &["hysteresis"],
        source: "Armstrong-Helouvry, Dupont & Canudas de Wit 1994, Automatica 30:1083-1138",
        is_general: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, s: &States, force: Lanes) -> Lanes {
        Hysteresis::tyre(p, m, s, force)
    }

    #[inline(always)]
    fn rates(p: &LaneValues, m: &Motion, s: &States) -> States {
        let w = m.w / m.scale.w_rms;
        let y = p[1] * (w * w + ROUND * ROUND).powf(p[2] * 0.5);
        [slide(y, m, s[0]), Lanes::ZERO]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    /// Yield deflection at so many RMS rates of 0.1 m/s, rounded off below 0.05 of one.
    fn yield_at(w: f64, power: f64) -> f64 {
        let share = w / 0.1;
        4e-4 * f64::powf(share * share + 0.0025, 0.5 * power)
    }

    #[test]
    fn the_yield_deflection_goes_with_a_power_of_the_rate() {
        for power in [-1.0, 0.0, 0.5, 2.0] {
            for (w, s) in [(0.05, 1e-4), (-0.05, 1e-4), (0.1, -3e-4), (-0.02, -2e-5)] {
                let at = At { d: 1e-3, w, step: 1e-6, states: [s, 0.0], ..AT };
                let values = padded([2e4, 4e-4, power]);
                near(rates::<RateHysteresis>(values, &at)[0], w - f64::abs(w) * s / yield_at(w, power));
                near(tyre::<RateHysteresis>(values, &at), 60.0 + 500.0 * w + 2e4 * s);
            }
        }
    }

    #[test]
    fn the_force_settles_where_it_yields_at_that_rate() {
        for w in [0.2, -0.02] {
            let at = At { w, step: 1e-6, ..AT };
            let way = 40.0 * yield_at(w, 0.5);
            let settled = later::<RateHysteresis>(padded([2e4, 4e-4, 0.5]), &at, way / f64::abs(w))[0];
            let truth = f64::signum(w) * yield_at(w, 0.5);
            assert!((settled / truth - 1.0).abs() < 1e-9, "{settled} instead of {truth}");
        }
    }

    #[test]
    fn without_stiffness_it_changes_nothing() {
        changes_nothing::<RateHysteresis>(padded([0.0, 4e-4, 0.5]));
    }

    #[test]
    fn limits_and_what_is_physical() {
        limits_are::<RateHysteresis>(&[[0.0, 1.8e7], [1e-5, 0.03], [-2.0, 2.0]]);
        physical_within::<RateHysteresis>(padded([2e4, 4e-4]), [2, 0], [-2.0, 2.0]);
    }
}
