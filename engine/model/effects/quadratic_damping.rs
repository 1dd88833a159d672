use crate::law::*;

/// c2 w |w|: damping that grows with speed.
pub struct QuadraticDamping;

const C2: Parameter = Parameter {
    name: "c2",
    unit: "N s^2/m^2",
    size: |s| 0.3 * s.b_size() / s.w_rms,
    limits: |s| [0.0, 300.0 * s.b_size() / s.w_rms],
};

impl Effect for QuadraticDamping {
    const SPEC: Spec = Spec {
        id: "quadratic_damping",
        acts: Acts::OneAxle,
        parameters: &[C2],
        amplitudes: &[0],
        starts: |s| vec![padded([(C2.size)(s)])],
        report: |p, s| vec![reported(&C2, p[0], [0.0, (C2.limits)(s)[1]])],
        law: "c2 |w| w",
        formula: Formula { tyre: "c2 * w * abs(w)", ..Formula::NONE },
        words: "damping grows with the speed of deflection",
        confused_with: &["coulomb_friction", "hysteresis"],
        noun: "quadratic damping of {c2}",
        source: "Dixon, The Shock Absorber Handbook, 2nd ed. 2007 (flow through an orifice)",
        family: Some(Family::Damper),
        is_odd: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force + p[0] * m.per_mass * m.w * m.w.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    #[test]
    fn damping_grows_with_the_rate_and_keeps_its_sign() {
        for (w, force) in [(0.0, 0.0), (0.1, 20.0), (-0.1, -20.0), (0.5, 500.0), (-1.0, -2000.0)] {
            let at = At { d: 1e-3, w, ..AT };
            near(tyre::<QuadraticDamping>(padded([2000.0]), &at), 60.0 + 500.0 * w + force);
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<QuadraticDamping>();
        limits_are::<QuadraticDamping>(&[[0.0, 1.5e6]]);
        physical_within::<QuadraticDamping>(padded([]), [0, 0], [0.0, 1.5e6]);
        comes_back::<QuadraticDamping>(padded([800.0]));
    }
}
