use crate::law::*;

/// A footprint of fixed length averages the road around the contact point. Deflection and the footprint's shape do not change it.
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
        starts: |_| [0.08, 0.16, 0.3].map(|l| padded([l])).to_vec(),
        report: |p, _| vec![reported(&LENGTH, p[0], [0.005, 0.6])],
        on_road: true,
        law: "u is the mean of the road over a footprint of fixed patch_length around the contact point",
        formula: Formula { half_window: "0.5 * patch_length / max(speed, 0.3)", ..Formula::NONE },
        words: "the tyre's contact patch averages the road",
        confused_with: &["sensor_delay", "sensor_gain"],
        noun: "tyre enveloping over a contact patch of {patch_length}",
        source: "Sayers 1995, Transp. Res. Rec. 1501:1-12 (moving average of 250 mm); a footprint of fixed length, not the cams of Schmeitz 2004",
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn road(p: &LaneValues, spot: &Spot, _scale: &Scale, tap: &mut Tap) {
        tap.half_window += p[0] * (0.5 / spot.speed.max(0.3));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    /// Half of the length to both sides, at no less than 0.3 m/s.
    #[test]
    fn the_road_is_averaged_over_as_long_as_the_patch_takes_to_pass() {
        for (speed, half) in [(5.0, 0.01), (1.0, 0.05), (0.3, 0.05 / 0.3), (0.0, 0.05 / 0.3)] {
            let [shift, half_window, value, slope] = road::<TyreEnveloping>(padded([0.1]), &At { speed, ..AT });
            near(half_window, half);
            assert_eq!([shift, value, slope], [0.0; 3]);
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_lie_within_limits::<TyreEnveloping>();
        changes_nothing::<TyreEnveloping>(padded([]));
        limits_are::<TyreEnveloping>(&[[0.0, 2.0]]);
        physical_within::<TyreEnveloping>(padded([]), [0, 0], [0.005, 0.6]);
        comes_back::<TyreEnveloping>(padded([0.12]));
    }
}
