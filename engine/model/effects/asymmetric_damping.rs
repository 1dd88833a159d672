use crate::law::*;

/// B (1 + a sign(w)) w: compression and rebound damp differently.
pub struct AsymmetricDamping;

const ASYMMETRY: Parameter = Parameter {
    name: "asymmetry",
    unit: "-",
    size: |_| 0.2,
    limits: |_| [-3.0, 3.0],
};

impl Effect for AsymmetricDamping {
    const SPEC: Spec = Spec {
        id: "asymmetric_damping",
        acts: Acts::OneAxle,
        parameters: &[ASYMMETRY],
        amplitudes: &[0],
        starts: |_| vec![padded([0.2])],
        report: |p, _| vec![reported(&ASYMMETRY, p[0], [-1.0, 1.0])],
        law: "B (1 + asymmetry sign(w)) w in the place of B w",
        formula: Formula { tyre: "asymmetry * B * abs(w)", ..Formula::NONE },
        words: "compression and rebound damp differently",
        confused_with: &["progressive_stiffness"],
        noun: "damping with an asymmetry of {asymmetry} between compression and rebound",
        source: "Dixon, The Shock Absorber Handbook, 2nd ed. 2007",
        family: Some(Family::Damper),
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force + p[0] * m.beta * m.w.abs()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    #[test]
    fn rebound_and_compression_damp_by_what_the_asymmetry_says() {
        let at = |d: f64, w: f64| tyre::<AsymmetricDamping>(padded([0.4]), &At { d, w, ..AT });
        for (d, w, damping) in [(1e-3, 0.2, 700.0), (-2e-3, 0.01, 700.0), (1e-3, -0.2, 300.0), (-2e-3, -0.01, 300.0)] {
            near(at(d, w), 60e3 * d + damping * w);
        }
        near(at(1e-3, 0.0), 60.0);
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<AsymmetricDamping>();
        limits_are::<AsymmetricDamping>(&[[-3.0, 3.0]]);
        physical_within::<AsymmetricDamping>(padded([]), [0, 0], [-1.0, 1.0]);
        comes_back::<AsymmetricDamping>(padded([-0.7]));
    }
}
