use crate::law::*;

/// + m V' h / L on the front, - m V' h / L on the rear axle: braking and accelerating load the axles.
pub struct LoadTransfer;

const HEIGHT: Parameter = Parameter {
    name: "cog_height",
    unit: "m",
    size: |_| 0.2,
    limits: |_| [-20.0, 20.0],
};

impl Effect for LoadTransfer {
    const SPEC: Spec = Spec {
        id: "load_transfer",
        acts: Acts::Both,
        needs: &[Need::VaryingSpeed, Need::Geometry, Need::Mass],
        parameters: &[HEIGHT],
        amplitudes: &[0],
        starts: |_| vec![padded([1.0])],
        report: |p, _| vec![reported(&HEIGHT, p[0], [0.05, 3.0])],
        slow: true,
        law: "+-m V' cog_height / L on the mass, plus on the front axle",
        formula: Formula { body: "cog_height * lift * speed_rate", ..Formula::NONE },
        words: "braking and accelerating shift load between the axles",
        confused_with: &["sensor_drift", "sensor_offset"],
        noun: "load transfer by braking and accelerating, with the centre of gravity {cog_height} high,",
        source: "Wilson & Schmidt, Bicycling Science, 4th ed. 2020",
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn body(p: &LaneValues, m: &Motion, _s: &States, force: Lanes) -> Lanes {
        force + p[0] * m.per_mass * (m.scale.lift * m.speed_rate)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    /// TYPICAL bears the whole mass over the wheelbase as 30 kg/m, with the front axle's sign.
    #[test]
    fn accelerating_pushes_by_the_height_of_the_centre_of_gravity() {
        for speed_rate in [-3.0, 0.0, 0.5] {
            for height in [0.9, -0.4] {
                let at = At { speed_rate, ..AT };
                near(body::<LoadTransfer>(padded([height]), &at), PUSH + 30.0 * speed_rate * height);
            }
        }
    }

    #[test]
    fn starts_limits_and_what_is_physical() {
        starts_grow_from_nothing::<LoadTransfer>();
        limits_are::<LoadTransfer>(&[[-20.0, 20.0]]);
        physical_within::<LoadTransfer>(padded([]), [0, 0], [0.05, 3.0]);
        comes_back::<LoadTransfer>(padded([1.1]));
    }
}
