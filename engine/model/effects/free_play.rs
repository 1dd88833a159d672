use crate::law::*;

/// Zero spring force within +-gap/2: backlash, a loose headset or bearing.
pub struct FreePlay;

const GAP: Parameter = Parameter {
    name: "gap",
    unit: "m",
    size: |s| 0.2 * s.d_rms,
    limits: |s| [0.0, 2.0 * s.d_peak],
};

impl Effect for FreePlay {
    const SPEC: Spec = Spec {
        id: "free_play",
        acts: Acts::OneAxle,
        parameters: &[GAP],
        amplitudes: &[],
        starts: |s| [0.15, 0.5, 1.0, 1.6, 2.4].map(|g| padded([g * s.d_rms])).to_vec(),
        report: |p, s| vec![reported(&GAP, p[0], [1e-6 * s.d_rms, (GAP.limits)(s)[1]])],
        corners: true,
        peaks: true,
        law: "k (d -+ gap/2) outside a gap and 0 within, in the place of k d",
        formula: Formula { tyre: "-k * min(max(d, -0.5 * gap), 0.5 * gap)", ..Formula::NONE },
        words: "there is backlash: no spring force within a gap",
        confused_with: &["bump_stop", "cubic_stiffness", "hysteresis"],
        noun: "free play of {gap}",
        source: "Kerschen et al. 2006, Mech. Syst. Signal Process. 20:505-592",
        family: Some(Family::Spring),
        is_odd: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        let half = p[0] * 0.5;
        force - m.kappa * m.d.max(-half).min(half)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    #[test]
    fn the_spring_pushes_only_beyond_half_the_gap_while_the_damper_always_does() {
        for (d, spring) in [(0.0, 0.0), (4e-4, 0.0), (-5e-4, 0.0), (1.5e-3, 60.0), (-1.5e-3, -60.0), (-3e-3, -150.0)] {
            for w in [-0.2, 0.0, 0.1] {
                let at = At { d, w, ..AT };
                near(tyre::<FreePlay>(padded([1e-3]), &at), spring + 500.0 * w);
            }
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_lie_within_limits::<FreePlay>();
        changes_nothing::<FreePlay>(padded([]));
        limits_are::<FreePlay>(&[[0.0, 6e-3]]);
        physical_within::<FreePlay>(padded([]), [0, 0], [1e-9, 6e-3]);
        comes_back::<FreePlay>(padded([7e-4]));
    }
}
