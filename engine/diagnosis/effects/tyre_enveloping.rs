use crate::diagnosis::law::*;

/// The contact patch averages the road over a length centred on the contact point.
pub struct TyreEnveloping;

const LENGTH: Parameter = Parameter {
    name: "patch_length",
    unit: "m",
    size: |_| 0.03,
    limits: |_| [0.0, 2.0],
};

impl Effect for TyreEnveloping {
    const SPEC: Spec = Spec {
        id: "tyre_enveloping",
        acts: Acts::OneAxle,
        needs: &[Need::Road, Need::Speed],
        parameters: &[LENGTH],
        amplitudes: &[],
        starts: |_| [0.08, 0.16, 0.3].map(|l| [l, 0.0, 0.0, 0.0]).to_vec(),
        report: |p, _| vec![reported(&LENGTH, p[0], [0.005, 0.6])],
        on_road: true,
        law: "u is the mean of the road over a patch_length around the contact point",
        words: "the tyre's contact patch averages the road",
        confused_with: &["sensor_delay", "sensor_gain"],
        source: "Pacejka, Tire and Vehicle Dynamics, 3rd ed. 2012, ch. 10; Schmeitz 2004",
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn road(p: &LaneValues, spot: &Spot, _scale: &Scale, tap: &mut Tap) {
        tap.half_window += p[0] * (0.5 / spot.speed.max(0.3));
    }
}
