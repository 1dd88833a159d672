use crate::law::*;

/// u + a sin(x/R + phase), x the distance ridden: run-out once per revolution. Fitted as sine and
/// cosine part and the rolling radius over the bike file's.
pub struct WheelOutOfRound;

const fn part(name: &'static str) -> Parameter {
    Parameter { name, unit: "m", size: |s| 0.05 * s.d_rms, limits: |_| [-0.05, 0.05] }
}
const RADIUS: Parameter = Parameter {
    name: "radius_ratio",
    unit: "-",
    size: |s| s.radius_step(),
    limits: |_| [0.965, 1.035],
};

impl Effect for WheelOutOfRound {
    const SPEC: Spec = Spec {
        id: "wheel_out_of_round",
        acts: Acts::OneAxle,
        needs: &[Need::Speed, Need::WheelRadius, Need::Road],
        parameters: &[part("sine"), part("cosine"), RADIUS],
        amplitudes: &[0, 1],
        starts: |s| {
            let step = s.radius_step();
            let a = 0.1 * s.d_rms;
            let count = (0.03 / step).ceil() as i32;
            let [low, high] = (RADIUS.limits)(s);
            (-count..=count)
                .map(|i| 1.0 + i as f64 * step)
                .filter(|ratio| (low..=high).contains(ratio))
                .flat_map(|ratio| {
                    [padded([a, 0.0, ratio]), padded([0.0, a, ratio])]
                })
                .collect()
        },
        report: |p, s| {
            vec![
                Reported { name: "amplitude".into(), unit: "m".into(), value: p[0].hypot(p[1]), physical: p[0].hypot(p[1]) < 0.02 },
                Reported { name: "phase".into(), unit: "rad".into(), value: p[1].atan2(p[0]), physical: true },
                Reported {
                    name: "rolling_radius".into(),
                    unit: "m".into(),
                    value: p[2] * s.wheel_radius,
                    physical: (0.97..=1.03).contains(&p[2]),
                },
            ]
        },
        on_road: true,
        law: "u + amplitude sin(x / rolling_radius + phase), x the distance ridden",
        formula: Formula {
            height: "sine * sin(distance / (radius_ratio * wheel_radius)) + cosine * cos(distance / (radius_ratio * wheel_radius))",
            slope: "(sine * cos(distance / (radius_ratio * wheel_radius)) - cosine * sin(distance / (radius_ratio * wheel_radius))) * speed / (radius_ratio * wheel_radius)",
            ..Formula::NONE
        },
        words: "the wheel is out of round",
        confused_with: &["pedalling_force"],
        noun: "a wheel out of round by {amplitude} (phase {phase}, rolling radius {rolling_radius})",
        source: "Wilson & Schmidt, Bicycling Science, 4th ed. 2020",
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn road(p: &LaneValues, spot: &Spot, scale: &Scale, tap: &mut Tap) {
        let turn = (p[2] * scale.wheel_radius).recip();
        let [sin, cos] = (turn * spot.distance).sin_cos();
        tap.value += p[0] * sin + p[1] * cos;
        tap.slope += (p[0] * cos - p[1] * sin) * turn * spot.speed;
    }

    fn from_reported(reported: &[f64], scale: &Scale) -> Values {
        let (sin, cos) = reported[1].sin_cos();
        padded([reported[0] * cos, reported[0] * sin, reported[2] / scale.wheel_radius])
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::effects::testing::*;

    const AMPLITUDE: f64 = 2e-3;
    const PHASE: f64 = -1.1;
    const RATIO: f64 = 1.01;

    fn values() -> Values {
        padded([AMPLITUDE * f64::cos(PHASE), AMPLITUDE * f64::sin(PHASE), RATIO])
    }

    /// The wheel has 0.34 m by the bike file.
    #[test]
    fn the_road_rises_and_falls_once_in_a_turn_of_the_wheel() {
        for (distance, speed) in [(0.0, 5.0), (0.7, 2.0), (33.3, 8.0), (400.0, 0.0)] {
            let turned: f64 = distance / (1.01 * 0.34) + PHASE;
            let [shift, half_window, value, slope] = road::<WheelOutOfRound>(values(), &At { distance, speed, ..AT });
            assert_eq!([shift, half_window], [0.0; 2]);
            near(value, AMPLITUDE * turned.sin());
            near(slope, AMPLITUDE * turned.cos() * speed / (1.01 * 0.34));
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<WheelOutOfRound>();
        limits_are::<WheelOutOfRound>(&[[-0.05, 0.05], [-0.05, 0.05], [0.965, 1.035]]);
        physical_within::<WheelOutOfRound>(padded([0.0, 0.0, 1.0]), [1, 0], [-0.02, 0.02]);
        physical_within::<WheelOutOfRound>(padded([0.012, 0.0, 1.0]), [1, 0], [-0.016, 0.016]);
        physical_within::<WheelOutOfRound>(padded([1e-3, 0.0, 1.0]), [2, 2], [0.97, 1.03]);
        comes_back::<WheelOutOfRound>(values());
        for (found, truth) in report::<WheelOutOfRound>(values()).into_iter().zip([2e-3, -1.1, 0.3434]) {
            near(found, truth);
        }
    }

    /// On the way of the fitted part a step from one radius to the next turns the phase by a radian.
    #[test]
    fn starts_cover_three_percent_of_the_radius_without_a_gap() {
        let starts = (WheelOutOfRound::SPEC.starts)(&Scale::TYPICAL);
        let mut ratios: Vec<f64> = starts.iter().map(|start| start[2]).collect();
        ratios.dedup();
        assert!(ratios[0] <= 0.97 && *ratios.last().unwrap() >= 1.03);
        for pair in ratios.windows(2) {
            assert!((300.0 / 0.34 * (pair[1] - pair[0]) - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn starts_of_a_short_ride_lie_within_limits() {
        for train_distance in [3.0, 12.0, 15.0, 40.0] {
            let short = Scale { train_distance, ..Scale::TYPICAL };
            for start in (WheelOutOfRound::SPEC.starts)(&short) {
                assert!((0.965..=1.035).contains(&start[2]), "{} on {train_distance} m", start[2]);
            }
        }
    }
}
