use crate::diagnosis::law::*;

/// ks (d - gap) beyond the gap, in compression, in rebound or both: bottoming, rim strike. The third
/// value chooses the side: 1, -1 or 0 for both.
pub struct BumpStop;

const GAP: Parameter = Parameter {
    name: "gap",
    unit: "m",
    size: |s| 0.3 * s.d_rms,
    limits: |s| [0.0, 1.05 * s.d_peak],
};

const STIFFNESS: Parameter = Parameter {
    name: "stop_stiffness",
    unit: "N/m",
    size: |s| 0.5 * s.k_size(),
    limits: |s| [0.0, 1e3 * s.k_size()],
};

impl Effect for BumpStop {
    const SPEC: Spec = Spec {
        id: "bump_stop",
        acts: Acts::OneAxle,
        parameters: &[GAP, STIFFNESS],
        amplitudes: &[1],
        size_parameter: 1,
        starts: |s| {
            let mut starts = Vec::new();
            for side in [1.0, -1.0, 0.0] {
                for gap in [0.5, 1.0, 1.5, 2.0, 2.7] {
                    let reach = if side > 0.0 { s.d_high } else if side < 0.0 { -s.d_low } else { s.d_peak };
                    if gap * s.d_rms < 0.95 * reach {
                        starts.push([gap * s.d_rms, s.k_size(), side, 0.0]);
                    }
                }
            }
            starts
        },
        report: |p, s| {
            let side = match p[2] {
                x if x > 0.0 => "compression",
                x if x < 0.0 => "rebound",
                _ => "both",
            };
            vec![
                reported(&GAP, p[0], [1e-3 * s.d_rms, (GAP.limits)(s)[1]]),
                reported(&STIFFNESS, p[1], [0.0, (STIFFNESS.limits)(s)[1]]),
                Reported { name: "side".into(), unit: side.into(), value: p[2], physical: true },
            ]
        },
        stiffens: |p, _| p[1],
        corners: true,
        peaks: true,
        law: "stop_stiffness (|d| - gap) sign(d) where |d| > gap, on one side (compression or rebound) or on both",
        words: "the travel ends at a stop (bottoming, rim strike)",
        confused_with: &["cubic_stiffness", "free_play", "progressive_stiffness"],
        source: "Sadauckas et al. 2024, Veh. Syst. Dyn. (rim strike)",
        family: Some(Family::Spring),
        is_odd: true,
        replaces_spring: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        let mut over = Lanes::ZERO;
        for i in 0..over.0.len() {
            let (d, gap, side) = (m.d.0[i], p[0].0[i], p[2].0[i]);
            let above = if d > gap && side >= 0.0 { d - gap } else { 0.0 };
            let below = if d < -gap && side <= 0.0 { d + gap } else { 0.0 };
            over.0[i] = above + below;
        }
        force + p[1] * m.per_mass * over
    }

    fn from_reported(reported: &[f64], _scale: &Scale) -> Values {
        let side = reported[2];
        [reported[0], reported[1], if side == 0.0 { 0.0 } else { side.signum() }, 0.0]
    }
}
