use crate::law::*;

/// The measured force follows what the law says by tau F' = f - F: a fluid that is pressed, a magnet, an amplifier.
pub struct ForceLag;

const LAG: Parameter = Parameter {
    name: "lag",
    unit: "s",
    size: |s| s.step,
    limits: |s| [0.0, 0.1 * s.train_s],
};

/// Part of a sample interval that a lag has at least: a shorter one is what a spline does between samples.
const SHORTEST: f64 = 0.2;

impl Effect for ForceLag {
    const SPEC: Spec = Spec {
        id: "force_lag",
        acts: Acts::OneAxle,
        needs: &[Need::PrescribedMotion],
        parameters: &[LAG],
        amplitudes: &[0],
        starts: |s| vec![padded([s.step])],
        report: |p, s| vec![reported(&LAG, p[0], [SHORTEST * s.step, 1.0])],
        on_sensor: true,
        law: "F, the force that is measured: lag F' = f - F, f the force of the law",
        formula: Formula { lag: "lag", ..Formula::NONE },
        words: "the force follows the motion with a first-order lag (a fluid, a magnet, an amplifier)",
        confused_with: &["hysteresis", "viscoelastic_tyre"],
        noun: "a force that lags the motion by {lag}",
        source: "Koo, Goncalves & Ahmadian 2006, Smart Mater. Struct. 15:351-358 (response time of MR dampers)",
        ..Spec::ORDINARY
    };

    fn sensor(p: &Values, _t: f64, pickup: &mut Pickup) {
        pickup.lag += p[0];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    #[test]
    fn the_lag_comes_to_that_of_the_sensor_and_to_nothing_else() {
        for lag in [0.0, 0.01, 0.5] {
            assert_eq!(sensor::<ForceLag>(padded([lag]), 7.0), [0.25, 2.0, 0.5, 0.125 + lag]);
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<ForceLag>();
        limits_are::<ForceLag>(&[[0.0, 6.0]]);
        physical_within::<ForceLag>(padded([]), [0, 0], [1e-3, 1.0]);
        comes_back::<ForceLag>(padded([0.03]));
    }
}
