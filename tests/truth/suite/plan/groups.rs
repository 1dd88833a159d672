//! Several effects at once.

use crate::chance::Chance;
use crate::simulate::effect::{Axle, Kind};

/// Kinds that act together, by what they touch; those of one ride are of different groups.
const GROUPS: [&[Kind]; 6] = [
    &[
        Kind::CubicStiffness,
        Kind::ProgressiveStiffness,
        Kind::BumpStop,
        Kind::ViscoelasticTyre,
    ],
    &[
        Kind::QuadraticDamping,
        Kind::CoulombFriction,
        Kind::AsymmetricDamping,
    ],
    &[Kind::SprungMass, Kind::PitchCoupling, Kind::UnsprungMass],
    &[
        Kind::WheelOutOfRound,
        Kind::PedallingForce,
        Kind::LoadTransfer,
    ],
    &[
        Kind::StiffnessDrift,
        Kind::SpeedDependentStiffness,
        Kind::WheelLift,
    ],
    &[
        Kind::SensorDelay,
        Kind::SensorGain,
        Kind::SensorDrift,
        Kind::TyreEnveloping,
    ],
];

pub fn pair(chance: &mut Chance) -> Vec<(Kind, Axle)> {
    feasible(chance, |chance| {
        let first = chance.index(GROUPS.len());
        let second = (first + 1 + chance.index(GROUPS.len() - 1)) % GROUPS.len();
        one_of_each(&[first, second], chance)
    })
}

pub fn three(chance: &mut Chance) -> Vec<(Kind, Axle)> {
    feasible(chance, |chance| {
        let mut groups = [0, 1, 2, 3, 4, 5];
        chance.shuffle(&mut groups);
        one_of_each(&groups[..3], chance)
    })
}

fn one_of_each(groups: &[usize], chance: &mut Chance) -> Vec<(Kind, Axle)> {
    let one = |group: &usize| {
        let kind = chance.pick(GROUPS[*group]);
        (kind, chance.pick(kind.axles()))
    };
    groups.iter().map(one).collect()
}

/// Draws again while dry friction acts on a wheel of one kilogram, which is stiffer than any fixed step.
fn feasible(
    chance: &mut Chance,
    draw: impl Fn(&mut Chance) -> Vec<(Kind, Axle)>,
) -> Vec<(Kind, Axle)> {
    loop {
        let drawn = draw(chance);
        let has = |kind| drawn.iter().any(|(k, _)| *k == kind);
        if !(has(Kind::UnsprungMass) && has(Kind::CoulombFriction)) {
            return drawn;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_effects_touch_three_different_things() {
        let chance = &mut Chance::new(2, 0);
        for _ in 0..50 {
            let drawn = three(chance);
            let of = |kind| GROUPS.iter().position(|group| group.contains(&kind));
            let mut groups: Vec<_> = drawn.iter().map(|(kind, _)| of(*kind)).collect();
            groups.sort();
            groups.dedup();
            assert_eq!(groups.len(), 3, "{drawn:?}");
        }
    }
}
