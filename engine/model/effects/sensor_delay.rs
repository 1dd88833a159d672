use crate::law::*;

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
        needs: &[Need::Mass, Need::Drive],
        parameters: &[DELAY],
        amplitudes: &[0],
        starts: |s| vec![padded([0.2 * s.step])],
        report: |p, _| vec![reported(&DELAY, p[0], [-0.1, 0.1])],
        on_sensor: true,
        law: "z is read as z(t - delay)",
        formula: Formula { delay: "delay", ..Formula::NONE },
        words: "the displacement is logged late or early against the road",
        confused_with: &["wheelbase_delay", "viscoelastic_tyre", "ground_damping"],
        noun: "a displacement sensor delay of {delay}",
        source: "effect library: separate loggers, separate clocks",
        ..Spec::ORDINARY
    };

    fn sensor(p: &Values, _t: f64, pickup: &mut Pickup) {
        pickup.delay += p[0];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    #[test]
    fn the_delay_comes_to_that_of_the_sensor_and_to_nothing_else() {
        for delay in [-0.01, 0.0, 0.02] {
            assert_eq!(sensor::<SensorDelay>(padded([delay]), 7.0), [0.25 + delay, 2.0, 0.5, 0.125]);
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<SensorDelay>();
        limits_are::<SensorDelay>(&[[-0.15, 0.15]]);
        physical_within::<SensorDelay>(padded([]), [0, 0], [-0.1, 0.1]);
        comes_back::<SensorDelay>(padded([-4e-3]));
    }
}
