//! One effect, pairs, and the twelve known kinds of strange physics, among clean rides.

use super::{any_noise, clean, groups, road_or_plate};
use crate::chance::Chance;
use crate::simulate::effect::Kind;
use crate::simulate::outside::Strange;
use crate::suite::case::{Case, Class, Setting};

/// Every effect on each of its axles at three sizes, 40 clean rides, 30 pairs, 36 rides with strange physics; shuffled.
pub fn standard(chance: &mut Chance) -> Vec<Case> {
    let mut cases = clean(40, chance);
    for kind in Kind::ALL {
        for &axle in kind.axles() {
            for size in 0..3 {
                let mut case = Case::new(
                    Class::Single,
                    setting(kind.needs_road(), kind, chance),
                    any_noise(chance),
                    chance,
                );
                case.effects = vec![(kind, axle)];
                case.size = size;
                cases.push(case);
            }
        }
    }
    for _ in 0..30 {
        let pair = groups::pair(chance);
        let needs_road = pair.iter().any(|(kind, _)| kind.needs_road());
        let setting = road_or_plate(needs_road, chance);
        let mut case = Case::new(Class::Two, setting, any_noise(chance), chance);
        case.effects = pair;
        case.size = 1 + chance.index(2);
        cases.push(case);
    }
    for kind in Strange::KNOWN {
        for turn in 0..3 {
            let setting = road_or_plate(kind.needs_road(), chance);
            let mut case = Case::new(Class::Outside, setting, any_noise(chance), chance);
            case.strange = Some((kind, (turn + chance.index(2)) % 2));
            case.size = turn;
            cases.push(case);
        }
    }
    chance.shuffle(&mut cases);
    cases
}

/// Rides of 60 s and of 300 s on a road, on which time is measured: the first of each class in a standard plan.
pub fn timing(chance: &mut Chance) -> Vec<Case> {
    let plan = standard(chance);
    let first = |class, count, duration_s| {
        let road = plan
            .iter()
            .filter(move |c| c.class == class && c.setting == Setting::Road);
        road.take(count).map(move |case| Case {
            duration_s,
            rate_hz: 100.0,
            ..case.clone()
        })
    };
    [Class::Clean, Class::Single, Class::Two, Class::Outside]
        .into_iter()
        .flat_map(|class| first(class, 20, 60.0).chain(first(class, 5, 300.0)))
        .collect()
}

fn setting(needs_road: bool, kind: Kind, chance: &mut Chance) -> Setting {
    if needs_road {
        return Setting::Road;
    }
    // With the ground at rest these are the plain damper, plain friction, or a free rest point.
    let on_moving_ground = matches!(
        kind,
        Kind::GroundDamping | Kind::GuideFriction | Kind::SensorOffset
    );
    let draw = chance.uniform(0.0, 1.0);
    if kind == Kind::GroundDamping || kind == Kind::GuideFriction {
        return if draw < 0.5 {
            Setting::Plate
        } else {
            Setting::Road
        };
    }
    if draw < 0.76 {
        Setting::Road
    } else if draw < 0.87 || on_moving_ground {
        Setting::Plate
    } else {
        Setting::Shaker
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::suite::case::Noise;

    #[test]
    fn time_is_measured_on_every_class_at_both_lengths() {
        let cases = timing(&mut Chance::new(1, 0));
        for class in [Class::Clean, Class::Single, Class::Two, Class::Outside] {
            let of = |duration_s| {
                let is = |c: &&Case| c.class == class && c.duration_s == duration_s;
                cases.iter().filter(is).count()
            };
            assert_eq!((of(60.0), of(300.0)), (20, 5), "{}", class.name());
        }
    }

    #[test]
    fn the_standard_suite_holds_what_the_issue_demands() {
        let cases = standard(&mut Chance::new(1, 0));
        let count = |class| cases.iter().filter(|c| c.class == class).count();
        assert!(cases.len() >= 240);
        assert_eq!(count(Class::Clean), 40);
        assert_eq!(count(Class::Two), 30);
        assert!(count(Class::Outside) >= 30);
        for kind in Kind::ALL {
            for &axle in kind.axles() {
                let sizes = cases
                    .iter()
                    .filter(|c| c.class == Class::Single && c.effects == [(kind, axle)])
                    .count();
                assert_eq!(sizes, 3, "{}", kind.id());
            }
        }
        for noise in Noise::ALL {
            assert_eq!(
                cases
                    .iter()
                    .filter(|c| c.class == Class::Clean && c.noise == noise)
                    .count(),
                8
            );
        }
    }
}
