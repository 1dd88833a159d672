use crate::law::*;

/// c |w / w_rms|^p sign(w): a damper of any power. Not an effect to be named: a general curve against
/// which the named laws of the rate are held.
pub struct PowerDamping;

const FORCE: Parameter = Parameter {
    name: "force",
    unit: "N",
    size: |s| 0.1 * s.b_size() * s.w_rms,
    limits: |s| [0.0, 20.0 * s.force_rms()],
};

const POWER: Parameter = Parameter {
    name: "power",
    unit: "-",
    size: |_| 0.3,
    limits: |_| [0.15, 5.0],
};

/// Share of the RMS value below which a power law is rounded off.
const ROUND: f64 = 0.03;

/// |x|^power sign(x), rounded off, of a number in RMS values.
#[inline(always)]
pub fn rounded(x: Lanes, power: Lanes) -> Lanes {
    x * (x * x + ROUND * ROUND).powf((power - 1.0) * 0.5)
}

impl Effect for PowerDamping {
    const SPEC: Spec = Spec {
        id: "power_damping",
        acts: Acts::OneAxle,
        parameters: &[FORCE, POWER],
        amplitudes: &[0],
        starts: |s| {
            [0.4, 1.6, 3.0]
                .map(|power| padded([(FORCE.size)(s), power]))
                .to_vec()
        },
        report: |p, s| vec![reported(&FORCE, p[0], (FORCE.limits)(s)), reported(&POWER, p[1], [0.15, 5.0])],
        law: "force |w / w_rms|^power sign(w)",
        formula: Formula { tyre: "force * w / w_rms * ((w / w_rms)^2 + 0.0009)^(0.5 * (power - 1))", ..Formula::NONE },
        words: "the damper follows some power of the rate",
        confused_with: &["coulomb_friction", "quadratic_damping"],
        source: "Worden & Tomlinson 2001, Nonlinearity in Structural Dynamics",
        family: Some(Family::Damper),
        is_general: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force + p[0] * m.per_mass * rounded(m.w / m.scale.w_rms, p[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    /// Rates in units of the RMS rate, 0.1 m/s, rounded off below 0.03 of it.
    #[test]
    fn the_force_goes_with_a_power_of_the_rate() {
        for power in [0.15, 0.5, 1.0, 2.5] {
            for share in [-4.0, -1.0, -0.02, 0.0, 0.3, 2.0_f64] {
                let force = 12.0 * share * (share * share + 9e-4).powf(0.5 * (power - 1.0));
                let w = 0.1 * share;
                let at = At { d: -1e-3, w, ..AT };
                near(tyre::<PowerDamping>(padded([12.0, power]), &at), -60.0 + 500.0 * w + force);
            }
        }
    }

    #[test]
    fn well_above_the_rounding_it_is_the_power_itself() {
        let force = |w: f64| tyre::<PowerDamping>(padded([12.0, 0.5]), &At { w, ..AT }) - 500.0 * w;
        assert!((force(-0.4) / -24.0 - 1.0).abs() < 1e-3);
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<PowerDamping>();
        limits_are::<PowerDamping>(&[[0.0, 3000.0], [0.15, 5.0]]);
        physical_within::<PowerDamping>(padded([10.0, 1.0]), [0, 0], [0.0, 3000.0]);
        physical_within::<PowerDamping>(padded([10.0, 1.0]), [1, 1], [0.15, 5.0]);
        comes_back::<PowerDamping>(padded([10.0, 1.7]));
    }
}
