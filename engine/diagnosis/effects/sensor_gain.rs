use crate::diagnosis::law::*;

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
        needs: &[Need::Mass],
        parameters: &[EXCESS],
        amplitudes: &[0],
        starts: |_| vec![[0.02, 0.0, 0.0, 0.0]],
        report: |p, _| vec![reported(&EXCESS, 1.0 + p[0], [0.6, 1.6])],
        on_sensor: true,
        law: "z is read as gain z",
        words: "the displacement sensor's gain is off",
        confused_with: &["tyre_enveloping", "ground_damping"],
        source: "effect library: calibration; g on z is 1/g on u",
        ..Spec::ORDINARY
    };

    fn sensor(p: &Values, _t: f64, pickup: &mut Pickup) {
        pickup.gain *= 1.0 + p[0];
    }

    fn from_reported(reported: &[f64], _scale: &Scale) -> Values {
        [reported[0] - 1.0, 0.0, 0.0, 0.0]
    }
}
