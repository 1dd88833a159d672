//! Which rides there are.

use super::class::Class;
use crate::chance::Chance;
use crate::simulate::effect::{Axle, Kind};
use crate::simulate::outside::Strange;

/// One ride, and what is to be concealed in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    pub class: Class,
    pub effects: Vec<(Kind, Axle)>,
    pub strange: Option<(Strange, Axle)>,
}

/// Effects that a ride without a road shows, on the axles on which it does.
pub const SHOWN: [Kind; 9] = [
    Kind::CoulombFriction,
    Kind::CubicStiffness,
    Kind::QuadraticDamping,
    Kind::AsymmetricDamping,
    Kind::SprungMass,
    Kind::BumpStop,
    Kind::WheelOutOfRound,
    Kind::PedallingForce,
    Kind::SensorDelay,
];
/// An absorbed effect and its axle, in turn.
const ABSORBED: [(Kind, Axle); 3] = [
    (Kind::ViscoelasticTyre, Axle::Front),
    (Kind::ViscoelasticTyre, Axle::Rear),
    (Kind::SprungMass, Axle::Front),
];
/// Springs and dampers of other shapes.
const STRANGE: [Strange; 6] = [
    Strange::PowerDamping,
    Strange::DeflectionDamping,
    Strange::CubicDamping,
    Strange::EddyDamping,
    Strange::TwoPowerSpring,
    Strange::RateStiffenedSpring,
];

/// Every ride, class by class, each class in a random order. A ride's number is its place.
pub fn plan(chance: &mut Chance) -> Vec<Planned> {
    let mut all = Vec::new();
    for class in Class::ALL {
        let turns = turns(class);
        let cycled = turns.iter().cycle().take(class.rides());
        let mut rides: Vec<Planned> = cycled.cloned().collect();
        chance.shuffle(&mut rides);
        all.extend(rides);
    }
    all
}

/// Numbers of every `one_in`-th ride of each class, at most `most` of each.
pub fn sample(plan: &[Planned], one_in: usize, most: u64) -> Vec<u64> {
    let of = |class: Class| {
        let numbers = (0..plan.len()).filter(move |i| plan[*i].class == class);
        numbers.step_by(one_in).zip(0..most).map(|(i, _)| i as u64)
    };
    Class::ALL.into_iter().flat_map(of).collect()
}

/// What the rides of a class conceal, in turn.
fn turns(class: Class) -> Vec<Planned> {
    let nothing = Planned {
        class,
        effects: Vec::new(),
        strange: None,
    };
    let with = |effects: &[(Kind, Axle)]| Planned {
        effects: effects.to_vec(),
        ..nothing.clone()
    };
    match class {
        Class::Clean | Class::CleanApart | Class::Car => vec![nothing],
        Class::Effect | Class::EffectApart => shown().map(|e| with(&[e])).collect(),
        Class::Absorbed => ABSORBED.map(|e| with(&[e])).to_vec(),
        Class::Lift => vec![with(&Axle::ONE.map(|axle| (Kind::WheelLift, axle)))],
        // Every third effect, so that each axle has some.
        Class::Equal => (shown().step_by(3))
            .flat_map(|e| [nothing.clone(), with(&[e])])
            .collect(),
        Class::Outside => {
            let on = |(kind, axle)| Planned {
                strange: Some((kind, axle)),
                ..nothing.clone()
            };
            each(&STRANGE).map(on).collect()
        }
    }
}

fn each<T: Copy>(kinds: &[T]) -> impl Iterator<Item = (T, Axle)> {
    kinds
        .iter()
        .flat_map(|kind| Axle::ONE.map(|axle| (*kind, axle)))
}

/// Effects on either axle in turn; a sprung mass only at the rear.
fn shown() -> impl Iterator<Item = (Kind, Axle)> {
    each(&SHOWN).map(|(kind, axle)| match kind {
        Kind::SprungMass => (kind, Axle::Rear),
        _ => (kind, axle),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planned() -> Vec<Planned> {
        plan(&mut Chance::new(1, 0))
    }

    #[test]
    fn classes_have_their_counts() {
        let plan = planned();
        let counts = Class::ALL.map(|class| plan.iter().filter(|p| p.class == class).count());
        assert_eq!(counts, [120, 60, 60, 30, 20, 12, 12, 8, 8]);
    }

    #[test]
    fn every_effect_is_on_either_axle_as_often() {
        let plan = planned();
        let count = |kind, axle| {
            let is = |p: &&Planned| p.class == Class::Effect && p.effects == [(kind, axle)];
            plan.iter().filter(is).count()
        };
        for kind in SHOWN {
            let [front, rear] = Axle::ONE.map(|axle| count(kind, axle));
            assert!((12..=14).contains(&(front + rear)), "{kind:?}");
            match kind {
                Kind::SprungMass => assert_eq!(front, 0),
                _ => assert!(front.abs_diff(rear) <= 1, "{kind:?}: {front} and {rear}"),
            }
        }
    }

    #[test]
    fn other_classes_conceal_what_they_are_named_for() {
        let plan = planned();
        let of = |class| plan.iter().filter(move |p| p.class == class);
        let is_clean = |p: &Planned| p.effects.is_empty() && p.strange.is_none();
        assert!(of(Class::Clean).chain(of(Class::Car)).all(is_clean));
        assert_eq!(of(Class::Equal).filter(|p| is_clean(p)).count(), 6);
        assert!(of(Class::Lift).all(|p| p.effects.len() == 2));
        let strange: Vec<_> = of(Class::Outside).filter_map(|p| p.strange).collect();
        assert!(each(&STRANGE).all(|law| strange.contains(&law)));
    }

    #[test]
    fn a_sample_has_every_class_and_keeps_numbers() {
        let plan = planned();
        let all = sample(&plan, 1, u64::MAX);
        assert_eq!(all, (0..330).collect::<Vec<u64>>());
        let some = sample(&plan, 6, u64::MAX);
        assert_eq!(some.len(), 20 + 10 + 10 + 5 + 4 + 2 + 2 + 2 + 2);
        assert_eq!(sample(&plan, 1, 2).len(), 2 * Class::ALL.len());
        assert_eq!(some[1], 6);
    }
}
