use crate::law::*;

/// z + r t, t from the first sample: the zero point wanders.
pub struct SensorDrift;

const RATE: Parameter = Parameter {
    name: "rate",
    unit: "m/s",
    size: |s| 0.1 * s.d_rms / s.train_s,
    limits: |s| [-100.0 * s.z_rms / s.train_s, 100.0 * s.z_rms / s.train_s],
};

impl Effect for SensorDrift {
    const SPEC: Spec = Spec {
        id: "sensor_drift",
        acts: Acts::OneAxle,
        needs: &[Need::Mass, Need::Hold],
        parameters: &[RATE],
        amplitudes: &[0],
        starts: |s| vec![padded([(RATE.size)(s)])],
        report: |p, s| vec![reported(&RATE, p[0], (RATE.limits)(s))],
        on_sensor: true,
        slow: true,
        law: "z is read as z + rate t",
        formula: Formula { offset: "rate * t", ..Formula::NONE },
        words: "the displacement sensor's zero point drifts",
        confused_with: &["sensor_offset", "load_transfer"],
        noun: "a displacement sensor drift of {rate}",
        source: "effect library: zero point",
        ..Spec::ORDINARY
    };

    fn sensor(p: &Values, t: f64, pickup: &mut Pickup) {
        pickup.offset += p[0] * t;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    #[test]
    fn the_zero_point_wanders_with_time() {
        for (rate, t, offset) in [(2e-3, 0.0, 0.0), (2e-3, 50.0, 0.1), (-1e-3, 50.0, -0.05)] {
            let [delay, gain, found, lag] = sensor::<SensorDrift>(padded([rate]), t);
            assert_eq!([delay, gain, lag], [0.25, 2.0, 0.125]);
            near(found, 0.5 + offset);
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<SensorDrift>();
        limits_are::<SensorDrift>(&[[-0.1 / 60.0, 0.1 / 60.0]]);
        physical_within::<SensorDrift>(padded([]), [0, 0], [-0.1 / 60.0, 0.1 / 60.0]);
        comes_back::<SensorDrift>(padded([-4e-5]));
    }
}
