use crate::law::*;

/// The rear road input is shifted by a wrong wheelbase: u_R(t - dL/V).
pub struct WheelbaseDelay;

const ERROR: Parameter = Parameter {
    name: "wheelbase_error",
    unit: "m",
    size: |_| 0.01,
    limits: |_| [-0.5, 0.5],
};

impl Effect for WheelbaseDelay {
    const SPEC: Spec = Spec {
        id: "wheelbase_delay",
        acts: Acts::Rear,
        needs: &[Need::Road, Need::Speed],
        parameters: &[ERROR],
        amplitudes: &[0],
        starts: |_| vec![padded([0.01])],
        report: |p, _| vec![reported(&ERROR, p[0], [-0.2, 0.2])],
        on_road: true,
        law: "u_r(t - wheelbase_error / V)",
        formula: Formula { shift: "wheelbase_error / max(speed, 0.3)", ..Formula::NONE },
        words: "the rear road input is shifted by a wrong wheelbase",
        confused_with: &["sensor_delay"],
        noun: "a wheelbase error of {wheelbase_error}",
        source: "effect library: rear input u_R(t) = u_F(t - L/V)",
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn road(p: &LaneValues, spot: &Spot, _scale: &Scale, tap: &mut Tap) {
        tap.shift += p[0] / spot.speed.max(0.3);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    #[test]
    fn the_road_is_read_earlier_by_what_the_error_takes_to_pass() {
        for (error, speed, seconds) in [(0.1, 5.0, 0.02), (-0.03, 1.0, -0.03), (0.03, 0.3, 0.1), (0.03, 0.0, 0.1)] {
            let [shift, half_window, value, slope] = road::<WheelbaseDelay>(padded([error]), &At { speed, ..AT });
            near(shift, seconds);
            assert_eq!([half_window, value, slope], [0.0; 3]);
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<WheelbaseDelay>();
        limits_are::<WheelbaseDelay>(&[[-0.5, 0.5]]);
        physical_within::<WheelbaseDelay>(padded([]), [0, 0], [-0.2, 0.2]);
        comes_back::<WheelbaseDelay>(padded([-0.04]));
    }
}
