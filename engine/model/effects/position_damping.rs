use crate::law::*;

/// c d^2 w: a damper that depends on where it is. Not an effect to be named: a general shape against
/// which the named laws of the rate are held.
pub struct PositionDamping;

const C: Parameter = Parameter {
    name: "c",
    unit: "N s/m^3",
    size: |s| 0.2 * s.b_size() / (s.d_rms * s.d_rms),
    limits: |s| {
        let most = 100.0 * s.b_size() / (s.d_rms * s.d_rms);
        [-most, most]
    },
};

impl Effect for PositionDamping {
    const SPEC: Spec = Spec {
        id: "position_damping",
        acts: Acts::OneAxle,
        parameters: &[C],
        amplitudes: &[0],
        starts: |s| vec![padded([(C.size)(s)])],
        report: |p, s| vec![reported(&C, p[0], (C.limits)(s))],
        law: "c d^2 w",
        formula: Formula { tyre: "c * d^2 * w", ..Formula::NONE },
        words: "the damper depends on its position",
        confused_with: &["quadratic_damping"],
        source: "van der Pol 1926, Phil. Mag. 2:978-992",
        family: Some(Family::Damper),
        is_general: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force + p[0] * m.per_mass * m.d * m.d * m.w
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    #[test]
    fn damping_goes_with_the_square_of_the_deflection() {
        for (d, w, force) in [(1e-3, 0.1, 20.0), (-1e-3, 0.1, 20.0), (2e-3, -0.1, -80.0), (-3e-3, -0.2, -360.0), (0.0, 0.5, 0.0)] {
            let at = At { d, w, ..AT };
            near(tyre::<PositionDamping>(padded([2e8]), &at), 60e3 * d + 500.0 * w + force);
            near(tyre::<PositionDamping>(padded([-1e8]), &at), 60e3 * d + 500.0 * w - 0.5 * force);
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<PositionDamping>();
        limits_are::<PositionDamping>(&[[-5e10, 5e10]]);
        physical_within::<PositionDamping>(padded([]), [0, 0], [-5e10, 5e10]);
        comes_back::<PositionDamping>(padded([-3e8]));
    }
}
