use crate::diagnosis::law::*;

/// a sin(2 crank angle + phase), fitted as its sine and cosine parts.
pub struct PedallingForce;

const fn part(name: &'static str) -> Parameter {
    Parameter {
        name,
        unit: "N",
        size: |s| 0.03 * s.force_rms(),
        limits: |s| [-20.0 * s.force_rms(), 20.0 * s.force_rms()],
    }
}

impl Effect for PedallingForce {
    const SPEC: Spec = Spec {
        id: "pedalling_force",
        acts: Acts::OneAxle,
        needs: &[Need::Cadence, Need::Mass],
        parameters: &[part("sine"), part("cosine")],
        amplitudes: &[0, 1],
        starts: |s| {
            let a = 0.03 * s.force_rms();
            vec![[a, 0.0, 0.0, 0.0], [0.0, a, 0.0, 0.0]]
        },
        report: |p, s| {
            let limit = 20.0 * s.force_rms();
            vec![
                Reported { name: "amplitude".into(), unit: "N".into(), value: p[0].hypot(p[1]), physical: p[0].hypot(p[1]) < limit },
                Reported { name: "phase".into(), unit: "rad".into(), value: p[1].atan2(p[0]), physical: true },
            ]
        },
        law: "amplitude sin(2 crank + phase) on the mass",
        words: "pedalling pushes the axle at twice the cadence",
        confused_with: &["wheel_out_of_round"],
        source: "Wilson & Schmidt, Bicycling Science, 4th ed. 2020 (two strokes in a turn of the crank)",
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn body(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        let [sin, cos] = m.crank.double();
        force + (p[0] * sin + p[1] * cos) * m.per_mass
    }

    fn from_reported(reported: &[f64], _scale: &Scale) -> Values {
        let (sin, cos) = reported[1].sin_cos();
        [reported[0] * cos, reported[0] * sin, 0.0, 0.0]
    }
}
