//! How large what is concealed is made, from what the plain bicycle does on the same ride.

use super::plan::Planned;
use crate::chance::Chance;
use crate::simulate::effect::{Axle, Effect, Kind};
use crate::simulate::outside::{Outside, Strange};
use crate::simulate::vehicle::{Bike, Vehicle};
use crate::suite::sizes::{self, Scale};
use crate::suite::strange::{self, Around};

const GRAVITY: f64 = 9.81;

/// The bicycle with what the plan conceals in it.
pub fn vehicle(planned: &Planned, bike: &Bike, scale: &Scale, chance: &mut Chance) -> Vehicle {
    let one = |(kind, axle): &(Kind, Axle)| effect(*kind, *axle, bike, scale, chance);
    let effects = planned.effects.iter().map(one).collect();
    let outside = (planned.strange).and_then(|(kind, axle)| law(kind, axle, bike, scale, chance));
    Vehicle {
        effects,
        outside,
        mean_speed_m_s: scale.mean_speed_m_s,
        ..Vehicle::plain(bike.clone())
    }
}

fn effect(kind: Kind, axle: Axle, bike: &Bike, scale: &Scale, chance: &mut Chance) -> Effect {
    let a = axle as usize;
    let (k, b) = (bike.stiffness_n_m[a], bike.damping_n_s_m[a]);
    let (d, w) = (scale.deflection_m[a], scale.rate_m_s[a]);
    let mut of = |low, high| chance.uniform(low, high);
    let values = match kind {
        Kind::CoulombFriction => vec![of(15.0, 60.0)],
        Kind::CubicStiffness => vec![of(0.2, 0.8) * k / (2.0 * d).powi(2)],
        Kind::QuadraticDamping => vec![of(0.5, 1.5) * b / w],
        Kind::AsymmetricDamping => vec![of(0.3, 0.6) * chance.sign()],
        Kind::SprungMass => vec![of(0.3, 0.5), of(4.0, 6.0), of(0.2, 0.4)],
        Kind::BumpStop => vec![of(1.0, 2.0) * d, of(1.0, 3.0) * k, chance.sign()],
        Kind::WheelOutOfRound => {
            let radius = bike.wheel_radius_m[a] * (1.0 + 0.01 * chance.normal());
            vec![chance.uniform(0.8e-3, 2e-3), chance.phase(), radius]
        }
        Kind::PedallingForce => vec![of(40.0, 100.0), chance.phase()],
        Kind::SensorDelay => vec![of(5e-3, 12e-3)],
        Kind::ViscoelasticTyre => vec![of(0.2, 0.5) * k, of(0.02, 0.08)],
        Kind::WheelLift => vec![GRAVITY * bike.mass_kg[a]],
        _ => return sizes::draw(kind, axle, 1, bike, scale, chance),
    };
    Effect::new(kind, axle, &values)
}

fn law(
    kind: Strange,
    axle: Axle,
    bike: &Bike,
    scale: &Scale,
    chance: &mut Chance,
) -> Option<Outside> {
    let axle = axle as usize;
    let (d, w) = (scale.deflection_m[axle], scale.rate_m_s[axle]);
    let share = bike.damping_n_s_m[axle] * chance.uniform(0.5, 1.5);
    let values = match kind {
        Strange::PowerDamping => vec![share * w.sqrt(), 0.5],
        Strange::DeflectionDamping => vec![share / (2.0 * d).powi(2)],
        _ => {
            let around = Around::new(axle, 1, 1.0, bike, scale);
            return strange::draw(kind, axle, &around, chance);
        }
    };
    Some(Outside {
        kind,
        axle,
        values,
        events: Vec::new(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::no_road::class::Class;
    use crate::no_road::conditions;
    use crate::no_road::plan;

    const SCALE: Scale = Scale {
        deflection_m: [1e-3, 2e-3],
        rate_m_s: [0.1, 0.2],
        fastest_m_s: 6.0,
        mean_speed_m_s: 5.0,
        duration_s: 60.0,
        noise_m: 0.0,
    };

    #[test]
    fn everything_planned_has_a_size() {
        let chance = &mut Chance::new(2, 0);
        for planned in plan::plan(chance) {
            let bike = conditions::bike(planned.class, chance);
            let vehicle = vehicle(&planned, &bike, &SCALE, chance);
            assert_eq!(vehicle.outside.is_some(), planned.strange.is_some());
            let sized = |e: &Effect| e.values[0] != 0.0 && e.values.iter().all(|v| v.is_finite());
            assert!(vehicle.effects.iter().all(sized));
            if planned.class == Class::Lift {
                let load = |e: &Effect| e.values[0] / bike.mass_kg[e.axle as usize];
                assert!(
                    vehicle
                        .effects
                        .iter()
                        .all(|e| (load(e) - GRAVITY).abs() < 1e-9)
                );
            }
        }
    }

    #[test]
    fn a_cubic_spring_is_a_share_of_k_at_two_sigma() {
        let chance = &mut Chance::new(2, 0);
        let bike = conditions::bike(Class::Effect, chance);
        let cubic = effect(Kind::CubicStiffness, Axle::Rear, &bike, &SCALE, chance);
        let share = cubic.values[0] * 4e-3_f64.powi(2) / bike.stiffness_n_m[1];
        assert!((0.2..0.8).contains(&share), "{share}");
    }
}
