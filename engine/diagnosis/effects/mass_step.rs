use crate::diagnosis::law::*;

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
                    starts.push([0.1, at(from), if to == parts { s.duration } else { at(to) }, 0.0]);
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
                        starts.push([0.1, from, to, 0.0]);
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
        words: "the mass on the axle changes for a while (the rider stands up, luggage falls off)",
        confused_with: &["stiffness_drift"],
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
