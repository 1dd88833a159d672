use crate::law::*;

/// The tyre cannot pull: its force is never below minus the static load.
pub struct WheelLift;

const LOAD: Parameter = Parameter {
    name: "static_load",
    unit: "N",
    size: |s| 0.1 * s.static_load,
    limits: |s| [0.02 * s.static_load, 20.0 * s.static_load],
};

impl Effect for WheelLift {
    const SPEC: Spec = Spec {
        id: "wheel_lift",
        acts: Acts::OneAxle,
        needs: &[Need::StaticLoad, Need::Mass],
        parameters: &[LOAD],
        amplitudes: &[],
        stronger: Stronger::Smaller,
        starts: |s| [0.4, 0.7, 1.0].map(|f| padded([f * s.static_load])).to_vec(),
        report: |p, s| vec![reported(&LOAD, p[0], [0.5 * s.static_load, 2.0 * s.static_load])],
        corners: true,
        peaks: true,
        law: "the tyre's force is never below -static_load",
        formula: Formula { tyre: "max(0, -static_load - tyre)", ..Formula::NONE },
        words: "the wheel leaves the ground: the tyre cannot pull",
        confused_with: &["progressive_stiffness", "cubic_stiffness", "bump_stop"],
        noun: "wheel lift at a static load of {static_load}",
        source: "paper, eq. (2): the load F_nF has no lower bound there",
        family: Some(Family::Spring),
        is_odd: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn tyre(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force.max(-(p[0] * m.per_mass))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    #[test]
    fn the_tyre_pulls_no_more_than_its_load() {
        for (d, w, force) in [(2e-3, 0.1, 170.0), (-1e-3, 0.0, -60.0), (-2e-3, 0.1, -70.0), (-2e-3, -0.1, -100.0), (-1.0, 0.0, -100.0)]
        {
            near(tyre::<WheelLift>(padded([100.0]), &At { d, w, ..AT }), force);
        }
    }

    /// The wheel rests with 300 N; a load that no pull comes up to changes nothing.
    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_lie_within_limits::<WheelLift>();
        limits_are::<WheelLift>(&[[6.0, 6000.0]]);
        physical_within::<WheelLift>(padded([]), [0, 0], [150.0, 600.0]);
        comes_back::<WheelLift>(padded([250.0]));
        changes_nothing::<WheelLift>(padded([6000.0]));
    }
}
