use crate::law::*;

/// z + o: the displacement sensor's zero point.
pub struct SensorOffset;

const OFFSET: Parameter = Parameter {
    name: "offset",
    unit: "m",
    size: |s| 0.05 * s.d_rms,
    limits: |s| [-100.0 * s.z_rms, 100.0 * s.z_rms],
};

impl Effect for SensorOffset {
    const SPEC: Spec = Spec {
        id: "sensor_offset",
        acts: Acts::OneAxle,
        needs: &[Need::Road, Need::Mass],
        parameters: &[OFFSET],
        amplitudes: &[0],
        starts: |s| vec![padded([0.05 * s.d_rms])],
        report: |p, s| vec![reported(&OFFSET, p[0], (OFFSET.limits)(s))],
        on_sensor: true,
        slow: true,
        law: "z is read as z + offset",
        formula: Formula { offset: "offset", ..Formula::NONE },
        words: "the displacement sensor's zero point is off",
        confused_with: &["progressive_stiffness", "asymmetric_damping", "sensor_drift"],
        noun: "a displacement sensor offset of {offset}",
        source: "effect library: zero point",
        ..Spec::ORDINARY
    };

    fn sensor(p: &Values, _t: f64, pickup: &mut Pickup) {
        pickup.offset += p[0];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    #[test]
    fn the_offset_comes_to_that_of_the_sensor_at_all_times() {
        for t in [0.0, 80.0] {
            for offset in [-0.25, 0.0, 0.125] {
                assert_eq!(sensor::<SensorOffset>(padded([offset]), t), [0.25, 2.0, 0.5 + offset, 0.125]);
            }
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<SensorOffset>();
        limits_are::<SensorOffset>(&[[-0.1, 0.1]]);
        physical_within::<SensorOffset>(padded([]), [0, 0], [-0.1, 0.1]);
        comes_back::<SensorOffset>(padded([-4e-3]));
    }
}
