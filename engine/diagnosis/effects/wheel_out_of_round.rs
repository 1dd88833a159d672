use crate::diagnosis::law::*;

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
            (-count..=count)
                .flat_map(|i| {
                    let ratio = 1.0 + i as f64 * step;
                    [[a, 0.0, ratio, 0.0], [0.0, a, ratio, 0.0]]
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
        words: "the wheel is out of round",
        confused_with: &["pedalling_force"],
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
        [reported[0] * cos, reported[0] * sin, reported[2] / scale.wheel_radius, 0.0]
    }
}
