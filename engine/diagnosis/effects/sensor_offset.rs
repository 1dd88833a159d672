use crate::diagnosis::law::*;

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
        starts: |s| vec![[0.05 * s.d_rms, 0.0, 0.0, 0.0]],
        report: |p, s| vec![reported(&OFFSET, p[0], (OFFSET.limits)(s))],
        on_sensor: true,
        slow: true,
        law: "z is read as z + offset",
        words: "the displacement sensor's zero point is off",
        confused_with: &["progressive_stiffness", "asymmetric_damping", "sensor_drift"],
        source: "effect library: zero point",
        ..Spec::ORDINARY
    };

    fn sensor(p: &Values, _t: f64, pickup: &mut Pickup) {
        pickup.offset += p[0];
    }
}
