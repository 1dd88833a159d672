use crate::diagnosis::law::*;

/// z is logged late by tau (negative: early): the loggers' clocks differ.
pub struct SensorDelay;

const DELAY: Parameter = Parameter {
    name: "delay",
    unit: "s",
    size: |s| 0.2 * s.step,
    limits: |s| [-30.0 * s.step, 30.0 * s.step],
};

impl Effect for SensorDelay {
    const SPEC: Spec = Spec {
        id: "sensor_delay",
        acts: Acts::OneAxle,
        needs: &[Need::Mass],
        parameters: &[DELAY],
        amplitudes: &[0],
        starts: |s| vec![[0.2 * s.step, 0.0, 0.0, 0.0]],
        report: |p, _| vec![reported(&DELAY, p[0], [-0.1, 0.1])],
        on_sensor: true,
        law: "z is read as z(t - delay)",
        words: "the displacement is logged late or early against the road",
        confused_with: &["wheelbase_delay", "viscoelastic_tyre", "ground_damping"],
        source: "effect library: separate loggers, separate clocks",
        ..Spec::ORDINARY
    };

    fn sensor(p: &Values, _t: f64, pickup: &mut Pickup) {
        pickup.delay += p[0];
    }
}
