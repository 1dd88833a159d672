//! Clean rides and common effects under unusual circumstances, and three effects at once.

use super::{any_noise, groups};
use crate::chance::Chance;
use crate::simulate::effect::{Axle, Kind};
use crate::suite::case::{Case, Class, Noise, Setting};
use crate::suite::circumstance::Circumstance;

/// A dozen effects that bicycles and benches often have.
const COMMON: [Kind; 12] = [
    Kind::CubicStiffness,
    Kind::ProgressiveStiffness,
    Kind::QuadraticDamping,
    Kind::AsymmetricDamping,
    Kind::CoulombFriction,
    Kind::Hysteresis,
    Kind::ViscoelasticTyre,
    Kind::BumpStop,
    Kind::SprungMass,
    Kind::UnsprungMass,
    Kind::WheelOutOfRound,
    Kind::PedallingForce,
];

/// Circumstances with their clean rides and their rides with one effect.
const COUNTS: [(Circumstance, usize, usize); 10] = [
    (Circumstance::Walking, 4, 8),
    (Circumstance::Slow, 4, 8),
    (Circumstance::Fast, 4, 8),
    (Circumstance::Short, 4, 8),
    (Circumstance::Long, 2, 3),
    (Circumstance::FrontAlone, 2, 4),
    (Circumstance::RearAlone, 2, 4),
    (Circumstance::Clipped, 4, 8),
    (Circumstance::MassDeclared, 3, 5),
    (Circumstance::MassWrong, 3, 5),
];
/// Rides with three effects.
const THREE: usize = 24;

/// Common effects go round over all circumstances, so that each has met several; shuffled.
pub fn conditions(chance: &mut Chance) -> Vec<Case> {
    let mut cases = Vec::new();
    let mut kinds = COMMON.into_iter().cycle();
    for (circumstance, clean, single) in COUNTS {
        for i in 0..clean {
            let noise = Noise::ALL[i % Noise::ALL.len()];
            let case = Case::new(Class::Clean, Setting::Road, noise, chance);
            cases.push(case.under(circumstance));
        }
        for kind in kinds.by_ref().take(single) {
            cases.push(one(kind, circumstance, chance));
        }
    }
    for _ in 0..THREE {
        let mut case = Case::new(Class::Three, Setting::Road, any_noise(chance), chance);
        case.effects = groups::three(chance);
        case.size = 1 + chance.index(2);
        cases.push(case);
    }
    chance.shuffle(&mut cases);
    cases
}

/// A medium or large effect, on the axle that is logged.
fn one(kind: Kind, circumstance: Circumstance, chance: &mut Chance) -> Case {
    let mut case = Case::new(Class::Single, Setting::Road, any_noise(chance), chance);
    let axle = match circumstance.alone() {
        Some(axle) => Axle::ONE[axle],
        None => chance.pick(&Axle::ONE),
    };
    case.effects = vec![(kind, axle)];
    case.size = 1 + chance.index(2);
    case.under(circumstance)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_circumstance_has_clean_rides_and_effects() {
        let cases = conditions(&mut Chance::new(1, 0));
        assert!((100..=120).contains(&cases.len()), "{}", cases.len());
        let count = |class, circumstance| {
            let is = |c: &&Case| c.class == class && c.circumstance == circumstance;
            cases.iter().filter(is).count()
        };
        for (circumstance, clean, single) in COUNTS {
            let found = [Class::Clean, Class::Single].map(|c| count(c, Some(circumstance)));
            assert_eq!(found, [clean, single], "{}", circumstance.name());
        }
        assert_eq!(count(Class::Three, None), THREE);
        for kind in COMMON {
            let has = |c: &&Case| c.class == Class::Single && c.effects[0].0 == kind;
            assert!(cases.iter().filter(has).count() >= 5, "{}", kind.id());
        }
    }

    #[test]
    fn what_a_ride_conceals_is_on_an_axle_that_its_log_has() {
        for case in conditions(&mut Chance::new(1, 0)) {
            let alone = case.circumstance.and_then(Circumstance::alone);
            let covers = |axle| case.effects.iter().all(|(_, on)| on.covers(axle));
            assert!(alone.is_none_or(covers), "{case:?}");
        }
    }
}
