use super::sprung_mass::{DAMPING, FRACTION, FREQUENCY, SprungMass};
use crate::law::*;

/// A sprung mass whose spring hardens or softens with the square of its travel. Not an effect to be named: a general law
/// against which a linear mode is held.
pub struct HardeningMass;

/// Stiffness that is added at a travel of the axle's RMS deflection, over the linear one.
const HARDENING: Parameter = Parameter {
    name: "hardening",
    unit: "-",
    size: |_| 0.1,
    limits: |_| [-0.2, 10.0],
};

impl Effect for HardeningMass {
    const SPEC: Spec = Spec {
        id: "hardening_mass",
        acts: Acts::OneAxle,
        needs: &[Need::Mass],
        parameters: &[FRACTION, FREQUENCY, DAMPING, HARDENING],
        report: |p, s| vec![reported(&HARDENING, p[3], (HARDENING.limits)(s))],
        states: 2,
        second_mass: true,
        law: "a sprung mass whose stiffness is multiplied by 1 + hardening (travel / z_rms)^2",
        formula: Formula {
            acceleration: "(acceleration - mass_fraction * 2 * pi * natural_frequency * (2 * pi * natural_frequency * (z - height) * (1 + hardening * min(((z - height) / d_rms)^2, 100)) + 2 * damping_ratio * (z_dot - velocity))) / (1 - mass_fraction)",
            states: &[
                ("height", "velocity"), 
                ("velocity", "2 * pi * natural_frequency * (2 * pi * natural_frequency * (z - height) * (1 + hardening * min(((z - height) / d_rms)^2, 100)) + 2 * damping_ratio * (z_dot - velocity))"),
            ],
            ..Formula::NONE
        },
        words: "the frequency of a second mass depends on how far it moves",
        confused_with: &["sprung_mass"],
        source: "Kerschen et al. 2006, Mech. Syst. Signal Process. 20:505-592",
        is_general: true,
        ..Spec::ORDINARY
    };

    #[inline(always)]
    fn inertia(p: &LaneValues, m: &Motion, s: &States, force: Lanes) -> Lanes {
        (force - p[0] * pull(p, m, s)) / (Lanes::all(1.0) - p[0])
    }

    #[inline(always)]
    fn rates(p: &LaneValues, m: &Motion, s: &States) -> States {
        [s[1], pull(p, m, s)]
    }
}

/// Acceleration that spring and damper give the sprung mass.
#[inline(always)]
fn pull(p: &LaneValues, m: &Motion, s: &States) -> Lanes {
    let w = p[1] * std::f64::consts::TAU;
    let travel = m.z - s[0];
    let share = travel / m.scale.d_rms;
    // Beyond ten deflections no ride goes, but a fit on its way may.
    let most = Lanes::all(100.0);
    SprungMass::pull(p, m, s) + w * w * p[3] * (share * share).min(most) * travel
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::testing::*;

    const TAU: f64 = std::f64::consts::TAU;

    /// Of a mass on 3 Hz that hardens by half at a travel of 1 mm, damped by a tenth: travel and its rate are those of the axle
    /// less its own.
    #[test]
    fn the_spring_hardens_with_the_square_of_its_travel_up_to_ten_deflections() {
        let values = padded([0.25, 3.0, 0.1, 0.5]);
        for (travel, rate) in [(1e-3, 0.0), (-2e-3, 0.1), (5e-3, -0.2), (-0.03, 0.0)] {
            let at = At { z: 2e-3, v: 0.05, states: [2e-3 - travel, 0.05 - rate], ..AT };
            let harder = 1.0 + 0.5 * (travel / 1e-3_f64).powi(2).min(100.0);
            let w = 3.0 * TAU;
            let pull = w * w * harder * travel + 2.0 * 0.1 * w * rate;
            let [moved, pulled] = rates::<HardeningMass>(values, &at);
            near(moved, 0.05 - rate);
            near(pulled, pull);
            near(acceleration::<HardeningMass>(values, &at, 90.0), (90.0 - 0.25 * 30.0 * pull) / (0.75 * 30.0));
        }
    }

    #[test]
    fn without_a_share_of_the_mass_it_changes_nothing() {
        changes_nothing::<HardeningMass>(padded([0.0, 3.0, 0.1, 0.5]));
    }

    #[test]
    fn limits_and_what_is_physical() {
        limits_are::<HardeningMass>(&[[0.0, 0.97], [0.005, 90.0], [0.0, 3.0], [-0.2, 10.0]]);
        physical_within::<HardeningMass>(padded([0.1, 3.0, 0.1]), [3, 0], [-0.2, 10.0]);
    }
}
