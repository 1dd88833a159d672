use crate::law::*;

/// m (1 + e) inside a window: the rider stands up, luggage falls off.
pub struct MassStep;

const FRACTION: Parameter = Parameter {
    name: "fraction",
    unit: "-",
    size: |_| 0.1,
    limits: |_| [-0.8, 5.0],
};
const fn edge(name: &'static str) -> Parameter {
    Parameter { name, unit: "s", size: |s| s.train_s / 30.0, limits: |s| [0.0, s.duration] }
}

impl Effect for MassStep {
    const SPEC: Spec = Spec {
        id: "mass_step",
        acts: Acts::OneAxle,
        needs: &[Need::Mass],
        parameters: &[FRACTION, edge("from"), edge("to")],
        amplitudes: &[0],
        starts: |s| {
            // A window from the start is the same as one to the end with another mass to begin with.
            let parts = 10;
            let at = |i: usize| i as f64 * s.train_s / parts as f64;
            let mut starts = Vec::new();
            for from in 1..parts {
                for to in from + 1..=parts {
                    starts.push(padded([0.1, at(from), if to == parts { s.duration } else { at(to) }]));
                }
            }
            starts
        },
        nearer: |p, s, zoom| {
            let step = s.train_s / 10.0 / 4_f64.powi(zoom as i32);
            let mut starts = Vec::new();
            for i in -2..=2 {
                for j in -2..=2 {
                    let (from, to) = (p[1] + i as f64 * step, p[2] + j as f64 * step);
                    let open_end = p[2] >= s.duration && j == 0;
                    if from > 0.0 && to > from + 0.2 && (open_end || to < s.train_s) {
                        starts.push(padded([0.1, from, to]));
                    }
                }
            }
            starts
        },
        report: |p, s| {
            vec![
                reported(&FRACTION, p[0], [-0.6, 2.0]),
                reported(&edge("from"), p[1], [0.0, s.duration]),
                reported(&edge("to"), p[2], [p[1], s.duration]),
            ]
        },
        local: true,
        law: "m (1 + fraction) in the place of m, from one time to another",
        formula: Formula {
            acceleration: "acceleration / (1 + fraction * min(max(50 * (t - from) + 0.5, 0), 1) * min(max(50 * (to - t) + 0.5, 0), 1))",
            ..Formula::NONE
        },
        words: "the mass on the axle changes for a while (the rider stands up, luggage falls off)",
        confused_with: &["stiffness_drift"],
        noun: "a relative change of the mass by {fraction} from {from} to {to}",
        source: "effect library: posture or load change",
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn inertia(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        // Inside is 1 within the window, with edges as wide as 20 ms so that the fit can move them.
        let edge = 50.0;
        let (zero, one) = (Lanes::ZERO, Lanes::all(1.0));
        let after = ((Lanes::all(m.t) - p[1]) * edge + 0.5).max(zero).min(one);
        let before = ((p[2] - Lanes::all(m.t)) * edge + 0.5).max(zero).min(one);
        force / (one + p[0] * after * before)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    /// Half of the mass more from 10 s to 20 s; the edges are 20 ms wide.
    #[test]
    fn the_mass_is_another_one_within_the_window_only() {
        let at = |t: f64| acceleration::<MassStep>(padded([0.5, 10.0, 20.0]), &At { t, ..AT }, 90.0);
        for (t, mass) in [
            (0.0, 30.0),
            (9.989, 30.0),
            (9.995, 33.75),
            (10.0, 37.5),
            (10.005, 41.25),
            (10.011, 45.0),
            (15.0, 45.0),
            (20.0, 37.5),
            (20.011, 30.0),
            (90.0, 30.0),
        ] {
            assert!((at(t) - 90.0 / mass).abs() < 1e-9, "{} at {t} s", at(t));
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<MassStep>();
        limits_are::<MassStep>(&[[-0.8, 5.0], [0.0, 100.0], [0.0, 100.0]]);
        let values = padded([0.5, 10.0, 20.0]);
        physical_within::<MassStep>(values, [0, 0], [-0.6, 2.0]);
        physical_within::<MassStep>(padded([0.5, 10.0, 100.0]), [1, 1], [0.0, 100.0]);
        physical_within::<MassStep>(values, [2, 2], [10.0, 100.0]);
        comes_back::<MassStep>(values);
    }

    /// 6 s lie between windows to begin with, of which the last end with the ride.
    #[test]
    fn starts_nearer_by_surround_the_best_one_ever_more_closely() {
        for (zoom, step) in [(1, 1.5), (2, 0.375)] {
            for (to, ends) in [(24.0, 25), (100.0, 5)] {
                let starts = (MassStep::SPEC.nearer)(&padded([0.3, 12.0, to]), &Scale::TYPICAL, zoom);
                assert_eq!(starts.len(), ends);
                for start in &starts {
                    lies_within_limits::<MassStep>(start);
                    let away = [start[1] - 12.0, start[2] - to];
                    assert!(away.iter().all(|x| x.abs() <= 2.0 * step + 1e-9), "{away:?}");
                }
                assert!(starts.iter().any(|start| (start[1] - 12.0 - step).abs() < 1e-9));
            }
        }
    }
}
