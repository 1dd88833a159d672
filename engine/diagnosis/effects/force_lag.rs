use crate::diagnosis::law::*;

/// The measured force follows what the law says by tau F' = f - F: a fluid that is pressed, a magnet, an amplifier.
pub struct ForceLag;

const LAG: Parameter = Parameter {
    name: "lag",
    unit: "s",
    size: |s| s.step,
    limits: |s| [0.0, 0.1 * s.train_s],
};

/// Part of a sample interval that a lag has at least: a shorter one is what a spline does between samples.
const SHORTEST: f64 = 0.2;

impl Effect for ForceLag {
    const SPEC: Spec = Spec {
        id: "force_lag",
        acts: Acts::OneAxle,
        needs: &[Need::PrescribedMotion],
        parameters: &[LAG],
        amplitudes: &[0],
        starts: |s| vec![[s.step, 0.0, 0.0, 0.0]],
        report: |p, s| vec![reported(&LAG, p[0], [SHORTEST * s.step, 1.0])],
        on_sensor: true,
        law: "F, the force that is measured: lag F' = f - F, f the force of the law",
        words: "the force follows the motion with a lag of the first order (a fluid, a magnet, an amplifier)",
        confused_with: &["hysteresis", "viscoelastic_tyre"],
        source: "Koo, Goncalves & Ahmadian 2006, Smart Mater. Struct. 15:351-358 (response time of MR dampers)",
        ..Spec::ORDINARY
    };

    fn sensor(p: &Values, _t: f64, pickup: &mut Pickup) {
        pickup.lag += p[0];
    }
}
