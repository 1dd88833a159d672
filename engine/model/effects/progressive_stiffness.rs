use crate::law::*;

/// k2 d^2: stiffens in compression, softens in rebound; beyond its turning point d = -k/(2 k2) the
/// spring force stays constant.
pub struct ProgressiveStiffness;

const K2: Parameter = Parameter {
    name: "k2",
    unit: "N/m^2",
    size: |s| 0.1 * s.k / (2.0 * s.d_rms),
    limits: |s| [-30.0 * s.k.abs() / s.d_rms, 30.0 * s.k.abs() / s.d_rms],
};

impl Effect for ProgressiveStiffness {
    const SPEC: Spec = Spec {
        id: "progressive_stiffness",
        acts: Acts::OneAxle,
        parameters: &[K2],
        amplitudes: &[0],
        starts: |s| vec![padded([(K2.size)(s)])],
        report: |p, s| vec![reported(&K2, p[0], (K2.limits)(s))],
        stiffens: |p, s| 2.0 * p[0].abs() * 2.0 * s.d_rms,
        law: "k2 d^2, constant beyond the turning point d = -k / (2 k2)",
        formula: Formula {
            tyre: "k * (sign(k2) * max(sign(k2) * d, -k / (2 * abs(k2))) - d) + k2 * max(sign(k2) * d, -k / (2 * abs(k2)))^2",
            ..Formula::NONE
        },
        words: "the spring stiffens in compression and softens in rebound",
        confused_with: &["asymmetric_damping", "wheel_lift", "bump_stop"],
        noun: "progressive stiffness of {k2}",
        source: "Renart & Roura-Grabulosa, Am. J. Phys. 87:102 (F ~ d^1.5 of a light tyre)",
        family: Some(Family::Spring),
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        let k2 = p[0] * m.per_mass;
        // The turning point lies in rebound for k2 > 0 and in compression for k2 < 0.
        let mut d = m.d;
        for i in 0..d.0.len() {
            let turn = -m.kappa.0[i] / (2.0 * k2.0[i]);
            let (low, high) = if k2.0[i] > 0.0 { (turn, f64::MAX) } else { (f64::MIN, turn) };
            let x = d.0[i];
            let x = if x < low { low } else { x };
            d.0[i] = if x > high && k2.0[i] < 0.0 { high } else { x };
        }
        force + m.kappa * (d - m.d) + k2 * d * d
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    fn force(k2: f64, d: f64) -> f64 {
        tyre::<ProgressiveStiffness>(padded([k2]), &At { d, w: 0.1, ..AT })
    }

    /// 60 kN/m turn at -k / (2 k2), 1.5 mm to one side or the other; the spring's force stays k^2 / (4 k2) there.
    #[test]
    fn the_force_goes_with_the_square_up_to_its_turning_point() {
        let k2 = 2e7;
        for d in [-3e-3, -1.6e-3, -1.5e-3, -1e-3, 0.0, 1e-3, 3e-3] {
            let spring = if d > -1.5e-3 { 60e3 * d + k2 * d * d } else { -45.0 };
            near(force(k2, d), spring + 50.0);
            // What softens in compression is the same seen from the other side.
            near(force(-k2, -d), -spring + 50.0);
        }
    }

    #[test]
    fn the_integrator_is_told_the_slope_at_two_rms_deflections() {
        let told = (ProgressiveStiffness::SPEC.stiffens)(&padded([-2e6]), &Scale::TYPICAL);
        let found = slope(|d| force(-2e6, d), -2e-3, 1e-5) - 60e3;
        assert!((told / found - 1.0).abs() < 1e-9, "{found}");
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<ProgressiveStiffness>();
        limits_are::<ProgressiveStiffness>(&[[-1.8e9, 1.8e9]]);
        physical_within::<ProgressiveStiffness>(padded([]), [0, 0], [-1.8e9, 1.8e9]);
        comes_back::<ProgressiveStiffness>(padded([-4e6]));
    }
}
