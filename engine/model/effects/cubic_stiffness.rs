use crate::law::*;

/// k3 d^3: stiffens (or softens) alike in compression and rebound.
pub struct CubicStiffness;

const K3: Parameter = Parameter {
    name: "k3",
    unit: "N/m^3",
    size: |s| 0.1 * s.k / (4.0 * s.d_rms * s.d_rms),
    limits: |s| [-0.9 * s.k.abs() / (s.d_peak * s.d_peak), 1e3 * s.k.abs() / (s.d_rms * s.d_rms)],
};

impl Effect for CubicStiffness {
    const SPEC: Spec = Spec {
        id: "cubic_stiffness",
        acts: Acts::OneAxle,
        parameters: &[K3],
        amplitudes: &[0],
        starts: |s| vec![padded([(K3.size)(s)])],
        report: |p, s| vec![reported(&K3, p[0], (K3.limits)(s))],
        stiffens: |p, s| 3.0 * p[0].max(0.0) * 4.0 * s.d_rms * s.d_rms,
        law: "k3 d^3",
        formula: Formula { tyre: "k3 * d^3", ..Formula::NONE },
        words: "the spring stiffens (or softens) with the cube of its deflection",
        confused_with: &["bump_stop", "free_play", "wheel_lift"],
        noun: "cubic stiffness of {k3}",
        source: "Kerschen et al. 2006, Mech. Syst. Signal Process. 20:505-592",
        family: Some(Family::Spring),
        is_odd: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force + p[0] * m.per_mass * m.d * m.d * m.d
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    const K3_N_M3: f64 = 3e9;

    #[test]
    fn the_force_goes_with_the_cube_to_both_sides() {
        for (d, w, cubic) in [(1e-3, 0.0, 3.0), (-1e-3, 0.1, -3.0), (2e-3, -0.3, 24.0), (-3e-3, 0.0, -81.0)] {
            let at = At { d, w, ..AT };
            near(tyre::<CubicStiffness>(padded([K3_N_M3]), &at), 60e3 * d + 500.0 * w + cubic);
            near(tyre::<CubicStiffness>(padded([-K3_N_M3]), &at), 60e3 * d + 500.0 * w - cubic);
        }
    }

    #[test]
    fn the_integrator_is_told_the_slope_at_two_rms_deflections() {
        let told = |k3: f64| (CubicStiffness::SPEC.stiffens)(&padded([k3]), &Scale::TYPICAL);
        let force = |d: f64| tyre::<CubicStiffness>(padded([K3_N_M3]), &At { d, ..AT });
        let found = slope(force, 2e-3, 1e-7) - 60e3;
        assert!((told(K3_N_M3) / found - 1.0).abs() < 1e-6, "{found}");
        assert_eq!(told(-K3_N_M3), 0.0);
    }

    /// The softest spring still pushes back a tenth of its plain force where the deflection is largest, 3 mm.
    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<CubicStiffness>();
        limits_are::<CubicStiffness>(&[[-6e9, 6e13]]);
        physical_within::<CubicStiffness>(padded([]), [0, 0], [-6e9, 6e13]);
        comes_back::<CubicStiffness>(padded([-2e9]));
        near(tyre::<CubicStiffness>(padded([-6e9]), &At { d: 3e-3, ..AT }), 18.0);
    }
}
