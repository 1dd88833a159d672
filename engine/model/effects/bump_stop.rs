use crate::law::*;

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
                        starts.push(padded([gap * s.d_rms, s.k_size(), side]));
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
        formula: Formula {
            tyre: "stop_stiffness * (step(side + 0.5) * max(d - gap, 0) + step(0.5 - side) * min(d + gap, 0))",
            choices: &["side"],
            ..Formula::NONE
        },
        words: "the travel ends at a stop (bottoming, rim strike)",
        confused_with: &["cubic_stiffness", "free_play", "progressive_stiffness"],
        noun: "a bump stop of {stop_stiffness} beyond {gap} ({side})",
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
        padded([reported[0], reported[1], if side == 0.0 { 0.0 } else { side.signum() }])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    const GAP_M: f64 = 1.5e-3;
    const STOP: f64 = 4e5;

    fn force(side: f64, d: f64) -> f64 {
        tyre::<BumpStop>(padded([GAP_M, STOP, side]), &At { d, w: 0.1, ..AT })
    }

    #[test]
    fn a_stop_pushes_beyond_its_gap_on_its_own_side_only() {
        for side in [1.0, -1.0, 0.0] {
            for d in [-2.5e-3, -1.5e-3, -1.4e-3, 0.0, 1.4e-3, 1.5e-3, 1.6e-3, 2.5e-3] {
                let stands = d * side >= 0.0 && f64::abs(d) > 1.5e-3;
                let over = if stands { 4e5 * (f64::abs(d) - 1.5e-3) * f64::signum(d) } else { 0.0 };
                near(force(side, d), 60e3 * d + 50.0 + over);
            }
        }
    }

    #[test]
    fn it_is_as_stiff_as_the_integrator_is_told() {
        let told = (BumpStop::SPEC.stiffens)(&padded([GAP_M, STOP, 1.0]), &Scale::TYPICAL);
        let found = slope(|d| force(1.0, d), 2e-3, 1e-4) - 60e3;
        assert!((found / told - 1.0).abs() < 1e-9, "{found} instead of {told}");
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<BumpStop>();
        limits_are::<BumpStop>(&[[0.0, 3.15e-3], [0.0, 6e7]]);
        let values = padded([1e-3, 1e5, -1.0]);
        physical_within::<BumpStop>(values, [0, 0], [1e-6, 3.15e-3]);
        physical_within::<BumpStop>(values, [1, 1], [0.0, 6e7]);
        for side in [1.0, -1.0, 0.0] {
            comes_back::<BumpStop>(padded([1e-3, 1e5, side]));
        }
    }

    /// Deflections reach 3 mm in compression and 1.2 mm in rebound here, of an RMS of 1 mm.
    #[test]
    fn gaps_start_where_the_ride_reaches_on_each_side() {
        let deeper = Scale { d_low: -1.2e-3, ..Scale::TYPICAL };
        let gaps = |side: f64| -> Vec<f64> {
            let starts = (BumpStop::SPEC.starts)(&deeper);
            starts.iter().filter(|start| start[2] == side).map(|start| 1e3 * start[0]).collect()
        };
        assert_eq!(gaps(1.0), [0.5, 1.0, 1.5, 2.0, 2.7]);
        assert_eq!(gaps(-1.0), [0.5, 1.0]);
        assert_eq!(gaps(0.0), [0.5, 1.0, 1.5, 2.0, 2.7]);
    }

    #[test]
    fn the_report_names_the_side() {
        for (side, name) in [(1.0, "compression"), (-1.0, "rebound"), (0.0, "both")] {
            let reported = (BumpStop::SPEC.report)(&padded([1e-3, 1e5, side]), &Scale::TYPICAL);
            assert_eq!(reported[2].unit, name);
        }
    }
}
