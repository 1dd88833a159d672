use super::power_damping::rounded;
use crate::law::*;

/// f |d / d_rms|^p sign(d): a spring that stiffens with any power. Not an effect to be named: a general curve against which several
/// named springs of one axle are held.
pub struct PowerStiffness;

const FORCE: Parameter = Parameter {
    name: "force",
    unit: "N",
    size: |s| 0.1 * s.k.abs() * s.d_rms,
    limits: |s| [0.0, 20.0 * s.force_rms()],
};

const POWER: Parameter = Parameter {
    name: "power",
    unit: "-",
    size: |_| 0.5,
    limits: |_| [1.2, 12.0],
};

impl Effect for PowerStiffness {
    const SPEC: Spec = Spec {
        id: "power_stiffness",
        acts: Acts::OneAxle,
        parameters: &[FORCE, POWER],
        amplitudes: &[0],
        starts: |s| {
            [2.0, 4.0, 7.0]
                .map(|power| padded([(FORCE.size)(s), power]))
                .to_vec()
        },
        report: |p, s| vec![reported(&FORCE, p[0], (FORCE.limits)(s)), reported(&POWER, p[1], [1.2, 12.0])],
        stiffens: |p, s| p[0] * p[1] * 2f64.powf(p[1] - 1.0) / s.d_rms,
        law: "force |d / d_rms|^power sign(d)",
        formula: Formula { tyre: "force * d / d_rms * ((d / d_rms)^2 + 0.0009)^(0.5 * (power - 1))", ..Formula::NONE },
        words: "the spring stiffens with some power of its deflection",
        confused_with: &["cubic_stiffness", "bump_stop"],
        source: "Worden & Tomlinson 2001, Nonlinearity in Structural Dynamics",
        family: Some(Family::Spring),
        is_general: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force + p[0] * m.per_mass * rounded(m.d / m.scale.d_rms, p[1])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    /// Deflections in units of the RMS deflection, 1 mm, rounded off below 0.03 of it.
    #[test]
    fn the_force_goes_with_a_power_of_the_deflection() {
        for power in [1.2, 2.0, 5.0_f64] {
            for share in [-2.0, -0.02, 0.0, 0.3, 1.5_f64] {
                let force = 12.0 * share * (share * share + 9e-4).powf(0.5 * (power - 1.0));
                let d = 1e-3 * share;
                let at = At { d, w: 0.1, ..AT };
                near(tyre::<PowerStiffness>(padded([12.0, power]), &at), 60e3 * d + 50.0 + force);
            }
        }
    }

    #[test]
    fn the_integrator_resolves_the_slope_at_two_rms_deflections() {
        let resolved = (PowerStiffness::SPEC.stiffens)(&padded([12.0, 5.0]), &Scale::TYPICAL);
        let force = |d: f64| tyre::<PowerStiffness>(padded([12.0, 5.0]), &At { d, ..AT });
        let found = slope(force, 2e-3, 1e-7) - 60e3;
        assert!((resolved / found - 1.0).abs() < 1e-3, "{resolved} {found}");
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<PowerStiffness>();
        physical_within::<PowerStiffness>(padded([10.0, 3.0]), [1, 1], [1.2, 12.0]);
        comes_back::<PowerStiffness>(padded([10.0, 3.7]));
    }
}
