use crate::diagnosis::law::*;

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
        starts: |s| [0.4, 0.7, 1.0].map(|f| [f * s.static_load, 0.0, 0.0, 0.0]).to_vec(),
        report: |p, s| vec![reported(&LOAD, p[0], [0.5 * s.static_load, 2.0 * s.static_load])],
        corners: true,
        peaks: true,
        law: "the tyre's force is never below -static_load",
        words: "the wheel leaves the ground: the tyre cannot pull",
        confused_with: &["progressive_stiffness", "cubic_stiffness", "bump_stop"],
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
