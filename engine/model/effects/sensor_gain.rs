use crate::law::*;

/// g z: the displacement sensor's calibration. Fitted as g - 1.
pub struct SensorGain;

const EXCESS: Parameter = Parameter {
    name: "gain",
    unit: "-",
    size: |_| 0.02,
    limits: |_| [-0.7, 2.0],
};

impl Effect for SensorGain {
    const SPEC: Spec = Spec {
        id: "sensor_gain",
        acts: Acts::OneAxle,
        needs: &[Need::Mass, Need::Drive],
        parameters: &[EXCESS],
        amplitudes: &[0],
        starts: |_| vec![padded([0.02])],
        report: |p, _| vec![reported(&EXCESS, 1.0 + p[0], [0.6, 1.6])],
        on_sensor: true,
        law: "z is read as gain z",
        formula: Formula { gain: "1 + gain", ..Formula::NONE },
        words: "the displacement sensor's gain is off",
        confused_with: &["tyre_enveloping", "ground_damping"],
        noun: "a displacement sensor gain of {gain}",
        source: "effect library: calibration; g on z is 1/g on u",
        ..Spec::ORDINARY
    };

    fn sensor(p: &Values, _t: f64, pickup: &mut Pickup) {
        pickup.gain *= 1.0 + p[0];
    }

    fn from_reported(reported: &[f64], _scale: &Scale) -> Values {
        padded([reported[0] - 1.0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    /// It is fitted as what comes to a gain of one.
    #[test]
    fn the_gain_multiplies_that_of_the_sensor_and_nothing_else() {
        for (excess, gain) in [(-0.5, 1.0), (0.0, 2.0), (0.25, 2.5)] {
            assert_eq!(sensor::<SensorGain>(padded([excess]), 7.0), [0.25, gain, 0.5, 0.125]);
            near(report::<SensorGain>(padded([excess]))[0], 1.0 + excess);
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<SensorGain>();
        limits_are::<SensorGain>(&[[-0.7, 2.0]]);
        physical_within::<SensorGain>(padded([]), [0, 0], [-0.4, 0.6]);
        comes_back::<SensorGain>(padded([-0.15]));
    }
}
